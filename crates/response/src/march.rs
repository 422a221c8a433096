//! From instant to instant: the loop that both exact methods share.

use eigentone_digits::DoubleDouble;
use eigentone_modes::FirstOrder;
use faer::{Mat, MatRef};

use crate::collector::{Collector, Wanted};
use crate::deviation::Deviation;
use crate::estimate::{Detour, Estimate};
use crate::hold::Laws;
use crate::operations::Operations;
use crate::problem::{Problem, ResponseError};
use crate::timeline::{Instant, Piece};
use crate::trajectory::Trajectory;
use crate::walk::{Leg, Walk};

/// z′ = A z + B f in the method's own coordinates, able to step over any interval.
pub(crate) trait Flow {
    /// Moves z over `h` seconds under the signals that hold at its start.
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &Signals);

    /// How many unit steps cost as much as preparing one step of a new length.
    fn preparation(&self) -> u64;

    /// What it took so far.
    fn operations(&self) -> Operations;
}

/// What the loads are at the start of an interval: for each law one value for each loaded
/// coordinate, in the order of [`crate::hold::Held::gamma`]; slopes are multiplied by the
/// interval's length.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    pub(crate) values: Vec<Vec<f64>>,
}

/// The loads of a problem, by loaded coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    /// Indices of the coordinates that any load but an impulse acts on.
    pub(crate) loaded: Vec<usize>,
    pub(crate) laws: Laws,
    /// Position in `loaded`, position in `laws.frequencies`, amplitude, phase.
    harmonics: Vec<(usize, usize, f64, f64)>,
}

impl Inputs {
    pub(crate) fn of(problem: &Problem<'_>) -> Inputs {
        let timeline = problem.timeline();
        let straight = || timeline.pieces().iter().flat_map(Piece::straight);
        let mut loaded: Vec<usize> = straight().map(|straight| straight.coordinate).collect();
        loaded.extend(
            timeline
                .harmonics()
                .iter()
                .map(|(coordinate, _)| *coordinate),
        );
        loaded.sort_unstable();
        loaded.dedup();
        let mut frequencies: Vec<f64> = Vec::new();
        let mut harmonics = Vec::new();
        for (coordinate, harmonic) in timeline.harmonics() {
            let position = loaded.binary_search(coordinate).expect("collected above");
            let known = frequencies
                .iter()
                .position(|known| *known == harmonic.frequency);
            let frequency = known.unwrap_or_else(|| {
                frequencies.push(harmonic.frequency);
                frequencies.len() - 1
            });
            harmonics.push((position, frequency, harmonic.amplitude, harmonic.phase));
        }
        let laws = Laws {
            straight: straight().any(|s| s.value != 0.0 || s.slope != 0.0),
            sloped: straight().any(|s| s.slope != 0.0),
            frequencies,
        };
        Inputs {
            loaded,
            laws,
            harmonics,
        }
    }

    /// The columns of B for the loaded coordinates.
    pub(crate) fn columns(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(b.nrows(), self.loaded.len(), |i, j| b[(i, self.loaded[j])])
    }

    /// The signals at `now`, within `piece`, for an interval of `h` seconds.
    pub(crate) fn signals(&self, now: &Instant, piece: &Piece, h: f64, signals: &mut Signals) {
        for values in &mut signals.values {
            values.fill(0.0);
        }
        let elapsed = (now.time - piece.start.time).to_f64();
        if self.laws.straight {
            for straight in piece.straight() {
                let j = self
                    .loaded
                    .binary_search(&straight.coordinate)
                    .expect("collected in of");
                signals.values[0][j] = straight.value + straight.slope * elapsed;
                if self.laws.sloped {
                    signals.values[1][j] = straight.slope * h;
                }
            }
        }
        let first = usize::from(self.laws.straight) + usize::from(self.laws.sloped);
        for &(j, frequency, amplitude, phase) in &self.harmonics {
            let angle = reduced_angle(self.laws.frequencies[frequency], now.time, phase);
            let (sine, cosine) = angle.sin_cos();
            signals.values[first + 2 * frequency][j] += amplitude * sine;
            signals.values[first + 2 * frequency + 1][j] += amplitude * cosine;
        }
    }

    pub(crate) fn empty_signals(&self) -> Signals {
        let laws = &self.laws;
        let count =
            usize::from(laws.straight) + usize::from(laws.sloped) + 2 * laws.frequencies.len();
        Signals {
            values: vec![vec![0.0; self.loaded.len()]; count],
        }
    }

