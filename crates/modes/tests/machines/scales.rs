//! Masses within others that are far heavier, which doubles lose, and roots that crowd. Roots are those of the exact polynomial, from
//! FLINT.

use eigentone_modes::{
    Beam, BeamEnd, Bounds, FirstOrder, GROUND, Modes, ModesError, Participation,
    ParticipationError, Precision, Rod, RodEnd, System, SystemBuilder,
};

use BeamEnd::{Clamped, Free, Guided};

const PRECISIONS: [Precision; 2] = [
    Precision::Double,
    Precision::Certified {
        tolerance: 2.0 * f64::EPSILON,
    },
];

fn beam(length: f64, elements: usize, rigidity: f64, mass: f64, ends: [BeamEnd; 2]) -> Beam {
    Beam {
        name: "b".to_owned(),
        length,
        elements,
        flexural_rigidity: rigidity,
        mass_per_length: mass,
        ends,
        lumped: false,
    }
}

/// A beam of 2e-24 kg in m, kg and s, with a mass that is shared by a displacement and a rotation.
fn cantilever(mass: f64) -> System {
    System::builder()
        .beam(beam(2e-9, 4, 3e-27, 1e-15, [Free, Clamped]))
        .point("p", [("b.3.w", 0.5), ("b.1.r", -1.0)], mass)
        .spring("b.2.r", "p", 8.59)
        .build()
        .expect("a system")
}

/// Each of these roots is that of the same rank among those found, by imaginary and then real part.
fn assert_roots(modes: &Modes, roots: &[[f64; 2]], known: f64) {
    let order = |a: &[f64; 2], b: &[f64; 2]| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]));
    let mut wanted = roots.to_vec();
    wanted.sort_by(order);
    let all = modes.eigenvalues().iter();
    let mut found: Vec<_> = all
        .map(|root| ([root.value.re, root.value.im], root))
        .collect();
    found.sort_by(|a, b| order(&a.0, &b.0));
    assert_eq!(found.len(), wanted.len());
    for ((value, root), wanted) in found.iter().zip(wanted) {
        let size = wanted[0].hypot(wanted[1]);
        let off = (value[0] - wanted[0]).hypot(value[1] - wanted[1]);
        let bound = root.bound.expect("it is known");
        // The roots are rounded to doubles.
        let rounding = 2.0 * f64::EPSILON * size;
        assert!(off <= bound + rounding, "{value:?}: {off:e}, not {bound:e}");
        assert!(bound <= known * size, "{value:?}: {bound:e}");
    }
}

#[test]
fn a_heavy_mass_on_a_sum_of_motions_hides_no_light_one() {
    const FREQUENCIES: [f64; 8] = [
        4.392_381_555_544_107e-09,
        4_997_873_016_944.705,
        23_658_191_649_665.96,
        39_179_121_284_699.64,
        55_110_285_290_784.68,
        154_344_252_363_924.72,
        269_668_104_563_557.5,
        7.170_779_984_444_917e+22,
    ];
    let roots = FREQUENCIES
        .iter()
        .flat_map(|omega| [[0.0, *omega], [0.0, -*omega]]);
    let roots: Vec<[f64; 2]> = roots.collect();
    let system = cantilever(1.399_470_169_935_015_6);
    for precision in PRECISIONS {
        let modes = system.modes_to(precision).expect("modes");
        assert_roots(&modes, &roots, 1e-14);
        let is_proven = precision != Precision::Double;
        assert_eq!(modes.bounds() == Bounds::Proven, is_proven);
    }
}

/// det M = 2e-20 + 1e-40 kg², which rounding to doubles makes 0.
#[test]
fn light_masses_on_both_ends_of_a_heavy_one_are_not_singular() {
    let system = System::builder()
        .mass("a", 1e-20)
        .mass("b", 1e-20)
        .point("p", [("a", 1.0), ("b", -1.0)], 1.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 2.0)
        .build()
        .expect("a system");
    let roots = [
        [0.0, 0.816_496_580_927_726],
        [0.0, -0.816_496_580_927_726],
        [0.0, 12_247_448_713.915_892],
        [0.0, -12_247_448_713.915_892],
    ];
    for precision in PRECISIONS {
        let modes = system.modes_to(precision).expect("modes");
        assert_roots(&modes, &roots, 1e-14);
    }
    // M⁻¹ is 1/det M times the other masses with the signs changed.
    let form = FirstOrder::of(&system).expect("it is regular");
    let inverse = (1.0 + 1e-20) / (2e-20 + 1e-40);
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let off = (form.b()[(2 + i, j)] / inverse - 1.0).abs();
        assert!(off <= 4.0 * f64::EPSILON, "{off:e}");
    }
}

fn assert_crowded(builder: SystemBuilder, roots: &[[f64; 2]]) {
    let system = builder.build().expect("a system");
    let modes = system.modes_to(Precision::Double).expect("modes");
    assert_roots(&modes, roots, 1e-9);
}

