//! The bounds hold, and are not idle.

use faer::Mat;
use num_complex::Complex;

use super::*;

use crate::inclusion::{self, Approximation};
use crate::structure::samples::{Join, network, with_matrices};
use crate::{Bounds, GROUND, MatrixKind, Modes, Precision};
use eigentone_digits::{Real, Wide, WideComplex};
use proptest::prelude::*;

const UNIT: f64 = f64::EPSILON / 2.0;

fn approximate(system: &System) -> Modes {
    system.modes_to(Precision::Double).unwrap()
}

fn proven(system: &System) -> Option<Vec<Paired>> {
    certify(system, approximate(system).as_slice(), None, 4.0 * UNIT)
}

/// What joins n masses in a row to each other, where it is not 0, from the ground on and perhaps to it.
fn joined(n: usize, values: &[f64]) -> Vec<Join> {
    let given = values
        .iter()
        .enumerate()
        .filter(|(_, value)| **value != 0.0);
    given
        .map(|(i, value)| (i, (i + 1) % (n + 1), *value))
        .collect()
}

/// Masses in a row, with a spring before each and one behind the last; dampers to the ground.
fn chain(masses: &[f64], springs: &[f64], dashpots: &[(usize, f64)]) -> System {
    let dashpots: Vec<Join> = dashpots.iter().map(|(i, c)| (0, i + 1, *c)).collect();
    network(masses, &joined(masses.len(), springs), &dashpots)
}

type Precise = WideComplex<Wide<4>>;

/// How far λ and its real part are from a root of the chain, by Newton's method on its determinant:
/// the recurrence of a tridiagonal matrix in 77 digits, with its derivative.
fn errors(
    masses: &[f64],
    springs: &[f64],
    dashpots: &[(usize, f64)],
    found: Complex<f64>,
) -> (f64, f64) {
    const STEPS: usize = 5;
    let start = Precise::new(found.re, found.im);
    let mut lambda = start;
    for _ in 0..STEPS {
        let [mut last, mut now] = [[Precise::ZERO; 2], [Precise::new(1.0, 0.0), Precise::ZERO]];
        for i in 0..masses.len() {
            let c: f64 = dashpots.iter().filter(|d| d.0 == i).map(|d| d.1).sum();
            let stiffness = Precise::new(springs[i] + springs[i + 1], 0.0);
            let entry = lambda * lambda * masses[i] + lambda * c + stiffness;
            let slope = lambda * (2.0 * masses[i]) + Precise::new(c, 0.0);
            let beside = springs[i] * springs[i];
            let value = entry * now[0] - last[0] * beside;
            let derivative = slope * now[0] + entry * now[1] - last[1] * beside;
            (last, now) = (now, [value, derivative]);
        }
        lambda = lambda - now[0] / now[1];
    }
    let apart = lambda - start;
    (apart.norm(), apart.re.to_f64().abs())
}

#[test]
fn long_chains_with_a_few_dashpots() {
    for (n, dashpots) in [
        (80, vec![(79, 0.75)]),
        (200, vec![(3, 0.5), (99, 2.0), (150, 1e-6)]),
        // Pairs of roots 1e-9 apart, which doubles mix.
        (200, vec![(3, 0.5), (100, 2.0)]),
    ] {
        let masses: Vec<f64> = (0..n).map(|i| 1.0 + 0.25 * (i % 4) as f64).collect();
        let mut springs: Vec<f64> = (0..=n).map(|i| 1.0 + (i % 3) as f64).collect();
        springs[n] = 0.0;
        let system = chain(&masses, &springs, &dashpots);
        let modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        assert_eq!(modes.eigenvalues().len(), 2 * n);
        for root in modes.eigenvalues() {
            let size = root.value.norm();
            let (bound, real_bound) = (root.bound.unwrap(), root.real_bound.unwrap());
            assert!(bound <= 4.0 * UNIT * size, "{root:?}");
            // Some modes keep away from all dashpots.
            let least = 1e-10 * UNIT * size;
            assert!(
                real_bound <= (8.0 * UNIT * root.value.re.abs()).max(least),
                "{root:?}"
            );
            let (error, real_error) = errors(&masses, &springs, &dashpots, root.value);
            assert!(
                error <= bound && real_error <= real_bound,
                "{error:e} {root:?}"
            );
        }
        for mode in &modes {
            assert!(mode.backward_error() <= 20.0 * UNIT);
        }
    }
}

