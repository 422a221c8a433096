//! The least maximum of several smooth functions within limits.
//!
//! Starts spread over the limits (Halton 1960) lead to local searches by sequential quadratic programming with a trust region
//! (Madsen 1975, *An algorithm for minimax solution of overdetermined systems*; Hald & Madsen 1981): each step minimises
//! max_j f_j + g_jᵀd + ½dᵀBd, where B is the curvature of the functions as the multipliers weigh them. Gradients are those that
//! are given; where none are, the last steps take differences of eighth order, so that the point is as good as the functions'
//! digits. Where functions are not smooth, meshes that become finer go on (Audet & Dennis 2006).

use eigentone_digits::{sort_by_number, symmetric_eigen, symmetric_eigenvalues};
use faer::Mat;
use thiserror::Error;

use crate::difference::difference;
use crate::programme::{Programme, Step};

/// A function at a point. What is minimised is the largest value of all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// What distinguishes it from the others where there are several, such as the logarithm of a frequency: continuous along the
    /// parameters.
    pub place: f64,
    /// Its value.
    pub value: f64,
}

/// Where the largest function is least, and what shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimum {
    /// The parameters.
    pub point: Vec<f64>,
    /// The largest function there.
    pub value: f64,
    /// The functions that are equally large there, with the weights by which their gradients cancel.
    pub active: Vec<(Piece, f64)>,
    /// How far the active functions are from equal, in parts of the largest.
    pub spread: f64,
    /// The length of what is left of the weighted gradients, those at limits left out, in parts of the largest gradient.
    /// Infinite where no derivatives could be computed.
    pub gradient: f64,
    /// The least curvature along which the active functions stay equal, in parts of the value and of the squared ranges of the
    /// parameters; `None` where they leave no direction, and where there are no derivatives.
    pub curvature: Option<f64>,
    /// Which parameters are at a limit of their range: −1 at the lower one, 1 at the upper one, 0 between.
    pub limits: Vec<i8>,
    /// Whether the largest function has the same value, but for rounding, wherever it was evaluated.
    pub is_constant: bool,
    /// What other starts have led to, the least first; this optimum is not among them.
    pub others: Vec<f64>,
    /// How many points have been evaluated.
    pub evaluations: usize,
}

impl Optimum {
    /// Whether derivatives show a local minimum: the gradients cancel with weights that are not negative, and what is left
    /// curves upwards.
    pub fn is_shown(&self) -> bool {
        let curved = self.curvature.is_none_or(|curvature| curvature > 0.0);
        self.is_balanced() && curved
    }

    /// Whether the active functions are equally large, and their weighted gradients cancel.
    pub fn is_balanced(&self) -> bool {
        const NOTHING: f64 = 1e-6;
        self.gradient <= NOTHING && self.spread <= NOTHING
    }
}

/// Why there is no optimum.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OptimumError {
    /// Too many parameters, or none.
    #[error("there are {count} parameters: give 1 to {MOST}")]
    Count {
        /// How many.
        count: usize,
    },
    /// Limits that leave nothing between them.
    #[error("{low:?} to {high:?} is no range: give two finite numbers, the lower one first")]
    Limits {
        /// The first.
        low: f64,
        /// The second.
        high: f64,
    },
    /// The functions have no value anywhere.
    #[error("no value is finite at any of {tried} points within the limits")]
    Nowhere {
        /// How many.
        tried: usize,
    },
}

/// The most parameters.
const MOST: usize = 8;

const PRIMES: [usize; MOST] = [2, 3, 5, 7, 11, 13, 17, 19];

/// Parameters with a ratio of limits beyond this vary by ratios.
const WIDE: f64 = 10.0;

/// What functions are taken to err by, in parts of them.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Whether a value is better than another by more than rounding.
pub(crate) fn surpasses(one: f64, other: f64) -> bool {
    one < other - ROUNDING * other.abs()
}

/// Meshes go out from so many points, each the best so far.
const MESHES: usize = 3;

/// Finds the least maximum within limits. `pieces` gives the functions at a point, or `None` where there are none; they may come in
/// any order and number.
///
/// ```
/// use eigentone_design::{Piece, minimise};
///
/// // The kink of two parabolas.
/// let optimum = minimise(&[(-3.0, 4.0)], |x| {
///     let values = [(0.0, x[0] * x[0]), (1.0, (x[0] - 2.0) * (x[0] - 2.0))];
///     Some(values.map(|(place, value)| Piece { place, value }).to_vec())
/// })?;
/// assert!((optimum.point[0] - 1.0).abs() < 1e-12);
/// assert_eq!(optimum.active.len(), 2);
/// assert!(optimum.is_shown());
/// # Ok::<(), eigentone_design::OptimumError>(())
/// ```
///
/// # Errors
/// [`OptimumError`].
pub fn minimise(
    limits: &[(f64, f64)],
    pieces: impl FnMut(&[f64]) -> Option<Vec<Piece>>,
) -> Result<Optimum, OptimumError> {
    minimise_with(limits, pieces, |_| None)
}