    /// f, f′ and f″ on every coordinate at `now`, of those loads that are not `split` off.
    fn forces(&self, now: &Instant, piece: &Piece, split: bool, forces: &mut [Vec<f64>; 3]) {
        for force in forces.iter_mut() {
            force.fill(0.0);
        }
        let elapsed = (now.time - piece.start.time).to_f64();
        for straight in piece.straight().iter().filter(|_| !split) {
            forces[0][straight.coordinate] += straight.value + straight.slope * elapsed;
            forces[1][straight.coordinate] += straight.slope;
        }
        for &(j, frequency, amplitude, phase) in &self.harmonics {
            let rate = self.laws.frequencies[frequency];
            let (sine, cosine) = reduced_angle(rate, now.time, phase).sin_cos();
            let coordinate = self.loaded[j];
            forces[0][coordinate] += amplitude * sine;
            forces[1][coordinate] += amplitude * rate * cosine;
            forces[2][coordinate] -= amplitude * rate * rate * sine;
        }
    }
}

/// Ωt + φ less whole turns, kept in double-double until the end.
pub(crate) fn reduced_angle(frequency: f64, time: DoubleDouble, phase: f64) -> f64 {
    let angle = time * frequency;
    let turns = (angle.to_f64() / std::f64::consts::TAU).round();
    let rest = angle - DoubleDouble::TAU * turns + phase;
    rest.to_f64()
}

/// How the method's coordinates ζ give what is asked for: x = X ζ + D f and its derivatives.
pub(crate) struct Outputs {
    /// X, X A and X A² (n × N).
    maps: [Mat<f64>; 3],
    /// D and X B, by which loads act on massless nodes at once; each absent where it vanishes.
    feed: [Option<Mat<f64>>; 2],
    /// X A B.
    acceleration_feed: Mat<f64>,
}

impl Outputs {
    /// The outputs of a first-order form whose state is z = T ζ.
    pub(crate) fn of(form: &FirstOrder, t: Option<MatRef<'_, f64>>) -> Outputs {
        let x = form.x().to_owned();
        let v = &x * form.a();
        let a = &v * form.a();
        let pushed = &x * form.b();
        let feed = [
            form.d().map(|d| d.to_owned()),
            (pushed.norm_max() != 0.0).then_some(pushed),
        ];
        let acceleration_feed = &v * form.b();
        let into = |map: Mat<f64>| match t {
            Some(t) => map * t,
            None => map,
        };
        Outputs {
            maps: [into(x), into(v), into(a)],
            feed,
            acceleration_feed,
        }
    }
}

/// How a method's own coordinates ζ are reached, and left.
pub(crate) struct Coordinates<'a> {
    /// N × n: what unit impulses add to ζ.
    pub(crate) b: MatRef<'a, f64>,
    /// ζ of a state.
    pub(crate) enter: &'a dyn Fn(&[f64]) -> Vec<f64>,
    pub(crate) outputs: &'a Outputs,
    /// What the way there and back makes of rounding errors.
    pub(crate) detour: Detour,
}

/// Runs the flow over the problem's timeline and collects the instants asked for.
pub(crate) fn march(
    method: &'static str,
    problem: &Problem<'_>,
    flow: &mut dyn Flow,
    form: &FirstOrder,
    coordinates: &Coordinates<'_>,
) -> Result<Trajectory, ResponseError> {
    let grid = problem.grid();
    let inputs = Inputs::of(problem);
    let n = problem.system().len();
    let Coordinates {
        b,
        enter,
        outputs,
        detour,
    } = *coordinates;
    let mut recorder = Recorder {
        outputs,
        collector: Collector::new(problem, Wanted::by(problem))?,
        forces: [vec![0.0; n], vec![0.0; n], vec![0.0; n]],
        estimate: Estimate::of(problem.system(), form).by_way_of(detour),
    };
    let mut z = enter(&form.state(problem.initial_displacement(), problem.initial_velocity()));
    let state = |x: &[f64]| enter(&form.state(x, &vec![0.0; n]));
    let mut deviation = Deviation::new(problem);
    let mut signals = inputs.empty_signals();
    let mut walk = Walk::of(problem);
    strike(walk.piece(), problem, outputs, b, &mut z)?;
    while let Some(target) = recorder.collector.next() {
        while let Some(leg) = walk.towards(&target) {
            let Leg::Pass { from, to } = leg else {
                deviation.join(problem, walk.index(), &mut z);
                strike(walk.piece(), problem, outputs, b, &mut z)?;
                continue;
            };
            deviation.split(problem, walk.index(), &mut z, state);
            let mut now = from;
            while now.order(&to).is_lt() {
                let next = hop(&now, &to, problem, flow.preparation());
                let h = next.elapsed(&now, grid);
                inputs.signals(&now, walk.piece(), h.to_f64(), &mut signals);
                if deviation.rest().is_some() {
                    signals.values[0].fill(0.0);
                }
                flow.advance(h, &mut z, &signals);
                now = next;
                recorder.estimate.step(h.to_f64());
            }
        }
        recorder.record(&z, &target, &inputs, walk.piece(), deviation.rest())?;
    }
    Ok(recorder.collector.finish(method).after(flow.operations()))
}

