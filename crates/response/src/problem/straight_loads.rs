//! The sums of all straight loads on each coordinate.

use eigentone_digits::Real;

use super::applied_load::AppliedLoad;
use super::instant::Instant;
use super::law::Law;
use super::load::Load;
use super::straight_load::{Known, StraightLoad};

/// The sum of several straight loads in a binary tree, so that a change of one of n takes the work of
/// log n, and every sum is made anew from its parts: no rounding stays behind.
#[derive(Clone, Debug)]
struct Sum<T> {
    /// Node 1 is the root, those below node k are 2k and 2k + 1, the last half are the loads; each from
    /// the latest instant on at which one of its loads changed its law.
    nodes: Vec<Option<(Instant, StraightLoad<T>)>>,
}

impl<T: Real> Sum<T> {
    fn of(loads: usize) -> Sum<T> {
        Sum {
            nodes: vec![None; 2 * loads.next_power_of_two()],
        }
    }

    fn root(&self) -> Option<&(Instant, StraightLoad<T>)> {
        self.nodes[1].as_ref()
    }

    /// Another law for the load of this number; `elapsed` gives the seconds from one instant to another.
    fn set(&mut self, number: usize, law: &Law, elapsed: impl Fn(&Instant, &Instant) -> Known<T>) {
        let mut node = self.nodes.len() / 2 + number;
        self.nodes[node] = Some((law.since, law.start()));
        while node > 1 {
            node /= 2;
            self.nodes[node] = match (&self.nodes[2 * node], &self.nodes[2 * node + 1]) {
                (Some((a_since, a)), Some((b_since, b))) => {
                    Some(if a_since.order(b_since).is_lt() {
                        (*b_since, a.after(elapsed(a_since, b_since)).plus(b))
                    } else {
                        (*a_since, a.plus(&b.after(elapsed(b_since, a_since))))
                    })
                }
                (one, None) => *one,
                (None, other) => *other,
            };
        }
    }
}

/// The straight loads of a problem as time goes on, summed up for each coordinate that has any.
#[derive(Clone, Debug)]
pub(crate) struct StraightLoads<T> {
    /// For each load that runs straight, which of `sums` it belongs to, and its number there.
    places: Vec<Option<(usize, usize)>>,
    /// By rising coordinate.
    sums: Vec<(usize, Sum<T>)>,
}

impl<T: Real> StraightLoads<T> {
    /// Before any has begun.
    pub(crate) fn of(loads: &[AppliedLoad]) -> StraightLoads<T> {
        let runs_straight = |applied: &&AppliedLoad| match applied.load {
            Load::Step(_) | Load::Ramp(_) | Load::Samples(_) | Load::Versine(_) => true,
            Load::Harmonic(_) | Load::Impulse(_) | Load::HalfSine(_) | Load::Polynomial(_) => false,
        };
        let straight = loads.iter().filter(runs_straight);
        let mut coordinates: Vec<usize> = straight.map(|applied| applied.coordinate).collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        let mut counts = vec![0; coordinates.len()];
        let places = loads.iter().map(|applied| {
            let straight = Some(applied).filter(runs_straight)?;
            let place = coordinates.binary_search(&straight.coordinate).ok()?;
            counts[place] += 1;
            Some((place, counts[place] - 1))
        });
        let places = places.collect();
        let sums = coordinates.into_iter().zip(counts);
        StraightLoads {
            places,
            sums: sums.map(|(on, count)| (on, Sum::of(count))).collect(),
        }
    }

    /// A law sets in; `elapsed` gives the seconds from one instant to another.
    pub(crate) fn set(&mut self, law: &Law, elapsed: impl Fn(&Instant, &Instant) -> Known<T>) {
        if let Some((place, number)) = self.places[law.load] {
            self.sums[place].1.set(number, law, elapsed);
        }
    }

    /// Whether one of the sums changes with time, or may.
    pub(crate) fn are_sloped(&self) -> bool {
        let mut roots = self.sums.iter().filter_map(|(_, sum)| sum.root());
        roots.any(|(_, straight)| straight.is_sloped())
    }

