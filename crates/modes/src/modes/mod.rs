//! The answer of the quadratic eigenproblem: eigenvalues, and modes with their quality. It knows `model`.

mod plan;
#[cfg(feature = "serde")]
mod serial;

use std::cmp::Ordering;

use num_complex::Complex;

use crate::model::{Names, NoCoordinate};

pub use plan::ModePlan;

/// A frequency; radians per second inside, hertz only by asking.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Frequency(f64);

impl Frequency {
    /// From radians per second.
    pub fn from_radians_per_second(value: f64) -> Frequency {
        Frequency(value)
    }

    /// In rad/s.
    pub fn radians_per_second(self) -> f64 {
        self.0
    }

    /// In Hz: rad/s divided by 2π.
    pub fn hertz(self) -> f64 {
        self.0 / std::f64::consts::TAU
    }
}

/// How a mode moves when nothing drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Motion {
    /// λ = 0: it stays, or drifts, where it is put.
    Rigid,
    /// λ real and negative: a relaxation mode, which returns to rest without oscillating.
    Decaying,
    /// λ complex, and not known to grow.
    Oscillating,
    /// Re λ > 0: it grows without limit.
    Growing,
    /// What is known of λ leaves open which of these it is.
    Doubtful,
}

impl std::fmt::Display for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Motion::Rigid => "rigid",
            Motion::Decaying => "decaying",
            Motion::Oscillating => "oscillating",
            Motion::Growing => "growing",
            Motion::Doubtful => "doubtful",
        })
    }
}

/// What the bounds of an answer are worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounds {
    /// Every bound is proven: the true value lies within it.
    Proven,
    /// First-order estimates from backward error and condition.
    Estimated,
}

/// How far an answer is to be trusted, and what it may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Precision {
    /// Bounds are proven, and more digits are taken until each is within `tolerance` of |λ| and of
    /// |Re λ|, or digits end at 1e-30 of |λ|.
    Certified {
        /// Relative; not below 2^-53.
        tolerance: f64,
    },
    /// Doubles throughout, with bounds that are first-order estimates.
    Double,
}

impl Default for Precision {
    /// Certified to 4 units of rounding (4·2^-53): right to the last digits.
    fn default() -> Precision {
        Precision::Certified {
            tolerance: 2.0 * f64::EPSILON,
        }
    }
}

/// One root λ of det(λ²M + λC + K), with how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenvalue {
    /// λ in 1/s.
    pub value: Complex<f64>,
    /// A bound of |λ̂ − λ| (absolute, 1/s), proven or estimated as [`Modes::bounds`] says; `None` where
    /// none is known that means anything: the root is [doubtful](Self::is_doubtful).
    pub bound: Option<f64>,
    /// The same for the real part alone.
    pub real_bound: Option<f64>,
}

impl Eigenvalue {
    /// ω_n = |λ|.
    pub fn natural_frequency(&self) -> Frequency {
        Frequency(self.value.norm())
    }

    /// Whether nothing is known of how far it may be off.
    pub fn is_doubtful(&self) -> bool {
        self.bound.is_none()
    }

    /// How the root moves, as far as its bounds show: a real part that they do not distinguish from 0 neither grows nor
    /// decays, and a root that they do not distinguish from the real axis does not oscillate.
    pub fn motion(&self) -> Motion {
        let Complex { re, im } = self.value;
        let (Some(bound), Some(real_bound)) = (self.bound, self.real_bound) else {
            return Motion::Doubtful;
        };
        if re == 0.0 && im == 0.0 {
            return if bound == 0.0 {
                Motion::Rigid
            } else {
                Motion::Doubtful
            };
        }
        // A root that is not 0 has the sign of its value even where it may come close to 0.
        let is_real = im == 0.0;
        let grows = re > real_bound || is_real && re > 0.0 && re >= bound;
        match is_real {
            _ if grows => Motion::Growing,
            true if -re >= bound => Motion::Decaying,
            false if im.abs() > bound => Motion::Oscillating,
            _ => Motion::Doubtful,
        }
    }

    /// Whether its real part is distinguished from 0, or is 0.
    fn is_side_known(&self) -> bool {
        let re = self.value.re;
        self.real_bound
            .is_some_and(|bound| re == 0.0 || re.abs() > bound)
    }

