//! Campbell diagrams: roots of a rotor against its speed, and the speeds at which a multiple of the speed is a frequency of its own
//! (Genta 2005, *Dynamics of Rotating Systems*, chapter 4).
//!
//! The j-th largest imaginary part of all roots is a continuous function ω_j of the speed Ω, whichever mode it belongs to. Where
//! ω_j − nΩ is proven to have one sign at one speed and the other at another, a critical speed of the order n lies between; no
//! identity of modes is needed for that. Without damping there is at most one for each j: H(Ω) = K − n²Ω²M + inΩ²G is
//! Hermitian, has as many negative eigenvalues as frequencies lie below nΩ, and H(Ω)/Ω² only falls while K ⪰ 0. So the
//! signs at both ends count all that lie between.

use eigentone_digits::sort_by_number;
use eigentone_modes::{Bounds, BuildError, Mode, Modes, ModesError, Precision, System, Term};
use num_complex::Complex;
use thiserror::Error;

use super::follower::{FollowError, Followed, Follower};

/// How often an interval with a critical speed is cut. Halving alone would take as many as a double has bits and a few more.
const CUTS: usize = 100;

/// Shapes whose gyroscopic forces cancel to less than this part whirl in no sense that rounding leaves.
const PLANE: f64 = 1e-9;

/// How far the components of a shape without proven bounds may be off, beside the largest one.
const UNPROVEN: f64 = 64.0 * f64::EPSILON;

/// What is asked of a rotor: modes against speed, and critical speeds.
///
/// ```
/// use eigentone_design::{Campbell, Whirl};
/// use eigentone_modes::System;
/// use faer::{Mat, mat};
///
/// // Two angles of a disc, I_p/I_d = 1/2: σ² − Ωσ/2 − 4 = 0 for frequencies σ of either sense, and σ = ±Ω.
/// let gyroscopic = mat![[0.0, 0.5], [-0.5, 0.0]];
/// let stiffness = mat![[4.0, 0.0], [0.0, 4.0]];
/// let mass = Mat::identity(2, 2);
/// let rotor = System::from_matrices(mass.as_ref(), gyroscopic.as_ref(), stiffness.as_ref())?;
/// let diagram = Campbell::of(&rotor).over(&[0.0, 1.0, 2.0, 3.0])?;
/// let [backward, forward] = diagram.critical_speeds() else {
///     panic!("two critical speeds");
/// };
/// assert!((backward.speed - (8.0f64 / 3.0).sqrt()).abs() <= backward.bound);
/// assert!((forward.speed - 8.0f64.sqrt()).abs() <= forward.bound);
/// assert_eq!(forward.whirl, Some(Whirl::Forward));
/// assert!(diagram.is_complete());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "nothing is computed until `over` is called"]
pub struct Campbell<'a> {
    system: &'a System,
    reference: f64,
    orders: Vec<f64>,
    precision: Precision,
}

/// Modes of a rotor at rising speeds, and its critical speeds.
#[derive(Clone, Debug)]
pub struct CampbellDiagram {
    speeds: Vec<f64>,
    branches: Vec<Branch>,
    critical: Vec<CriticalSpeed>,
    orders: Vec<f64>,
    bounds: Bounds,
    complete: bool,
    sure: bool,
}

/// A mode through all speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its root at each speed, in 1/s, with a positive imaginary part where it oscillates.
    pub roots: Vec<Complex<f64>>,
    /// How it whirls at each speed, where that can be determined.
    pub whirl: Vec<Option<Whirl>>,
}

/// The sense of a whirl, by the work of the gyroscopic forces in the shape of the mode: it distinguishes shapes in any coordinates.
/// Without damping it says what these forces do to the frequency. With damping the frequency may change the other way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whirl {
    /// With the rotor: without damping gyroscopic forces raise the frequency.
    Forward,
    /// Against it: without damping they lower the frequency.
    Backward,
}

/// A speed at which an order of it is the damped frequency of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalSpeed {
    /// How often it acts in a turn.
    pub order: f64,
    /// In rad/s.
    pub speed: f64,
    /// How far it may be off, as [`CampbellDiagram::bounds`] says.
    pub bound: f64,
    /// How many modes meet the order there, within the bound.
    pub count: usize,
    /// The root of the mode, or of one of them, in 1/s.
    pub root: Complex<f64>,
    /// How it whirls, if all of them whirl in one sense.
    pub whirl: Option<Whirl>,
}

