//! From instant to instant: the loop that both exact methods share.

use eigentone_digits::{DoubleDouble, product};
use eigentone_modes::FirstOrder;
use faer::{Mat, MatMut, MatRef};

use super::deviation::Deviation;
use super::estimate::Estimate;
use super::queue::{Mark, Queue};
use super::strides::{all_finite, largest};
use crate::answer::{Collector, Operations, Trajectory, Wanted};
use crate::hold::Inputs;
use crate::problem::{Instant, Leg, Piece, Plant, Problem, ResponseError, Walk};

/// z′ = A z + B f in the method's own coordinates, able to step over any interval.
pub(crate) trait Flow {
    /// Moves z over `h` seconds under the [values of signals](crate::hold::Signals::values) at its start.
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &[f64]);

    /// So many steps are best taken together.
    fn together(&self) -> usize;

    /// Takes a step of `h` seconds for each column of `states` under the signals of each, one after the other, and writes the
    /// state after each.
    fn advance_all(
        &mut self,
        h: DoubleDouble,
        z: &mut [f64],
        signals: &[f64],
        states: MatMut<'_, f64>,
    );

    /// How many unit steps cost as much as preparing one step of a new length.
    fn preparation(&self) -> u64;

    /// What it took so far.
    fn operations(&self) -> Operations;
}

/// How the method's coordinates ζ give what is asked for: x = X ζ + D f and its derivatives, of the coordinates and then
/// of the supports.
pub(crate) struct Outputs {
    /// X, X A and X A², of N columns.
    maps: [Map; 3],
    /// D and X B, by which inputs act at once; each absent where it vanishes.
    feed: [Option<Mat<f64>>; 2],
    /// X A B.
    acceleration_feed: Mat<f64>,
}

impl Outputs {
    /// The outputs of a system whose state is z = T ζ.
    pub(crate) fn of(plant: &Plant, t: Option<MatRef<'_, f64>>) -> Outputs {
        let [by_states, by_inputs] = &plant.supports;
        let x = stacked(&plant.x, by_states);
        let d = match &plant.d {
            None if by_inputs.nrows() == 0 => None,
            Some(d) => Some(stacked(d, by_inputs)),
            None => {
                let zero = Mat::zeros(plant.x.nrows(), by_inputs.ncols());
                Some(stacked(&zero, by_inputs))
            }
        };
        let v = product(x.as_ref(), plant.a.as_ref());
        let a = product(v.as_ref(), plant.a.as_ref());
        let pushed = product(x.as_ref(), plant.b.as_ref());
        let feed = [d, (pushed.norm_max() != 0.0).then_some(pushed)];
        let acceleration_feed = product(v.as_ref(), plant.b.as_ref());
        let into = |map: Mat<f64>| match t {
            Some(t) => Map::Full(product(map.as_ref(), t)),
            None => Map::of(map),
        };
        Outputs {
            maps: [into(x), into(v), into(a)],
            feed,
            acceleration_feed,
        }
    }

    /// The largest displacement, velocity and acceleration that inputs of these sizes may make at once.
    pub(super) fn at_once(&self, sizes: &[f64]) -> [f64; 3] {
        let largest = |feed: &Mat<f64>| {
            let row = |i: usize| -> f64 {
                let loaded = sizes.iter().enumerate().filter(|(_, size)| **size != 0.0);
                loaded.map(|(j, size)| feed[(i, j)].abs() * size).sum()
            };
            (0..feed.nrows()).map(row).fold(0.0, f64::max)
        };
        let [d, pushed] = &self.feed;
        let feeds = [d.as_ref(), pushed.as_ref(), Some(&self.acceleration_feed)];
        feeds.map(|feed| feed.map_or(0.0, largest))
    }
}

/// A matrix that states are multiplied by.
enum Map {
    /// Each row is one of the states, or nothing.
    Chosen(Vec<Option<usize>>),
    Full(Mat<f64>),
}

impl Map {
    fn of(matrix: Mat<f64>) -> Map {
        let row = |i: usize| {
            let mut entries = (0..matrix.ncols()).filter(|j| matrix[(i, *j)] != 0.0);
            match (entries.next(), entries.next()) {
                (None, _) => Some(None),
                (Some(j), None) if matrix[(i, j)] == 1.0 => Some(Some(j)),
                _ => None,
            }
        };
        match (0..matrix.nrows()).map(row).collect() {
            Some(rows) => Map::Chosen(rows),
            None => Map::Full(matrix),
        }
    }

    fn rows(&self) -> usize {
        match self {
            Map::Chosen(rows) => rows.len(),
            Map::Full(matrix) => matrix.nrows(),
        }
    }

    /// What it makes of one state.
    fn apply(&self, z: &[f64], to: &mut [f64]) {
        match self {
            Map::Chosen(rows) => {
                for (to, row) in to.iter_mut().zip(rows) {
                    *to = row.map_or(0.0, |at| z[at]);
                }
            }
            Map::Full(matrix) => {
                to.fill(0.0);
                add(to, matrix, z);
            }
        }
    }