    /// The conjugate root, with the same bounds.
    pub fn conjugate(&self) -> Eigenvalue {
        Eigenvalue {
            value: self.value.conj(),
            ..*self
        }
    }
}

/// How many roots share a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repeats {
    /// So many coincide exactly; whether they have fewer shapes, where that is known.
    Exactly {
        count: usize,
        defective: Option<bool>,
    },
    /// So many are neither separated nor proved to coincide.
    Cluster(usize),
    /// So many are, and there may be others that were not found.
    AtLeast(usize),
}

impl Repeats {
    pub(crate) const SIMPLE: Repeats = Repeats::Exactly {
        count: 1,
        defective: Some(false),
    };
}

/// One mode: a conjugate pair (given by its root with Im λ > 0) or a real root, its shape and its
/// quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    pub(crate) eigenvalue: Eigenvalue,
    pub(crate) repeats: Repeats,
    pub(crate) roots: usize,
    pub(crate) names: Names,
    pub(crate) shape: Vec<Complex<f64>>,
    pub(crate) shape_bound: Option<Vec<f64>>,
    pub(crate) left_shape: Option<Vec<Complex<f64>>>,
    pub(crate) left_shape_bound: Option<Vec<f64>>,
    pub(crate) backward_error: f64,
    pub(crate) condition: Option<f64>,
}

impl Mode {
    /// λ, with Im λ ≥ 0.
    pub fn eigenvalue(&self) -> Eigenvalue {
        self.eigenvalue
    }

    /// How many roots are known to coincide exactly at λ: 1 for a simple root. Every entry of a repeated root carries it.
    /// `None` where the roots of a [`cluster`](Self::cluster) are neither separated nor proved to coincide.
    pub fn multiplicity(&self) -> Option<usize> {
        match self.repeats {
            Repeats::Exactly { count, .. } => Some(count),
            Repeats::Cluster(_) | Repeats::AtLeast(_) => None,
        }
    }

    /// How many roots lie so near to each other here that they are neither separated nor proved to coincide;
    /// `None` where the [`multiplicity`](Self::multiplicity) is known, or some of them may not have been found, as
    /// where some modes of a large system are not proved complete.
    pub fn cluster(&self) -> Option<usize> {
        match self.repeats {
            Repeats::Exactly { .. } | Repeats::AtLeast(_) => None,
            Repeats::Cluster(count) => Some(count),
        }
    }

    /// How many such roots were found; `None` where the [`multiplicity`](Self::multiplicity) is known.
    pub fn cluster_found(&self) -> Option<usize> {
        match self.repeats {
            Repeats::Exactly { .. } => None,
            Repeats::Cluster(count) | Repeats::AtLeast(count) => Some(count),
        }
    }

    /// Whether the root has fewer shapes than its multiplicity, as critical damping has; `None` where that is not known.
    pub fn is_defective(&self) -> Option<bool> {
        match self.repeats {
            Repeats::Exactly { defective, .. } => defective,
            Repeats::Cluster(_) | Repeats::AtLeast(_) => None,
        }
    }

    /// How many roots this entry stands for: 1, or several that have, or may have, one shape in common. Such a mode
    /// must not be superposed.
    pub fn roots(&self) -> usize {
        self.roots
    }

    /// How it moves; [`Motion::Doubtful`] where the bound of λ does not decide, and where a cluster on the real axis
    /// may hold conjugate pairs.
    pub fn motion(&self) -> Motion {
        match (self.eigenvalue.motion(), self.repeats) {
            (Motion::Decaying, Repeats::Cluster(_) | Repeats::AtLeast(_)) => Motion::Doubtful,
            (motion, _) => motion,
        }
    }

    /// ω_n = |λ|.
    pub fn natural_frequency(&self) -> Frequency {
        self.eigenvalue.natural_frequency()
    }

    /// ω_d = |Im λ|; 0 for a real root.
    pub fn damped_frequency(&self) -> Frequency {
        Frequency(self.eigenvalue.value.im.abs())
    }

