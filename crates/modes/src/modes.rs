//! The answer of the quadratic eigenproblem: eigenvalues, and modes with their quality.

use std::cmp::Ordering;

use num_complex::Complex;

use crate::plan::ModePlan;

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
    /// λ real and negative: it creeps back without crossing.
    Decaying,
    /// λ complex, Re λ ≤ 0.
    Oscillating,
    /// Re λ > 0: it grows without limit.
    Growing,
}

impl std::fmt::Display for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Motion::Rigid => "rigid",
            Motion::Decaying => "decaying",
            Motion::Oscillating => "oscillating",
            Motion::Growing => "growing",
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
    /// First-order estimate of |λ̂ − λ| (absolute, 1/s); `None` where none can be given.
    pub bound: Option<f64>,
    /// The same for the real part alone.
    pub real_bound: Option<f64>,
}

impl Eigenvalue {
    /// ω_n = |λ|.
    pub fn natural_frequency(&self) -> Frequency {
        Frequency(self.value.norm())
    }

    /// How the root moves.
    pub fn motion(&self) -> Motion {
        let Complex { re, im } = self.value;
        if re == 0.0 && im == 0.0 {
            Motion::Rigid
        } else if re > 0.0 {
            Motion::Growing
        } else if im == 0.0 {
            Motion::Decaying
        } else {
            Motion::Oscillating
        }
    }

    /// The conjugate root, with the same bounds.
    pub fn conjugate(&self) -> Eigenvalue {
        Eigenvalue {
            value: self.value.conj(),
            ..*self
        }
    }
}

/// One mode: a conjugate pair (given by its root with Im λ > 0) or a real root, its shape and its
/// quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    pub(crate) eigenvalue: Eigenvalue,
    pub(crate) multiplicity: usize,
    pub(crate) defective: bool,
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

    /// How many roots coincide at λ: 1 for a simple root. A repeated root with a full set of
    /// shapes is listed once for each shape, every entry carrying the multiplicity.
    pub fn multiplicity(&self) -> usize {
        self.multiplicity
    }

    /// Whether the root has fewer shapes than its multiplicity, as critical damping has. Such a
    /// mode must not be superposed.
    pub fn is_defective(&self) -> bool {
        self.defective
    }

    /// How it moves.
    pub fn motion(&self) -> Motion {
        self.eigenvalue.motion()
    }

    /// ω_n = |λ|.
    pub fn natural_frequency(&self) -> Frequency {
        self.eigenvalue.natural_frequency()
    }

    /// ω_d = |Im λ|; 0 for a real root.
    pub fn damped_frequency(&self) -> Frequency {
        Frequency(self.eigenvalue.value.im.abs())
    }

    /// ζ = −Re λ / |λ|, for complex roots; `None` for real ones. It is negative for a growing
    /// oscillation.
    pub fn damping_ratio(&self) -> Option<f64> {
        let value = self.eigenvalue.value;
        (value.im != 0.0).then(|| {
            let ratio = value.re / value.norm();
            if ratio == 0.0 { 0.0 } else { -ratio }
        })
    }

    /// −Re λ in 1/s.
    pub fn decay_rate(&self) -> f64 {
        let re = self.eigenvalue.value.re;
        if re == 0.0 { 0.0 } else { -re }
    }

    /// 1/(−Re λ) in s, for modes that decay; `None` for the others.
    pub fn time_constant(&self) -> Option<f64> {
        (self.eigenvalue.value.re < 0.0).then(|| 1.0 / self.decay_rate())
    }

    /// The shape x with (λ²M + λC + K) x = 0, one entry for each coordinate; its largest component
    /// is 1 + 0i, the first one on ties: of those that doubles do not tell apart.
    pub fn shape(&self) -> &[Complex<f64>] {
        &self.shape
    }

    /// How far each component of the [`shape`](Self::shape) may be from that of the true shape whose component
    /// of 1 is the same one: proven, absolute, with the rounding to doubles. With the default tolerance it
    /// is within 4·2^-53 of the component wherever digits allow; a component that is not told from 0 at 1e-22 is 0.
    ///
    /// `None` where the shape is not determined, as at a root that several shapes share, or nothing is proved:
    /// in doubles, and above 64 coordinates where the bounds of roots do not tell them apart.
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

    /// How the modes were computed, and what was left out.
    pub fn plan(&self) -> &ModePlan {
        &self.plan
    }

    /// Those `count` modes whose natural frequencies are nearest to `target`, in order, with their
    /// eigenvalues; of two that are as near the one that comes first. All, if there are no more.
    pub fn nearest(mut self, target: Frequency, count: usize) -> Modes {
        let apart = |mode: &Mode| (mode.natural_frequency().0 - target.0).abs();
        self.modes.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        self.modes.truncate(count);
        self.modes
            .sort_by(|a, b| order(&a.eigenvalue, &b.eigenvalue));
        self.eigenvalues = listed(&self.modes);
        self
    }
}

/// Every root of the modes, conjugates and repeats included, sorted.
pub(crate) fn listed(modes: &[Mode]) -> Vec<Eigenvalue> {
    let mut eigenvalues = Vec::with_capacity(2 * modes.len());
    for mode in modes {
        let count = if mode.defective { mode.multiplicity } else { 1 };
        for _ in 0..count {
            eigenvalues.push(mode.eigenvalue);
            if mode.eigenvalue.value.im != 0.0 {
                eigenvalues.push(mode.eigenvalue.conjugate());
            }
        }
    }
    eigenvalues.sort_by(order);
    eigenvalues
}

/// |λ|, then Re λ, then + before − Im λ.
pub(crate) fn order(a: &Eigenvalue, b: &Eigenvalue) -> Ordering {
    let size = |e: &Eigenvalue| e.natural_frequency().radians_per_second();
    size(a)
        .total_cmp(&size(b))
        .then(a.value.re.total_cmp(&b.value.re))
        .then(b.value.im.total_cmp(&a.value.im))
}

impl<'a> IntoIterator for &'a Modes {
    type Item = &'a Mode;
    type IntoIter = std::slice::Iter<'a, Mode>;

    fn into_iter(self) -> Self::IntoIter {
        self.modes.iter()
    }
}
