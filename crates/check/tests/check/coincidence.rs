//! Roots that coincide or nearly do: what is said of them, with proof and in doubles, against the exact multiplicities
//! and the many digits of the reference.

use eigentone_check::{Reference, ReferenceEigenvalue, ReferenceModes};
use eigentone_modes::{
    Bounds, Eigenvalue, GROUND, Mode, Modes, Motion, Precision, System, solvers,
};
use faer::{Mat, mat};
use proptest::prelude::*;

use crate::row::in_a_row;

fn distance(truth: &ReferenceEigenvalue, root: &Eigenvalue) -> f64 {
    let (re, im) = (root.value.re, root.value.im);
    truth.re.minus(re).hypot(truth.im.minus(im))
}

/// What lies within the bound of a root.
fn inside<'a>(truth: &'a ReferenceModes, root: &Eigenvalue) -> Vec<&'a ReferenceEigenvalue> {
    let Some(bound) = root.bound else {
        return Vec::new();
    };
    let each = truth.eigenvalues().iter();
    // The reference has an error too, beside which a bound may be small.
    let reach =
        |truth: &ReferenceEigenvalue| bound * (1.0 + 1e-12) + truth.re.radius() + truth.im.radius();
    each.filter(|truth| distance(truth, root) <= reach(truth))
        .collect()
}

/// Why an answer is wrong.
pub(super) fn fault(truth: &ReferenceModes, modes: &Modes) -> Option<String> {
    let expected: usize = truth
        .eigenvalues()
        .iter()
        .map(|root| root.multiplicity)
        .sum();
    if modes.eigenvalues().len() != expected {
        return Some(format!(
            "{} roots, not {expected}",
            modes.eigenvalues().len()
        ));
    }
    // Each root is in as many discs as it occurs, unless doubtful ones stand for it.
    let doubtful = modes
        .eigenvalues()
        .iter()
        .filter(|root| root.is_doubtful())
        .count();
    let mut missing = 0;
    for root in truth.eigenvalues() {
        let all = modes.eigenvalues().iter();
        let held = all.filter(|found| {
            inside(truth, found)
                .iter()
                .any(|other| std::ptr::eq(*other, root))
        });
        missing += root.multiplicity.saturating_sub(held.count());
    }
    if missing > doubtful {
        return Some(format!("{missing} roots in no disc, {doubtful} doubtful"));
    }
    for mode in modes {
        let root = mode.eigenvalue();
        let near = inside(truth, &root);
        if !root.is_doubtful() && near.is_empty() {
            return Some(format!("no root within the bound of {root:?}"));
        }
        if let Some(real_bound) = root.real_bound
            && !near.iter().any(|truth| {
                truth.re.minus(root.value.re).abs()
                    <= real_bound * (1.0 + 1e-12) + truth.re.radius()
            })
        {
            return Some(format!("no real part within the bound of {root:?}"));
        }
        if let Some(count) = mode.multiplicity()
            && !near.iter().any(|truth| truth.multiplicity == count)
        {
            return Some(format!("{root:?} is not {count}-fold"));
        }
        if !moves(mode, &near) {
            return Some(format!("{root:?} is not {}", mode.motion()));
        }
    }
    None
}

/// Whether the word for its motion is right for one of the roots that it may be.
fn moves(mode: &Mode, near: &[&ReferenceEigenvalue]) -> bool {
    let (re, im) = (
        |root: &ReferenceEigenvalue| root.re.nearest(),
        |root: &ReferenceEigenvalue| root.im.nearest(),
    );
    near.iter().any(|root| match mode.motion() {
        Motion::Rigid => re(root) == 0.0 && im(root) == 0.0,
        Motion::Growing => re(root) > 0.0,
        Motion::Decaying => re(root) < 0.0 && im(root) == 0.0,
        Motion::Oscillating => im(root) != 0.0,
        _ => true,
    }) || mode.eigenvalue().is_doubtful() && mode.motion() == Motion::Doubtful
}

