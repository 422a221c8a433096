//! Every error that a call of the library can return, with a call that returns it.

use eigentone::check::{
    ChainEnds, DormandPrince5, ExactMass, Integrator, Limit, MassSpringDamper, Reference,
    UniformChain,
};
use eigentone::design::{Campbell, Grid, Range, fit, minimise};
use eigentone::modes::{
    Beam, BeamEnd, Design, Eigenpair, FirstOrder, Frequency, GROUND, MatrixKind, ModeSolver,
    ModesWorkspace, Parameter, Participation, Precision, Sensitivity, SparseDynamicStiffness,
    SparseModes, SpringFactor, System, examine_pairs, modal_assurance, phase_collinearity,
};
use eigentone::response::{
    Baseline, ByCertifiedExponential, BySuperposition, Combination, Exponential, FrequencyResponse,
    HalfSine, Harmonic, Hold, Impulse, Load, ModalTruncation, Noise, Output, Pade13, Polynomial,
    Problem, Quantity, Ramp, RandomVibration, Response, ResponseSpectrum, Samples, State,
    StateSpace, SteadyState, Step, Sum, Sweep, Versine, expm, receptance,
};
use eigentone::switching::{Friction, Impact, Period, Switch, Switching};
use eigentone::tables::{ModeTable, ResponseTable};
use faer::sparse::SparseColMat;
use faer::{Mat, mat};
use num_complex::Complex;

use super::listing::Listing;

pub const ENUMS: [(&str, &str); 29] = [
    ("crates/design/src/campbell.rs", "CampbellError"),
    ("crates/design/src/minimax.rs", "OptimumError"),
    ("crates/design/src/fit.rs", "FitError"),
    ("crates/design/src/range.rs", "RangeError"),
    ("crates/design/src/grid.rs", "GridError"),
    ("crates/design/src/follower.rs", "FollowError"),
    ("crates/switching/src/error.rs", "SwitchingError"),
    ("crates/switching/src/switch.rs", "SwitchFault"),
    ("crates/switching/src/cycle_error.rs", "CycleError"),
    ("crates/modes/src/system/builder.rs", "BuildError"),
    ("crates/modes/src/solver/mode_solver.rs", "ModesError"),
    ("crates/modes/src/first_order/error.rs", "FirstOrderError"),
    ("crates/modes/src/sparse/error.rs", "SparseError"),
    ("crates/modes/src/participation.rs", "ParticipationError"),
    ("crates/modes/src/assurance.rs", "AssuranceError"),
    ("crates/modes/src/sensitivity.rs", "SensitivityError"),
    ("crates/modes/src/sweep/design.rs", "DesignError"),
    ("crates/response/src/problem/error.rs", "ResponseError"),
    (
        "crates/response/src/frequency_response/harmonic_motion.rs",
        "SteadyStateError",
    ),
    (
        "crates/response/src/frequency_response/question.rs",
        "FrequencyError",
    ),
    (
        "crates/response/src/state_space/error.rs",
        "StateSpaceError",
    ),
    (
        "crates/response/src/response_spectrum/error.rs",
        "SpectrumError",
    ),
    ("crates/response/src/sweep/mod.rs", "SweepError"),
    ("crates/response/src/exponential/error.rs", "ExpmError"),
    ("crates/check/src/reference/error.rs", "ReferenceError"),
    ("crates/check/src/closed_form/digits.rs", "ClosedFormError"),
    (
        "crates/check/src/closed_form/mass_spring_damper.rs",
        "OneMassError",
    ),
    ("crates/eigentone/tables/error.rs", "TableError"),
    ("crates/response/src/problem/load.rs", "LoadError"),
];

