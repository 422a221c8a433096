//! The designs of a sweep, in their order: runs of them are solved and followed by several threads, and joined by one.

use std::ops::Range;
use std::time::{Duration, Instant};

use eigentone::design::{FollowError, Followed, Follower, Grid};
use eigentone::modes::Modes;
use eigentone::report::SweptDesign;
use eigentone::scene::Scene;
use num_complex::Complex;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::Failure;
use super::study::{Metric, Varied};

/// A block takes about so long: what is done is shown, and no thread waits for long.
const BLOCK: Duration = Duration::from_millis(100);

/// A block has so many runs at most, which are kept until they are joined.
const MOST: usize = 128;

/// What is looked at, and what is reported of it.
pub struct Designs<'a> {
    pub varied: &'a Varied,
    pub grid: &'a Grid,
    pub metrics: &'a [Metric],
}

/// Designs that follow each other, by themselves: roots have the places of the first one's. In few pieces of memory, which one
/// thread asks for and another gives back.
struct Run {
    start: u64,
    roots: Vec<Complex<f64>>,
    /// Which of them have no bound.
    doubts: Vec<bool>,
    metrics: Vec<Option<f64>>,
    followed: Vec<Followed>,
    /// At the first design and the last.
    ends: Option<[Follower; 2]>,
    /// Why there are no more.
    failure: Option<Failure>,
}

/// The designs that others are followed from, by their indices.
type Trail = Vec<(u64, Follower)>;