/// Masses in a row, each with a damper to the ground; springs and dampers before each, and behind the last. What a mass
/// feels of the next one is `follow` times what that feels of it.
struct Row {
    masses: Vec<f64>,
    dashpots: Vec<f64>,
    springs: Vec<f64>,
    dampers: Vec<f64>,
    follow: f64,
}

impl Row {
    fn system(&self) -> System {
        let n = self.masses.len();
        let held = (1..).zip(&self.dashpots).filter(|(_, c)| **c != 0.0);
        let mut dampers: Vec<Join> = held.map(|(i, c)| (0, i, *c)).collect();
        dampers.extend(joined(n, &self.dampers));
        let beyond = |joins: &[f64]| {
            let entry = |i, j| {
                if j == i + 1 {
                    joins[j] * (1.0 - self.follow)
                } else {
                    0.0
                }
            };
            (self.follow != 1.0).then(|| Mat::from_fn(n, n, entry))
        };
        let added = [None, beyond(&self.dampers), beyond(&self.springs)];
        with_matrices(&self.masses, &joined(n, &self.springs), &dampers, added)
    }

    /// The shape at the root near one that is found, with the given component 1: the root by Newton's method on the
    /// determinant, then from mass to mass, in 154 digits. Left shapes are those of the transposed matrices.
    fn shape(&self, found: Complex<f64>, pivot: usize, is_left: bool) -> (Fine, Vec<Fine>) {
        const STEPS: usize = 7;
        let n = self.masses.len();
        let real = |value: f64| Fine::new(value, 0.0);
        let join = |i: usize, lambda: Fine| real(self.springs[i]) + lambda * self.dampers[i];
        let entry = |i: usize, lambda: Fine| {
            let own = lambda * lambda * self.masses[i] + lambda * self.dashpots[i];
            own + join(i, lambda) + join(i + 1, lambda)
        };
        let mut lambda = Fine::new(found.re, found.im);
        for _ in 0..STEPS {
            let [mut last, mut now] = [[Fine::ZERO; 2], [real(1.0), Fine::ZERO]];
            for i in 0..n {
                let constant = self.dashpots[i] + self.dampers[i] + self.dampers[i + 1];
                let slope = lambda * (2.0 * self.masses[i]) + real(constant);
                let before = join(i, lambda);
                let square = [before, Fine::new(2.0 * self.dampers[i], 0.0)];
                let square = square.map(|part| part * before * self.follow);
                let own = entry(i, lambda);
                let value = own * now[0] - square[0] * last[0];
                let derived = slope * now[0] + own * now[1];
                let derived = derived - square[1] * last[0] - square[0] * last[1];
                (last, now) = (now, [value, derived]);
            }
            lambda = lambda - now[0] / now[1];
        }
        // Towards the largest component from both ends, along which errors do not grow.
        let (lower, upper) = if is_left {
            (self.follow, 1.0)
        } else {
            (1.0, self.follow)
        };
        let mut shape = vec![real(1.0); n];
        for i in 0..pivot {
            let mut force = entry(i, lambda) * shape[i];
            if i > 0 {
                force = force - join(i, lambda) * shape[i - 1] * lower;
            }
            shape[i + 1] = force / (join(i + 1, lambda) * upper);
        }
        let at_pivot = shape[pivot];
        (0..pivot).for_each(|i| shape[i] = shape[i] / at_pivot);
        shape[n - 1] = real(1.0);
        for i in (pivot + 1..n).rev() {
            let mut force = entry(i, lambda) * shape[i];
            if i + 1 < n {
                force = force - join(i + 1, lambda) * shape[i + 1] * upper;
            }
            shape[i - 1] = force / (join(i, lambda) * lower);
        }
        let at_pivot = shape[pivot];
        (pivot..n).for_each(|i| shape[i] = shape[i] / at_pivot);
        (lambda, shape)
    }
}

type Fine = WideComplex<Wide<8>>;

