//! The one-mass scenes of the gallery, retyped, with their truths.

use eigentone_modes::{GROUND, System};
use eigentone_response::{Harmonic, Problem, Response, State};

pub struct Scene {
    pub title: &'static str,
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    end: f64,
    step: f64,
    initial: [f64; 2],
    truth: &'static str,
}

pub struct Truth {
    pub step: u64,
    pub displacement: f64,
    pub velocity: f64,
}

macro_rules! truth {
    ($name:literal) => {
        include_str!(concat!("../../../../tests/gallery/truth/", $name, ".json"))
    };
}

/// From 1 m and 0.5 m/s.
pub const FREE: [Scene; 4] = [
    free("undamped", 0.0, truth!("one-mass-undamped")),
    free("underdamped", 0.4, truth!("one-mass-underdamped")),
    free("critical", 4.0, truth!("one-mass-critical")),
    free("overdamped", 40.0, truth!("one-mass-overdamped")),
];

const fn free(title: &'static str, damping: f64, truth: &'static str) -> Scene {
    Scene {
        title,
        mass: 1.0,
        damping,
        stiffness: 4.0,
        end: 20.0,
        step: 0.01,
        initial: [1.0, 0.5],
        truth,
    }
}

/// From rest, under sin 2t, which is its own frequency.
pub const RESONANCE: Scene = Scene {
    title: "resonance",
    mass: 1.0,
    damping: 0.0,
    stiffness: 4.0,
    end: 100.0,
    step: 0.05,
    initial: [0.0, 0.0],
    truth: truth!("one-mass-resonance"),
};

pub fn system(mass: f64, damping: f64, stiffness: f64) -> System {
    let mut builder = System::builder().mass("m1", mass);
    if stiffness != 0.0 {
        builder = builder.spring(GROUND, "m1", stiffness);
    }
    if damping != 0.0 {
        builder = builder.damper(GROUND, "m1", damping);
    }
    builder.build().expect("valid")
}

impl Scene {
    pub fn system(&self) -> System {
        system(self.mass, self.damping, self.stiffness)
    }

    pub fn problem<'a>(&self, system: &'a System) -> Problem<'a> {
        let [displacement, velocity] = self.initial;
        let initial = State::at_rest()
            .displace("m1", displacement)
            .push("m1", velocity);
        let mut response = Response::of(system)
            .from(initial)
            .every(self.step)
            .until(self.end);
        if self.initial == [0.0, 0.0] {
            response = response.load("m1", Harmonic::of(1.0, 2.0));
        }
        response.problem().expect("valid")
    }

    pub fn truth(&self) -> Vec<Truth> {
        let all: serde_json::Value = serde_json::from_str(self.truth).expect("valid JSON");
        let number = |value: &serde_json::Value| {
            let text = value[0].as_str().expect("a string");
            text.parse().expect("a number")
        };
        let instants = all["response"].as_array().expect("a list").iter();
        instants
            .map(|instant| Truth {
                step: instant["step"].as_u64().expect("an index"),
                displacement: number(&instant["displacement"]),
                velocity: number(&instant["velocity"]),
            })
            .collect()
    }
}