const LEFT_OUT: [(&str, &str); 33] = [
    (
        "CampbellError::Modes",
        "passes on a `ModesError`, all of which are shown or named here",
    ),
    (
        "CampbellError::System",
        "no rotor is known that is singular at some speed alone",
    ),
    (
        "CampbellError::Follow",
        "passes on a `FollowError`, all of which are named here",
    ),
    (
        "FollowError::NoDesign",
        "is what a program says itself, of a design that it cannot solve",
    ),
    (
        "FollowError::Count",
        "takes a path of designs on which a mass vanishes",
    ),
    (
        "FollowError::SomeModes",
        "takes modes of which some were left out",
    ),
    (
        "SwitchFault::Massless",
        "is found when the motion is, as the fault of a `SwitchingError::Switch`",
    ),
    (
        "SwitchFault::BeyondGap",
        "is found when the motion is, as the fault of a `SwitchingError::Switch`",
    ),
    (
        "SwitchingError::Response",
        "passes on a `ResponseError`, all of which are shown or named here",
    ),
    (
        "SwitchingError::Undecided",
        "several dampers that share out what holds a body still are beyond a table",
    ),
    (
        "StateSpaceError::NotShownStationary",
        "is said of roots of which no digits in reach show on which side of the axis they are",
    ),
    (
        "SwitchingError::Endless",
        "takes half a million events within a billionth of the time asked for",
    ),
    (
        "CycleError::Switching",
        "passes on a `SwitchingError`, all of which are shown or named here",
    ),
    (
        "CycleError::Halted",
        "passes on a `SwitchingError` of a motion that the search tries",
    ),
    (
        "CycleError::NoMultipliers",
        "is said of a damper between bodies that rest beside a periodic motion of others",
    ),
    (
        "CycleError::Lost",
        "is said of motions that do not come near a periodic one, as chaotic ones",
    ),
    (
        "SwitchingError::OutOfRange",
        "takes a stop of 1e308 N/m that a mass of 1e-5 kg presses on",
    ),
    (
        "SwitchingError::Stuck",
        "no system is known that is regular and not distinguished from a singular one",
    ),
    (
        "FrequencyError::Sparse",
        "passes on a `SparseError`, all of which are shown or named here",
    ),
    (
        "ModesError::NoConvergence",
        "no system is known whose iteration does not converge",
    ),
    (
        "ModesError::FirstOrder",
        "passes on a `FirstOrderError`, all of which are shown",
    ),
    (
        "SparseError::TooDense",
        "takes a factor of hundreds of millions of entries",
    ),
    (
        "SparseError::TooManyParts",
        "takes hundreds of loose parts beside a mass matrix that is not diagonal",
    ),
    (
        "SparseError::Projected",
        "passes on a `ModesError` of the small equation between the shapes found",
    ),
    (
        "SparseError::NoConvergence",
        "takes modes that lie close together beside their distance from the frequency to look near",
    ),
    (
        "SparseError::OutOfRange",
        "takes matrices that no shift makes regular enough for double-double, or whose factors leave the range of doubles",
    ),
    (
        "SteadyStateError::Undecided",
        "takes a frequency that agrees with a natural one to hundreds of digits and is none",
    ),
    (
        "StateSpaceError::FirstOrder",
        "passes on a `FirstOrderError`, all of which are shown",
    ),
    (
        "StateSpaceError::TooMuchWork",
        "takes a thousand coordinates",
    ),
    (
        "StateSpaceError::Lost",
        "takes a growth that uses up a thousand digits",
    ),
    (
        "ExpmError::Uncertain",
        "takes a matrix of hundreds of rows that is far from normal",
    ),
    (
        "ReferenceError::TooManyBits",
        "takes roots nearer to each other than 2^-16384",
    ),
    (
        "ReferenceError::UnknownLoad",
        "every load that there is now is known",
    ),
];

/// Masses in a row, each on a spring of 1 N/m to the one before, the first one to the ground.
fn row(masses: &[f64]) -> System {
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(format!("m{i}"), *mass);
    }
    for i in 1..masses.len() {
        builder = builder.spring(format!("m{}", i - 1), format!("m{i}"), 1.0);
    }
    builder.spring(GROUND, "m0", 1.0).build().expect("a system")
}

/// One mass called m0.
fn single(mass: f64, damping: f64, stiffness: f64) -> System {
    let builder = System::builder().mass("m0", mass);
    let builder = builder.damper(GROUND, "m0", damping);
    let builder = builder.spring(GROUND, "m0", stiffness);
    builder.build().expect("a system")
}

/// M, C, K.
fn matrices(m: [[f64; 2]; 2], c: [[f64; 2]; 2], k: [[f64; 2]; 2]) -> System {
    let dense = |m: [[f64; 2]; 2]| Mat::from_fn(2, 2, |i, j| m[i][j]);
    let (m, c, k) = (dense(m), dense(c), dense(k));
    System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system")
}

/// A force held between samples.
fn samples(step: f64, values: Vec<f64>) -> Samples {
    Samples {
        step,
        values,
        hold: Hold::Zero,
    }
}

macro_rules! list {
    ($listing:ident: $($call:expr;)*) => {
        $($listing.call(stringify!($call), $call);)*
    };
}

#[test]
fn every_error_of_the_library_is_listed() {
    let mut listing = Listing::headed(["call", "message"]);
    build_errors(&mut listing);
    mode_errors(&mut listing);
    response_errors(&mut listing);
    switching_errors(&mut listing);
    design_errors(&mut listing);
    sweep_errors(&mut listing);
    check_errors(&mut listing);
    let table = listing.finish(&ENUMS, &LEFT_OUT);
    super::page::assert_shown("errors.md", "library", &table);
}

