//! Full matrices without any pattern, from well to very ill conditioned: proven, and in doubles within the estimates of what is proved.

use eigentone_modes::{Bounds, Modes, Precision, System};
use faer::prelude::Solve;
use faer::{Mat, c64};
use proptest::prelude::*;

use crate::estimated::covered;
use crate::random::Random;

/// What M, C and K are.
#[derive(Clone, Copy, Debug)]
enum Family {
    Undamped,
    Singular,
    Massive,
    Gyroscopic,
    Follower,
    Dashpots,
    Passive,
    Active,
    Overdamped,
    Classical,
}

const FAMILIES: [Family; 10] = [
    Family::Undamped,
    Family::Singular,
    Family::Massive,
    Family::Gyroscopic,
    Family::Follower,
    Family::Dashpots,
    Family::Passive,
    Family::Active,
    Family::Overdamped,
    Family::Classical,
];

impl Random {
    fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| 0.5 * self.signed())
    }

    /// Symmetric, with eigenvalues from 10^−digits to 1.
    fn definite(&mut self, n: usize, digits: f64) -> Mat<f64> {
        let values = (0..n).map(|i| 10f64.powf(-digits * i as f64 / (n - 1) as f64));
        let values: Vec<f64> = values.collect();
        let mut matrix = Mat::from_fn(n, n, |i, j| if i == j { values[i] } else { 0.0 });
        for _ in 0..3 {
            let v = self.matrix(n, 1);
            let square = v.squared_norm_l2();
            let reflection =
                Mat::<f64>::identity(n, n) - &v * v.transpose() * faer::Scale(2.0 / square);
            matrix = &reflection * matrix * &reflection;
        }
        Mat::from_fn(n, n, |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]))
    }

    fn whole(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| (3.0 * self.signed()).round())
    }

    /// M, C and K.
    fn matrices(&mut self, family: Family, n: usize, digits: f64) -> [Mat<f64>; 3] {
        let scaled = |matrix: Mat<f64>, factor: f64| matrix * faer::Scale(factor);
        let mut m = self.definite(n, 0.25 * digits);
        let mut c = Mat::zeros(n, n);
        let mut k = self.definite(n, digits);
        match family {
            Family::Undamped => {}
            Family::Singular => {
                let factor = self.whole(n - 3, n);
                k = factor.transpose() * &factor;
            }
            Family::Massive => m = self.definite(n, digits.min(9.0)),
            Family::Gyroscopic => {
                let turn = self.matrix(n, n);
                c = scaled(&turn - turn.transpose(), 0.1);
            }
            Family::Follower => {
                k += scaled(self.matrix(n, n), 10f64.powf(-0.7 * digits));
                c = scaled(self.definite(n, 1.0), 0.01);
            }
            Family::Dashpots => {
                let factor = self.matrix(n, 2);
                c = &factor * factor.transpose();
            }
            Family::Passive => c = scaled(self.definite(n, digits), 0.2),
            Family::Active => {
                let any = self.matrix(n, n);
                c = scaled(&any + any.transpose(), 0.01);
            }
            Family::Overdamped => c = scaled(self.definite(n, 1.0), 1e2),
            Family::Classical => {
                // Whole numbers, so that the damping is exactly in proportion.
                let factor = self.whole(n, n);
                k = factor.transpose() * &factor;
                m = Mat::identity(n, n);
                c = scaled(k.clone(), 0.0625);
            }
        }
        [m, c, k]
    }
}

/// Σ 1/(s − λ) over all roots is the trace of Q(s)⁻¹ Q′(s), at points around 0 from the smallest root to the largest:
/// what is lost, invented or off changes it. `lu` errs by the condition of Q(s) at most, times n u.
fn assert_sums([m, c, k]: &[Mat<f64>; 3], modes: &Modes) {
    let n = m.nrows();
    let sizes = modes.eigenvalues().iter().map(|root| root.value.norm());
    let largest = sizes.clone().fold(0.0, f64::max);
    let least = sizes
        .filter(|&size| size > 1e-7 * largest)
        .fold(largest, f64::min);
    for i in 0..6 {
        let size = 1.1 * least * (largest / least).powf(f64::from(i) / 5.0);
        let s = c64::from_polar(size, 1.0 + f64::from(i));
        let at = |i, j| c64::from(m[(i, j)]) * s * s + s * c[(i, j)] + k[(i, j)];
        let value = Mat::from_fn(n, n, at);
        let slope = Mat::from_fn(n, n, |i, j| c64::from(m[(i, j)]) * s * 2.0 + c[(i, j)]);
        let lu = value.partial_piv_lu();
        let inverse = lu.solve(Mat::<c64>::identity(n, n));
        let turned = &inverse * &slope;
        let trace: c64 = (0..n).map(|i| turned[(i, i)]).sum();
        let sum: c64 = modes
            .eigenvalues()
            .iter()
            .map(|root| 1.0 / (s - root.value))
            .sum();
        let condition = value.norm_l2() * inverse.norm_l2();
        let error = 4.0 * n as f64 * f64::EPSILON * condition * turned.norm_l2();
        let off = (trace - sum).norm();
        assert!(off <= error, "{trace} {sum} {error:e} at {s}");
    }
}