/// Springs of a beam, and the dampers in proportion to them, are so much stiffer than its masses that roots crowd about −1/β, 3 of them
/// the same.
#[test]
fn estimates_of_roots_that_crowd_hold() {
    let lumped = Beam {
        lumped: true,
        ..beam(0.25, 3, 4.93, 0.25, [Guided, Free])
    };
    let builder = System::builder()
        .beam(lumped)
        .point("p", [("b.3.w", -1.0), ("b.1.r", 1.0)], 0.0)
        .support("s")
        .spring("b.1.r", "b.0.w", 5.0)
        .spring("s", "b.1.r", 1.0)
        .rayleigh(0.0, 1.39, None);
    assert_crowded(
        builder,
        &[
            [-0.719_424_460_431_654_8, 0.0],
            [-0.719_424_460_431_654_8, 0.0],
            [-0.719_424_460_431_654_8, 0.0],
            [-0.719_424_484_503_783_9, 0.0],
            [-0.719_424_571_737_857_9, 0.0],
            [-0.719_427_024_300_334_7, 0.0],
            [-0.724_613_665_492_281_6, 0.0],
            [-100.459_471_003_294_47, 0.0],
            [-201_872.039_241_855_2, 0.0],
            [-4_649_980.141_082_22, 0.0],
            [-21_500_863.776_974_987, 0.0],
        ],
    );
    let rod = Rod {
        name: "r".to_owned(),
        length: 4.23,
        elements: 1,
        axial_rigidity: 5.0,
        mass_per_length: 75.265_623_363_764_92,
        ends: [RodEnd::Free, RodEnd::Free],
        lumped: false,
        twists: false,
    };
    let builder = System::builder()
        .beam(beam(0.072_612_916_263_603_26, 3, 1.0, 3.0, [Clamped, Free]))
        .rod(rod)
        .point("p", [("b.1.w", 0.5), ("r.1", 1.38), ("b.3.w", -1.0)], 0.0)
        .support("s")
        .spring("b.3.w", "b.1.r", 4.518_831_298_680_659)
        .damper("b.2.w", "p", 4.0)
        .damper("b.1.w", "b.3.w", 2.16)
        .rayleigh(0.0, 0.57, None);
    assert_crowded(
        builder,
        &[
            [0.0, 0.0],
            [-0.024_928_721_332_852_993, 0.0],
            [-0.048_091_242_651_031_57, 0.201_130_034_863_221_34],
            [-0.048_091_242_651_031_57, -0.201_130_034_863_221_34],
            [-1.750_575_387_570_715_3, 0.0],
            [-1.754_366_045_919_539_8, 0.0],
            [-1.754_385_967_588_309_8, 0.0],
            [-1.754_385_978_196_303_6, 0.0],
            [-1.754_386_003_309_463_4, 0.0],
            [-1.754_386_090_679_99, 0.0],
            [-90_758.217_775_567_87, 0.0],
            [-3_370_437.898_084_517, 0.0],
            [-26_694_565.360_063_307, 0.0],
            [-136_196_638.319_670_5, 0.0],
            [-481_712_215.164_159_06, 0.0],
            [-1_904_411_373.703_641_4, 0.0],
        ],
    );
}

/// Shapes that doubles cannot hold, as a heavy mass would move with their rounding, have no modal masses.
#[test]
fn participation_of_shapes_that_rounding_spoils_is_refused() {
    for (mass, is_known) in [(1.4, true), (1.4e3, false)] {
        let system = cantilever(mass);
        assert!(system.modes().is_ok());
        match Participation::along(&system, &[1.0; 8]) {
            Ok(_) => assert!(is_known),
            Err(ParticipationError::Modes(ModesError::OutOfRange { .. })) => assert!(!is_known),
            Err(error) => panic!("{error}"),
        }
    }
}

/// The same of more coordinates, with a dashpot that couples them.
#[test]
fn estimates_of_many_roots_that_crowd_hold() {
    const ROOTS: [f64; 29] = [
        -18_167_065_131.162_18,
        -14_491_464_620.584_747,
        -9_553_432_623.593_927,
        -5_384_494_943.552_891,
        -2_604_961_881.463_144,
        -1_040_505_239.920_373,
        -308_653_202.067_326_1,
        -51_905_698.784_175_67,
        -1_823_555.304_852_474_5,
        -2.665_682_015_126_976,
        -0.628_931_099_888_817_9,
        -0.628_930_835_216_425_8,
        -0.628_930_819_536_313_6,
        -0.628_930_818_001_264_3,
        -0.628_930_817_851_205_6,
        -0.628_930_817_693_364_2,
        -0.628_930_817_654_435_5,
        -0.628_930_817_643_980_2,
        -0.628_930_817_632_458,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        -0.628_930_817_610_062_9,
        0.0,
    ];
    let lumped = Beam {
        lumped: true,
        ..beam(0.09, 9, 5.54, 2.26, [Guided, Free])
    };
    let system = System::builder()
        .beam(lumped)
        .damper(GROUND, "b.6.w", 0.5422)
        .rayleigh(0.0, 1.59, None)
        .build()
        .expect("a system");
    let modes = system.modes_to(Precision::Double).expect("modes");
    let mut found = modes.eigenvalues().to_vec();
    found.sort_by(|a, b| a.value.re.total_cmp(&b.value.re));
    assert_eq!(found.len(), ROOTS.len());
    for (root, wanted) in found.iter().zip(ROOTS) {
        let off = (root.value - wanted).norm();
        let rounding = 2.0 * f64::EPSILON * wanted.abs();
        assert!(
            root.bound.is_none_or(|bound| off <= bound + rounding),
            "{root:?}: {off:e}"
        );
    }
}