fn design_errors(listing: &mut Listing) {
    let range = |text: &str| text.parse::<Range>();
    let pair = || vec![range("1,2").expect("a range")];
    let wide = || vec![range("0:1:10000000").expect("a range"); 3];
    let rotor = |masses: [f64; 2], forces: f64| {
        let gyroscopic = mat![[0.0, forces], [-forces, 0.0]];
        let builder = System::builder().mass("y", masses[0]).mass("z", masses[1]);
        let builder = builder.spring(GROUND, "y", 4.0).spring(GROUND, "z", 4.0);
        let builder = builder.matrix(MatrixKind::Damping, gyroscopic.as_ref());
        builder.build().expect("a rotor")
    };
    let disc = rotor([1.0, 1.0], 0.5);
    list! { listing:
        range("1:2");
        range("1:x:3");
        range("1:2:1");
        range("0:1:3:log");
        range("-1e308:1e308:3");
        Grid::new(Vec::new());
        Grid::new(wide());
        Grid::new(pair()).and_then(|grid| grid.part(3, 2));
        Campbell::of(&disc).over(&[]);
        Campbell::of(&disc).over(&[2.0, 1.0]);
        Campbell::of(&disc).given_at(0.0).over(&[0.0, 1.0]);
        Campbell::of(&rotor([1.0, 1.0], 1e300)).over(&[0.0, 1e10]);
        Campbell::of(&rotor([1.0, 0.0], 0.5)).over(&[0.0, 1.0]);
        minimise(&[], |_| None);
        minimise(&[(2.0, 1.0)], |_| None);
        minimise(&[(1.0, 2.0)], |_| None);
        fit(&[], false, |_| None);
        fit(&[0.0], false, |_| None);
        fit(&[1.0], false, |_| None);
        fit(&[1.0], false, |_| Some(Vec::new()));
    }
}

fn to_a_hundred_seconds(response: Response<'_>) -> Problem<'_> {
    let problem = response.every(1.0).until(100.0).problem();
    problem.expect("a problem")
}

fn switching_errors(listing: &mut Listing) {
    let held = single(1.0, 0.0, 4.0);
    let stiff = System::builder().mass("m0", 1.0).mass("m1", 1.0);
    let stiff = stiff.spring(GROUND, "m1", 1e20).build().expect("a system");
    let friction = |a: &str, b: &str, force: f64| {
        Switch::Friction(Friction {
            between: [a.to_owned(), b.to_owned()],
            force,
            static_force: force,
        })
    };
    let wall = |gap: f64| {
        Switch::Impact(Impact {
            between: [GROUND.to_owned(), "m0".to_owned()],
            gap,
            restitution: 0.5,
        })
    };
    let jaws = System::builder().mass("m0", 1.0).support("jaw");
    let jaws = jaws.build().expect("a system");
    let jaw = || {
        Switch::Impact(Impact {
            between: ["jaw".to_owned(), "m0".to_owned()],
            gap: 2.0,
            restitution: 0.0,
        })
    };
    let press = || {
        let problem = Response::of(&jaws).motion("jaw", Quantity::Displacement, Ramp::of(-1.0));
        let problem = problem.every(1.0).until(5.0).problem().expect("a problem");
        let floor = Switch::Impact(Impact {
            between: ["m0".to_owned(), GROUND.to_owned()],
            gap: 0.5,
            restitution: 0.0,
        });
        Switching::new(&problem, vec![jaw(), floor])?.run()
    };
    let run = |system: &System, switches: Vec<Switch>| {
        let problem = Response::of(system).every(1.0).until(1e3).problem();
        let problem = problem.expect("a problem");
        Switching::new(&problem, switches)?.run()
    };
    let cycle = |problem: &Problem<'_>, period: Period| {
        let switching = Switching::new(problem, Vec::new())?;
        switching.limit_cycle(period)
    };
    let rubbing = |problem: &Problem<'_>, period: Period| {
        let switching = Switching::new(problem, vec![friction(GROUND, "m0", 1.0)])?;
        switching.limit_cycle(period)
    };
    let damped = single(1.0, 0.5, 4.0);
    let pushed = to_a_hundred_seconds(Response::of(&damped).load("m0", Harmonic::of(1.0, 3.0)));
    let free = System::builder().mass("m0", 1.0).build().expect("a system");
    let unheld = to_a_hundred_seconds(Response::of(&free));
    list! { listing:
        friction(GROUND, "m1", 1.0).check(&held);
        friction("m0", "m0", 1.0).check(&held);
        friction(GROUND, "m0", -1.0).check(&held);
        run(&held, vec![wall(-0.1)]);
        run(&held, vec![wall(0.0), wall(0.0)]);
        press();
        run(&stiff, vec![friction(GROUND, "m0", 0.0)]);
        cycle(&pushed, Period::Seconds(0.0));
        cycle(&pushed, Period::Seconds(2.0));
        cycle(&pushed, Period::Free);
        rubbing(&unheld, Period::Free);
        cycle(&unheld, Period::Cycles(1));
        cycle(&unheld, Period::Seconds(2.0));
    }
}