/// The same with gradients: `gradients` gives each function at a point with its derivatives by the parameters, or `None` where
/// differences are to be taken.
///
/// ```
/// use eigentone_design::{Piece, minimise_with};
///
/// let piece = |x: f64| Piece { place: 0.0, value: x.cosh() - 0.5 * x };
/// let optimum = minimise_with(
///     &[(-3.0, 4.0)],
///     |x| Some(vec![piece(x[0])]),
///     |x| Some(vec![(piece(x[0]), vec![x[0].sinh() - 0.5])]),
/// )?;
/// assert!((optimum.point[0] - 0.5f64.asinh()).abs() < 1e-15);
/// # Ok::<(), eigentone_design::OptimumError>(())
/// ```
///
/// # Errors
/// [`OptimumError`].
pub fn minimise_with(
    limits: &[(f64, f64)],
    pieces: impl FnMut(&[f64]) -> Option<Vec<Piece>>,
    gradients: impl FnMut(&[f64]) -> Option<Vec<(Piece, Vec<f64>)>>,
) -> Result<Optimum, OptimumError> {
    minimise_from(None, limits, pieces, gradients)
}

/// The same by a search from one point alone, if there is one.
pub(crate) fn minimise_from(
    start: Option<&[f64]>,
    limits: &[(f64, f64)],
    pieces: impl FnMut(&[f64]) -> Option<Vec<Piece>>,
    gradients: impl FnMut(&[f64]) -> Option<Vec<(Piece, Vec<f64>)>>,
) -> Result<Optimum, OptimumError> {
    let n = limits.len();
    if !(1..=MOST).contains(&n) {
        return Err(OptimumError::Count { count: n });
    }
    for &(low, high) in limits {
        if !(low < high && (high - low).is_finite()) {
            return Err(OptimumError::Limits { low, high });
        }
    }
    let mut search = Search {
        limits,
        pieces,
        gradients,
        evaluations: 0,
        least: None,
        most: f64::NEG_INFINITY,
    };
    let starts = match start {
        Some(start) => search.station(inside(limits, start)).into_iter().collect(),
        None => search.starts(),
    };
    let tried = search.evaluations;
    let mut found: Vec<Station> = Vec::new();
    for start in starts {
        found.push(search.descend(start));
    }
    sort_by_number(&mut found, |one| one.worst());
    let mut found = found.into_iter();
    let best = found.next().ok_or(OptimumError::Nowhere { tried })?;
    let mut optimum = search.finish(best);
    let mut is_left = !optimum.is_shown();
    for _ in 0..MESHES {
        let least = search.least.clone();
        let Some(least) = least.filter(|least| is_left || surpasses(least.worst(), optimum.value))
        else {
            break;
        };
        let meshed = search.mesh(least);
        let next = search.descend(meshed);
        let next = search.finish(next);
        if next.value < optimum.value || next.is_shown() && next.value <= optimum.value {
            optimum = next;
        }
        is_left = false;
    }
    // What is beside a place without derivatives may still be better than it.
    let least = search.least.clone();
    if let Some(least) = least.filter(|least| surpasses(least.worst(), optimum.value)) {
        optimum = search.unshown(&least);
    }
    optimum.is_constant = search.is_constant();
    optimum.others = found.map(|station| station.worst()).collect();
    optimum.evaluations = search.evaluations;
    Ok(optimum)
}

struct Search<'a, F, G> {
    limits: &'a [(f64, f64)],
    pieces: F,
    gradients: G,
    evaluations: usize,
    /// The best of all points.
    least: Option<Station>,
    /// The largest value of all.
    most: f64,
}

/// A point in parts of the ranges, and the functions there.
#[derive(Clone, Debug)]
struct Station {
    at: Vec<f64>,
    pieces: Vec<Piece>,
}