#[test]
fn components_of_shapes_are_within_their_bounds() {
    let masses = |n: usize| (0..n).map(|i| 1.0 + (0.618 * i as f64).fract()).collect();
    let uneven = |n: usize| -> Vec<f64> { (0..=n).map(|i| 1.0 + 0.5 * (i % 3) as f64).collect() };
    let free = |mut joins: Vec<f64>| {
        let n = joins.len() - 1;
        (joins[0], joins[n]) = (0.0, 0.0);
        joins
    };
    let few = |n: usize, at: &[(usize, f64)]| {
        let mut dashpots = vec![0.0; n];
        at.iter().for_each(|(i, c)| dashpots[*i] = *c);
        dashpots
    };
    let light = |n: usize| (0..=n).map(|i| 0.02 * (1 + i % 5) as f64).collect();
    for row in [
        // Held at both ends, and everything damped.
        Row {
            masses: masses(70),
            dashpots: vec![0.0; 70],
            springs: uneven(70),
            dampers: light(70),
            follow: 1.0,
        },
        // A few dashpots on a longer one, some of them strong.
        Row {
            masses: masses(120),
            dashpots: few(120, &[(3, 0.5), (60, 20.0), (99, 1e-6)]),
            springs: uneven(120),
            dampers: vec![0.0; 121],
            follow: 1.0,
        },
        // It drifts.
        Row {
            masses: masses(66),
            dashpots: vec![0.0; 66],
            springs: free(uneven(66)),
            dampers: free(light(66)),
            follow: 1.0,
        },
        // It relaxes.
        Row {
            masses: masses(66),
            dashpots: few(66, &[(0, 0.25), (40, 3.0)]),
            springs: free(uneven(66)),
            dampers: vec![0.0; 67],
            follow: 1.0,
        },
        // Forces that follow.
        Row {
            masses: masses(70),
            dashpots: few(70, &[(5, 0.5), (40, 2.0)]),
            springs: uneven(70),
            dampers: light(70),
            follow: 0.9375,
        },
        Row {
            masses: masses(100),
            dashpots: few(100, &[(0, 0.25), (50, 1.0)]),
            springs: uneven(100),
            dampers: vec![0.0; 101],
            follow: 1.0 + 2f64.powi(-10),
        },
    ] {
        let modes = row.system().modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        let moving = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.norm() > 0.0);
        for mode in moving {
            let root = mode.eigenvalue();
            let sides = [
                (mode.shape(), mode.shape_bound(), false),
                (mode.left_shape().unwrap(), mode.left_shape_bound(), true),
            ];
            for (shape, bounds, is_left) in sides {
                let bounds = bounds.expect("every root is single");
                let pivot = shape.iter().position(|x| *x == Complex::ONE);
                let (lambda, truth) = row.shape(root.value, pivot.unwrap(), is_left);
                let off = lambda - Fine::new(root.value.re, root.value.im);
                assert!(off.norm() <= root.bound.unwrap(), "{root:?}");
                assert!(
                    off.re.to_f64().abs() <= root.real_bound.unwrap(),
                    "{root:?}"
                );
                assert!(root.bound.unwrap() <= 4.0 * UNIT * root.value.norm());
                for ((x, bound), truth) in shape.iter().zip(bounds).zip(truth) {
                    let truth = if is_left { truth.conj() } else { truth };
                    let off = (truth - Fine::new(x.re, x.im)).norm();
                    assert!(off <= *bound, "{off:e} {bound:e} {x} {root:?}");
                    // Not idle: relative to each component that is not very small.
                    let size = x.norm();
                    let enough = if size > 1e-6 {
                        4.0 * UNIT * size
                    } else {
                        1e-21
                    };
                    assert!(*bound <= enough, "{bound:e} {x} {root:?}");
                }
            }
        }
    }
}