fn build_errors(listing: &mut Listing) {
    let kind = MatrixKind::Stiffness;
    let wide = mat![[1.0, 0.0]];
    let infinite = mat![[f64::INFINITY]];
    let vast = SparseColMat::<usize, f64>::try_new_from_triplets(10_000_001, 10_000_001, &[]);
    let vast = vast.expect("it has no entries");
    let one = System::builder().mass("m", 1.0);
    let free = System::builder().mass("m", 0.0);
    list! { listing:
        System::builder().build();
        System::builder().sparse_matrix(kind, vast).build();
        System::builder().mass("", 1.0).build();
        System::builder().mass(GROUND, 1.0).build();
        one.clone().mass("m", 2.0).build();
        System::builder().mass("m", f64::NAN).build();
        one.clone().spring(GROUND, "m", f64::INFINITY).build();
        one.clone().spring(GROUND, "n", 1.0).build();
        one.clone().damper("m", "m", 1.0).build();
        System::builder().matrix(kind, wide.as_ref()).build();
        System::builder().matrix(kind, infinite.as_ref()).build();
        one.clone().spring(GROUND, "m", f64::MAX).spring(GROUND, "m", f64::MAX).build();
        free.build();
    }
    let point = |moves: &[(&str, f64)]| one.clone().point("p", moves.iter().copied(), 0.0);
    let follower = || one.clone().support("s").spring("m", "s", 1.0);
    let twins = || {
        let masses = System::builder().mass("a", 1.0).mass("b", 1.0);
        masses.spring(GROUND, "a", 1.0).spring(GROUND, "b", 1.0)
    };
    let row = (0..201).fold(System::builder(), |builder, i| {
        let name = format!("m{i}");
        builder.mass(&name, 1.0).spring(GROUND, &name, 1.0)
    });
    let beam = Beam {
        name: "mast".to_owned(),
        length: 2.0,
        elements: 4,
        flexural_rigidity: 100.0,
        mass_per_length: 1.2,
        ends: [BeamEnd::Clamped, BeamEnd::Free],
        lumped: false,
    };
    let [mut short, mut pointlike] = [beam.clone(), beam];
    (short.length, pointlike.length) = (0.0, 1e-200);
    list! { listing:
        one.clone().support("m").build();
        point(&[]).build();
        point(&[("n", 1.0)]).build();
        point(&[("p", 1.0)]).build();
        point(&[("q", 1.0)]).point("q", [("m", 1.0)], 0.0).build();
        point(&[("m", f64::NAN)]).build();
        point(&[("m", 1e-200)]).spring("p", GROUND, 1.0).build();
        one.clone().spring(GROUND, "m", 1.0).named("").build();
        System::builder().beam(short).build();
        System::builder().beam(pointlike).build();
        one.clone().rayleigh(f64::NAN, 0.0, None).build();
        one.clone().rayleigh(1e-300, 0.0, None).build();
        follower().rayleigh(1.0, 0.0, Some("m")).build();
        follower().mass("free", 1.0).damper("m", GROUND, 1.0).spring("m", GROUND, 1.0).rayleigh(1.0, 0.0, Some("s")).build();
        row.clone().support("s").spring("m0", "s", 1.0).rayleigh(1.0, 0.0, Some("s")).build();
        row.modal_damping([0.1], None).build();
        one.clone().modal_damping([], None).build();
        one.clone().modal_damping([0.1, 0.2], None).build();
        one.clone().spring(GROUND, "m", -1.0).modal_damping([0.1], None).build();
        twins().modal_damping([0.1, 0.2], None).build();
    }
}