    /// What a full one makes of many states, which is one product.
    fn product(&self, states: &Mat<f64>) -> Option<Mat<f64>> {
        match self {
            Map::Chosen(_) => None,
            Map::Full(matrix) => Some(product(matrix.as_ref(), states.as_ref())),
        }
    }
}

fn stacked(above: &Mat<f64>, below: &Mat<f64>) -> Mat<f64> {
    let n = above.nrows();
    Mat::from_fn(n + below.nrows(), above.ncols(), |i, j| match i < n {
        true => above[(i, j)],
        false => below[(i - n, j)],
    })
}

/// How a method's own coordinates ζ are reached, and left.
pub(crate) struct Coordinates<'a> {
    /// N × inputs: what unit impulses add to ζ.
    pub(crate) b: MatRef<'a, f64>,
    /// ζ of a state.
    pub(crate) enter: &'a dyn Fn(&[f64]) -> Vec<f64>,
    pub(crate) outputs: &'a Outputs,
    /// With what the way there and back makes of rounding errors, if it goes by way of modes.
    pub(crate) estimate: Estimate,
    /// How many states are integrals of signals.
    pub(crate) integrals: usize,
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
        ref estimate,
        integrals,
    } = *coordinates;
    let rows = outputs.maps[0].rows();
    let mut recorder = Recorder {
        outputs,
        collector: Collector::new(problem, Wanted::by(problem))?,
        forces: std::array::from_fn(|_| vec![0.0; b.ncols()]),
        sizes: std::array::from_fn(|_| vec![0.0; b.ncols()]),
        motion: std::array::from_fn(|_| vec![0.0; rows]),
        estimate: estimate.clone(),
    };
    for (frequency, sizes) in inputs.amplitudes() {
        let at_once = outputs.at_once(&sizes);
        recorder.estimate.swing(at_once, frequency);
    }
    // What supports have moved is nothing at the start.
    let whole = |mut state: Vec<f64>| {
        state.resize(state.len() + integrals, 0.0);
        enter(&state)
    };
    let mut z = whole(form.state(problem.initial_displacement(), problem.initial_velocity()));
    let state = |x: &[f64]| whole(form.state(x, &vec![0.0; n]));
    let mut deviation = Deviation::new(problem);
    let mut signals = inputs.empty_signals();
    let mut walk = Walk::of(problem);
    let mut queue = Queue::default();
    let together = flow.together();
    let begun = problem.momenta(walk.index());
    add_momenta(begun, walk.index(), problem, outputs, b, &mut z)?;
    while let Some(target) = recorder.collector.after(queue.marks.len()) {
        while let Some(leg) = walk.towards(&target) {
            let Leg::Pass { from, to } = leg else {
                let momenta = problem.momenta(walk.index());
                if deviation.ends(problem, walk.index()) || !momenta.is_empty() {
                    recorder.catch_up(&mut queue, flow, &mut z, &inputs, deviation.rest())?;
                }
                deviation.join(problem, walk.index(), &mut z);
                add_momenta(momenta, walk.index(), problem, outputs, b, &mut z)?;
                continue;
            };
            if deviation.waits(problem, walk.index(), state) {
                // Time after time, so that little of what decays is lost before.
                if queue.len() >= (queue.taken() / 8).max(16).min(together) {
                    recorder.catch_up(&mut queue, flow, &mut z, &inputs, deviation.rest())?;
                }
                if queue.len() == 0 {
                    deviation.split(&mut z);
                }
            }
            let mut now = from;
            while now.order(&to).is_lt() {
                let next = hop(&now, &to, problem, flow.preparation());
                let h = next.elapsed(&now, grid);
                inputs.signals(&now, walk.piece(), h, &mut signals);
                if let Some(sizes) = inputs.cancelled(&signals) {
                    recorder
                        .estimate
                        .cancel(outputs.at_once(&sizes), h.to_f64());
                }
                if deviation.rest().is_some() {
                    signals.values[..inputs.loaded.len()].fill(0.0);
                }
                now = next;
                if together == 1 {
                    flow.advance(h, &mut z, &signals.values);
                    recorder.estimate.step(h.to_f64());
                    continue;
                }
                queue.push(h, &signals.values);
                if queue.len() >= together {
                    recorder.catch_up(&mut queue, flow, &mut z, &inputs, deviation.rest())?;
                }
            }
        }
        if together == 1 {
            recorder.record(&z, &target, &inputs, walk.piece(), deviation.rest())?;
        } else {
            queue.mark(target, walk.piece());
        }
    }
    recorder.catch_up(&mut queue, flow, &mut z, &inputs, deviation.rest())?;
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

