//! Random systems with switches against a time-stepping scheme that knows nothing of events, and against themselves.

use eigentone_modes::{GROUND, Precision, System};
use eigentone_response::{Harmonic, Response, State, Trajectory};

use eigentone_switching::{
    ControlledDamper, DamperLaw, Event, EventKind, Friction, Impact, Stop, Switch, SwitchedMotion,
    Switching, SwitchingError,
};
use faer::MatRef;
use proptest::prelude::*;

/// Masses in a chain, the first at the ground; each with an initial state.
#[derive(Clone, Debug)]
struct Chain {
    masses: Vec<f64>,
    springs: Vec<f64>,
    dampers: Vec<f64>,
    start: Vec<(f64, f64)>,
    load: (f64, f64),
    switches: Vec<Given>,
}

/// A switch between places, 0 being the ground and k the k-th mass.
#[derive(Clone, Debug)]
enum Given {
    Friction(usize, usize, f64, f64),
    Stop(usize, usize, f64, f64, f64),
    Impact(usize, usize, f64, f64),
    Damper(usize, usize, f64, f64, Option<f64>),
}

fn name(place: usize) -> String {
    match place {
        0 => GROUND.to_owned(),
        place => format!("m{place}"),
    }
}

impl Given {
    fn switch(&self) -> Switch {
        let between = |a: usize, b: usize| [name(a), name(b)];
        match *self {
            Given::Friction(a, b, force, static_force) => Switch::Friction(Friction {
                between: between(a, b),
                force,
                static_force,
            }),
            Given::Stop(a, b, gap, stiffness, damping) => Switch::Stop(Stop {
                between: between(a, b),
                gap,
                stiffness,
                damping,
            }),
            Given::Impact(a, b, gap, restitution) => Switch::Impact(Impact {
                between: between(a, b),
                gap,
                restitution,
            }),
            Given::Damper(a, b, low, high, sky) => Switch::ControlledDamper(ControlledDamper {
                between: between(a, b),
                low,
                high,
                law: sky.map_or(DamperLaw::OnOffSkyhook, |sky| DamperLaw::ClippedSkyhook {
                    sky,
                }),
            }),
        }
    }
}

impl Given {
    /// Whether all samples between two of its events are of one law: where an event was missed, some are not.
    fn keeps_its_law(&self, events: &[&Event], motion: &Trajectory) -> Result<(), String> {
        /// Smaller values have no sign.
        const NOTHING: f64 = 1e-12;
        let (x, v) = (motion.displacement(), motion.velocity());
        let at = |values: MatRef<'_, f64>, place: usize, k: usize| match place {
            0 => 0.0,
            place => values[(place - 1, k)],
        };
        let between = |values, a: usize, b: usize, k| at(values, b, k) - at(values, a, k);
        let sign = |value: f64| i8::from(value > NOTHING) - i8::from(value < -NOTHING);
        let mut next = events.iter().peekable();
        let mut last = None;
        // What the samples since the last event may be: of three laws each.
        let mut may = [true; 3];
        for (k, time) in motion.times().iter().enumerate() {
            while next.peek().is_some_and(|event| event.time <= *time) {
                last = next.next();
                may = [true; 3];
            }
            let near = last.into_iter().chain(next.peek().copied());
            if near
                .into_iter()
                .any(|event| (event.time - time).abs() < 1e-9)
            {
                continue;
            }
            let here = match *self {
                Given::Friction(a, b, ..) => {
                    let rate = sign(between(v, a, b, k));
                    let slides = last.is_some_and(|event| event.kind == EventKind::Slip);
                    // Sliding may begin at rest.
                    [rate >= 0, rate <= 0, !slides && rate == 0]
                }
                Given::Stop(a, b, gap, ..) => {
                    let beyond = sign(between(x, a, b, k) - gap);
                    [beyond >= 0, beyond <= 0, false]
                }
                Given::Impact(a, b, gap, _) => {
                    let beyond = sign(between(x, a, b, k) - gap);
                    let touches = last.is_some_and(|event| event.kind == EventKind::Contact);
                    [touches && beyond == 0, !touches && beyond <= 0, false]
                }
                Given::Damper(a, b, low, high, sky) => {
                    let (rate, body) = (between(v, a, b, k), at(v, b, k));
                    match sky {
                        None => {
                            let power = sign(body).signum() * sign(rate);
                            [power >= 0, power <= 0, sign(body) == 0]
                        }
                        Some(sky) => {
                            let side = |c: f64| sign(sky * body - c * rate) * sign(rate);
                            let (low, high) = (side(low), side(high));
                            [low <= 0, high >= 0, low >= 0 && high <= 0]
                        }
                    }
                }
            };
            for (may, here) in may.iter_mut().zip(here) {
                *may &= here;
            }
            if may == [false; 3] {
                return Err(format!("no law since {last:?} at t = {time:?}"));
            }
        }
        Ok(())
    }
}

