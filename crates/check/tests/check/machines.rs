//! Machines drawn at random: points on masses and supports, nodes without mass, forms that cancel, coefficients that are
//! twenty powers of ten apart. What is said of their roots holds against the exact determinant, and what is said of their
//! motions against the reference in more digits and against each other.

use eigentone_check::Reference;
use eigentone_modes::{Bounds, ElementKind, GROUND, ModesError, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, HalfSine, Harmonic, Hold, Impulse, Load, Polynomial, Quantity, Ramp,
    Response, ResponseMethod, Samples, State, Step, Trajectory, Versine, methods,
};
use proptest::collection::vec;
use proptest::prelude::*;

use super::coincidence::fault;

/// What a machine is made of. Numbers of names are taken modulo how many there are.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) masses: Vec<f64>,
    pub(super) supports: usize,
    pub(super) points: Vec<(Vec<(usize, f64)>, f64)>,
    pub(super) elements: Vec<(bool, usize, usize, f64)>,
}

impl Drawn {
    /// `None` where it is refused.
    pub(super) fn system(&self) -> Option<System> {
        let mut names: Vec<String> = (0..self.masses.len()).map(|i| format!("m{i}")).collect();
        names.extend((0..self.supports).map(|i| format!("s{i}")));
        let moving = names.len();
        names.extend((0..self.points.len()).map(|i| format!("p{i}")));
        names.push(GROUND.to_owned());
        let mut builder = System::builder();
        for (name, mass) in names.iter().zip(&self.masses) {
            builder = builder.mass(name, *mass);
        }
        for name in &names[self.masses.len()..moving] {
            builder = builder.support(name);
        }
        for (name, (moves, mass)) in names[moving..].iter().zip(&self.points) {
            let moves = moves.iter().map(|(i, times)| (&names[i % moving], *times));
            builder = builder.point(name, moves, *mass);
        }
        for (spring, a, b, coefficient) in &self.elements {
            let [a, b] = [a, b].map(|i| &names[i % names.len()]);
            builder = match (a == b, spring) {
                (true, _) => builder,
                (_, true) => builder.spring(a, b, *coefficient),
                (_, false) => builder.damper(a, b, *coefficient),
            };
        }
        builder.build().ok()
    }
}

fn coefficients() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-8.0..12.0f64).prop_map(|power| 10f64.powf(power)),
        4 => (1u8..9).prop_map(f64::from),
        1 => -3.0..0.0f64,
    ]
}

pub(super) fn machines() -> impl Strategy<Value = Drawn> {
    let mass = || prop_oneof![2 => Just(0.0), 3 => (1u8..4).prop_map(f64::from), 3 => 0.1..1e3f64];
    let times = || {
        let simple = prop::sample::select(vec![1.0, -1.0, 0.5, 0.1, 0.6, 0.8, -1.2, 3.0]);
        prop_oneof![5 => simple, 2 => -2.0..2.0f64, 1 => Just(1e-5)]
    };
    let moves = vec((0..16usize, times()), 1..4);
    let point_mass = prop_oneof![3 => Just(0.0), 1 => 0.1..10.0f64];
    let elements = (any::<bool>(), 0..32usize, 0..32usize, coefficients());
    let sizes = prop_oneof![3 => 1..5usize, 1 => 5..13usize];
    (
        sizes.prop_flat_map(move |n| vec(mass(), n)),
        0..3usize,
        vec((moves, point_mass), 0..5),
        vec(elements, 1..16),
    )
        .prop_map(|(masses, supports, points, elements)| Drawn {
            masses,
            supports,
            points,
            elements,
        })
}