impl Station {
    fn worst(&self) -> f64 {
        let values = self.pieces.iter().map(|piece| piece.value);
        values.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The functions that have derivatives at a point.
struct Derivatives {
    pieces: Vec<Piece>,
    gradients: Vec<Vec<f64>>,
    curvatures: Vec<Mat<f64>>,
    /// Whether the gradients are those that were given.
    are_given: bool,
}

impl Derivatives {
    /// The most that the curvature of a function changes it by along a step.
    fn bend(&self, step: &[f64]) -> f64 {
        let n = step.len();
        let each = self.curvatures.iter().map(|curvature| {
            let along = |i: usize| (0..n).map(|k| curvature[(i, k)] * step[k]).sum::<f64>();
            let square: f64 = (0..n).map(|i| step[i] * along(i)).sum();
            square.abs() / 2.0
        });
        each.fold(0.0, f64::max)
    }
}

impl<F, G> Search<'_, F, G>
where
    F: FnMut(&[f64]) -> Option<Vec<Piece>>,
    G: FnMut(&[f64]) -> Option<Vec<(Piece, Vec<f64>)>>,
{
    /// Whether no point is better than another.
    fn is_constant(&self) -> bool {
        let least = self.least.as_ref().map(Station::worst);
        !least.is_some_and(|least| surpasses(least, self.most))
    }

    /// Parameters from parts of the ranges.
    fn outside(&self, at: &[f64]) -> Vec<f64> {
        let each = self.limits.iter().zip(at);
        let each = each.map(|(&(low, high), &u)| match u {
            0.0 => low,
            1.0 => high,
            u => match Scale::of(low, high) {
                // In two steps: the ratio to `low` may itself be beyond doubles.
                Scale::Ratios(range) if !(high / low).is_finite() => {
                    let half = (0.5 * u * range).exp();
                    low * half * half
                }
                Scale::Ratios(range) => low * (u * range).exp(),
                Scale::FromZero => high * ((u * FROM_ZERO.ln_1p()).exp_m1() / FROM_ZERO),
                Scale::Even => low + u * (high - low),
            },
        });
        each.collect()
    }

    /// The gradients that are given, of all functions at a point, by parts of the ranges.
    fn given(&mut self, here: &Station) -> Option<Vec<Vec<f64>>> {
        let point = self.outside(&here.at);
        let known = (self.gradients)(&point)?;
        let units: Vec<f64> = self
            .limits
            .iter()
            .zip(&point)
            .map(|(&(low, high), &x)| match Scale::of(low, high) {
                Scale::Ratios(range) => x * range,
                Scale::FromZero => (x + high / FROM_ZERO) * FROM_ZERO.ln_1p(),
                Scale::Even => high - low,
            })
            .collect();
        let each = here.pieces.iter().map(|piece| {
            let (_, gradient) = known.iter().find(|(known, _)| known.place == piece.place)?;
            let parts = gradient
                .iter()
                .zip(&units)
                .map(|(slope, unit)| slope * unit);
            let parts: Vec<f64> = parts.collect();
            let known = parts.len() == units.len() && parts.iter().all(|part| part.is_finite());
            known.then_some(parts)
        });
        each.collect()
    }

    fn station(&mut self, at: Vec<f64>) -> Option<Station> {
        self.evaluations += 1;
        let point = self.outside(&at);
        let pieces = (self.pieces)(&point)?;
        let known = !pieces.is_empty() && pieces.iter().all(|piece| piece.value.is_finite());
        let station = known.then_some(Station { at, pieces })?;
        self.most = self.most.max(station.worst());
        let is_least = |least: &Station| station.worst() < least.worst();
        if self.least.as_ref().is_none_or(is_least) {
            self.least = Some(station.clone());
        }
        Some(station)
    }

    /// The best of the corners and of a sequence that fills the limits, apart from each other.
    fn starts(&mut self) -> Vec<Station> {
        /// So many points for each parameter.
        const POINTS: usize = 40;
        /// Searches go out from so many.
        const SEARCHES: usize = 8;
        let n = self.limits.len();
        // Twice the share of each point: those nearer to a better one are taken to lead where it does (Rinnooy Kan & Timmer 1987).
        let apart = (2.0 / (POINTS * n) as f64).powf(1.0 / n as f64);
        let mut all: Vec<Station> = Vec::new();
        for index in 1..=POINTS * n {
            let at = PRIMES[..n].iter().map(|base| halton(index, *base));
            all.extend(self.station(at.collect()));
        }
        // The sequence leaves the corners' neighbourhoods out, and what only grows is least in one of them.
        for corner in 0..1u32 << n {
            let at = (0..n).map(|i| f64::from(corner >> i & 1));
            all.extend(self.station(at.collect()));
        }
        sort_by_number(&mut all, |one| one.worst());
        let mut kept: Vec<Station> = Vec::new();
        for station in all {
            let far = |other: &Station| {
                let parts = station.at.iter().zip(&other.at);
                parts.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > apart
            };
            if kept.len() < SEARCHES && kept.iter().all(far) {
                kept.push(station);
            }
        }
        kept
    }

    /// Steps of a trust region until none is better.
    fn descend(&mut self, start: Station) -> Station {
        const STEPS: usize = 60;
        const SHORTEST: f64 = 1e-7;
        let mut here = start;
        let mut radius = 0.1f64;
        let mut weights: Option<Vec<f64>> = None;
        let mut known: Option<Derivatives> = None;
        for _ in 0..STEPS {
            let derivatives = match known.take() {
                Some(known) => known,
                None => match self.derivatives(&here) {
                    Some(known) => known,
                    None => return here,
                },
            };
            let Some(step) = self.step(&here, &derivatives, radius, weights.as_deref()) else {
                return here;
            };
            let length = step.by.iter().fold(0.0f64, |most, d| most.max(d.abs()));
            let expected = here.worst() - step.value;
            if length < SHORTEST || expected <= 1e-14 * here.worst().abs() {
                return here;
            }
            let at = moved(&here.at, &step.by);
            let next = self.station(at);
            let gained = next
                .as_ref()
                .map_or(0.0, |next| here.worst() - next.worst());
            let ratio = gained / expected;
            if ratio < 0.25 {
                radius = (length / 4.0).min(radius / 2.0);
            } else if ratio > 0.75 {
                radius = (radius * 2.0).min(0.5);
            }
            match next {
                Some(next) if gained > 0.0 => {
                    weights = Some(step.weights).filter(|_| next.pieces.len() == here.pieces.len());
                    here = next;
                }
                _ => known = Some(derivatives),
            }
            if radius < SHORTEST {
                return here;
            }
        }
        here
    }

    /// The step that the quadratic model likes best.
    fn step(
        &self,
        here: &Station,
        known: &Derivatives,
        radius: f64,
        weights: Option<&[f64]>,
    ) -> Option<Step> {
        let worst = here.worst();
        let first = |piece: &Piece| if piece.value == worst { 1.0 } else { 0.0 };
        let weights = weights.filter(|weights| weights.len() == known.pieces.len());
        let mut weights: Vec<f64> = match weights {
            Some(weights) => weights.to_vec(),
            None => known.pieces.iter().map(first).collect(),
        };
        let mut step = None;
        // The curvature follows the weights that it leads to.
        for _ in 0..3 {
            let programme = Programme {
                values: known.pieces.iter().map(|piece| piece.value).collect(),
                gradients: &known.gradients,
                curvature: upwards(&self.curvature(here, known, &weights)),
                low: here.at.iter().map(|u| (-radius).max(-u)).collect(),
                high: here.at.iter().map(|u| radius.min(1.0 - u)).collect(),
            };
            let found = programme.solve()?;
            weights.clone_from(&found.weights);
            step = Some(found);
        }
        step
    }

    /// The curvature of the weighed functions. A parameter that their gradient holds at a limit does not bend the others.
    fn curvature(&self, here: &Station, known: &Derivatives, weights: &[f64]) -> Mat<f64> {
        let mut curvature = weighed(&known.curvatures, weights);
        let n = here.at.len();
        for i in 0..n {
            let each = known.gradients.iter().zip(weights);
            let slope: f64 = each.map(|(gradient, weight)| weight * gradient[i]).sum();
            let is_held = match limit(here.at[i]) {
                0 => false,
                side => f64::from(side) * slope < 0.0,
            };
            for k in (0..n).filter(|k| is_held && *k != i) {
                (curvature[(i, k)], curvature[(k, i)]) = (0.0, 0.0);
            }
        }
        curvature
    }

    /// First and second derivatives by differences, of the functions that can be distinguished from each other.
    fn derivatives(&mut self, here: &Station) -> Option<Derivatives> {
        const H: f64 = 1e-3;
        let n = here.at.len();
        let centre: Vec<f64> = here.at.iter().map(|u| u.clamp(H, 1.0 - H)).collect();
        let mut offsets: Vec<Vec<(usize, f64)>> = vec![Vec::new()];
        for i in 0..n {
            offsets.push(vec![(i, H)]);
            offsets.push(vec![(i, -H)]);
        }
        for i in 0..n {
            for j in 0..i {
                offsets.push(vec![(i, H), (j, H)]);
                offsets.push(vec![(i, -H), (j, -H)]);
            }
        }
        let mut around = Vec::new();
        for offset in offsets {
            let mut at = centre.clone();
            offset.iter().for_each(|&(i, h)| at[i] += h);
            around.push(self.station(at)?.pieces);
        }
        let given = self.given(here);
        let mut known = Derivatives {
            pieces: Vec::new(),
            gradients: Vec::new(),
            curvatures: Vec::new(),
            are_given: given.is_some(),
        };
        for (j, piece) in here.pieces.iter().enumerate() {
            let Some(f) = follow(piece, &here.pieces, &around) else {
                if piece.value == here.worst() {
                    return None;
                }
                continue;
            };
            let (up, down) = (|i: usize| f[1 + 2 * i], |i: usize| f[2 + 2 * i]);
            let mut curvature = Mat::<f64>::zeros(n, n);
            let mut pair = 1 + 2 * n;
            for i in 0..n {
                curvature[(i, i)] = (up(i) - 2.0 * f[0] + down(i)) / (H * H);
                for j in 0..i {
                    let both = f[pair] + f[pair + 1] + 2.0 * f[0];
                    let mixed = (both - up(i) - down(i) - up(j) - down(j)) / (2.0 * H * H);
                    (curvature[(i, j)], curvature[(j, i)]) = (mixed, mixed);
                    pair += 2;
                }
            }
            let gradient = (0..n).map(|i| {
                let away = (0..n).map(|j| curvature[(i, j)] * (here.at[j] - centre[j]));
                (up(i) - down(i)) / (2.0 * H) + away.sum::<f64>()
            });
            known.gradients.push(match &given {
                Some(given) => given[j].clone(),
                None => gradient.collect(),
            });
            known.curvatures.push(curvature);
            known.pieces.push(*piece);
        }
        Some(known)
    }

    /// Gradients of eighth order, in the places of those known, from the spacing at which neighbouring spacings agree best.
    fn sharpen(&mut self, here: &Station, known: &mut Derivatives) -> Option<()> {
        const SPACINGS: [f64; 6] = [1e-2, 4e-3, 1.6e-3, 6.4e-4, 2.5e-4, 1e-4];
        for i in 0..here.at.len() {
            let mut all: Vec<Vec<f64>> = Vec::new();
            for h in SPACINGS {
                // As many of the nine nodes below as the limits allow.
                let below = (0..=8usize).min_by_key(|below| {
                    let low = here.at[i] - *below as f64 * h;
                    let high = here.at[i] + (8 - below) as f64 * h;
                    let out = (-low).max(high - 1.0).max(0.0);
                    ((out / h).ceil() as usize, below.abs_diff(4))
                })?;
                let nodes: Option<Vec<Vec<Piece>>> = (0..=8usize)
                    .map(|node| {
                        let mut at = here.at.clone();
                        at[i] = (at[i] + (node as f64 - below as f64) * h).clamp(0.0, 1.0);
                        match node == below {
                            true => Some(here.pieces.clone()),
                            false => self.station(at).map(|station| station.pieces),
                        }
                    })
                    .collect();
                // Wide spacings may leave where the functions are.
                let Some(around) = nodes else {
                    continue;
                };
                let weights = difference(below);
                let each = known.pieces.iter().map(|piece| {
                    let values = follow(piece, &here.pieces, &around)?;
                    let terms = values.iter().zip(weights).map(|(f, w)| f * w);
                    Some(terms.sum::<f64>() / h)
                });
                all.extend(each.collect::<Option<Vec<f64>>>());
            }
            for (j, gradient) in known.gradients.iter_mut().enumerate() {
                let best = (1..all.len()).min_by(|a, b| {
                    let gap = |k: usize| (all[k][j] - all[k - 1][j]).abs();
                    gap(*a).total_cmp(&gap(*b))
                })?;
                gradient[i] = all[best - 1][j];
            }
        }
        Some(())
    }

    /// The last steps, and what they show.
    fn finish(&mut self, best: Station) -> Optimum {
        const STEPS: usize = 8;
        let mut here = best;
        let mut weights: Option<Vec<f64>> = None;
        let mut shown: Option<Optimum> = None;
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            let Some(mut known) = self.derivatives(&here) else {
                break;
            };
            if !known.are_given && self.sharpen(&here, &mut known).is_none() {
                break;
            }
            let Some(step) = self.step(&here, &known, 0.01, weights.as_deref()) else {
                break;
            };
            let length = step.by.iter().fold(0.0f64, |most, d| most.max(d.abs()));
            if length >= before {
                break;
            }
            before = length;
            // A step uphill that no other brings down again led astray.
            let is_worse = |shown: &Optimum| surpasses(shown.value, here.worst());
            if !shown.as_ref().is_some_and(is_worse) {
                shown = Some(self.certificate(&here, &known, &step));
            }
            let Some(next) = self.station(moved(&here.at, &step.by)) else {
                break;
            };
            // Functions bend apart along a step, and the next brings them together again.
            let allowed = ROUNDING * here.worst().abs() + 2.0 * known.bend(&step.by);
            if length == 0.0 || next.worst() > here.worst() + allowed {
                break;
            }
            weights = Some(step.weights).filter(|_| next.pieces.len() == here.pieces.len());
            here = next;
        }
        shown.unwrap_or_else(|| self.unshown(&here))
    }

    /// A point of which derivatives show nothing.
    fn unshown(&self, here: &Station) -> Optimum {
        Optimum {
            point: self.outside(&here.at),
            value: here.worst(),
            active: Vec::new(),
            spread: 0.0,
            gradient: f64::INFINITY,
            curvature: None,
            limits: here.at.iter().map(|u| limit(*u)).collect(),
            is_constant: false,
            others: Vec::new(),
            evaluations: 0,
        }
    }

    fn certificate(&self, here: &Station, known: &Derivatives, step: &Step) -> Optimum {
        /// Weights below this are those of functions that could as well be absent.
        const SOME: f64 = 1e-9;
        let n = here.at.len();
        let worst = here.worst();
        let limits: Vec<i8> = here.at.iter().map(|u| limit(*u)).collect();
        let active: Vec<usize> = (0..known.pieces.len())
            .filter(|&j| step.weights[j] > SOME)
            .collect();
        let least = active.iter().map(|&j| known.pieces[j].value);
        let least = least.fold(worst, f64::min);
        let largest = active.iter().flat_map(|&j| &known.gradients[j]);
        let largest = largest.fold(0.0f64, |most, g| most.max(g.abs()));
        let left = (0..n).map(|i| {
            let sum: f64 = active
                .iter()
                .map(|&j| step.weights[j] * known.gradients[j][i])
                .sum();
            // At a limit the gradient may point out.
            match limits[i] {
                1 => sum.max(0.0),
                -1 => sum.min(0.0),
                _ => sum,
            }
        });
        let left = left.fold(0.0f64, |most, g| most.max(g.abs()));
        let free: Vec<usize> = (0..n).filter(|&i| limits[i] == 0).collect();
        let curvature = weighed(&known.curvatures, &step.weights);
        let scale = worst.abs().max(f64::MIN_POSITIVE);
        // With one function the gradient itself vanishes, and says nothing about directions.
        let across: Vec<Vec<f64>> = active
            .iter()
            .skip(1)
            .map(|&j| {
                let apart = |i: &usize| known.gradients[j][*i] - known.gradients[active[0]][*i];
                free.iter().map(apart).collect()
            })
            .collect();
        Optimum {
            point: self.outside(&here.at),
            value: worst,
            active: active
                .iter()
                .map(|&j| (known.pieces[j], step.weights[j]))
                .collect(),
            spread: (worst - least) / scale,
            gradient: match largest > 0.0 {
                true if active.len() == 1 => left / largest.max(scale),
                true => left / largest,
                false => 0.0,
            },
            curvature: least_curvature(&curvature, &free, &across).map(|least| least / scale),
            limits,
            is_constant: false,
            others: Vec::new(),
            evaluations: 0,
        }
    }

    /// Polls in all directions, which turn, on meshes that become finer.
    fn mesh(&mut self, start: Station) -> Station {
        const FINEST: f64 = 1e-9;
        const MOST_POLLS: usize = 400;
        let n = start.at.len();
        let mut here = start;
        let mut size = 0.05;
        for poll in 1..=MOST_POLLS {
            if size < FINEST {
                break;
            }
            // A reflection of the axes (Abramson et al. 2009).
            let normal: Vec<f64> = PRIMES[..n]
                .iter()
                .map(|base| 2.0 * halton(poll, *base) - 1.0)
                .collect();
            let square: f64 = normal.iter().map(|v| v * v).sum();
            let mut better = None;
            for (axis, sign) in (0..2 * n).map(|k| (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 })) {
                let step: Vec<f64> = (0..n)
                    .map(|i| {
                        let own = if i == axis { 1.0 } else { 0.0 };
                        let turned = 2.0 * normal[axis] * normal[i] / square.max(1e-12);
                        sign * size * (own - turned)
                    })
                    .collect();
                let next = self.station(moved(&here.at, &step));
                if let Some(next) = next.filter(|next| next.worst() < here.worst()) {
                    better = Some(next);
                    break;
                }
            }
            match better {
                Some(next) => {
                    here = next;
                    size = (size * 2.0f64).min(0.25);
                }
                None => size /= 2.0,
            }
        }
        here
    }
}