/// Why there is no diagram.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CampbellError {
    /// No range of speeds.
    #[error("a diagram takes two speeds or more, of which the first may be 0: there is {}", if *count == 0 { "none" } else { "one" })]
    FewSpeeds {
        /// How many there are, below two.
        count: usize,
    },
    /// Speeds do not rise from 0 or more.
    #[error("speeds must rise from 0 or more: {before:?} comes before {after:?}")]
    Speeds {
        /// A speed.
        before: f64,
        /// The one that does not come after it.
        after: f64,
    },
    /// An order or the speed that the system is given at is not a positive number.
    #[error(
        "{value:?} is not a finite number greater than 0, as orders and the speed of the scene must be"
    )]
    NotPositive {
        /// The value.
        value: f64,
    },
    /// Gyroscopic forces at some speed, or what they make of the frequencies, leave the range of doubles.
    #[error(
        "at {speed:?} rad/s gyroscopic forces lie too far from all others for doubles: take speeds and orders nearer to the frequencies, and to the speed that the system is given at"
    )]
    FarSpeed {
        /// In rad/s.
        speed: f64,
    },
    /// The system is none at some speed.
    #[error("at {speed:?} rad/s: {error}")]
    System {
        /// In rad/s.
        speed: f64,
        /// What is wrong.
        error: BuildError,
    },
    /// It has no modes at some speed.
    #[error("at {speed:?} rad/s: {error}")]
    Modes {
        /// In rad/s.
        speed: f64,
        /// What is wrong.
        error: ModesError,
    },
    /// Roots may come from infinity as the rotor turns faster.
    #[error(
        "gyroscopic forces act on coordinate {index} in a system where mass is missing, so that roots may come from infinity: give all coordinates that they act on masses"
    )]
    Massless {
        /// Of the coordinate, from 0.
        index: usize,
    },
    /// Modes cannot be followed.
    #[error("at {speed:?} rad/s: {error}")]
    Follow {
        /// In rad/s.
        speed: f64,
        /// What is wrong.
        error: FollowError,
    },
}

impl<'a> Campbell<'a> {
    /// Of a system whose C, as far as it is skew, holds at a speed of 1 rad/s; of the order 1; proven.
    pub fn of(system: &'a System) -> Campbell<'a> {
        Campbell {
            system,
            reference: 1.0,
            orders: vec![1.0],
            precision: Precision::default(),
        }
    }

    /// Says at which speed, in rad/s, the skew part of C is as the system has it; at others it is in proportion.
    pub fn given_at(mut self, speed: f64) -> Campbell<'a> {
        self.reference = speed;
        self
    }