    /// The load of one coordinate, where it has one that has begun and `elapsed` gives the seconds since an instant.
    pub(crate) fn of_one(
        &self,
        coordinate: usize,
        elapsed: impl Fn(&Instant) -> Known<T>,
    ) -> Option<StraightLoad<T>> {
        let place = self.sums.binary_search_by_key(&coordinate, |sum| sum.0);
        let (since, straight) = self.sums[place.ok()?].1.root()?;
        Some(straight.after(elapsed(since)))
    }

    /// Coordinate and load of each sum that has begun, where `elapsed` gives the seconds since an instant.
    pub(crate) fn now(
        &self,
        elapsed: impl Fn(&Instant) -> Known<T>,
    ) -> impl Iterator<Item = (usize, StraightLoad<T>)> {
        self.sums.iter().filter_map(move |(coordinate, sum)| {
            let (since, straight) = sum.root()?;
            Some((*coordinate, straight.after(elapsed(since))))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use eigentone_digits::{DoubleDouble, Magnitude};
    use eigentone_modes::{GROUND, System};

    use super::StraightLoads;
    use crate::problem::Piece;
    use crate::{Problem, Ramp, Response, ResponsePlan, Step};

    /// Loads that begin every `spacing` s, in no order.
    fn problem(system: &System, loads: usize, spacing: f64, every: f64) -> Problem<'_> {
        let mut response = Response::of(system);
        for k in 0..loads {
            let start = spacing * ((k * 7919) % loads) as f64;
            let size = if k % 2 == 0 { 1.0 } else { -1.0 };
            response = match k % 3 {
                0 => response.load("m", Ramp::of(size).starting_at(start)),
                _ => response.load("m", Step::of(size).starting_at(start)),
            };
        }
        response
            .every(every)
            .until(spacing * loads as f64)
            .problem()
            .expect("a problem")
    }

    fn oscillator() -> System {
        let mass = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0);
        mass.damper(GROUND, "m", 0.3).build().expect("a system")
    }

    /// The force of every piece, of loads added up one by one.
    #[test]
    fn sums_in_a_tree_are_those_of_all_loads() {
        let system = oscillator();
        for loads in [1, 2, 3, 50] {
            let problem = problem(&system, loads, 8.0 / loads as f64, 0.25);
            let pieces = problem.timeline().pieces();
            for (at, piece) in pieces.iter().enumerate() {
                let (mut found, t) = ([0.0], piece.start() + 0.01);
                let timeline = problem.timeline();
                timeline.signals(at, t, |on, [value, ..]| found[on] += value);
                let each = problem.loads().iter().map(|applied| match &applied.load {
                    crate::Load::Step(step) if step.start <= piece.start() => step.force,
                    crate::Load::Ramp(ramp) if ramp.start <= piece.start() => {
                        ramp.rate * (t - ramp.start)
                    }
                    _ => 0.0,
                });
                let wanted: f64 = each.sum();
                let off = (found[0] - wanted).abs();
                assert!(off < 1e-12, "{at}: {found:?} {wanted}");
            }
        }
    }

    /// Many loads are answered with proof, in as many times more operations as there are more loads, but for the depth of
    /// the tree.
    #[test]
    fn many_loads_take_few_operations_each() {
        let system = oscillator();
        for loads in [500, 4_000] {
            let problem = problem(&system, loads, 1e-3, 1e-3);
            let mut sums = StraightLoads::<DoubleDouble>::of(problem.drives());
            let additions = Cell::new(0);
            for law in problem.timeline().pieces().iter().flat_map(Piece::changes) {
                sums.set(law, |from, to| {
                    additions.set(additions.get() + 1);
                    (to.elapsed(from, problem.grid()), Magnitude::ZERO)
                });
            }
            let depth = loads.next_power_of_two().ilog2() as usize;
            assert!(additions.get() <= loads * depth, "{additions:?}");
            let plan = ResponsePlan::of(&problem).expect("a plan");
            let motion = plan.run(&problem).expect("a motion");
            assert_eq!(motion.bounds(), eigentone_modes::Bounds::Proven);
            let operations = motion.operations();
            assert!(operations.steps <= 2 * loads as u64, "{operations:?}");
            assert!(operations.exponentials <= 64, "{operations:?}");
        }
    }
}