    /// ζ = −Re λ / |λ|, for complex roots; `None` for real ones, and where the bound of λ leaves open whether it is
    /// real or on which side of 0 its real part lies. It is negative for a growing oscillation.
    pub fn damping_ratio(&self) -> Option<f64> {
        let Eigenvalue { value, bound, .. } = self.eigenvalue;
        let swings = value.im != 0.0 && bound.is_some_and(|bound| value.im.abs() > bound);
        (swings && self.eigenvalue.is_side_known()).then(|| {
            let ratio = value.re / value.norm();
            if ratio == 0.0 { 0.0 } else { -ratio }
        })
    }

    /// −Re λ in 1/s.
    pub fn decay_rate(&self) -> f64 {
        let re = self.eigenvalue.value.re;
        if re == 0.0 { 0.0 } else { -re }
    }

    /// 1/(−Re λ) in s, for modes that are known to decay; `None` for the others.
    pub fn time_constant(&self) -> Option<f64> {
        let decays = self.eigenvalue.value.re < 0.0 && self.eigenvalue.is_side_known();
        (decays || self.eigenvalue.motion() == Motion::Decaying).then(|| 1.0 / self.decay_rate())
    }

    /// The shape x with (λ²M + λC + K) x = 0, one entry for each coordinate; its largest component
    /// is 1 + 0i, the first one on ties: of those that doubles do not distinguish.
    pub fn shape(&self) -> &[Complex<f64>] {
        &self.shape
    }

    /// The component of the [`shape`](Self::shape) at the coordinate of a name.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    ///
    /// let system = System::builder()
    ///     .mass("m1", 1.0)
    ///     .mass("m2", 1.0)
    ///     .spring(GROUND, "m1", 2.0)
    ///     .spring("m1", "m2", 3.0)
    ///     .build()?;
    /// let modes = system.modes()?;
    /// assert_eq!(modes[0].component("m2")?, modes[0].shape()[1]);
    /// assert_eq!(
    ///     modes[0].component("m3").unwrap_err().to_string(),
    ///     "there is no coordinate \"m3\": there are \"m1\", \"m2\""
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`NoCoordinate`], which names those that there are.
    pub fn component(&self, name: &str) -> Result<Complex<f64>, NoCoordinate> {
        Ok(self.shape[self.names.find(name)?])
    }

    /// How far each component of the [`shape`](Self::shape) may be from that of the true shape whose component
    /// of 1 is the same one: proven, absolute, with the rounding to doubles. With the default tolerance it
    /// is within 4·2^-53 of the component wherever digits allow; a component that is not distinguished from 0 at 1e-22 is 0.
    ///
    /// `None` where the shape is not determined, as at a root that several shapes share, or nothing is proved:
    /// in doubles, and above 64 coordinates where the bounds of roots do not separate them.
    pub fn shape_bound(&self) -> Option<&[f64]> {
        self.shape_bound.as_deref()
    }

    /// The left shape y with y*(λ²M + λC + K) = 0, normalised as [`shape`](Self::shape) is: what a
    /// force must be shaped like to drive this mode most. For symmetric M, C, K it is the conjugate
    /// of the shape; for others `None` at λ = 0 and at defective roots.
    pub fn left_shape(&self) -> Option<&[Complex<f64>]> {
        self.left_shape.as_deref()
    }

    /// What [`shape_bound`](Self::shape_bound) is to the shape, for the left shape.
    pub fn left_shape_bound(&self) -> Option<&[f64]> {
        self.left_shape_bound.as_deref()
    }

    /// η = ‖Q(λ)x‖ / ((|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖), the smallest relative change of M, C, K for
    /// which λ and x are exact (Tisseur 2000, *Lin. Alg. Appl.* 309, theorem 1; here with
    /// Frobenius norms). Small η does not imply a correct λ: see [`condition`](Self::condition).
    pub fn backward_error(&self) -> f64 {
        self.backward_error
    }

    /// κ = (|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖‖y‖ / (|λ||y*(2λM + C)x|), the relative change of λ for a
    /// relative change of M, C, K (Tisseur 2000, theorem 5). `None` at λ = 0 and at defective
    /// roots, where no such number exists.
    pub fn condition(&self) -> Option<f64> {
        self.condition
    }
}