/// Adds what the impulses at the start of a piece, and jumps of supports there, do to the state.
fn add_momenta(
    momenta: Vec<(usize, f64)>,
    piece: usize,
    problem: &Problem<'_>,
    outputs: &Outputs,
    b: MatRef<'_, f64>,
    z: &mut [f64],
) -> Result<(), ResponseError> {
    /// Beside its parts, a displacement below this is rounding.
    const ROUNDING: f64 = 1e-12;
    if let Some(d) = &outputs.feed[0] {
        for i in 0..problem.system().len() {
            let parts = momenta
                .iter()
                .map(|(coordinate, momentum)| d[(i, *coordinate)] * momentum);
            let size: f64 = parts.clone().map(f64::abs).sum();
            if parts.clone().sum::<f64>().abs() > ROUNDING * size {
                let first = parts.zip(&momenta).find(|(part, _)| *part != 0.0);
                let coordinate = first.map_or(0, |(_, (coordinate, _))| *coordinate);
                return Err(problem.unresisted(coordinate, piece));
            }
        }
    }
    for (coordinate, magnitude) in momenta {
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
    /// The sizes of the parts of the forces.
    sizes: [Vec<f64>; 3],
    /// Displacements, velocities and accelerations of coordinates and supports.
    motion: [Vec<f64>; 3],
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
        let wanted = self.wanted();
        for (value, map) in self.motion.iter_mut().zip(&self.outputs.maps).take(wanted) {
            map.apply(z, value);
        }
        self.close(now, inputs, piece, rest)
    }

    /// How many of displacements, velocities and accelerations.
    fn wanted(&self) -> usize {
        if self.collector.accelerates() { 3 } else { 2 }
    }

    /// Takes the steps that wait, and records the instants among them.
    fn catch_up(
        &mut self,
        queue: &mut Queue<'_>,
        flow: &mut dyn Flow,
        z: &mut [f64],
        inputs: &Inputs,
        rest: Option<&[f64]>,
    ) -> Result<(), ResponseError> {
        let (states, lengths) = queue.take(
            |h, z, signals, states| flow.advance_all(h, z, signals, states),
            z,
        );
        let wanted = self.wanted();
        let outputs = self.outputs;
        let maps = &outputs.maps[..wanted];
        let products: Vec<_> = maps.iter().map(|map| map.product(&states)).collect();
        let mut done = 0;
        for Mark {
            after,
            instant,
            piece,
        } in queue.marks.drain(..)
        {
            for h in &lengths[done..after] {
                self.estimate.step(*h);
            }
            done = after;
            let each = self.motion.iter_mut().zip(maps.iter().zip(&products));
            for (value, (map, product)) in each {
                match product {
                    Some(product) => value.copy_from_slice(product.col_as_slice(after)),
                    None => map.apply(states.col_as_slice(after), value),
                }
            }
            self.close(&instant, inputs, piece, rest)?;
        }
        for h in &lengths[done..] {
            self.estimate.step(*h);
        }
        Ok(())
    }

    /// Adds what inputs do at once to the motion found, and keeps it.
    fn close(
        &mut self,
        now: &Instant,
        inputs: &Inputs,
        piece: &Piece,
        rest: Option<&[f64]>,
    ) -> Result<(), ResponseError> {
        let accelerates = self.collector.accelerates();
        // What inputs would do at once if their parts did not cancel.
        let mut reached = [0.0; 3];
        let [x, v, a] = &mut self.motion;
        let [d, pushed] = &self.outputs.feed;
        if d.is_some() || pushed.is_some() || accelerates {
            let (forces, sizes) = (&mut self.forces, &mut self.sizes);
            inputs.forces(now, piece, rest.is_some(), forces, sizes);
            let [f, rate, curvature] = &self.forces;
            if let Some(d) = d {
                add(x, d, f);
                add(v, d, rate);
                if accelerates {
                    add(a, d, curvature);
                }
            }
            if let Some(pushed) = pushed {
                add(v, pushed, f);
                if accelerates {
                    add(a, pushed, rate);
                }
            }
            if accelerates {
                add(a, &self.outputs.acceleration_feed, f);
            }
            let each = self.sizes.each_ref();
            let [by_f, by_rate, by_curvature] = each.map(|sizes| self.outputs.at_once(sizes));
            reached = [
                by_f[0],
                by_rate[0] + by_f[1],
                by_curvature[0] + by_rate[1] + by_f[2],
            ];
        }
        for (x, rest) in x.iter_mut().zip(rest.into_iter().flatten()) {
            *x += rest;
        }
        if !all_finite(x) || !all_finite(v) {
            let index = now.index().expect("only grid instants are recorded");
            return Err(ResponseError::Overflow { index });
        }
        for (top, values) in reached.iter_mut().zip([x, v, a]) {
            *top = top.max(largest(values));
        }
        let bounds = self.estimate.bounds(reached);
        self.collector.close(&self.motion, bounds);
        Ok(())
    }
}

/// sum += map · vector.
fn add(sum: &mut [f64], map: &Mat<f64>, vector: &[f64]) {
    for (j, entry) in vector
        .iter()
        .enumerate()
        .filter(|(_, entry)| **entry != 0.0)
    {
        for (sum, factor) in sum.iter_mut().zip(map.col(j).iter()) {
            *sum += factor * entry;
        }
    }
}
