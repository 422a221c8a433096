//! What a sweep allocates. Alone in this file, since another test beside it would be counted too.

use std::alloc::System as Allocator;

use eigentone_modes::{GROUND, Parameter, System};
use eigentone_response::{AppliedLoad, Load, Problem, State, Step, Sweep, TimeGrid};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<Allocator> = &INSTRUMENTED_SYSTEM;

#[test]
fn nothing_is_allocated_after_the_first_design() {
    let system = System::builder()
        .mass("m1", 6.0)
        .mass("m2", 9.0)
        .mass("m3", 5.0)
        .spring(GROUND, "m1", 6.0)
        .spring("m1", "m2", 7.0)
        .spring("m2", "m3", 4.0)
        .spring("m3", GROUND, 1.0)
        .damper(GROUND, "m1", 1.0)
        .damper("m2", "m3", 0.1)
        .build()
        .unwrap();
    let loads = vec![AppliedLoad {
        coordinate: 1,
        load: Load::Step(Step {
            force: 2.0,
            start: 0.25,
        }),
    }];
    let grid = TimeGrid::new(0.1, 20.0).unwrap();
    let start = State::at_rest().displace("m1", 6.0);
    let problem = Problem::new(&system, &start, loads, grid).unwrap();
    let mut sweep = Sweep::of(&problem).unwrap();
    sweep.solve().unwrap();
    let mut sum = 0.0;
    let mut allocated = || {
        let region = Region::new(ALLOCATOR);
        for k in 1..=100 {
            sweep.set(Parameter::Spring(1), 0.5 * f64::from(k)).unwrap();
            sweep
                .set(Parameter::Damper(1), 0.25 * f64::from(k))
                .unwrap();
            let answer = sweep.solve().unwrap();
            sum += answer.displacement()[(0, 200)] + answer.eigenvalues()[0].re;
        }
        let change = region.change();
        (change.allocations, change.reallocations)
    };
    // The thread that waits for this one allocates at times; what a sweep allocates is there each time.
    let least = (0..3).map(|_| allocated()).min();
    assert!(sum.is_finite());
    assert_eq!(least, Some((0, 0)));
}