/// The largest number of coordinates that is drawn.
fn coordinates() -> usize {
    let asked = std::env::var("EIGENTONE_COORDINATES").ok();
    asked.map_or(70, |asked| asked.parse().expect("a number of coordinates"))
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 3,
        max_shrink_iters: 8,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn full_matrices_are_proven(seed in any::<u64>(), n in 65..=coordinates(), digits in 0.0..16.0f64) {
        for family in FAMILIES {
            assert_proven(family, seed, n, digits);
        }
    }
}

/// All roots are there, and those of doubles are within their estimates.
fn assert_proven(family: Family, seed: u64, n: usize, digits: f64) {
    let matrices = Random(seed).matrices(family, n, digits);
    let [m, c, k] = &matrices;
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
    let proven = system.modes().expect("modes");
    let plan = proven.plan();
    assert_eq!(proven.bounds(), Bounds::Proven, "{family:?}: {plan}");
    assert!(proven.is_complete());
    assert_sums(&matrices, &proven);
    covered(&proven, &system.modes_to(Precision::Double).expect("modes"));
}

/// Of 36 slow roots next to each other doubles know no digit: within their span a pencil with a definite matrix keeps them real.
#[test]
fn slow_roots_that_doubles_do_not_know_stay_real() {
    assert_proven(
        Family::Overdamped,
        5_081_999_407_525_209_964,
        77,
        15.983_773_303_107_863,
    );
}

/// Masses of 1 kg between two walls, springs of 1 N/m and of `stiff` in turn.
fn alternating(n: usize, stiff: f64) -> Mat<f64> {
    let spring = |i: usize| if i.is_multiple_of(2) { 1.0 } else { stiff };
    Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => spring(i) + spring(i + 1),
        1 => -spring(i.max(j)),
        _ => 0.0,
    })
}

/// Every root stands alone, within the last digits of |λ|, and of Re λ unless that is hidden.
fn assert_known_to_the_last_digits(m: &Mat<f64>, c: &Mat<f64>, k: &Mat<f64>) {
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref());
    let modes = system.expect("a system").modes().expect("its modes");
    assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
    assert!(modes.iter().all(|mode| mode.multiplicity() == Some(1)));
    for root in modes.eigenvalues() {
        let (size, part) = (root.value.norm(), root.value.re.abs());
        let (bound, real_bound) = (root.bound.unwrap(), root.real_bound.unwrap());
        assert!(bound <= f64::EPSILON * size, "{root:?}");
        let is_hidden = real_bound <= 1e-30 * size;
        assert!(is_hidden || real_bound <= f64::EPSILON * part, "{root:?}");
    }
}

/// Real shapes know the decay rates, pairs the frequencies, and determinants about these the few roots that neither
/// brings to the last digit. Twenty roots lie within 1e-18 of −1024.
#[test]
fn proofs_make_up_for_each_other() {
    let n = 40;
    let k = alternating(n, 1e12);
    let c = &k * faer::Scale(1.0 / 1024.0);
    assert_known_to_the_last_digits(&Mat::identity(n, n), &c, &k);
}

/// Determinants reach the decay rates that pairs leave open only from the roots of these.
#[test]
fn stiff_pairs_with_one_dashpot() {
    for n in [30, 45, 64] {
        let mut c = Mat::<f64>::zeros(n, n);
        c[(2, 2)] = 0.5;
        assert_known_to_the_last_digits(&Mat::identity(n, n), &c, &alternating(n, 3e6));
    }
}