impl Chain {
    fn system(&self) -> System {
        let mut builder = System::builder();
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(name(i + 1), *mass);
        }
        for (i, (spring, damper)) in self.springs.iter().zip(&self.dampers).enumerate() {
            builder =
                builder
                    .spring(name(i), name(i + 1), *spring)
                    .damper(name(i), name(i + 1), *damper);
        }
        builder.build().expect("a chain")
    }

    fn run(
        &self,
        step: f64,
        end: f64,
        precision: Precision,
    ) -> Result<SwitchedMotion, SwitchingError> {
        let system = self.system();
        let mut state = State::at_rest();
        for (i, (x, v)) in self.start.iter().enumerate() {
            state = state.displace(name(i + 1), *x).push(name(i + 1), *v);
        }
        let last = name(self.masses.len());
        let ask = Response::of(&system)
            .from(state)
            .load(last, Harmonic::of(self.load.0, self.load.1));
        let problem = ask
            .every(step)
            .until(end)
            .to(precision)
            .problem()
            .expect("a problem");
        let switches = self.switches.iter().map(Given::switch).collect();
        Switching::new(&problem, switches)?.with_peaks().run()
    }

    /// The displacements at the end by Moreau's scheme with small steps: friction by impulses within their limits, found
    /// by repeated projection, and impacts by Newton's law.
    fn stepped(&self, end: f64, steps: usize) -> Vec<f64> {
        /// How wide a damper's slope is, in m/s² times the step.
        const STEEP: f64 = 60.0;
        let n = self.masses.len();
        let h = end / steps as f64;
        let (mut x, mut v): (Vec<f64>, Vec<f64>) = self.start.iter().copied().unzip();
        let at = |values: &[f64], place: usize| if place == 0 { 0.0 } else { values[place - 1] };
        let inverse = |place: usize| {
            if place == 0 {
                0.0
            } else {
                1.0 / self.masses[place - 1]
            }
        };
        let mut impulses = vec![0.0; self.switches.len()];
        let mut sticks = vec![false; self.switches.len()];
        for k in 0..steps {
            let middle: Vec<f64> = x.iter().zip(&v).map(|(x, v)| x + 0.5 * h * v).collect();
            let mut force = vec![0.0; n];
            force[n - 1] += self.load.0 * (self.load.1 * (k as f64 + 0.5) * h).sin();
            let mut pull = |a: usize, b: usize, size: f64| {
                if b > 0 {
                    force[b - 1] -= size;
                }
                if a > 0 {
                    force[a - 1] += size;
                }
            };
            for (i, (spring, damper)) in self.springs.iter().zip(&self.dampers).enumerate() {
                let stretch = at(&middle, i + 1) - at(&middle, i);
                pull(
                    i,
                    i + 1,
                    spring * stretch + damper * (at(&v, i + 1) - at(&v, i)),
                );
            }
            for given in &self.switches {
                match *given {
                    Given::Stop(a, b, gap, stiffness, damping) => {
                        let beyond = at(&middle, b) - at(&middle, a) - gap;
                        if beyond > 0.0 {
                            pull(a, b, stiffness * beyond + damping * (at(&v, b) - at(&v, a)));
                        }
                    }
                    Given::Damper(a, b, low, high, sky) => {
                        let rate = at(&v, b) - at(&v, a);
                        let size = match sky {
                            // Steep in place of a jump: on the slope a body rests that neither damping lets go.
                            None => {
                                let share = at(&v, b) * rate.signum() / (STEEP * h);
                                (low + (high - low) * share.clamp(0.0, 1.0)) * rate
                            }
                            Some(sky) => {
                                let ends = [low * rate, high * rate];
                                (sky * at(&v, b)).clamp(ends[0].min(ends[1]), ends[0].max(ends[1]))
                            }
                        };
                        pull(a, b, size);
                    }
                    _ => {}
                }
            }
            let mut w: Vec<f64> = (0..n)
                .map(|i| v[i] + h * force[i] / self.masses[i])
                .collect();
            let kick = |w: &mut Vec<f64>, a: usize, b: usize, size: f64| {
                if b > 0 {
                    w[b - 1] += size * inverse(b);
                }
                if a > 0 {
                    w[a - 1] -= size * inverse(a);
                }
            };
            // First with the static limits: what they hold sticks. Then all else slides.
            let free = w.clone();
            for first in [true, false] {
                w.clone_from(&free);
                impulses.fill(0.0);
                for _ in 0..if self.switches.len() < 2 { 1 } else { 40 } {
                    for (j, given) in self.switches.iter().enumerate() {
                        if let Given::Friction(a, b, kinetic, most) = *given {
                            let limit = h * if first || sticks[j] { most } else { kinetic };
                            let rate = at(&w, b) - at(&w, a);
                            let next = (impulses[j] - rate / (inverse(a) + inverse(b)))
                                .clamp(-limit, limit);
                            kick(&mut w, a, b, next - impulses[j]);
                            impulses[j] = next;
                        }
                    }
                }
                for (j, given) in self.switches.iter().enumerate() {
                    if let Given::Friction(_, _, _, most) = *given
                        && first
                    {
                        sticks[j] = impulses[j].abs() < h * most * (1.0 - 1e-9);
                    }
                }
            }
            for given in &self.switches {
                if let Given::Impact(a, b, gap, restitution) = *given {
                    let rate = at(&w, b) - at(&w, a);
                    // What a few steps' forces add is not an impact, but contact.
                    let bounce = if rate > 300.0 * h { restitution } else { 0.0 };
                    if at(&middle, b) - at(&middle, a) >= gap && rate > 0.0 {
                        let size = -(1.0 + bounce) * rate / (inverse(a) + inverse(b));
                        kick(&mut w, a, b, size);
                    }
                }
            }
            for i in 0..n {
                x[i] = middle[i] + 0.5 * h * w[i];
            }
            v = w;
        }
        x
    }
}