fn mode_errors(listing: &mut Listing) {
    let unit = [[1.0, 0.0], [0.0, 1.0]];
    let zero = [[0.0; 2]; 2];
    let one = row(&[1.0]);
    let pair = row(&[1.0, 1.0]);
    let large = row(&[1.0; 5000]);
    let far_apart = single(1e300, 0.0, 5e-324);
    let too_fast = single(5e-324, 0.0, 1e308);
    let apart = System::builder().mass("m0", 1.0).mass("m1", 1.0);
    let apart = apart.spring(GROUND, "m0", 1.0).spring(GROUND, "m1", 1.0);
    let apart = apart.build().expect("a system");
    let critical = single(1.0, 2.0, 1.0);
    let unsymmetric = matrices(unit, zero, [[2.0, -1.0], [1.0, 2.0]]);
    let indefinite = matrices([[1.0, 2.0], [2.0, 1.0]], zero, unit);
    let joint_mass = matrices([[1.0, 1.0], [1.0, 1.0]], zero, [[2.0, 0.0], [0.0, 3.0]]);
    let node = [[1.0, 0.0], [0.0, 0.0]];
    let constraint = matrices(node, zero, [[1.0, 1.0], [1.0, 0.0]]);
    let one_way = matrices(node, [[0.0, 1.0], [1.0, 0.0]], unit);
    let massless = single(0.0, 1.0, 1.0);
    // Beside dampers of 1e100 and 1 even 384 bits lose that of 1e-100, by which p and q hang on a.
    let weak = System::builder().mass("a", 1.0).damper(GROUND, "a", 1.0);
    let weak = weak.mass("p", 0.0).mass("q", 0.0).spring("p", "q", 1.0);
    let weak = weak.damper("p", "q", 1e100).damper("p", "q", 1.0);
    let weak = weak.damper("a", "p", 1e-100);
    let weak = weak.build().expect("a system");
    let twins = matrices(unit, zero, unit);
    let at_rest = Frequency::from_radians_per_second(0.0);
    let longer_pair = Eigenpair {
        value: Complex::I,
        shape: vec![Complex::ONE; 2],
    };
    let below_zero = Frequency::from_radians_per_second(-1.0);
    list! { listing:
        large.modes();
        too_fast.modes();
        weak.modes_to(Precision::Double);
        SpringFactor.solve(&critical);
        FirstOrder::of(&joint_mass);
        FirstOrder::of(&constraint);
        FirstOrder::of(&one_way);
        FirstOrder::of(&large);
        SparseModes::lowest(&one, 0);
        SparseModes::nearest(&one, below_zero, 1);
        SparseModes::lowest(&unsymmetric, 1);
        SparseModes::lowest(&massless, 1);
        SparseModes::lowest(&indefinite, 1);
        examine_pairs(&one, at_rest, 1, vec![longer_pair], 0.0);
        SparseDynamicStiffness::of(&one, &[0.1, 0.2]);
        Participation::of(&unsymmetric);
        Participation::along(&one, &[1.0, 1.0]);
        Participation::along(&one, &[f64::NAN]);
        Participation::along(&one, &[1e300]);
        Participation::of(&far_apart);
        Participation::of(&apart);
    }
    let shape = [Complex::ONE];
    let longer = [Complex::ONE; 2];
    list! { listing:
        modal_assurance(&[&shape[..], &longer[..]], &[]);
        phase_collinearity(&[Complex::ZERO]);
    }
    let modes = |system: &System| system.modes().expect("modes").as_slice().to_vec();
    let (swing, both, same, defective) = (
        modes(&one).remove(0),
        modes(&pair).remove(0),
        modes(&twins).remove(0),
        modes(&critical).remove(0),
    );
    let stiffer = single(1.0, 0.0, 2.0);
    let of_one = Sensitivity::of(&one, &swing).expect("it is simple");
    list! { listing:
        Sensitivity::of(&critical, &defective);
        Sensitivity::of(&twins, &same);
        Sensitivity::of(&stiffer, &swing);
        Sensitivity::of(&one, &both);
        of_one.to(Parameter::Spring(7));
    }
}