/// The answers to a system are right, and that with proof separates all roots.
fn examine(system: &System) -> Result<(), TestCaseError> {
    let structure = system.structure();
    if structure.zero_roots() == structure.finite_roots() {
        return Ok(());
    }
    let truth = Reference::with_digits(40).modes(system);
    let Ok(truth) = truth else {
        return Ok(());
    };
    let proven = system
        .modes()
        .map_err(|error| TestCaseError::fail(error.to_string()))?;
    prop_assert_eq!(proven.bounds(), Bounds::Proven, "{}", proven.plan());
    prop_assert!(proven.is_complete());
    prop_assert_eq!(fault(&truth, &proven), None, "{:?}", proven.as_slice());
    let open: Vec<_> = proven
        .iter()
        .filter(|mode| mode.cluster().is_some())
        .collect();
    prop_assert!(open.is_empty(), "{open:?}");
    let doubles = system.modes_to(Precision::Double);
    let doubles = doubles.map_err(|error| TestCaseError::fail(error.to_string()))?;
    prop_assert!(!doubles.is_complete());
    prop_assert_eq!(
        fault(&truth, &doubles),
        None,
        "{}: {:?}",
        doubles.plan(),
        doubles.as_slice()
    );
    for solver in solvers() {
        if solver.refuses(system).is_none()
            && let Ok(modes) = solver.solve(system)
            && modes.eigenvalues().len() == doubles.eigenvalues().len()
        {
            for mode in &modes {
                let root = mode.eigenvalue();
                let near = inside(&truth, &root);
                prop_assert!(
                    root.is_doubtful() || !near.is_empty(),
                    "{}: {root:?}",
                    solver.name()
                );
                prop_assert!(moves(mode, &near), "{}: {mode:?}", solver.name());
            }
        }
    }
    Ok(())
}

/// m, c and k of one motion: critical or a few units of 2^-44 off, free, held by a damper, or without mass.
fn motions() -> impl Strategy<Value = [f64; 3]> {
    const UNIT: f64 = 1.0 / 17_592_186_044_416.0;
    let off = || prop_oneof![4 => Just(0.0), 1 => (-3i32..4).prop_map(|k| f64::from(k) * UNIT)];
    let rate = || (1i32..5).prop_map(|k| f64::from(k) / 4.0);
    prop_oneof![
        6 => (1u8..4, rate(), off(), off()).prop_map(|(m, a, c, k)| {
            let m = f64::from(m);
            [m, 2.0 * a * m + c, a * a * m + k]
        }),
        1 => rate().prop_map(|c| [1.0, c, 0.0]),
        1 => Just([1.0, 0.0, 0.0]),
        1 => (rate(), off()).prop_map(|(a, k)| [0.0, 1.0, a + k]),
    ]
}

/// LDR for M, C and K, with L and R of determinant 1.
fn planted(motions: &[[f64; 3]], shears: &[(usize, usize, i8)], symmetric: bool) -> Option<System> {
    let n = motions.len();
    let product = |shears: &mut dyn Iterator<Item = &(usize, usize, i8)>| {
        let mut product = Mat::<f64>::identity(n, n);
        for &(from, to, times) in shears {
            let (from, to) = (from % n, to % n);
            if from != to {
                for j in 0..n {
                    let add = f64::from(times) * product[(from, j)];
                    product[(to, j)] += add;
                }
            }
        }
        product
    };
    let right = product(&mut shears.iter());
    let left = if symmetric {
        right.transpose().to_owned()
    } else {
        product(&mut shears.iter().rev())
    };
    let around = |part: usize| {
        let middle = Mat::from_fn(n, n, |i, j| if i == j { motions[i][part] } else { 0.0 });
        &left * middle * &right
    };
    System::from_matrices(around(0).as_ref(), around(1).as_ref(), around(2).as_ref()).ok()
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn planted_coincidences(
        motions in prop::collection::vec(motions(), 1..5),
        shears in prop::collection::vec((0usize..5, 0usize..5, -2i8..3), 0..6),
        symmetric in any::<bool>(),
    ) {
        if let Some(system) = planted(&motions, &shears, symmetric) {
            examine(&system)?;
        }
    }

    #[test]
    fn networks_of_small_numbers(
        masses in prop::collection::vec(0u8..4, 1..6),
        springs in prop::collection::vec((0usize..6, 0usize..6, -1i8..4), 0..8),
        dampers in prop::collection::vec((0usize..6, 0usize..6, -1i8..5), 0..6),
    ) {
        let n = masses.len();
        let name = |i: usize| if i == 0 { GROUND.to_owned() } else { format!("m{i}") };
        let all = masses.iter().enumerate().fold(System::builder(), |builder, (i, mass)| {
            builder.mass(name(i + 1), f64::from(*mass))
        });
        let ends = |(a, b, size): (usize, usize, i8)| (a % (n + 1), b % (n + 1), f64::from(size));
        let joins = |list: Vec<(usize, usize, i8)>| list.into_iter().map(ends).filter(|(a, b, _)| a != b);
        let sprung = joins(springs).fold(all, |builder, (a, b, k)| builder.spring(name(a), name(b), k));
        let damped = joins(dampers).fold(sprung, |builder, (a, b, c)| builder.damper(name(a), name(b), c));
        if let Ok(system) = damped.build() {
            examine(&system)?;
        }
    }

    #[test]
    fn an_ulp_off_critical(
        m in -2.0..2.0f64,
        k in -2.0..2.0f64,
        ulps in -3i64..4,
        count in 1usize..3,
    ) {
        let (m, k) = (10f64.powf(m), 10f64.powf(k));
        let c = f64::from_bits(((2.0 * (m * k).sqrt()).to_bits() as i64 + ulps) as u64);
        let each = (0..count).fold(System::builder(), |builder, i| {
            let name = format!("m{i}");
            builder.mass(&name, m).spring(GROUND, &name, k).damper(GROUND, &name, c)
        });
        examine(&each.clone().build().expect("a system"))?;
        // Joined, so that one mode of two is nearly critical.
        let pair = each.mass("a", m).mass("b", m);
        let pair = [(GROUND, "a"), ("a", "b"), ("b", GROUND)].into_iter().fold(pair, |builder, (from, to)| {
            builder.spring(from, to, k).damper(from, to, c)
        });
        examine(&pair.build().expect("a system"))?;
    }
}