/// Pairs of coordinates on springs, each pair turning: z'' − 2iΩz' + kz = 0 for z = x + iy.
#[test]
fn turning_frames_neither_damp_nor_drive() {
    let half = 35;
    let rate = 0.75;
    let n = 2 * half;
    let chain = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    };
    let springs = Mat::from_fn(n, n, |i, j| {
        if i % 2 == j % 2 {
            chain(i / 2, j / 2)
        } else {
            0.0
        }
    });
    let turning = Mat::from_fn(n, n, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
        (true, 0, 1) => rate,
        (true, 1, 0) => -rate,
        _ => 0.0,
    });
    let masses = Mat::<f64>::identity(n, n);
    let system = System::from_matrices(masses.as_ref(), turning.as_ref(), springs.as_ref());
    let modes = system.unwrap().modes().unwrap();
    assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
    let mut truth: Vec<f64> = Vec::new();
    for j in 1..=half {
        let angle = std::f64::consts::PI * j as f64 / (2 * half + 2) as f64;
        let k = 4.0 * angle.sin().powi(2);
        let root = (rate * rate + 4.0 * k).sqrt();
        truth.extend([(root + rate) / 2.0, (root - rate) / 2.0]);
    }
    truth.sort_by(f64::total_cmp);
    assert_eq!(modes.as_slice().len(), n);
    for (mode, frequency) in modes.iter().zip(truth) {
        let root = mode.eigenvalue();
        assert_eq!(root.value.re, 0.0);
        assert!((root.value.im - frequency).abs() <= 1e-12 * frequency);
        assert!(root.bound.unwrap() <= 4.0 * UNIT * frequency);
        assert!(mode.shape_bound().is_some() && mode.left_shape_bound().is_some());
    }
}

/// A beam of Hermite elements, EI = 1 and each 1 long, 420 kg/m, clamped at both ends.
fn clamped_beam(elements: usize) -> [Mat<f64>; 2] {
    let mass = [
        [156.0, 22.0, 54.0, -13.0],
        [22.0, 4.0, 13.0, -3.0],
        [54.0, 13.0, 156.0, -22.0],
        [-13.0, -3.0, -22.0, 4.0],
    ];
    let stiffness = [
        [12.0, 6.0, -12.0, 6.0],
        [6.0, 4.0, -6.0, 2.0],
        [-12.0, -6.0, 12.0, -6.0],
        [6.0, 2.0, -6.0, 4.0],
    ];
    let n = 2 * elements - 2;
    [mass, stiffness].map(|element| {
        let mut whole = Mat::zeros(n, n);
        for at in 0..elements {
            for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                let place = |k: usize| (2 * at + k).checked_sub(2).filter(|place| *place < n);
                if let (Some(a), Some(b)) = (place(i), place(j)) {
                    whole[(a, b)] += element[i][j];
                }
            }
        }
        whole
    })
}

#[test]
fn a_clamped_beam_with_a_dashpot_at_its_middle() {
    let elements = 60;
    let [mass, stiffness] = clamped_beam(elements);
    let n = mass.nrows();
    let names = (0..n).fold(System::builder(), |b, i| b.mass(format!("q{i}"), 0.0));
    let system = names
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Stiffness, stiffness.as_ref())
        .damper(GROUND, format!("q{}", elements - 2), 8.0)
        .build()
        .unwrap();
    let modes = system.modes().unwrap();
    assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
    let undamped = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.re == 0.0);
    assert_eq!(undamped.count(), n / 2);
    for root in modes.eigenvalues() {
        assert!(root.value.re <= 0.0);
        assert!(
            root.bound.unwrap() <= 4.0 * UNIT * root.value.norm(),
            "{root:?}"
        );
        assert!(
            root.real_bound.unwrap() <= 8.0 * UNIT * root.value.re.abs(),
            "{root:?}"
        );
    }
}

#[test]
fn no_proof_of_what_it_is_not_meant_for() {
    // Critical damping, and a force that follows and holds nothing.
    let critical = chain(&[1.0], &[1.0, 0.0], &[(0, 2.0)]);
    assert!(proven(&critical).is_none());
    let names = System::builder().mass("a", 1.0).mass("b", 2.0);
    let follower = faer::mat![[2.0, -1.0], [0.0, 0.0]];
    let follower = names.matrix(MatrixKind::Stiffness, follower.as_ref());
    assert!(proven(&follower.build().unwrap()).is_none());
    // A root is missing, and one is given twice.
    let system = chain(&[1.0, 2.0], &[1.0, 2.0, 3.0], &[(0, 0.5)]);
    let modes = approximate(&system);
    assert!(certify(&system, modes.as_slice(), None, 4.0 * UNIT).is_some());
    assert!(certify(&system, &modes.as_slice()[..1], None, 4.0 * UNIT).is_none());
    let twice = [modes.as_slice()[0].clone(), modes.as_slice()[0].clone()];
    // Refinement may find the one that is missing: then each is proved once.
    if let Some(found) = certify(&system, &twice, None, 4.0 * UNIT) {
        let holds = |root: Complex<f64>| {
            let near = |one: &&Paired| (one.value - root).norm() <= one.bound + 1e-14;
            found.iter().filter(near).count()
        };
        let each = modes.iter().map(|mode| holds(mode.eigenvalue().value));
        assert!(each.eq([1, 1]), "{found:?}");
    }
}