/// All modes of a system, sorted by |λ|, then Re λ, with every finite root.
///
/// ```
/// use eigentone_modes::{GROUND, Motion, System};
///
/// // One mass with a strong damper, ζ = 5/4.
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 4.0)
///     .damper(GROUND, "m", 5.0)
///     .build()?;
/// let modes = system.modes()?;
/// let rates: Vec<f64> = modes.iter().map(|mode| mode.decay_rate()).collect();
/// assert_eq!(rates, [1.0, 4.0]);
/// assert!(modes.iter().all(|mode| mode.motion() == Motion::Decaying));
/// assert!(modes.eigenvalues()[0].bound.is_some_and(|bound| bound < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    pub(crate) modes: Vec<Mode>,
    pub(crate) eigenvalues: Vec<Eigenvalue>,
    pub(crate) infinite: usize,
    pub(crate) bounds: Bounds,
    pub(crate) complete: bool,
    pub(crate) plan: ModePlan,
}

impl Modes {
    /// The modes in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Mode> {
        self.modes.iter()
    }

    /// The modes in order.
    pub fn as_slice(&self) -> &[Mode] {
        &self.modes
    }

    /// How many modes there are: one for each conjugate pair or real root, each shape of a repeated root by itself.
    pub fn len(&self) -> usize {
        self.modes.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.modes.is_empty()
    }

    /// Every finite root, conjugates and repeats included, sorted by |λ|, then Re λ, then +
    /// before − Im λ.
    pub fn eigenvalues(&self) -> &[Eigenvalue] {
        &self.eigenvalues
    }

    /// The number n of coordinates: the length of each shape.
    pub fn coordinates(&self) -> usize {
        self.modes.first().map_or(0, |mode| mode.shape.len())
    }

    /// How many of the 2n roots are infinite: two for each undamped massless node, one for each
    /// independent damper of a damped one.
    pub fn infinite(&self) -> usize {
        self.infinite
    }

    /// Whether the eigenvalues' bounds are proven.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether it is proved that these are all roots that were asked for, each as often as it occurs.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// How the modes were computed, and what was left out.
    pub fn plan(&self) -> &ModePlan {
        &self.plan
    }

    /// Those `count` modes whose natural frequencies are nearest to `target`, in order, with their
    /// eigenvalues; of two that are as near the one that comes first. All, if there are no more. They are
    /// [complete](Self::is_complete) where all modes are and bounds show that no other is nearer.
    pub fn nearest(mut self, target: Frequency, count: usize) -> Modes {
        let target = target.0;
        let at = |mode: &Mode| mode.natural_frequency().0;
        let distances = |a: &Mode, b: &Mode| compare_distances(target, at(a), at(b));
        self.modes.sort_by(distances);
        let rest = self.modes.split_off(count.min(self.modes.len()));
        // The least and the largest that it may be; |λ| is a rounded root of a rounded sum.
        let range = |mode: &Mode| {
            let (middle, bound) = (at(mode), mode.eigenvalue.bound?);
            let reach = bound + 2.0 * f64::EPSILON * middle;
            Some([(middle - reach).next_down(), (middle + reach).next_up()])
        };
        // Roots that coincide are as near as each other. Of others the farthest end of the one is no farther than the
        // nearest end of the other.
        let beyond = |near: &Mode, far: &Mode| {
            if near.eigenvalue == far.eigenvalue && near.multiplicity().is_some() {
                return true;
            }
            let (Some(own), Some([low, high])) = (range(near), range(far)) else {
                return false;
            };
            let end = match target {
                _ if target <= low => low,
                _ if target >= high => high,
                _ => return false,
            };
            own.into_iter()
                .all(|own| compare_distances(target, own, end).is_le())
        };
        let mut each = self.modes.iter();
        self.complete &= each.all(|near| rest.iter().all(|far| beyond(near, far)));
        sort(&mut self.modes);
        self.eigenvalues = listed(&self.modes);
        self
    }
}

