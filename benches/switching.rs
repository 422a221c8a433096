//! Motions through events, in events a second: one mass under impacts, a stop and friction, and a quarter car with an on-off
//! damper; in doubles and proven.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use eigentone::modes::{GROUND, Precision, System};
use eigentone::response::{Harmonic, Problem, Quantity, Response, State, Step};
use eigentone::switching::{
    ControlledDamper, DamperLaw, Friction, Impact, Stop, Switch, Switching,
};

fn at_ground(name: &str) -> [String; 2] {
    [GROUND.to_owned(), name.to_owned()]
}

/// What it is called, the question, and the switch.
fn cases<'a>(
    free: &'a System,
    held: &'a System,
    car: &'a System,
    precision: Precision,
) -> [(&'static str, Problem<'a>, Switch); 4] {
    let problem = |ask: Response<'a>, end: f64| {
        let ask = ask.every(1.0).until(end).to(precision);
        ask.problem().expect("a problem")
    };
    let falling = Response::of(free)
        .from(State::at_rest().displace("m", -1.0))
        .load("m", Step::of(9.81));
    let driven = |force: f64| {
        let from = State::at_rest().displace("m", 1.0);
        Response::of(held)
            .from(from)
            .load("m", Harmonic::of(force, 7.0))
    };
    let road = Harmonic::of(0.02, 9.0);
    let driving = Response::of(car).motion("road", Quantity::Displacement, road);
    let impact = Impact {
        between: at_ground("m"),
        gap: 0.0,
        restitution: 0.999,
    };
    let stop = Stop {
        between: at_ground("m"),
        gap: 0.05,
        stiffness: 400.0,
        damping: 1.0,
    };
    let friction = Friction {
        between: at_ground("m"),
        force: 5.0,
        static_force: 6.0,
    };
    let damper = ControlledDamper {
        between: ["wheel".to_owned(), "body".to_owned()],
        low: 300.0,
        high: 3000.0,
        law: DamperLaw::OnOffSkyhook,
    };
    [
        ("impacts", problem(falling, 400.0), Switch::Impact(impact)),
        ("stop", problem(driven(3.0), 100.0), Switch::Stop(stop)),
        (
            "friction",
            problem(driven(30.0), 100.0),
            Switch::Friction(friction),
        ),
        (
            "quarter car",
            problem(driving, 30.0),
            Switch::ControlledDamper(damper),
        ),
    ]
}

fn motions(c: &mut Criterion) {
    let mut group = c.benchmark_group("switching");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(2));
    group.warm_up_time(Duration::from_millis(300));
    let mass = || System::builder().mass("m", 1.0);
    let free = mass().build().expect("a mass");
    let held = mass().spring(GROUND, "m", 100.0).build().expect("a system");
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16_812.0)
        .spring("road", "wheel", 190_000.0)
        .build()
        .expect("a car");
    for (how, precision) in [
        ("doubles", Precision::Double),
        ("proven", Precision::default()),
    ] {
        for (name, problem, switch) in cases(&free, &held, &car, precision) {
            let switching = Switching::new(&problem, vec![switch]).expect("a switch");
            let motion = switching.run().expect("a motion");
            group.throughput(Throughput::Elements(motion.events().len() as u64));
            group.bench_function(format!("{name}, {how}"), |b| {
                b.iter(|| black_box(&switching).run().expect("a motion"));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, motions);
criterion_main!(benches);
