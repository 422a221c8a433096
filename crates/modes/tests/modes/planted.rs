//! Systems built from chosen poles and shapes, so that M, C and K are exact in doubles.

use eigentone_modes::{Bounds, Modes, System};
use faer::Mat;
use proptest::prelude::*;

use crate::root::{Root, U, assert_roots};

/// Two poles that belong together, in units of 2^-20.
#[derive(Clone, Copy, Debug)]
enum Poles {
    /// −decay ± i·turn.
    Pair { decay: i32, turn: i32 },
    /// −first and −second.
    Real { first: i32, second: i32 },
}

const UNIT: f64 = 1.0 / 1_048_576.0;

impl Poles {
    /// c and k of s² + cs + k.
    fn quadratic(self) -> (f64, f64) {
        let at = |units: i32| f64::from(units) * UNIT;
        match self {
            Poles::Pair { decay, turn } => {
                (2.0 * at(decay), at(decay) * at(decay) + at(turn) * at(turn))
            }
            Poles::Real { first, second } => (at(first) + at(second), at(first) * at(second)),
        }
    }

    fn roots(self) -> [Root; 2] {
        let at = |units: i32| f64::from(units) * UNIT;
        match self {
            Poles::Pair { decay, turn } => {
                let root = Root::new(-at(decay), at(turn));
                [root, root.conjugate()]
            }
            Poles::Real { first, second } => {
                [Root::new(-at(first), 0.0), Root::new(-at(second), 0.0)]
            }
        }
    }
}

/// Row (or column) `from` is added `times` over to `to`.
type Shear = (usize, usize, i32);

/// A product of shears: whole numbers, determinant 1.
fn unimodular(n: usize, shears: &[Shear]) -> Mat<f64> {
    let mut matrix = Mat::<f64>::identity(n, n);
    for &(from, to, times) in shears {
        let (from, to) = (from % n, to % n);
        if from != to {
            for j in 0..n {
                let add = f64::from(times) * matrix[(from, j)];
                matrix[(to, j)] += add;
            }
        }
    }
    matrix
}

/// Its inverse: the shears undone.
fn inverse(n: usize, shears: &[Shear]) -> Mat<f64> {
    let undone: Vec<Shear> = shears.iter().rev().map(|&(a, b, t)| (a, b, -t)).collect();
    unimodular(n, &undone)
}

/// L·diag·R for each of M, C, K, with `coupling` above the diagonal of C.
fn plant(
    left: &Mat<f64>,
    right: &Mat<f64>,
    poles: &[Poles],
    coupling: impl Fn(usize, usize) -> f64,
) -> System {
    let n = poles.len();
    let around = |middle: Mat<f64>| left * middle * right;
    let quadratics: Vec<(f64, f64)> = poles.iter().map(|poles| poles.quadratic()).collect();
    let mass = around(Mat::identity(n, n));
    let damping = around(Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Equal => quadratics[i].0,
        std::cmp::Ordering::Less => coupling(i, j),
        std::cmp::Ordering::Greater => 0.0,
    }));
    let stiffness = around(Mat::from_fn(n, n, |i, j| {
        if i == j { quadratics[i].1 } else { 0.0 }
    }));
    System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref())
        .expect("a regular system")
}

fn roots(poles: &[Poles]) -> Vec<Root> {
    poles.iter().flat_map(|poles| poles.roots()).collect()
}

/// Poles near whole numbers, so that near-repeats and repeats are common.
fn poles() -> impl Strategy<Value = Poles> {
    let near_whole = |range: std::ops::Range<i32>| {
        (range, prop_oneof![3 => Just(0), 2 => -3..4]).prop_map(|(whole, off)| (whole << 20) + off)
    };
    prop_oneof![
        (near_whole(0..3), near_whole(1..4)).prop_map(|(decay, turn)| Poles::Pair { decay, turn }),
        (near_whole(1..4), near_whole(1..4))
            .prop_map(|(first, second)| Poles::Real { first, second }),
    ]
}

/// Each below 2^21 in size: products stay below 2^42 units², and whole matrices below 2^53.
fn shears(most: usize) -> impl Strategy<Value = Vec<Shear>> {
    prop::collection::vec((0usize..4, 0usize..4, -2i32..3), 0..most)
}

/// No two poles are equal, but some may be within a few times 2^-20.
fn all_differ(poles: &[Poles]) -> bool {
    let mut keys: Vec<(i32, i32)> = poles
        .iter()
        .flat_map(|poles| match *poles {
            Poles::Pair { decay, turn } => [(decay, turn), (decay, -turn)],
            Poles::Real { first, second } => [(first, 0), (second, 0)],
        })
        .collect();
    let count = keys.len();
    keys.sort_unstable();
    keys.dedup();
    keys.len() == count
}