/// How a parameter varies between its limits.
enum Scale {
    /// By ratios; ln(high/low).
    Ratios(f64),
    /// By ratios, but for the part next to the lower limit, which is 0.
    FromZero,
    Even,
}

impl Scale {
    fn of(low: f64, high: f64) -> Scale {
        match low > 0.0 {
            true if high / low > WIDE => Scale::Ratios(logarithm(high, low)),
            false if low == 0.0 => Scale::FromZero,
            _ => Scale::Even,
        }
    }
}

/// The upper limit over the part next to 0 that varies evenly.
const FROM_ZERO: f64 = 1e3;

/// ln(a/b), also where the ratio is beyond doubles.
fn logarithm(a: f64, b: f64) -> f64 {
    let ratio = a / b;
    match ratio > 0.0 && ratio.is_finite() {
        true => ratio.ln(),
        false => a.ln() - b.ln(),
    }
}

/// Parts of the ranges from parameters.
pub(crate) fn inside(limits: &[(f64, f64)], point: &[f64]) -> Vec<f64> {
    let each = limits.iter().zip(point);
    let each = each.map(|(&(low, high), &x)| match Scale::of(low, high) {
        Scale::Ratios(range) => logarithm(x, low) / range,
        Scale::FromZero => (FROM_ZERO * (x / high)).ln_1p() / FROM_ZERO.ln_1p(),
        Scale::Even => (x - low) / (high - low),
    });
    each.map(|u| u.clamp(0.0, 1.0)).collect()
}