fn examine(drawn: &Drawn) -> Result<(), TestCaseError> {
    let Some(system) = drawn.system() else {
        return Ok(());
    };
    for kind in [ElementKind::Spring, ElementKind::Damper] {
        let count = drawn.elements.iter().filter(|element| {
            let names = system.len() + system.points().len() + system.supports().len() + 1;
            element.0 == (kind == ElementKind::Spring) && element.1 % names != element.2 % names
        });
        prop_assert_eq!(system.elements(kind).len(), count.count());
    }
    let structure = system.structure();
    if structure.finite_roots() == Some(0) {
        return Ok(());
    }
    let Ok(truth) = Reference::with_digits(40).modes(&system) else {
        return Ok(());
    };
    for precision in [Precision::default(), Precision::Double] {
        let modes = match system.modes_to(precision) {
            Ok(modes) => modes,
            // Frequencies may lie too far apart for doubles.
            Err(ModesError::OutOfRange { .. }) if precision == Precision::Double => continue,
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        if modes.bounds() == Bounds::Proven || precision == Precision::Double {
            prop_assert_eq!(
                fault(&truth, &modes),
                None,
                "{}: {:?}",
                modes.plan(),
                modes.as_slice()
            );
        }
    }
    if structure.is_passive() {
        let growing = truth
            .eigenvalues()
            .iter()
            .find(|root| root.re.nearest() > 0.0);
        prop_assert!(growing.is_none(), "{growing:?}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_said_of_their_roots_holds(drawn in machines()) {
        examine(&drawn)?;
    }
}

/// What moves a machine: which name, which quantity if it is a support, what course, how large and from when.
type Driving = (usize, usize, usize, f64, f64);

fn course(kind: usize, size: f64, start: f64) -> Load {
    let values = vec![0.0, size, -0.5 * size, 2.0 * size, size];
    let samples = |hold| Samples {
        step: 0.25,
        values: values.clone(),
        hold,
    };
    match kind {
        0 => Step::of(size).starting_at(start).into(),
        1 => Ramp::of(size).starting_at(start).into(),
        2 => Harmonic::of(size, 3.0 + start).into(),
        3 => HalfSine::of(size, 0.6).starting_at(start).into(),
        4 => Versine::of(size, 0.9).starting_at(start).into(),
        5 => samples(Hold::First).into(),
        6 => samples(Hold::Zero).into(),
        7 => Polynomial::of([0.0, size, -size]).starting_at(start).into(),
        _ => Impulse::of(size).at(start).into(),
    }
}

fn drivings() -> impl Strategy<Value = Vec<Driving>> {
    let size = prop_oneof![Just(1.0), 0.1..10.0f64];
    let start = prop_oneof![Just(0.5), 0.0..1.5f64];
    vec((0..16usize, 0..3usize, 0..9usize, size, start), 1..4)
}

/// Whether no value of one motion lies farther from that of the other than both bounds allow; where there is none, nothing
/// is said.
fn far_apart(one: &Trajectory, other: &Trajectory) -> Option<String> {
    let kinds = [
        (
            [one.displacement(), other.displacement()],
            [one.displacement_bound(), other.displacement_bound()],
        ),
        (
            [one.velocity(), other.velocity()],
            [one.velocity_bound(), other.velocity_bound()],
        ),
    ];
    let accelerations = one.acceleration().zip(other.acceleration());
    let accelerations = accelerations.map(|(first, second)| {
        let bounds = [one.acceleration_bound(), other.acceleration_bound()];
        ([first, second], bounds)
    });
    for k in 0..one.len() {
        let all = kinds.iter().chain(&accelerations);
        for (kind, (values, bounds)) in ["x", "v", "a"].into_iter().zip(all) {
            let [Some(first), Some(second)] = bounds.map(|bounds| bounds[k]) else {
                continue;
            };
            for i in 0..values[0].nrows() {
                let off = (values[0][(i, k)] - values[1][(i, k)]).abs();
                if off > (first + second) * (1.0 + 1e-9) {
                    return Some(format!(
                        "{kind} {i} at {k}: {off:e} for {first:e} and {second:e}"
                    ));
                }
            }
        }
        for row in 0..one.outputs().count() {
            let bounds = [one, other].map(|motion| motion.output_bound(row)[k]);
            let [Some(first), Some(second)] = bounds else {
                continue;
            };
            let off = (one.output(row)[k] - other.output(row)[k]).abs();
            if off > (first + second) * (1.0 + 1e-9) {
                return Some(format!("sum at {k}: {off:e} for {first:e} and {second:e}"));
            }
        }
    }
    None
}

fn examine_motion(drawn: &Drawn, driven: &[Driving]) -> Result<(), TestCaseError> {
    let Some(system) = drawn.system() else {
        return Ok(());
    };
    let (names, supports) = (system.names(), system.supports());
    let points = system.points().iter().map(|point| &point.name);
    let loaded: Vec<&String> = names.iter().chain(points).collect();
    let mut ask = Response::of(&system).every(0.25).until(2.0);
    if let Some(first) = (0..system.len()).find(|i| system.masses()[*i] > 0.0) {
        ask = ask.from(
            State::at_rest()
                .displace(&names[first], 0.3)
                .push(&names[first], -1.0),
        );
    }
    for &(name, quantity, kind, size, start) in driven {
        let course = course(kind, size, start);
        let quantities = [
            Quantity::Displacement,
            Quantity::Velocity,
            Quantity::Acceleration,
        ];
        ask = match name.checked_rem(supports.len()) {
            Some(support) if name % 3 > 0 && kind < 8 => {
                ask.motion(&supports[support], quantities[quantity], course)
            }
            _ => ask.load(loaded[name % loaded.len()], course),
        };
    }
    let ends = [loaded[0], loaded[loaded.len() - 1]];
    let sum = ends.map(|name| (Quantity::Displacement, name.as_str(), 1.0));
    let mut ask = ask.sum("sum", [sum[0], (Quantity::Velocity, ends[1], -0.5)]);
    if driven.len() % 2 == 1 {
        ask = ask.with_acceleration();
    }
    let Ok(problem) = ask.problem() else {
        return Ok(());
    };
    let proven = ByCertifiedExponential.run(&problem).ok();
    if let Some(proven) = &proven
        && system.len() <= 3
        && let Ok(truth) = Reference::with_digits(25).response(&problem)
    {
        for k in 0..proven.len() {
            for (truth, values, bounds) in [
                (
                    truth.displacement(k),
                    proven.displacement(),
                    proven.displacement_bound(),
                ),
                (
                    truth.velocity(k),
                    proven.velocity(),
                    proven.velocity_bound(),
                ),
            ] {
                let Some(bound) = bounds[k] else { continue };
                for (i, truth) in truth.iter().enumerate() {
                    let off = truth.minus(values[(i, k)]).abs();
                    // What the reference does not distinguish from 0 is known to its radius.
                    let room = bound + truth.radius();
                    prop_assert!(off <= room, "{} at {}: {:e} for {:e}", i, k, off, room);
                }
            }
        }
    }
    for method in methods() {
        if method.name() == ByCertifiedExponential.name() || method.refuses(&problem).is_some() {
            continue;
        }
        if let (Ok(motion), Some(proven)) = (method.run(&problem), &proven) {
            prop_assert_eq!(far_apart(&motion, proven), None, "{}", method.name());
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        // Proofs of motions take longer than those of roots.
        cases: ProptestConfig::default().cases / 4,
        ..ProptestConfig::default()
    })]

    #[test]
    fn what_is_said_of_their_motion_holds(drawn in machines(), driven in drivings()) {
        examine_motion(&drawn, &driven)?;
    }
}

/// Of the springs on a node without mass less than a 3e5th is left when it is eliminated: what rounds in the state matrix are
/// units of the springs.
#[test]
fn what_cancels_in_the_state_matrix_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0, 1.0],
        supports: 0,
        points: Vec::new(),
        elements: vec![(true, 0, 1, 314_561.5), (true, 0, 2, 1.0)],
    };
    // A step on the node without mass, and at once all accelerations.
    examine_motion(&drawn, &[(0, 0, 0, 1.0, 0.5)]).expect("right within its bounds");
}