/// At most two poles are close to each other or equal.
fn no_three_alike(poles: &[Poles]) -> bool {
    let all = roots(poles);
    all.iter().all(|root| {
        let near = |other: &&Root| {
            let (re, im) = ((root.re - other.re).to_f64(), (root.im - other.im).to_f64());
            re.hypot(im) < 0.5
        };
        all.iter().filter(near).count() <= 2
    })
}

/// The shape of a simple mode is the planted one up to a factor.
fn assert_shapes(modes: &Modes, poles: &[Poles], columns: &Mat<f64>) {
    let all = roots(poles);
    for mode in modes {
        let value = mode.eigenvalue().value;
        let distance =
            |root: &Root| (root.re.to_f64() - value.re).hypot(root.im.to_f64() - value.im);
        let mut near: Vec<usize> = (0..all.len()).collect();
        near.sort_by(|&a, &b| distance(&all[a]).total_cmp(&distance(&all[b])));
        if near.len() > 1 && distance(&all[near[1]]) < 1e-2 {
            continue;
        }
        let planted = columns.col(near[0] / 2);
        let shape = mode.shape();
        let most = (0..shape.len())
            .max_by(|&a, &b| {
                planted[a]
                    .abs()
                    .total_cmp(&planted[b].abs())
                    .then(b.cmp(&a))
            })
            .expect("a coordinate");
        for (i, entry) in shape.iter().enumerate() {
            let off = (entry - planted[i] / planted[most]).norm();
            assert!(off <= 1e4 * U, "shape at {value}: {off:e}");
        }
    }
}

/// A triple root −3, twice defective, beside pairs that coincide.
#[test]
fn a_double_root_beside_a_simple_one() {
    let whole = |first: i32, second: i32| Poles::Real {
        first: first << 20,
        second: second << 20,
    };
    let pair = Poles::Pair {
        decay: 0,
        turn: 1 << 20,
    };
    let poles = [pair, whole(3, 3), pair, whole(1, 3)];
    let right = unimodular(4, &[(3, 1, -1), (1, 0, -2)]);
    let system = plant(&right.transpose().to_owned(), &right, &poles, |_, _| 0.0);
    let modes = system.modes().expect("modes");
    assert_eq!(modes.bounds(), Bounds::Proven);
    assert_roots(&roots(&poles), &modes, 4.0, "symmetric");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Congruent to uncoupled oscillators: M = XᵀX, C = XᵀΓX, K = XᵀΛX.
    #[test]
    fn symmetric_systems(poles in prop::collection::vec(poles(), 1..5), shears in shears(5)) {
        let n = poles.len();
        let right = unimodular(n, &shears);
        let system = plant(&right.transpose().to_owned(), &right, &poles, |_, _| 0.0);
        let modes = system.modes().expect("modes");
        prop_assert_eq!(modes.bounds(), Bounds::Proven);
        assert_roots(&roots(&poles), &modes, 4.0, "symmetric");
        assert_shapes(&modes, &poles, &inverse(n, &shears));
    }

    /// Equivalent to uncoupled oscillators, but not symmetric.
    #[test]
    fn systems_without_symmetry(
        poles in prop::collection::vec(poles(), 1..5),
        left in shears(4),
        right in shears(4),
    ) {
        prop_assume!(all_differ(&poles) || no_three_alike(&poles));
        let n = poles.len();
        let system = plant(&unimodular(n, &left), &unimodular(n, &right), &poles, |_, _| 0.0);
        let modes = system.modes().expect("modes");
        prop_assert_eq!(modes.bounds(), Bounds::Proven);
        assert_roots(&roots(&poles), &modes, 4.0, "not symmetric");
        assert_shapes(&modes, &poles, &inverse(n, &right));
    }

    /// Equivalent to a triangular system: no modal coordinates, and defective where poles repeat.
    #[test]
    fn triangular_systems(
        poles in prop::collection::vec(poles(), 1..4),
        left in shears(4),
        right in shears(4),
        coupling in -3i32..4,
    ) {
        prop_assume!(no_three_alike(&poles));
        let n = poles.len();
        let system = plant(
            &unimodular(n, &left),
            &unimodular(n, &right),
            &poles,
            |i, j| f64::from(coupling) + (j - i) as f64,
        );
        let modes = system.modes().expect("modes");
        prop_assert_eq!(modes.bounds(), Bounds::Proven);
        assert_roots(&roots(&poles), &modes, 4.0, "triangular");
    }
}