    /// How often what excites the rotor acts in a turn; each counts once.
    pub fn orders(mut self, orders: impl Into<Vec<f64>>) -> Campbell<'a> {
        let mut known = Vec::new();
        self.orders = orders.into();
        self.orders.retain(|order| {
            let is_new = !known.contains(order);
            known.push(*order);
            is_new
        });
        self
    }

    /// How far answers may be off.
    pub fn precision(mut self, precision: Precision) -> Campbell<'a> {
        self.precision = precision;
        self
    }

    /// The diagram at rising speeds in rad/s, and the critical speeds between the first and the last.
    ///
    /// # Errors
    /// [`CampbellError`].
    pub fn over(&self, speeds: &[f64]) -> Result<CampbellDiagram, CampbellError> {
        let rises = |pair: &[f64]| pair[0] >= 0.0 && pair[0] < pair[1] && pair[1].is_finite();
        if speeds.len() < 2 {
            let count = speeds.len();
            return Err(CampbellError::FewSpeeds { count });
        }
        if let Some(pair) = speeds.windows(2).find(|pair| !rises(pair)) {
            let (before, after) = (pair[0], pair[1]);
            return Err(CampbellError::Speeds { before, after });
        }
        let numbers = self.orders.iter().chain([&self.reference]);
        for &value in numbers {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CampbellError::NotPositive { value });
            }
        }
        let far = speeds
            .iter()
            .find(|speed| !(*speed / self.reference).is_finite());
        if let Some(&speed) = far {
            return Err(CampbellError::FarSpeed { speed });
        }
        let gyroscopic = self.system.gyroscopic_terms();
        if let Some(index) = self.unsettled(&gyroscopic) {
            return Err(CampbellError::Massless { index });
        }
        // Without a gyroscopic part the modes are the same at every speed.
        let still = match gyroscopic.is_empty() {
            true => Some(self.at(1.0)?),
            false => None,
        };
        let still = still.as_ref();
        let (stations, columns, sure) = self.stations(still, speeds, &gyroscopic)?;
        let branches = branches(&columns, &stations);
        let mut bounds = match stations.iter().all(|station| station.is_proven) {
            true => Bounds::Proven,
            false => Bounds::Estimated,
        };
        // It has one at every speed but 0, if at any.
        let mut complete = stations.last().is_some_and(|last| last.is_countable);
        let mut critical = Vec::new();
        for &order in &self.orders {
            let line = Line {
                factor: times([order; 2], self.reference),
            };
            let mut found: Vec<([f64; 2], usize)> = Vec::new();
            let counts = stations.iter().map(|station| station.sorted.len());
            let count = counts.min().unwrap_or(0);
            for j in 0..count {
                let signs = stations
                    .iter()
                    .map(|station| line.sign(station.sorted[j], station.ratio));
                let signs: Vec<i32> = signs.collect();
                complete &= signs[0] != 0 && signs[signs.len() - 1] != 0;
                let decided: Vec<usize> = (0..signs.len()).filter(|k| signs[*k] != 0).collect();
                for pair in decided.windows(2) {
                    let [a, b] = [pair[0], pair[1]];
                    if signs[a] != signs[b] {
                        let end = |k: usize| (stations[k].ratio, stations[k].sorted[j]);
                        let ends = [end(a), end(b)];
                        let interval = self.crossing(still, &line, j, ends, &mut bounds)?;
                        found.push((interval, 1));
                    }
                }
            }
            sort_by_number(&mut found, |(ends, _)| ends[0]);
            let mut apart: Vec<([f64; 2], usize)> = Vec::new();
            for (interval, count) in found {
                match apart.last_mut() {
                    Some((last, sum)) if interval[0] <= last[1] => {
                        last[1] = last[1].max(interval[1]);
                        *sum += count;
                    }
                    _ => apart.push((interval, count)),
                }
            }
            for (interval, count) in apart {
                critical.push(self.described(still, order, interval, count, &gyroscopic)?);
            }
        }
        sort_by_number(&mut critical, |one| one.speed);
        Ok(CampbellDiagram {
            speeds: speeds.to_vec(),
            branches,
            critical,
            orders: self.orders.clone(),
            bounds,
            complete: complete && bounds == Bounds::Proven,
            sure,
        })
    }

    /// A coordinate at which the gyroscopic part may change the number of roots. Where M is regular for all coordinates that have
    /// mass, and that part acts on no others, the highest power of λ in the determinant knows nothing of it.
    fn unsettled(&self, gyroscopic: &[Term]) -> Option<usize> {
        let structure = self.system.structure();
        if structure.finite_roots() == Some(2 * self.system.len()) {
            return None;
        }
        let massless = structure.massless();
        let is_regular = structure.mass_rank() == Some(self.system.len() - massless.len());
        let mut rows = gyroscopic.iter().map(|term| term.row);
        rows.find(|i| !is_regular || massless.contains(i))
    }

    /// The system at a multiple of the speed that it is given at.
    fn at(&self, ratio: f64) -> Result<Rotor, CampbellError> {
        self.at_with(ratio, self.precision)
    }

    fn at_unless(&self, still: Option<&Rotor>, ratio: f64) -> Result<Rotor, CampbellError> {
        match still {
            Some(still) => Ok(Rotor {
                ratio,
                ..still.clone()
            }),
            None => self.at(ratio),
        }
    }

    fn at_with(&self, ratio: f64, precision: Precision) -> Result<Rotor, CampbellError> {
        let speed = ratio * self.reference;
        let system = self.system.with_gyroscopic_part(ratio);
        let system = system.map_err(|error| match error {
            BuildError::DampingRange => CampbellError::FarSpeed { speed },
            error => CampbellError::System { speed, error },
        })?;
        let modes = system.modes_to(precision);
        let modes = modes.map_err(|error| match error {
            ModesError::OutOfRange { .. } if !system.gyroscopic_terms().is_empty() => {
                CampbellError::FarSpeed { speed }
            }
            error => CampbellError::Modes { speed, error },
        })?;
        Ok(Rotor {
            ratio,
            system,
            modes,
        })
    }

    /// What is kept of each speed, the roots there in one order for all speeds, and whether that order is sure. Followed from the
    /// highest speed downwards: at rest the two senses are one, and no shape distinguishes them.
    #[allow(clippy::type_complexity, reason = "three parts of one answer")]
    fn stations(
        &self,
        still: Option<&Rotor>,
        speeds: &[f64],
        gyroscopic: &[Term],
    ) -> Result<(Vec<Station>, Vec<Vec<Complex<f64>>>, bool), CampbellError> {
        let mut stations: Vec<Station> = Vec::with_capacity(speeds.len());
        let mut columns: Vec<Vec<Complex<f64>>> = Vec::with_capacity(speeds.len());
        let mut follower: Option<Follower> = None;
        let mut sure = true;
        for &speed in speeds.iter().rev() {
            let failure = |error| CampbellError::Follow { speed, error };
            let rotor = self.at_unless(still, speed / self.reference)?;
            let before = stations.last().map(|station| station.ratio);
            stations.push(Station::of(&rotor, gyroscopic));
            let goal = || Follower::at(&rotor.system, &rotor.modes).map_err(failure);
            let follower = match (&mut follower, before) {
                (Some(_), _) if gyroscopic.is_empty() => {
                    columns.push(columns[0].clone());
                    continue;
                }
                (Some(follower), Some(from)) => {
                    let to = rotor.ratio;
                    let mut goal = Some(goal()?);
                    let followed = follower.advance(|t| {
                        if t == 1.0 {
                            return goal.take();
                        }
                        let rotor = self.at_with(from + t * (to - from), Precision::Double);
                        let rotor = rotor.ok()?;
                        Follower::at(&rotor.system, &rotor.modes).ok()
                    });
                    sure &= followed.map_err(failure)? == Followed::Surely;
                    follower
                }
                (first, _) => first.insert(goal()?),
            };
            columns.push(follower.roots().to_vec());
        }
        stations.reverse();
        columns.reverse();
        Ok((stations, columns, sure))
    }

    /// Ratios of speeds between which the j-th frequency crosses a line, from two at which it lies on different sides.
    fn crossing(
        &self,
        still: Option<&Rotor>,
        line: &Line,
        j: usize,
        ends: [(f64, [f64; 2]); 2],
        bounds: &mut Bounds,
    ) -> Result<[f64; 2], CampbellError> {
        let mut look = |ratio: f64| -> Result<[f64; 2], CampbellError> {
            let station = self.at_unless(still, ratio)?;
            if station.modes.bounds() == Bounds::Estimated {
                *bounds = Bounds::Estimated;
            }
            let none = [f64::NEG_INFINITY, f64::INFINITY];
            Ok(station.sorted().get(j).copied().unwrap_or(none))
        };
        let mut sides = ends.map(|(ratio, found)| (ratio, line.off(found, ratio)));
        let before = line.sign(ends[0].1, ends[0].0);
        let mut undecided = None;
        for cut in 0..CUTS {
            let [(low, at_low), (high, at_high)] = sides;
            let middle = f64::midpoint(low, high);
            let chord = low - at_low * ((high - low) / (at_high - at_low));
            let is_within = low < chord && chord < high;
            let next = if cut % 3 != 2 && is_within {
                chord
            } else {
                middle
            };
            if next <= low || next >= high {
                break;
            }
            let found = look(next)?;
            match line.sign(found, next) {
                0 => {
                    undecided = Some((next, found));
                    break;
                }
                sign if sign == before => sides[0] = (next, line.off(found, next)),
                _ => sides[1] = (next, line.off(found, next)),
            }
        }
        let mut interval = sides.map(|side| side.0);
        let Some((centre, found)) = undecided else {
            return Ok(interval);
        };
        // Steps that grow, on both sides of where digits end, until their signs are known.
        let slope = (sides[1].1 - sides[0].1) / (interval[1] - interval[0]);
        let doubt = (found[1] - found[0]).max(f64::EPSILON * line.factor[1] * centre);
        let least = (doubt / slope.abs()).max(f64::EPSILON * centre);
        for (side, away) in [(0, -1.0), (1, 1.0)] {
            let mut step = least;
            while step.is_finite() {
                let next = centre + away * step;
                if next <= interval[0] || next >= interval[1] {
                    break;
                }
                let sign = line.sign(look(next)?, next);
                if sign != 0 && (sign == before) == (side == 0) {
                    interval[side] = next;
                    break;
                }
                step *= 2.0;
            }
        }
        Ok(interval)
    }

    fn described(
        &self,
        still: Option<&Rotor>,
        order: f64,
        interval: [f64; 2],
        count: usize,
        gyroscopic: &[Term],
    ) -> Result<CriticalSpeed, CampbellError> {
        let ratio = f64::midpoint(interval[0], interval[1]);
        let speed = ratio * self.reference;
        let [low, high] = interval.map(|end| times([end; 2], self.reference));
        let bound = (high[1] - speed).max(speed - low[0]).next_up();
        let station = self.at_unless(still, ratio)?;
        let target = order * speed;
        let mut modes: Vec<&Mode> = station.modes.iter().collect();
        let off = |mode: &Mode| (mode.eigenvalue().value.im.abs() - target).abs();
        sort_by_number(&mut modes, |mode| off(mode));
        modes.truncate(count);
        let mut senses = modes.iter().map(|mode| station.whirl(mode, gyroscopic));
        let first = senses.next().flatten();
        let root = modes.first().map(|mode| mode.eigenvalue().value);
        Ok(CriticalSpeed {
            order,
            speed,
            bound,
            count,
            root: root.unwrap_or_default(),
            whirl: first.filter(|_| senses.all(|sense| sense == first)),
        })
    }
}