fn response_errors(listing: &mut Listing) {
    let one = row(&[1.0]);
    let large = row(&[1.0; 5000]);
    let node = row(&[1.0, 0.0]);
    let dashpot = System::builder()
        .mass("m0", 1.0)
        .mass("m1", 0.0)
        .damper("m0", "m1", 1.0)
        .build()
        .expect("a system");
    let growing = single(1.0, 0.0, -400.0);
    let far_apart = single(1e300, 0.0, 5e-324);
    let soft = single(1.0, 0.0, 5e-324);
    let free = System::builder().mass("m0", 1.0).build().expect("a system");
    let beside = System::builder().mass("m0", 1.0).mass("m1", 1.0);
    let beside = beside.spring(GROUND, "m0", -1e8).spring(GROUND, "m1", -1e8);
    let beside = beside.spring("m0", "m1", 1e8).build().expect("a system");
    let apart = State::at_rest().displace("m0", 1.0).displace("m1", -1.0);
    let problem = Response::of(&one)
        .from(State::at_rest().displace("m0", 1.0))
        .every(1.0)
        .until(10.0)
        .problem()
        .expect("a problem");
    let of = |system| Response::of(system).every(1.0).until(10.0);
    let displaced = State::at_rest().displace("m1", 1.0);
    let pushed = State::at_rest().push("m1", 1.0);
    let unknown = State::at_rest().displace("m0", f64::NAN);
    let away = State::at_rest().displace("m0", 1.0);
    let early = Impulse::of(1.0).at(-1.0);
    let empty = samples(1.0, vec![]);
    let no_number = samples(1.0, vec![f64::NAN]);
    let no_step = samples(0.0, vec![1.0]);
    let uneven = samples(0.7, vec![1.0]);
    let one_step = Limit {
        steps: 1,
        time: None,
    };
    let dopri = DormandPrince5 { tolerance: 1e-9 };
    let turning = Mat::from_fn(64, 64, |i, j| 1e300 * (i as f64 - j as f64));
    list! { listing:
        Response::of(&one).every(0.0).until(10.0).run();
        Response::of(&one).every(1.0).until(-1.0).run();
        Response::of(&one).every(1.0).until(1e300).run();
        Response::of(&one).every(1e308).until(1.7e308).run();
        Response::of(&one).run();
        of(&one).load("n", Step::of(1.0)).run();
        of(&one).follow(&[Output::Velocity(4)]);
        of(&one).from(unknown).run();
        of(&node).from(displaced).run();
        of(&dashpot).from(pushed).run();
        of(&node).load("m1", Impulse::of(1.0)).run();
        problem.clone().at(&[11]);
        ByCertifiedExponential.at(&problem, &[10.5]);
        Response::of(&one).every(1e-3).until(1e9).to(Precision::Double).run();
        of(&large).run();
        ModalTruncation { modes: 1 }.run(&problem.clone().with_acceleration());
        of(&far_apart).run_by(&BySuperposition);
        ModalTruncation { modes: 0 }.run(&problem);
        Response::of(&growing).every(1.0).until(100.0).from(away).run();
        Response::of(&beside).every(1.0).until(1.0).from(apart).run();
        dopri.integrate(&problem, one_step);
        receptance(&one, "m0", 1.0);
        receptance(&free, "m0", 0.0);
        receptance(&soft, "m0", 0.0);
        receptance(&large, "m7", 0.5);
        receptance(&one, "m0", f64::NAN);
        receptance(&one, "n", 1.0);
        expm(mat![[1.0, 2.0]].as_ref());
        expm(mat![[f64::NAN]].as_ref());
        expm(turning.as_ref());
        Pade13.exponential(mat![[1e10]].as_ref());
    }
    let of_load = |load: eigentone::response::Load| match of(&one).load("m0", load).run() {
        Err(error) => match error {
            eigentone::response::ResponseError::Load { error, .. } => Err(error),
            other => panic!("{other}"),
        },
        Ok(_) => Ok(()),
    };
    let quarter = System::builder()
        .mass("m0", 1.0)
        .mass("p", 0.0)
        .mass("q", 0.0);
    let quarter = quarter
        .support("road")
        .point("both", [("p", 1.0), ("q", -1.0), ("road", 1.0)], 0.0)
        .spring("m0", "p", 1.0)
        .spring("p", GROUND, 1.0)
        .spring("q", GROUND, 1.0)
        .damper("both", GROUND, 1.0)
        .build()
        .expect("a system");
    // What the support's damper passes on, another one takes back.
    let passed_on = System::builder().mass("p", 0.0).support("road");
    let passed_on = passed_on
        .spring("p", GROUND, 1.0)
        .damper("road", "p", 1.0)
        .damper("p", GROUND, -1.0)
        .build()
        .expect("a system");
    let carried = System::builder().mass("m0", 1.0).support("road");
    let carried = carried
        .point("p", [("m0", 1.0), ("road", 1.0)], 1.0)
        .spring("m0", GROUND, 1.0)
        .build()
        .expect("a system");
    let kerb = |system, name: &str, load: eigentone::response::Load| {
        of(system).motion(name, Quantity::Displacement, load)
    };
    let of_motion = |system, load: eigentone::response::Load| match kerb(system, "road", load).run()
    {
        Err(error) => match error {
            eigentone::response::ResponseError::Motion { error, .. } => Err(error),
            other => panic!("{other}"),
        },
        Ok(_) => Ok(()),
    };
    let steady = Load::from(Harmonic::of(1.0, 0.0).with_phase(1.0));
    let drifts = of(&quarter)
        .motion("road", Quantity::Acceleration, steady)
        .problem();
    let drifts = drifts.expect("a problem");
    let frf = || FrequencyResponse::of(&quarter).from("road");
    let pull = Combination {
        name: "travel".to_owned(),
        of: Sum::Pull("tire".to_owned()),
    };
    let car = System::builder().mass("wheel", 1.0).support("road");
    let car = car.damper("road", "wheel", 1.0).build();
    let car = car.expect("a system");
    let plant = || StateSpace::of(&car).motion("road", Quantity::Displacement);
    let form = plant().build().expect("a form");
    let growth = StateSpace::of(&growing).force("m0").build();
    let growth = growth.expect("a form");
    let undamped = StateSpace::of(&one).force("m0").build();
    let undamped = undamped.expect("a form");
    let held = System::builder().mass("m", 1.0).support("road");
    let held = held.spring("road", "m", 1.0).damper(GROUND, "m", 1.0);
    let held = held.build().expect("a system");
    let record = |values: &[f64]| Samples {
        step: 0.1,
        values: values.to_vec(),
        hold: Hold::First,
    };
    let spectrum = |values: &[f64], ratio: f64, frequency: f64| {
        ResponseSpectrum::of(record(values), ratio, &[frequency], Precision::default())
    };
    let slow = HalfSine::of(1.0, 1e7);
    list! { listing:
        plant().force("road").build();
        plant().motion("wheel", Quantity::Velocity).build();
        plant().pull("tyre force", "tyre").build();
        plant().output("wheel", Quantity::Acceleration).build();
        form.discretise(0.0, Hold::Zero);
        form.process_noise(0.1, mat![[1.0, 0.0]].as_ref());
        growth.discretise(100.0, Hold::Zero);
        undamped.stationary_covariance(mat![[1.0]].as_ref());
        RandomVibration::of(&growing).force("m0", 1.0).solve();
        RandomVibration::of(&held).force("m", -1.0).solve();
        RandomVibration::of(&held).force("m", Noise::within(1.0, [10.0, 1.0])).solve();
        spectrum(&[], 0.05, 1.0);
        spectrum(&[0.0, 1.0], -0.05, 1.0);
        spectrum(&[0.0, 1.0], 0.05, 0.0);
        spectrum(&[0.0, 1.0], 0.05, 1e-200);
        ResponseSpectrum::of(slow, 0.0, &[1.0], Precision::Double);
        Baseline::of(&record(&[1.5e308, 1.5e308]));
    }
    list! { listing:
        kerb(&quarter, "wall", Step::of(1.0).into()).run();
        kerb(&passed_on, "road", Step::of(1.0).into()).run();
        kerb(&quarter, "road", Impulse::of(1.0).into()).run();
        of(&one).pull("tyre force", "tyre").run();
        of_motion(&quarter, Impulse::of(1.0).into());
        of_motion(&carried, Step::of(1.0).into());
        of_load(HalfSine::of(1.0, 0.0).into());
        of_load(Versine::of(1.0, 1.0).starting_at(-1.0).into());
        of_load(Polynomial::of([0.0; 8]).into());
        of_load(Polynomial::of([0.0, 1e306]).into());
        SteadyState::of(&drifts);
        FrequencyResponse::of(&quarter).at(&[1.0]);
        frf().to("wall").at(&[1.0]);
        frf().output(pull).at(&[1.0]);
        frf().at(&[-1.0]);
        frf().loss_factors([0.1, 0.1]).at(&[1.0]);
        frf().loss_factors([-0.1, 0.0, 0.0]).at(&[1.0]);
        FrequencyResponse::of(&soft).from("m0").at(&[0.0]);
        of(&one).load("m0", Step::of(f64::NAN)).run();
        of_load(Step::of(f64::NAN).into());
        of_load(early.into());
        of_load(empty.into());
        of_load(no_number.into());
        of_load(no_step.into());
        of_load(uneven.into());
    }
}