/// The van der Corput sequence of a base.
fn halton(mut index: usize, base: usize) -> f64 {
    let (mut value, mut part) = (0.0, 1.0);
    while index > 0 {
        part /= base as f64;
        value += part * (index % base) as f64;
        index /= base;
    }
    value
}

fn moved(at: &[f64], by: &[f64]) -> Vec<f64> {
    /// So near to a limit it is meant.
    const NEAR: f64 = 1e-13;
    let each = at.iter().zip(by).map(|(u, d)| (u + d).clamp(0.0, 1.0));
    let snap = |u: f64| match u {
        _ if u < NEAR => 0.0,
        _ if u > 1.0 - NEAR => 1.0,
        _ => u,
    };
    each.map(snap).collect()
}

fn limit(u: f64) -> i8 {
    i8::from(u == 1.0) - i8::from(u == 0.0)
}

/// The values of one function at the points around: those nearest in place. `None` where another function is as near.
fn follow(piece: &Piece, own: &[Piece], around: &[Vec<Piece>]) -> Option<Vec<f64>> {
    let each = around.iter().map(|pieces| {
        let distance = |other: &Piece| (other.place - piece.place).abs();
        if pieces.len() == own.len() {
            // In the order of places, for as many as there are.
            let rank = own.iter().filter(|p| p.place < piece.place).count();
            let mut sorted: Vec<&Piece> = pieces.iter().collect();
            sort_by_number(&mut sorted, |one| one.place);
            return sorted.get(rank).map(|piece| piece.value);
        }
        let nearest = pieces
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let taken = own.iter().any(|other| {
            other.place != piece.place && (other.place - nearest.place).abs() < distance(nearest)
        });
        (!taken).then_some(nearest.value)
    });
    each.collect()
}