impl CampbellDiagram {
    /// In rad/s, as they were asked for.
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }

    /// Modes that oscillate at some speed, by their frequency at the lowest.
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// As they were asked for.
    pub fn orders(&self) -> &[f64] {
        &self.orders
    }

    /// By speed, of all orders.
    pub fn critical_speeds(&self) -> &[CriticalSpeed] {
        &self.critical
    }

    /// What the bounds of critical speeds are worth.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether it is proved that no critical speed of these orders is missing between the lowest and the highest speed. With
    /// damping an even number of them may hide between two speeds.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Whether each branch is surely one mode: none coincided with another, or came nearer than doubles distinguish.
    pub fn is_sure(&self) -> bool {
        self.sure
    }
}

/// Modes that oscillate at some speed, from the roots at each in one order. A mode has two places of that order. Where both are
/// real it does not oscillate, and either may become the upper root of a pair, with the other or with one of another mode that
/// does not oscillate, which has what is left.
fn branches(columns: &[Vec<Complex<f64>>], stations: &[Station]) -> Vec<Branch> {
    let last = columns.len() - 1;
    let count = columns[0].len();
    let mut owners: Vec<usize> = (0..count).map(|place| place / 2).collect();
    let mut all: Vec<Vec<Complex<f64>>> = vec![Vec::new(); count.div_ceil(2)];
    for column in columns {
        let mut below: Vec<usize> = (0..count).filter(|place| column[*place].im < 0.0).collect();
        for place in (0..count).filter(|place| column[*place].im > 0.0) {
            let is_conjugate = |other: &&usize| column[**other] == column[place].conj();
            let own = |other: &&usize| owners[**other] == owners[place];
            let mut others = below.iter().filter(is_conjugate);
            let other = others.clone().find(own).or_else(|| others.next());
            let Some(&other) = other else { continue };
            below.retain(|one| *one != other);
            let owner = owners[place];
            if owners[other] != owner {
                match (0..count).find(|one| *one != place && owners[*one] == owner) {
                    Some(left) => owners.swap(other, left),
                    None => owners[other] = owner,
                }
            }
        }
        for (mode, roots) in all.iter_mut().enumerate() {
            let own = (0..count).filter(|place| owners[*place] == mode);
            let own = own.map(|place| column[place]);
            let upper = own.reduce(|a, b| if b.im > a.im { b } else { a });
            roots.push(upper.expect("a mode has a place"));
        }
    }
    all.retain(|roots| roots.iter().any(|root| root.im > 0.0));
    all.sort_by(|a, b| {
        let ends = |roots: &[Complex<f64>]| (roots[0].im, roots[last].im);
        let (a, b) = (ends(a), ends(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let branches = all.into_iter().map(|roots| {
        let whirl = roots.iter().zip(stations).map(|(root, station)| {
            let mut all = station.whirls.iter();
            all.find(|(value, _)| value == root)?.1
        });
        Branch {
            whirl: whirl.collect(),
            roots,
        }
    });
    branches.collect()
}

/// What is kept of a speed: of many speeds, whole systems and their modes would fill the memory.
struct Station {
    ratio: f64,
    /// As [`Rotor::sorted`] has them.
    sorted: Vec<[f64; 2]>,
    /// The root of each mode, and how it whirls.
    whirls: Vec<(Complex<f64>, Option<Whirl>)>,
    is_proven: bool,
    /// Whether signs at both ends count all critical speeds between them.
    is_countable: bool,
}

impl Station {
    fn of(rotor: &Rotor, gyroscopic: &[Term]) -> Station {
        let whirls = rotor.modes.iter().map(|mode| {
            let root = mode.eigenvalue().value;
            (root, rotor.whirl(mode, gyroscopic))
        });
        let structure = rotor.system.structure();
        Station {
            ratio: rotor.ratio,
            sorted: rotor.sorted(),
            whirls: whirls.collect(),
            is_proven: rotor.modes.bounds() == Bounds::Proven,
            is_countable: structure.is_gyroscopic()
                || structure.is_undamped() && structure.is_passive(),
        }
    }
}

/// The system at a speed.
#[derive(Clone)]
struct Rotor {
    ratio: f64,
    system: System,
    modes: Modes,
}

impl Rotor {
    /// Bounds of the imaginary parts of all roots, the largest first: of sorted numbers, the j-th lies between the j-th of their
    /// lower and the j-th of their upper bounds.
    fn sorted(&self) -> Vec<[f64; 2]> {
        let bounds = |side: f64| {
            let ends = self.modes.eigenvalues().iter().map(|root| {
                let off = side * root.bound.unwrap_or(f64::INFINITY);
                let end = root.value.im + off;
                match off == 0.0 {
                    true => end,
                    false if side < 0.0 => end.next_down(),
                    false => end.next_up(),
                }
            });
            let mut ends: Vec<f64> = ends.collect();
            sort_by_number(&mut ends, |end| -end);
            ends
        };
        let both = bounds(-1.0).into_iter().zip(bounds(1.0));
        both.map(|(low, high)| [low, high]).collect()
    }

    /// The sign of x*(iG)x, of which dω/dΩ = ω x*(iG)x/(ωm + k/ω) without damping.
    fn whirl(&self, mode: &Mode, gyroscopic: &[Term]) -> Option<Whirl> {
        let sign = match mode.eigenvalue().value.im {
            im if im > 0.0 => 1.0,
            im if im < 0.0 => -1.0,
            _ => return None,
        };
        let shape = mode.shape();
        let largest = shape.iter().map(|x| x.norm()).fold(0.0, f64::max);
        let bounds = mode.shape_bound();
        let bound = |at: usize| bounds.map_or(UNPROVEN * largest, |bounds| bounds[at]);
        let (mut work, mut size, mut error) = (0.0f64, 0.0f64, 0.0f64);
        for term in gyroscopic {
            let (x, y) = (shape[term.row], shape[term.column]);
            let (off_x, off_y) = (bound(term.row), bound(term.column));
            work -= sign * term.value * (x.conj() * y).im;
            size += (x.norm() * y.norm() * term.value).abs();
            let off = off_x * y.norm() + off_y * x.norm() + off_x * off_y;
            error += off * term.value.abs();
        }
        match self.ratio > 0.0 && work.abs() > (PLANE * size).max(error) {
            true if work > 0.0 => Some(Whirl::Forward),
            true => Some(Whirl::Backward),
            false => None,
        }
    }
}

/// The line ω = nΩ.
struct Line {
    /// Bounds of n times the speed that the system is given at.
    factor: [f64; 2],
}

impl Line {
    /// 1 above the line, −1 below it, 0 where bounds do not decide.
    fn sign(&self, frequency: [f64; 2], ratio: f64) -> i32 {
        let [low, high] = times(self.factor, ratio);
        i32::from(frequency[0] > high) - i32::from(frequency[1] < low)
    }

    /// How far above the line, about.
    fn off(&self, frequency: [f64; 2], ratio: f64) -> f64 {
        f64::midpoint(frequency[0], frequency[1]) - self.factor[0] * ratio
    }
}

/// Bounds of the product of a positive interval and a number that is not negative, exact where the product is.
fn times(interval: [f64; 2], by: f64) -> [f64; 2] {
    let exact = |a: f64| {
        (
            a * by,
            a.mul_add(by, -(a * by)) == 0.0 && (a * by >= 1e-290 || by == 0.0),
        )
    };
    let [(low, low_is_exact), (high, high_is_exact)] = interval.map(exact);
    [
        if low_is_exact { low } else { low.next_down() },
        if high_is_exact { high } else { high.next_up() },
    ]
}
