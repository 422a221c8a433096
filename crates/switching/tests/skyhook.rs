//! A quarter car with an on-off skyhook damper on a bump, against events and motions with 50 digits: exponentials of each piece
//! and roots of the laws by mpmath, with the damper held at v_body = 0 where neither damping keeps its sign.

use eigentone_modes::System;
use eigentone_response::{Quantity, Response, Versine};
use eigentone_switching::{ControlledDamper, DamperLaw, EventKind, Switch, Switching};

const EVENTS: [f64; 20] = [
    0.21370779073339738,
    0.29382013803284557,
    0.2975429802534863,
    0.3488662922943399,
    0.37763725547281346,
    0.4120357373692878,
    0.4129098383439543,
    0.46425771751169687,
    0.5086547516255974,
    0.5218602317598414,
    0.5297697352522655,
    0.5768677089140035,
    1.0602727225146027,
    1.080046310320081,
    1.5785070349028125,
    1.5982858343557895,
    2.096742119072574,
    2.116520918277756,
    2.6149772031854464,
    2.634756002390641,
];

/// Index of the sample, body and wheel in m.
const SAMPLES: [(u64, f64, f64); 5] = [
    (20, 0.00542220131019974, 0.07774470419265228),
    (40, 0.02102647965649586, 0.010518901020660132),
    (80, 0.0037722644158760315, -0.0003504969209231721),
    (150, 6.698324987952521e-05, 1.5997657838107317e-05),
    (299, -6.542989233527958e-10, -9.06462126630037e-09),
];

#[test]
fn a_skyhook_damper_over_a_bump_is_that_of_50_digits() {
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16_812.0)
        .spring("road", "wheel", 190_000.0)
        .build()
        .expect("a car");
    let bump = Versine::of(0.08, 0.25).starting_at(0.1);
    let ask = Response::of(&car).motion("road", Quantity::Displacement, bump);
    let problem = ask.every(0.01).until(3.0).problem().expect("a problem");
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["wheel".to_owned(), "body".to_owned()],
        low: 300.0,
        high: 3000.0,
        law: DamperLaw::OnOffSkyhook,
    });
    let motion = Switching::new(&problem, vec![damper])
        .expect("a damper")
        .run()
        .expect("a motion");
    assert_eq!(motion.events().len(), EVENTS.len());
    for (event, wanted) in motion.events().iter().zip(EVENTS) {
        assert_eq!(event.kind, EventKind::Switch);
        let rounding = wanted * f64::EPSILON / 2.0;
        assert!(
            (event.time - wanted).abs() <= event.bound + rounding,
            "{event:?} {wanted}"
        );
        assert!(event.bound <= 1e-15, "{event:?}");
    }
    let found = motion.trajectory();
    for (index, body, wheel) in SAMPLES {
        let k = index as usize;
        let bound = found.displacement_bound()[k].expect("proven");
        assert!(bound <= 1e-16, "{bound:e}");
        for (i, wanted) in [body, wheel].into_iter().enumerate() {
            let off = (found.displacement()[(i, k)] - wanted).abs();
            assert!(
                off <= bound + wanted.abs() * f64::EPSILON,
                "{index} {i}: {off:e} {bound:e}"
            );
        }
    }
}