fn chain() -> impl Strategy<Value = Chain> {
    (1usize..7).prop_flat_map(|n| {
        // Often between the same places.
        let last = prop_oneof![1..=n, 1..=n.min(2)];
        let between =
            (prop_oneof![0..=n, Just(0)], last).prop_filter("two places", |(a, b)| a != b);
        let switch = (0..5, between, 0.1..3.0f64, 1.0..1.6f64, 0.02..0.3f64).prop_map(
            |(kind, (a, b), force, ratio, gap)| match kind {
                0 | 1 => Given::Friction(a, b, force, force * ratio),
                2 => Given::Stop(a, b, gap, 2e3 * ratio, force),
                3 => Given::Impact(a, b, gap, gap * 3.0),
                _ => Given::Damper(
                    a,
                    b,
                    force,
                    4.0 * force,
                    (ratio > 1.3).then_some(3.0 * force),
                ),
            },
        );
        (
            prop::collection::vec(0.2..3.0f64, n),
            prop::collection::vec(20.0..300.0f64, n),
            prop::collection::vec(0.0..1.0f64, n),
            prop::collection::vec((-0.05..0.015f64, -1.0..1.0f64), n),
            (0.0..8.0f64, 1.0..20.0f64),
            prop::collection::vec(switch, 1..5),
        )
            .prop_map(|(masses, springs, dampers, start, load, mut switches)| {
                // What several dampers share out at v_b = 0 is not unique.
                let mut controlled = 0;
                switches.retain(|given| {
                    controlled += usize::from(matches!(given, Given::Damper(..)));
                    !matches!(given, Given::Damper(..)) || controlled < 2
                });
                // The scheme cannot show in which order several static limits are reached, nor that a body stops below one in
                // place of going on where a damper is steep.
                let frictions = switches
                    .iter()
                    .filter(|given| matches!(given, Given::Friction(..)));
                let is_on_off = |given: &Given| matches!(given, Given::Damper(.., None));
                let several = frictions.count() > 1 || switches.iter().any(is_on_off);
                for given in &mut switches {
                    if let Given::Friction(_, _, force, most) = given
                        && several
                    {
                        *most = *force;
                    }
                }
                Chain {
                    masses,
                    springs,
                    dampers,
                    start,
                    load,
                    switches,
                }
            })
    })
}

/// What may be refused: forces that are not unique, a start beyond a gap, and bounces between several stops that die out.
fn is_refusal(error: &SwitchingError) -> bool {
    match error {
        SwitchingError::Dependent { .. } | SwitchingError::Switch { .. } => true,
        SwitchingError::Undecided { reason, .. } => reason.contains("die out"),
        _ => false,
    }
}