/// The next instant on the way to `end`: the end itself, or one grid step where several of them are
/// cheaper than preparing one long step.
fn hop(now: &Instant, end: &Instant, problem: &Problem<'_>, preparation: u64) -> Instant {
    match (now.index(), end.index()) {
        (Some(from), Some(to)) if to - from > 1 && to - from <= preparation => {
            Instant::on_grid(problem.grid(), from + 1)
        }
        _ => *end,
    }
}

/// Adds what the impulses at the start of a piece do to the state.
fn strike(
    piece: &Piece,
    problem: &Problem<'_>,
    outputs: &Outputs,
    b: MatRef<'_, f64>,
    z: &mut [f64],
) -> Result<(), ResponseError> {
    for &(coordinate, magnitude) in piece.impulses() {
        let moves_at_once =
            |d: &Mat<f64>| (0..d.nrows()).any(|i| d[(i, coordinate)] * magnitude != 0.0);
        if outputs.feed[0].as_ref().is_some_and(moves_at_once) {
            return Err(problem.unresisted(coordinate));
        }
        for (entry, column) in z.iter_mut().zip(b.col(coordinate).iter()) {
            *entry += column * magnitude;
        }
    }
    Ok(())
}

/// Turns states into what was asked for.
struct Recorder<'a, 'b> {
    outputs: &'a Outputs,
    collector: Collector<'a, 'b>,
    forces: [Vec<f64>; 3],
    estimate: Estimate,
}

impl Recorder<'_, '_> {
    fn record(
        &mut self,
        z: &[f64],
        now: &Instant,
        inputs: &Inputs,
        piece: &Piece,
        rest: Option<&[f64]>,
    ) -> Result<(), ResponseError> {
        let n = self.forces[0].len();
        let column = self.collector.column();
        for (value, map) in self.collector.values.iter_mut().zip(&self.outputs.maps) {
            if value.ncols() == 0 {
                continue;
            }
            for (j, entry) in z.iter().enumerate() {
                for i in 0..n {
                    value[(i, column)] += map[(i, j)] * entry;
                }
            }
        }
        let [x, v, a] = &mut self.collector.values;
        let [d, pushed] = &self.outputs.feed;
        if d.is_some() || pushed.is_some() || a.ncols() > 0 {
            inputs.forces(now, piece, rest.is_some(), &mut self.forces);
            let [f, rate, curvature] = &self.forces;
            let add = |to: &mut Mat<f64>, map: &Mat<f64>, force: &[f64]| {
                for (j, entry) in force.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                    for i in 0..n {
                        to[(i, column)] += map[(i, j)] * entry;
                    }
                }
            };
            if let Some(d) = d {
                add(x, d, f);
                add(v, d, rate);
                if a.ncols() > 0 {
                    add(a, d, curvature);
                }
            }
            if let Some(pushed) = pushed {
                add(v, pushed, f);
                if a.ncols() > 0 {
                    add(a, pushed, rate);
                }
            }
            if a.ncols() > 0 {
                add(a, &self.outputs.acceleration_feed, f);
            }
        }
        for (i, rest) in rest.into_iter().flatten().enumerate() {
            x[(i, column)] += rest;
        }
        let largest = |m: &Mat<f64>| {
            m.col(column).iter().fold(0.0, |top: f64, entry| {
                if entry.abs() > top || entry.is_nan() {
                    entry.abs()
                } else {
                    top
                }
            })
        };
        let (displacement, velocity) = (largest(x), largest(v));
        if !displacement.is_finite() || !velocity.is_finite() {
            let index = now.index().expect("only grid instants are recorded");
            return Err(ResponseError::Overflow { index });
        }
        let (displacement, velocity) = self.estimate.bounds(displacement, velocity);
        self.collector.close(displacement, velocity);
        Ok(())
    }
}