/// Whether |target − a| is less than |target − b|, without rounding: distances from a target that is far away would be equal.
fn compare_distances(target: f64, a: f64, b: f64) -> Ordering {
    if target.is_nan() {
        return Ordering::Equal;
    }
    match (a <= target, b <= target) {
        (true, true) => b.total_cmp(&a),
        (false, false) => a.total_cmp(&b),
        // The target is between them: beside their middle a + b = sum + rest, all halved so that nothing overflows.
        (is_below, _) => {
            let (a, b) = (0.5 * a, 0.5 * b);
            let sum = a + b;
            let part = sum - a;
            let rest = (a - (sum - part)) + (b - part);
            let of_rest = rest.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
            let beside = sum.total_cmp(&target).then(of_rest);
            // A middle above the target: what is below is nearer to it.
            if is_below { beside.reverse() } else { beside }
        }
    }
}

/// Every root of the modes, conjugates and repeats included, sorted.
pub(crate) fn listed(modes: &[Mode]) -> Vec<Eigenvalue> {
    let mut eigenvalues = Vec::with_capacity(2 * modes.len());
    for mode in modes {
        for _ in 0..mode.roots {
            eigenvalues.push(mode.eigenvalue);
            if mode.eigenvalue.value.im != 0.0 {
                eigenvalues.push(mode.eigenvalue.conjugate());
            }
        }
    }
    eigenvalues.sort_by(order);
    eigenvalues
}

/// By the [order] of their eigenvalues.
pub(crate) fn sort(modes: &mut [Mode]) {
    modes.sort_by(|a, b| order(&a.eigenvalue, &b.eigenvalue));
}

/// |λ|, then Re λ, then + before − Im λ.
pub(crate) fn order(a: &Eigenvalue, b: &Eigenvalue) -> Ordering {
    let size = |e: &Eigenvalue| e.natural_frequency().radians_per_second();
    size(a)
        .total_cmp(&size(b))
        .then(a.value.re.total_cmp(&b.value.re))
        .then(b.value.im.total_cmp(&a.value.im))
}

/// The modes by their place in the order, from 0: `modes[0]` is the one of the smallest |λ|. As with slices, a place that does not
/// exist panics; [`as_slice`](Modes::as_slice) has `get`.
impl std::ops::Index<usize> for Modes {
    type Output = Mode;

    fn index(&self, place: usize) -> &Mode {
        &self.modes[place]
    }
}

impl<'a> IntoIterator for &'a Modes {
    type Item = &'a Mode;
    type IntoIter = std::slice::Iter<'a, Mode>;

    fn into_iter(self) -> Self::IntoIter {
        self.modes.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GROUND, System};

    /// 2 rad/s is nearer than 1 rad/s to whatever is above both, also where doubles do not hold the difference of distances.
    #[test]
    fn the_nearest_mode_to_a_far_target_is_the_highest() {
        let builder = System::builder().mass("a", 1.0).mass("b", 1.0);
        let builder = builder.spring(GROUND, "a", 1.0).spring(GROUND, "b", 4.0);
        let system = builder.build().expect("a system");
        let nearest = |target: f64| {
            let modes = system.modes().expect("modes");
            let nearest = modes.nearest(Frequency(target), 1);
            (nearest[0].natural_frequency().0, nearest.is_complete())
        };
        for target in [1.6, 1e17, f64::MAX, f64::INFINITY] {
            assert_eq!(nearest(target), (2.0, true), "{target}");
        }
        for target in [1.4, 0.0, -1e300] {
            assert_eq!(nearest(target), (1.0, true), "{target}");
        }
        // As near as the bounds let it be.
        assert_eq!(nearest(1.5), (1.0, false));
        assert!(!nearest(f64::NAN).1);
    }

    #[test]
    fn distances_are_compared_without_rounding() {
        let middle = 1.0 + f64::EPSILON;
        for (target, a, b, right) in [
            (1.0, 0.0, 2.0, Ordering::Equal),
            (1.0, 2.0, 0.0, Ordering::Equal),
            (1.0, 1e-30, 2.0, Ordering::Less),
            (1.0, 2.0, 1e-30, Ordering::Greater),
            (middle, 0.0, 2.0, Ordering::Greater),
            (f64::MAX, f64::MAX, f64::INFINITY, Ordering::Less),
            (f64::MAX, 1.0, f64::INFINITY, Ordering::Less),
        ] {
            assert_eq!(compare_distances(target, a, b), right, "{target} {a} {b}");
        }
    }
}