fn sweep_errors(listing: &mut Listing) {
    let one = row(&[1.0]);
    let pair = row(&[1.0, 1.0]);
    let free = System::builder().mass("m0", 1.0).build().expect("a system");
    let matrix = matrices(
        [[1.0, 0.0], [0.0, 1.0]],
        [[0.0; 2]; 2],
        [[2.0, 0.0], [0.0, 2.0]],
    );
    let stiff = single(1e-300, 0.0, 1e308);
    let beside = System::builder().mass("m0", 1.0).support("wall");
    let beside = beside.spring("wall", GROUND, 1.0).spring("wall", "m0", 1.0);
    let beside = beside.build().expect("a system");
    let proportional = System::builder().mass("m0", 1.0).spring(GROUND, "m0", 1.0);
    let proportional = proportional
        .rayleigh(0.0, 0.1, None)
        .build()
        .expect("a system");
    let problem = |step: f64, force: f64| -> Problem<'_> {
        let asked = Response::of(&one).load("m0", Step::of(force));
        asked.every(step).until(1.0).problem().expect("a problem")
    };
    let chosen = problem(0.1, 1.0).at(&[3]).expect("it is there");
    let fine = problem(1e-9, 1.0);
    let mut pushed = Sweep::of(&problem(0.1, 1e308)).expect("a sweep");
    pushed
        .set(Parameter::Mass(0), 1e-10)
        .expect("it is positive");
    let whole = Response::of(&matrix).every(0.1).until(1.0);
    let whole = whole.problem().expect("a problem");
    let mut design = Design::of(&one).expect("a design");
    let design_of = |system| Design::of(system).expect("a design");
    let mut workspace = ModesWorkspace::of(&design);
    let (loose, of_pair, apart) = (design_of(&free), design_of(&pair), design_of(&stiff));
    let mut of_loose = ModesWorkspace::of(&loose);
    let mut of_apart = ModesWorkspace::of(&apart);
    list! { listing:
        Sweep::of(&whole);
        Sweep::of(&chosen);
        Sweep::of(&fine);
        pushed.solve();
        Design::of(&matrix);
        Design::of(&beside);
        Design::of(&proportional);
        design.set(Parameter::Spring(7), 1.0);
        design.set(Parameter::Mass(0), 0.0);
        of_loose.solve(&loose);
        workspace.solve(&of_pair);
        of_apart.solve(&apart);
    }
}