/// Samples between two instants of the coarse motion.
const DENSE: usize = 256;

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, max_shrink_iters: 8, ..ProptestConfig::with_cases(cases()) })]

    #[test]
    fn random_motions_agree_with_small_steps_and_with_themselves(chain in chain()) {
        const END: f64 = 0.625;
        let motion = match chain.run(0.0625, END, Precision::default()) {
            Ok(motion) => motion,
            Err(error) if is_refusal(&error) => return Ok(()),
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        // Output steps change neither the events nor the motion.
        let finer = chain.run(0.0625 / DENSE as f64, END, Precision::default()).expect("as before");
        prop_assert_eq!(motion.events().len(), finer.events().len());
        for (a, b) in motion.events().iter().zip(finer.events()) {
            prop_assert_eq!((a.switch, a.kind), (b.switch, b.kind));
            prop_assert!((a.time - b.time).abs() <= a.bound + b.bound, "{:?} {:?}", a, b);
        }
        let (coarse, fine) = (motion.trajectory(), finer.trajectory());
        for (switch, given) in chain.switches.iter().enumerate() {
            let own = finer.events().iter().filter(|event| event.switch == switch).collect::<Vec<_>>();
            if let Err(missed) = given.keeps_its_law(&own, fine) {
                return Err(TestCaseError::fail(format!("switch {switch}: {missed}")));
            }
        }
        for k in 0..coarse.len() {
            let bound = coarse.displacement_bound()[k].expect("proven") + fine.displacement_bound()[DENSE * k].expect("proven");
            for i in 0..chain.masses.len() {
                let off = (coarse.displacement()[(i, k)] - fine.displacement()[(i, DENSE * k)]).abs();
                prop_assert!(off <= bound, "{i} {k}: {off:e} {bound:e}");
                prop_assert!(bound < 1e-14, "{bound:e}");
            }
        }
        // Peaks are not below any sample, and not above them by more than happens in between.
        let peaks = finer.peaks().expect("asked for");
        for i in 0..chain.masses.len() {
            let [x, v, a] = [peaks.displacement(i), peaks.velocity(i), peaks.acceleration(i)].map(|peaks| (peaks.highest, peaks.lowest));
            let fastest = v.0.value.abs().max(v.1.value.abs());
            let hardest = a.0.value.abs().max(a.1.value.abs());
            let impulses = chain.switches.iter().any(|given| matches!(given, Given::Impact(..)));
            for (values, (high, low), rate) in [(fine.displacement(), x, fastest), (fine.velocity(), v, hardest)] {
                let (top, bottom) = (0..fine.len()).fold((f64::MIN, f64::MAX), |(top, bottom), k| (values[(i, k)].max(top), values[(i, k)].min(bottom)));
                prop_assert!(high.value >= top - high.bound && low.value <= bottom + low.bound, "{i}: {high:?} {top:?}, {low:?} {bottom:?}");
                let between = rate * 0.0625 / DENSE as f64 + 1e-12;
                let jumps = impulses && rate == hardest;
                prop_assert!(jumps || high.value <= top + between && low.value >= bottom - between, "{i}: {high:?} {top:?}, {low:?} {bottom:?}");
            }
        }
        // Nothing passes a rigid stop.
        for given in &chain.switches {
            if let Given::Impact(a, b, gap, _) = *given {
                let at = |place: usize, k: usize| if place == 0 { 0.0 } else { fine.displacement()[(place - 1, k)] };
                for k in 0..fine.len() {
                    prop_assert!(at(b, k) - at(a, k) <= gap + 1e-14);
                }
            }
        }
        // The scheme is of first order: two step lengths show how far it may be off, unless errors of several kinds cancel in
        // part, or an event is a near miss.
        let last = coarse.len() - 1;
        let near = chain.stepped(END, 60_000);
        let far = chain.stepped(END, 30_000);
        let scale = (0..chain.masses.len()).map(|i| far[i].abs()).fold(0.01, f64::max);
        let spread = near.iter().zip(&far).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if spread < 1e-3 * scale {
            for (i, near) in near.iter().enumerate() {
                let off = (coarse.displacement()[(i, last)] - near).abs();
                prop_assert!(off <= 12.0 * spread + 1e-3 * scale, "{i}: {off:e}, spread {spread:e}");
            }
        }
        // Doubles are near.
        let doubles = chain.run(0.0625, END, Precision::Double).expect("an estimate");
        for i in 0..chain.masses.len() {
            let off = (doubles.trajectory().displacement()[(i, last)] - coarse.displacement()[(i, last)]).abs();
            prop_assert!(off <= 1e-7 * scale, "doubles {i}: {off:e}");
        }
    }
}

fn cases() -> u32 {
    let asked = std::env::var("PROPTEST_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok());
    asked.unwrap_or(64)
}