/// Of the dampers on two nodes without mass less than a 1e7th is left when the stiff one is eliminated, and forces act through
/// that.
#[test]
fn what_cancels_in_the_effect_of_forces_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0, 0.0],
        supports: 1,
        points: vec![(vec![(0, 1.0)], 0.0), (vec![(4, -1.0)], 0.0)],
        elements: vec![
            (false, 3, 4, 14_045_888.593_804_67),
            (false, 17, 3, 1.0),
            (true, 8, 10, 1.0),
            (true, 1, 15, 1.0),
        ],
    };
    examine_motion(&drawn, &[(9, 0, 1, 1.0, 0.5)]).expect("right within its bounds");
    // And so do what dampers on a support make of its motion.
    let drawn = Drawn {
        masses: vec![0.0, 0.0],
        supports: 2,
        points: vec![
            (vec![(4, 1.0)], 0.0),
            (vec![(9, 1.0), (11, 1.0)], 0.0),
            (vec![(0, 1.0)], 0.0),
            (vec![(0, -1.0)], 0.0),
        ],
        elements: vec![
            (true, 6, 1, 1.0),
            (true, 7, 0, 1.0),
            (false, 5, 4, 267_404_430.094_846_52),
            (false, 6, 25, 1.0),
        ],
    };
    examine_motion(&drawn, &[(13, 0, 2, 1.0, 0.5)]).expect("right within its bounds");
}