/// Roots that are proved are those that Weierstrass corrections prove.
fn agree(system: &System) -> Result<(), TestCaseError> {
    let modes = approximate(system);
    let Some(found) = proven(system) else {
        // Only where roots lie close to each other.
        let roots = modes.eigenvalues();
        let near = |i: usize| {
            (0..i).any(|j| {
                let gap = (roots[i].value - roots[j].value).norm();
                gap <= 1e-2 * roots[i].value.norm()
            })
        };
        prop_assert!((0..roots.len()).any(near), "{:?}", roots);
        return Ok(());
    };
    let nonzero = modes.eigenvalues().iter().map(|root| root.value);
    let nonzero = nonzero.filter(|z| z.norm() > 0.0);
    let start: Vec<Approximation<'_>> = nonzero.map(Approximation::of).collect();
    let found_at = inclusion::certify(system, &start, 4.0 * UNIT, f64::INFINITY);
    let (discs, _) = found_at.unwrap();
    let count: usize = discs.iter().map(|disc| disc.members.len()).sum();
    let ours: usize = found.iter().map(|disc| disc.members.len()).sum();
    prop_assert!(ours <= count);
    for disc in &found {
        let met = discs.iter().filter(|other| {
            let reach = (disc.bound + other.bound) * (1.0 + 1e-9);
            let real = (disc.real_bound + other.real_bound) * (1.0 + 1e-9);
            let apart = disc.value - other.value;
            apart.norm() <= reach && apart.re.abs() <= real
        });
        prop_assert_eq!(met.count(), 1, "{:?}", disc);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn agrees_with_the_determinant(
        masses in prop::collection::vec(0.5..3.0f64, 2..7),
        springs in prop::collection::vec(-2.0..2.0f64, 7),
        dashpots in prop::collection::vec((0usize..7, -3.0..1.0f64), 0..4),
        cross in prop::collection::vec((0usize..7, 0usize..7, -3.0..1.0f64), 0..3),
        ends in 0..3,
    ) {
        let n = masses.len();
        let mut springs: Vec<f64> = springs[..=n].iter().map(|x| 10f64.powf(*x)).collect();
        springs[n] = 0.0;
        if ends == 0 {
            springs[0] = 0.0;
        }
        let held = dashpots.iter().map(|(i, c)| (0, i % n + 1, 10f64.powf(*c)));
        let cross = cross.iter().filter(|(i, j, _)| i % n != j % n);
        let cross = cross.map(|(i, j, c)| (i % n + 1, j % n + 1, 10f64.powf(*c)));
        let system = network(&masses, &joined(n, &springs), &held.chain(cross).collect::<Vec<_>>());
        agree(&system)?;
    }

    #[test]
    fn unsymmetric_ones_agree_with_the_determinant(
        n in 2..7usize,
        masses in prop::collection::vec(0.5..3.0f64, 7),
        damping in prop::collection::vec(-0.25..0.25f64, 49),
        stiffness in prop::collection::vec(-1.0..1.0f64, 49),
    ) {
        let square = |entries: &[f64], diagonal: f64| Mat::from_fn(n, n, |i, j| {
            entries[i * n + j] + if i == j { diagonal } else { 0.0 }
        });
        let masses = Mat::from_fn(n, n, |i, j| if i == j { masses[i] } else { 0.0 });
        let (damping, stiffness) = (square(&damping, 0.25), square(&stiffness, 3.0));
        let system =
            System::from_matrices(masses.as_ref(), damping.as_ref(), stiffness.as_ref());
        agree(&system.unwrap())?;
    }
}