fn weighed(curvatures: &[Mat<f64>], weights: &[f64]) -> Mat<f64> {
    let n = curvatures[0].nrows();
    let mut sum = Mat::<f64>::zeros(n, n);
    for (curvature, weight) in curvatures.iter().zip(weights) {
        sum += faer::Scale(*weight) * curvature;
    }
    sum
}

/// The same with eigenvalues that are positive.
fn upwards(matrix: &Mat<f64>) -> Mat<f64> {
    /// In parts of the largest.
    const LEAST: f64 = 1e-6;
    let n = matrix.nrows();
    let Some((values, u)) = symmetric_eigen(matrix) else {
        return Mat::identity(n, n);
    };
    let values: Vec<f64> = values.into_iter().map(f64::abs).collect();
    let most = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    Mat::from_fn(n, n, |i, j| {
        let terms = (0..n).map(|k| u[(i, k)] * values[k].max(LEAST * most) * u[(j, k)]);
        terms.sum()
    })
}

/// The least eigenvalue along what is orthogonal to all of `across`, in the free coordinates. `None` where nothing is.
fn least_curvature(curvature: &Mat<f64>, free: &[usize], across: &[Vec<f64>]) -> Option<f64> {
    let n = free.len();
    // Orthonormal rows of `across`, then the rest of the axes.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut along: Vec<Vec<f64>> = Vec::new();
    let axes = (0..n).map(|i| {
        (0..n)
            .map(|k| f64::from(u8::from(k == i)))
            .collect::<Vec<f64>>()
    });
    let all = across.iter().cloned().map(|row| (row, false));
    for (mut row, is_axis) in all.chain(axes.map(|axis| (axis, true))) {
        let length = |row: &[f64]| row.iter().map(|v| v * v).sum::<f64>().sqrt();
        let before = length(&row);
        for _ in 0..2 {
            for known in basis.iter().chain(&along) {
                let share: f64 = known.iter().zip(&row).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(known).for_each(|(v, a)| *v -= share * a);
            }
        }
        let after = length(&row);
        if basis.len() + along.len() == n || after <= 1e-6 * before {
            continue;
        }
        row.iter_mut().for_each(|v| *v /= after);
        if is_axis {
            along.push(row)
        } else {
            basis.push(row)
        }
    }
    let count = along.len();
    let reduced = Mat::from_fn(count, count, |a, b| {
        let terms = (0..n * n).map(|k| {
            let (i, j) = (k / n, k % n);
            along[a][i] * curvature[(free[i], free[j])] * along[b][j]
        });
        terms.sum::<f64>()
    });
    symmetric_eigenvalues(&reduced)?.first().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(place: f64, value: f64) -> Piece {
        Piece { place, value }
    }

    /// The ratio of the limits is beyond doubles; the least is where ln x = −300.
    #[test]
    fn limits_may_be_any_powers_of_ten_apart() {
        for limits in [(1e-300, 1e300), (1e-308, 1e308), (1e-200, 1e10)] {
            let optimum = minimise(&[limits], |x| {
                assert!((limits.0..=limits.1).contains(&x[0]), "{x:?}");
                Some(vec![piece(0.0, 1.0 + (x[0].ln() + 300.0).powi(2))])
            });
            let optimum = optimum.unwrap();
            let apart = optimum.point[0].ln() + 300.0;
            assert!(apart.abs() < 1e-5, "{limits:?}: {apart}");
        }
    }

    #[test]
    fn a_smooth_minimum_is_found_to_the_last_digits() {
        let (a, b) = (0.317, 2.75);
        let optimum = minimise(&[(-1.0, 1.0), (0.1, 10.0)], |x| {
            let value = 3.0
                + (x[0] - a).powi(2)
                + (x[0] - a) * (x[1] - b)
                + (x[1] - b).powi(2)
                + (x[1] - b).powi(4);
            Some(vec![piece(0.0, value)])
        });
        let optimum = optimum.unwrap();
        assert!((optimum.point[0] - a).abs() < 1e-12, "{optimum:?}");
        assert!((optimum.point[1] - b).abs() < 1e-12, "{optimum:?}");
        assert!(
            optimum.is_shown() && optimum.curvature > Some(0.0),
            "{optimum:?}"
        );
    }

    #[test]
    fn the_least_of_many_minima_is_found() {
        let optimum = minimise(&[(-10.0, 10.0)], |x| {
            Some(vec![piece(
                0.0,
                (x[0] - 3.0).powi(2) / 50.0 - (3.0 * x[0]).cos(),
            )])
        });
        let optimum = optimum.unwrap();
        assert!((optimum.point[0] - 2.1).abs() < 0.1, "{optimum:?}");
        assert!(optimum.others.iter().all(|other| *other >= optimum.value));
    }

    /// A plane that falls to one corner, and a well in the opposite one that no point of the sequence is near.
    #[test]
    fn a_well_in_a_corner_is_found() {
        let optimum = minimise(&[(0.0, 1.0), (0.0, 1.0)], |x| {
            let well = (-2e3 * (x[0] * x[0] + x[1] * x[1])).exp();
            Some(vec![piece(0.0, 1.0 - 0.4 * (x[0] + x[1]) - well)])
        });
        let optimum = optimum.unwrap();
        assert!(optimum.value < 0.0, "{optimum:?}");
    }

    #[test]
    fn limits_and_kinks_are_reported() {
        let optimum = minimise(&[(1.0, 2.0), (-1.0, 1.0)], |x| {
            Some(vec![piece(0.0, x[0] + x[1].abs())])
        });
        let optimum = optimum.unwrap();
        assert_eq!(optimum.limits[0], -1, "{optimum:?}");
        assert!((optimum.value - 1.0).abs() < 1e-7, "{optimum:?}");
        assert!(matches!(
            minimise(&[(1.0, 1.0)], |_| None),
            Err(OptimumError::Limits { .. })
        ));
        assert!(matches!(
            minimise(&[], |_| None),
            Err(OptimumError::Count { count: 0 })
        ));
        assert!(matches!(
            minimise(&[(0.0, 1.0)], |_| None),
            Err(OptimumError::Nowhere { .. })
        ));
    }
}