/// The shapes of this machine are so alike that an elimination leaves more of T T⁻¹ − 1 than products round.
#[test]
fn what_shapes_take_up_of_the_start_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0, 1.0, 781.818_514_340_313_3, 0.0],
        supports: 1,
        points: vec![(vec![(8, 0.8)], 0.0)],
        elements: vec![
            (true, 23, 8, 27_201_728.443_418_83),
            (false, 12, 10, 862_349_632.966_127_3),
            (true, 13, 0, 1.524_861_252_406_294_6e-8),
            (true, 12, 22, 40_141_991.396_002_03),
            (false, 8, 16, 22_996.327_696_044_7),
            (true, 5, 24, 1.0),
        ],
    };
    examine_motion(&drawn, &[(1, 0, 0, 1.0, 0.5)]).expect("right within its bounds");
}

/// Beside a spring of 1e11 doubles lose all that holds this machine: nothing is known of what rounding does to it.
#[test]
fn what_is_singular_in_doubles_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0, 1.0, 1.0],
        supports: 0,
        points: vec![
            (vec![(11, 1e-5)], 0.0),
            (vec![(9, -1.0), (9, 0.5)], 8.992_858_156_707_658),
        ],
        elements: vec![
            (true, 19, 28, 1.009_042_618_664_204_4e-7),
            (true, 24, 23, 7.0),
            (false, 10, 27, 58_294.431_246_181_81),
            (true, 5, 15, 8.0),
            (false, 7, 4, 2.0),
            (true, 11, 10, 8.0),
            (true, 2, 19, 175_620_054_514.044_6),
            (true, 0, 4, 28_634_543.133_192_97),
        ],
    };
    let driven = [(14, 1, 5, 1.0, 0.9771400731783266), (12, 2, 5, 1.0, 0.5)];
    examine_motion(&drawn, &driven).expect("right within its bounds");
}

/// A force that is integrated, as a polynomial is, does 1e-12 to the one node without mass.
#[test]
fn what_is_integrated_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0],
        supports: 0,
        points: Vec::new(),
        elements: vec![
            (false, 7, 8, 616_179_614_145.124_6),
            (true, 1, 8, 3_735_519_974.137_522),
        ],
    };
    let driven = [(0, 0, 7, 1.0, 0.5), (0, 0, 7, 1.0, 0.5435778332624064)];
    examine_motion(&drawn, &driven).expect("right within its bounds");
}

/// What a versine moves just after it begins is 1e-4 of its height; its constant and its cosine are half of it each.
#[test]
fn what_has_just_begun_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![0.0],
        supports: 0,
        points: vec![(vec![(0, -1.0)], 0.0)],
        elements: vec![(true, 0, 2, 1.0)],
    };
    let pulse = (1, 0, 4, 1.0, 0.24826972264295902);
    examine_motion(&drawn, &[pulse]).expect("right within its bounds");
}

/// A slow relaxation through a lever of 1e-5 beside a stiff spring: what Newton's method in double-double leaves of its
/// root shows in its steps alone.
#[test]
fn a_slow_root_beside_a_stiff_spring_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![1.0, 0.0, 1.0],
        supports: 0,
        points: vec![
            (vec![(10, 0.5)], 0.1),
            (vec![(0, 1.0)], 0.0),
            (vec![(9, 1e-5)], 0.0),
            (vec![(4, 0.6)], 0.0),
        ],
        elements: vec![
            (true, 18, 14, 4802857324.997414),
            (false, 1, 2, 1.0),
            (false, 5, 17, 1.0),
        ],
    };
    examine(&drawn).expect("right within its bounds");
}

/// A slow motion beside a free one and a fast one, which rounding mixes by 4e-8: its damping errs by the square of that.
#[test]
fn a_slow_shape_with_a_free_motion_in_it_is_within_its_estimate() {
    let drawn = Drawn {
        masses: vec![1.0, 0.0, 0.0, 1.0],
        supports: 2,
        points: vec![
            (vec![(3, 1.0)], 0.0),
            (vec![(2, 1.0), (6, 1.0)], 9.733209200902369),
            (vec![(0, 1.0)], 0.0),
            (vec![(7, 1.0), (6, -0.8009361761651769)], 0.1),
        ],
        elements: vec![
            (true, 4, 7, 1.512221599523195e-8),
            (false, 15, 29, 1.058943146109393e-8),
            (true, 0, 9, 1.0),
        ],
    };
    examine(&drawn).expect("right within its bounds");
}