fn check_errors(listing: &mut Listing) {
    let zero = [[0.0; 2]; 2];
    let unit = [[1.0, 0.0], [0.0, 1.0]];
    let node = [[1.0, 0.0], [0.0, 0.0]];
    let one = row(&[1.0]);
    let pair = row(&[1.0, 1.0]);
    let large = row(&[1.0; 400]);
    let joint_mass = matrices([[1.0, 1.0], [1.0, 1.0]], zero, [[2.0, 0.0], [0.0, 3.0]]);
    let constraint = matrices(node, zero, [[1.0, 1.0], [1.0, 0.0]]);
    let one_way = matrices(node, [[0.0, 1.0], [1.0, 0.0]], unit);
    let between = System::builder()
        .mass("m", 1.0)
        .mass("p", 0.0)
        .mass("q", 0.0)
        .spring("m", "p", 1.0)
        .damper("p", "q", 1.0)
        .spring("q", GROUND, 1.0)
        .build()
        .expect("a system");
    let reference = Reference::default();
    let problem = |system| -> Problem<'_> {
        let problem = Response::of(system).every(1.0).until(10.0).problem();
        problem.expect("a problem")
    };
    let impulse = Response::of(&between).load("p", Impulse::of(1.0));
    let impulse = impulse.every(1.0).until(10.0).problem().expect("a problem");
    let growing = single(1.0, 0.0, -1e14);
    let fast = problem(&growing);
    let of_one = one.modes().expect("modes");
    let of_pair = reference.modes(&pair).expect("a reference");
    list! { listing:
        reference.modes(&large);
        reference.response(&problem(&joint_mass));
        reference.response(&problem(&one_way));
        reference.response(&problem(&constraint));
        reference.response(&impulse);
        reference.response(&fast);
        of_pair.error_of(&of_one);
        ExactMass::new(0.0, 1.0, 1.0);
        ExactMass::new(1.0, -1.0, 1.0);
    }
    let chain = UniformChain::new(ChainEnds::BothGrounded, 2, 1.0, 1.0);
    let chain = chain.expect("a chain");
    list! { listing:
        chain.free(&[1.0], &[0.0], 1.0);
        UniformChain::new(ChainEnds::Free, 0, 1.0, 1.0);
        MassSpringDamper::new(0.0, 1.0, 1.0);
        MassSpringDamper::new(1.0, -1.0, 1.0);
        MassSpringDamper::new(1.0, 1.0, 1e-71);
    }
    // After 1000 s its motion is smaller than 320 digits show beside where it began.
    let damped = single(0.5, 2.4, 2.6);
    let late = Response::of(&damped).from(State::at_rest().displace("m0", 1.0));
    let late = late.every(0.1).until(1000.0).problem().expect("a problem");
    let late = late.at(&[1, 9999]).expect("both are there");
    list! { listing:
        ModeTable::of(&large);
        ResponseTable::of(&late);
    }
    let scene = r#"{"masses": [{"name": "m", "mass": 1}], "time": {"end": 1, "step": 0.1}}"#;
    let scene = eigentone::scene::Scene::parse(scene, std::path::Path::new("scene.json"));
    let scene = scene.expect("a scene");
    list! { listing:
        eigentone::tables::SceneTables::of("title", &scene, Some(&[11]));
    }
}