impl Designs<'_> {
    /// Gives each design to `visit`, until it says that it has seen enough.
    ///
    /// # Errors
    /// The first design that has no answer, and those of `visit`.
    pub fn each(
        &self,
        range: Range<u64>,
        mut visit: impl FnMut(SweptDesign) -> Result<bool, Failure> + Send,
    ) -> Result<(), Failure> {
        let mut trail = Trail::new();
        let mut size = rayon::current_num_threads();
        let mut start = range.start;
        let mut next_block = |size: usize| {
            let mut runs = Vec::new();
            while runs.len() < size && start < range.end {
                let run = self.grid.run(start);
                start = run.end;
                runs.push(run);
            }
            runs
        };
        let mut block = self.solve(&next_block(size), &range);
        while !block.is_empty() {
            let next = next_block(size);
            let begin = Instant::now();
            let join = || -> Result<bool, Failure> {
                for run in block {
                    if !self.join(run, &range, &mut trail, &mut visit)? {
                        return Ok(false);
                    }
                }
                Ok(true)
            };
            let (more, solved) = rayon::join(join, || self.solve(&next, &range));
            if !more? {
                break;
            }
            block = solved;
            if begin.elapsed() < BLOCK {
                size = (2 * size).min(MOST);
            }
        }
        Ok(())
    }

    fn solve(&self, runs: &[Range<u64>], wanted: &Range<u64>) -> Vec<Run> {
        // Threads that take one at a time end together.
        let each = runs.par_iter().with_max_len(1);
        each.map(|run| self.run(run.clone(), wanted)).collect()
    }

    /// Solves designs, and follows them from the first; metrics are measured where they are wanted.
    fn run(&self, run: Range<u64>, wanted: &Range<u64>) -> Run {
        let mut answer = Run {
            start: run.start,
            roots: Vec::new(),
            doubts: Vec::new(),
            metrics: Vec::new(),
            followed: Vec::new(),
            ends: None,
            failure: None,
        };
        let last = wanted.end.min(run.end);
        for index in run.start..last {
            let values = self.grid.design(index).unwrap_or_default();
            let add = |answer: &mut Run| -> Result<(), String> {
                let (scene, modes, found) = self.found(&values)?;
                let followed = match &mut answer.ends {
                    None => {
                        answer.ends = Some([found.clone(), found]);
                        Followed::Surely
                    }
                    Some([_, last]) => self.follow(last, index - 1, &values, found)?,
                };
                if wanted.contains(&index) {
                    self.measure(&scene, &modes, &mut answer.metrics)?;
                }
                if let Some([_, last]) = &answer.ends {
                    answer.roots.extend(last.roots());
                    let bounds = last.bounds().iter();
                    answer
                        .doubts
                        .extend(bounds.map(|bound| bound.is_infinite()));
                }
                answer.followed.push(followed);
                Ok(())
            };
            if let Err(why) = add(&mut answer) {
                answer.failure = Some(self.failure(index, &values, &why));
                break;
            }
        }
        answer
    }

    fn measure(
        &self,
        scene: &Scene,
        modes: &Modes,
        metrics: &mut Vec<Option<f64>>,
    ) -> Result<(), String> {
        for metric in self.metrics {
            let value = self.varied.measure(&metric.kind, scene, modes);
            let value = value.map_err(|why| format!("{}: {why}", metric.text))?;
            metrics.push(value.filter(|value| value.is_finite()));
        }
        Ok(())
    }

    /// Gives the roots of a run the places of those before, and gives its designs to `visit`.
    fn join(
        &self,
        run: Run,
        wanted: &Range<u64>,
        trail: &mut Trail,
        visit: &mut impl FnMut(SweptDesign) -> Result<bool, Failure>,
    ) -> Result<bool, Failure> {
        // Those that it is followed from, and that are not known yet: a part begins anywhere.
        let mut needed = Vec::new();
        let mut at = run.start;
        while let Some(before) = self.grid.before(at) {
            let known = trail.binary_search_by_key(&before, |(known, _)| *known);
            if known.is_ok() {
                break;
            }
            at = self.grid.run(before).start;
            needed.push(at..before + 1);
        }
        for needed in needed.into_iter().rev() {
            let mut run = self.run(needed, &(0..0));
            self.link(&mut run, trail)?;
            if let Some(failure) = run.failure {
                return Err(failure);
            }
        }
        let mut run = run;
        let (followed, order) = self.link(&mut run, trail)?;
        let places = order.len();
        let mut metrics = run.metrics.chunks(self.metrics.len().max(1));
        for (k, within) in run.followed.iter().enumerate() {
            let index = run.start + k as u64;
            if !wanted.contains(&index) {
                continue;
            }
            let own = k * places..(k + 1) * places;
            let (roots, doubts) = (&run.roots[own.clone()], &run.doubts[own]);
            let followed = if k == 0 { followed } else { *within };
            let more = visit(SweptDesign {
                index,
                values: self.grid.design(index).unwrap_or_default(),
                metrics: metrics.next().unwrap_or_default().to_vec(),
                roots: order
                    .iter()
                    .map(|at| [roots[*at].re, roots[*at].im])
                    .collect(),
                doubtful_roots: (0..places).filter(|place| doubts[order[*place]]).collect(),
                has_doubtful_places: followed == Followed::Doubtful,
            })?;
            if !more {
                return Ok(false);
            }
        }
        match run.failure {
            Some(failure) => Err(failure),
            None => Ok(true),
        }
    }

    /// Puts both ends of a run on the trail, which keeps those that others are followed from: how its first design was
    /// followed, and which of its own places stands at each.
    fn link(&self, run: &mut Run, trail: &mut Trail) -> Result<(Followed, Vec<usize>), Failure> {
        let behind = run.followed.len().checked_sub(1);
        let (Some([first, last]), Some(behind)) = (run.ends.take(), behind) else {
            return Ok((Followed::Surely, Vec::new())); // its first design has failed
        };
        let before = self.grid.before(run.start);
        while trail.last().is_some_and(|(known, _)| Some(*known) > before) {
            trail.pop();
        }
        let mut followed = Followed::Surely;
        let mut here = first.clone();
        if let (Some(before), Some((_, follower))) = (before, trail.last()) {
            let values = self.grid.design(run.start).unwrap_or_default();
            here = follower.clone();
            let outcome = self.follow(&mut here, before, &values, first);
            followed = outcome.map_err(|why| self.failure(run.start, &values, &why))?;
            // Along one range nothing more is followed from the design before.
            let step = self.grid.before(before).map(|earlier| before - earlier);
            if step == Some(run.start - before) {
                trail.pop();
            }
        }
        let order = here.order().to_vec();
        let end = run.start + behind as u64;
        // A run that begins elsewhere than behind its neighbour begins where others are followed from.
        if before.is_none_or(|before| before + 1 < run.start) || end == run.start {
            trail.push((run.start, here));
        }
        if end > run.start {
            trail.push((end, last.ordered(&order)));
        }
        Ok((followed, order))
    }

    fn found(&self, values: &[f64]) -> Result<(Scene, Modes, Follower), String> {
        let (scene, modes) = self.varied.solve(values)?;
        let found = Follower::at(scene.system(), &modes).map_err(|error| error.to_string())?;
        Ok((scene, modes, found))
    }

    /// Follows from a design to one that was found.
    fn follow(
        &self,
        follower: &mut Follower,
        before: u64,
        values: &[f64],
        found: Follower,
    ) -> Result<Followed, String> {
        let start = self.grid.design(before).unwrap_or_default();
        let (mut goal, mut why) = (Some(found), None);
        let followed = follower.advance(|t| {
            if t == 1.0 {
                return goal.take();
            }
            let ends = start.iter().zip(values);
            let between: Vec<f64> = ends.map(|(from, to)| from + t * (to - from)).collect();
            let found = self.found(&between).map(|(_, _, found)| found);
            found.map_err(|message| why.get_or_insert(message)).ok()
        });
        match (followed, why) {
            (Err(FollowError::NoDesign), Some(why)) => Err(why),
            (followed, _) => followed.map_err(|error| error.to_string()),
        }
    }

    fn failure(&self, index: u64, values: &[f64], why: &str) -> Failure {
        let design = self.varied.named(values);
        self.varied
            .refuse(format!("design {index} ({design}): {why}"))
    }
}