#[test]
fn known_coincidences() {
    let m = mat![[2.0, 0.0, -1.0], [0.0, 1.0, 2.0], [-1.0, 2.0, 5.0]];
    let c = mat![
        [4.0, 0.0, -2.0000000000000018],
        [0.0, 2.0, 4.0],
        [-2.0000000000000018, 4.0, 10.000000000000002]
    ];
    let six = System::from_matrices(m.as_ref(), c.as_ref(), m.as_ref()).expect("a system");
    examine(&six).expect("−1 twice, and four about it");
    let m = mat![[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let c = mat![
        [2.0000000000001705, 0.0, -2.0000000000001705],
        [2.0, 1.0, -3.999999999999943],
        [0.0, 0.0, 2.0000000000001705]
    ];
    let k = mat![
        [1.0000000000001705, 0.0, -1.0000000000001705],
        [2.0, 1.0, -4.0],
        [0.0, 0.0, 1.0000000000001705]
    ];
    let five = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
    examine(&five).expect("−1 three times and another root twice");
    let modes = five.modes().expect("modes");
    let counts: Vec<_> = modes
        .iter()
        .map(|mode| (mode.multiplicity(), mode.is_defective()))
        .collect();
    assert_eq!(
        counts,
        [
            (Some(3), Some(true)),
            (Some(2), Some(false)),
            (Some(2), Some(false))
        ]
    );
}

#[test]
fn equal_oscillators_share_their_roots() {
    let critical = |names: &[&str]| {
        let each = names.iter().fold(System::builder(), |builder, name| {
            builder
                .mass(*name, 1.0)
                .spring(GROUND, *name, 1.0)
                .damper(GROUND, *name, 2.0)
        });
        each.build().expect("a system")
    };
    for precision in [Precision::default(), Precision::Double] {
        let modes = critical(&["a", "b"]).modes_to(precision).expect("modes");
        assert_eq!(modes.as_slice().len(), 2);
        for mode in &modes {
            assert_eq!((mode.multiplicity(), mode.roots()), (Some(4), 2));
            assert_eq!(
                (mode.is_defective(), mode.motion()),
                (Some(true), Motion::Decaying)
            );
        }
    }
}

/// Systems that doubles alone would call singular, or lose a root of.
#[test]
fn ordinary_systems_are_answered() {
    let stiff = System::builder()
        .mass("a", 1.0)
        .mass("p", 0.0)
        .mass("q", 0.0)
        .spring("p", "q", 1.0)
        .damper(GROUND, "a", 1.0)
        .damper("p", "q", 1e9)
        .damper("a", "p", 1e-9)
        .build()
        .expect("a system");
    let truth = Reference::default().modes(&stiff).expect("roots");
    let modes = stiff.modes().expect("its damping matrix is regular");
    assert_eq!(modes.bounds(), Bounds::Proven);
    assert_eq!(fault(&truth, &modes), None);
    // Free motions that only the exact rank of K shows, with a critical pair.
    let m = mat![[1.0, 3.0], [3.0, 10.0]];
    let k = mat![[1.0, 3.0], [3.0, 9.0]];
    let parts = [0.5, 0.0625].map(|factor| &k * faer::Scale(factor));
    let [c, k] = parts.each_ref().map(Mat::as_ref);
    let free = System::from_matrices(m.as_ref(), c, k).expect("a system");
    examine(&free).expect("0 twice and −1/4 twice");
    // What massless nodes add cancels.
    let cancelling = in_a_row(
        &[("a", 1.0), ("p", 0.0)],
        &[1.6587773485758532, 3.3175546971517065, -1.1058515657172352],
        &[],
    );
    examine(&cancelling).expect("one slow frequency");
}

/// −c/m and −k/c of one mass, where these are less than the least double.
#[test]
fn roots_below_the_doubles_are_listed() {
    let least = f64::from_bits(1);
    for (m, c, k, expected) in [
        (1.0, 1e300, 1e-80, [-least, -1e300]),
        (2.0, least, 0.0, [0.0, -least]),
        (2.0, -least, 0.0, [0.0, least]),
    ] {
        let one = in_a_row(&[("m", m)], &[k], &[c]);
        for precision in [Precision::default(), Precision::Double] {
            let modes = one.modes_to(precision).expect("modes");
            assert_eq!(modes.infinite(), 0);
            let values: Vec<f64> = modes
                .eigenvalues()
                .iter()
                .map(|root| root.value.re)
                .collect();
            assert_eq!(values, expected);
            let last = modes
                .iter()
                .find(|mode| mode.eigenvalue().value.re.abs() == least);
            let last = last.expect("it is there");
            let motion = if c < 0.0 {
                Motion::Growing
            } else {
                Motion::Decaying
            };
            assert_eq!(last.motion(), motion, "{last:?}");
            assert!(
                last.eigenvalue()
                    .bound
                    .is_some_and(|bound| (least..=2.0 * least).contains(&bound))
            );
        }
    }
}

/// Critical damping beside a pair 3e-7 off the real axis, mixed by a shear: in doubles the estimates of single roots do not
/// see each other.
#[test]
fn a_critical_root_beside_a_pair_keeps_its_estimate() {
    let motions = [[3.0, 3.0, 0.75], [3.0, 3.0, 0.7500000000001705]];
    let system = planted(&motions, &[(0, 1, 1)], false).expect("a system");
    examine(&system).expect("right within its bounds");
}

/// Critical damping of one rate twice, beside free motions: the points of both start on one circle.
#[test]
fn critical_pairs_of_one_rate_are_proven() {
    let motions = [
        [2.0, 3.0, 1.125],
        [1.0, 0.25, 0.0],
        [1.0, 0.5, 0.0],
        [1.0, 1.5, 0.5625],
    ];
    let shears = [(1, 2, 1), (1, 3, -1), (1, 0, 1)];
    let system = planted(&motions, &shears, true).expect("a system");
    examine(&system).expect("−3/4 four times");
}

/// Damping that is critical or nearly so, mixed by shears: planted coincidences whose estimates were exceeded, by what
/// Newton's method left, by pairs that stand for their mean, and by classical dampings that are mixed.
#[test]
fn planted_coincidences_keep_their_estimates() {
    const NEAR: f64 = 1.0 / 17_592_186_044_416.0;
    type Case<'a> = (&'a [[f64; 3]], &'a [(usize, usize, i8)], bool);
    let cases: [Case<'_>; 6] = [
        (
            &[[2.0, 4.0, 2.0], [1.0, 1.0, 0.25], [3.0, 1.5, 0.1875]],
            &[(2, 0, 2), (1, 2, -1)],
            true,
        ),
        (
            &[[3.0, 6.0, 3.0], [2.0, 2.0 - 3.0 * NEAR, 0.5]],
            &[(2, 1, -1), (0, 1, -1), (1, 2, -2), (2, 1, 2)],
            false,
        ),
        (
            &[[2.0, 1.0 + NEAR, 0.125], [1.0, 2.0, 1.0]],
            &[(1, 0, 2), (2, 1, 2)],
            true,
        ),
        (
            &[[1.0, 0.0, 0.0], [1.0, 1.0, 0.25 + 2.0 * NEAR]],
            &[(1, 0, -2), (2, 1, 2), (1, 2, 2)],
            true,
        ),
        (
            &[
                [1.0, 0.5, 0.0625 - NEAR],
                [1.0, 0.5, 0.0625],
                [1.0, 0.5 - NEAR, 0.0625],
                [1.0, 0.25, 0.0],
            ],
            &[(2, 4, -2), (2, 1, -1), (4, 3, -1)],
            true,
        ),
        (
            &[
                [3.0, 1.5, 0.1875],
                [1.0, 0.25, 0.0],
                [1.0, 1.5 - NEAR, 0.5625],
                [3.0, 4.5, 1.6875],
            ],
            &[(3, 2, -2), (3, 1, -1), (2, 0, -1), (1, 0, 2), (2, 0, 2)],
            true,
        ),
    ];
    for (motions, shears, symmetric) in cases {
        let system = planted(motions, shears, symmetric).expect("a system");
        examine(&system).expect("right within its bounds");
    }
}
