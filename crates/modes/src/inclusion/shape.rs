//! Shapes of roots that lie in known discs, with a proven bound for each component.
//!
//! Q(λ) is eliminated with complete pivoting in balls that hold it for every λ of the disc. Where
//! n − 1 pivots are certainly not zero, its rank is n − 1 at least, and at a root no more: what the
//! last row leaves is 0 there, and back substitution gives balls about the components of the one
//! shape (Rump 2010, *Acta Numerica* 19, §10).
//!
//! Where the disc is too wide for that to tell enough, it is narrowed. With the root λ, its shape x, a
//! point z of the disc and any w,
//!
//! 0 = wᵀQ(λ)x = wᵀQ(z)x + (λ − z)·wᵀ((λ + z)M + C)x,
//!
//! and all but the first λ is known in balls. Near a left shape w the row wᵀQ(z) is nearly 0, so that
//! what is not known of x multiplies what is not known of λ: the digits double.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide};
use num_complex::Complex;

use super::exactly::{Terms, exact, radius, real, terms, upper};
use super::pencil::{Pencil, PencilIn};

/// Up to so many coordinates, twice the digits are quick enough to tell whether a component that 32
/// digits leave at 0 is 0, and one that they leave equal to the largest equal.
const FEW: usize = 12;

/// What so many coordinates leave open beside a largest component of 1: whether a smaller one is 0, and which
/// of two that differ by less is the larger.
pub(crate) fn hidden(coordinates: usize) -> f64 {
    if coordinates <= FEW { 1e-28 } else { 1e-22 }
}

/// A disc in units that any precision can read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    centre: [Terms; 2],
    radius: f64,
}

impl Disc {
    /// A disc that holds the ball, and little more.
    pub(crate) fn of<T: Real>(ball: Ball<T>) -> Disc {
        let middle = ball.middle();
        let mut disc = Disc {
            centre: [terms(middle.re), terms(middle.im)],
            radius: 0.0,
        };
        disc.radius = upper(ball - disc.ball());
        disc
    }

    fn ball<T: Real>(&self) -> Ball<T> {
        let part = |terms: &Terms| {
            let sum = terms.iter().map(|term| real(*term));
            sum.fold(Ball::<T>::ZERO, |sum, term| sum + term)
        };
        let [re, im] = [part(&self.centre[0]), part(&self.centre[1])];
        let middle = exact(re.middle().re, im.middle().re).middle();
        Ball::new(
            middle,
            re.radius() + im.radius() + Magnitude::from(self.radius),
        )
    }
}

/// A shape whose largest component is 1, the first one on ties.
#[derive(Clone, Debug)]
pub(crate) struct Enclosed {
    pub(crate) shape: Vec<Complex<f64>>,
    /// How far each component may be off.
    pub(crate) bounds: Vec<f64>,
    /// How far apart components may be of which the largest could be any; 0 where it is one alone.
    tie: f64,
}

impl Enclosed {
    /// From balls about the components of any multiple; with `is_real`, of a real one. `None` where they do not tell the
    /// largest one to six digits.
    pub(crate) fn of<T: Real>(components: &[Ball<T>], is_real: bool) -> Option<Enclosed> {
        const TOLD: f64 = 1e-6;
        let (pivot, tie) = largest(components)?;
        let divisor = components[pivot];
        if divisor.contains_zero() || divisor.radius() > divisor.upper() * Magnitude::from(TOLD) {
            return None;
        }
        let end = hidden(components.len());
        let mut enclosed = Enclosed {
            shape: Vec::with_capacity(components.len()),
            bounds: Vec::with_capacity(components.len()),
            tie,
        };
        for (i, component) in components.iter().enumerate() {
            let (value, bound) = if i == pivot {
                (Complex::ONE, 0.0)
            } else {
                rounded(component.checked_div(divisor)?, is_real, end)
            };
            if !value.is_finite() || !bound.is_finite() {
                return None;
            }
            enclosed.shape.push(value);
            enclosed.bounds.push(bound);
        }
        Some(enclosed)
    }

    /// The shape that is known exactly.
    pub(crate) fn exactly(shape: Vec<Complex<f64>>) -> Enclosed {
        Enclosed {
            bounds: vec![0.0; shape.len()],
            shape,
            tie: 0.0,
        }
    }

    /// Whether every bound is within half of a relative tolerance, which leaves the other half to those who
    /// compute with the shape, and the largest component is known or equals others as far as digits show.
    pub(crate) fn meets(&self, tolerance: f64) -> bool {
        self.looseness() <= 0.5 * tolerance && self.tie <= hidden(self.shape.len())
    }

    /// The largest relative bound, but for components that may stay hidden.
    pub(crate) fn looseness(&self) -> f64 {
        let each = self.shape.iter().zip(&self.bounds);
        let end = hidden(self.shape.len());
        let told = each.filter(|(x, bound)| x.norm() > 0.0 || **bound > end);
        let relative = told.map(|(x, bound)| match *bound {
            0.0 => 0.0,
            bound => bound / x.norm(),
        });
        relative.fold(0.0, f64::max)
    }

    /// Whether a component is given as 0, or as equal to the largest, that need not be.
    fn is_doubtful(&self) -> bool {
        let mut each = self.shape.iter().zip(&self.bounds);
        self.tie > 0.0 || each.any(|(x, bound)| x.norm() == 0.0 && *bound > 0.0)
    }

    fn conjugate(mut self) -> Enclosed {
        self.shape.iter_mut().for_each(|x| *x = x.conj());
        self
    }
}

/// Which component is the largest, the first of those that may be; and how much less than the largest square
/// that of any of these may be, in proportion.
fn largest<T: Real>(components: &[Ball<T>]) -> Option<(usize, f64)> {
    let larger = |a: Magnitude, b: Magnitude| if a < b { b } else { a };
    let sizes = components.iter().map(|x| x.lower());
    let size = sizes.fold(Magnitude::ZERO, larger);
    let near = (0..components.len()).filter(|i| components[*i].upper() >= size);
    // Sizes have the digits of doubles, squares all.
    let square = |i: usize| {
        let x = components[i];
        (i, x * Ball::new(x.middle().conj(), x.radius()))
    };
    let near: Vec<(usize, Ball<T>)> = near.map(square).collect();
    let (mut top, rest) = (near.first()?.1, near.get(1..)?);
    for (_, square) in rest {
        if square.middle().re > top.middle().re {
            top = *square;
        }
    }
    let mut rivals = near.iter().map(|(i, square)| (*i, top - *square));
    let mut rivals = rivals.by_ref().filter(|(_, less)| less.contains_zero());
    let (pivot, _) = rivals.next()?;
    let shares = rivals.map(|(_, less)| (less.upper() / top.upper()).to_f64());
    Some((pivot, shares.fold(0.0, f64::max)))
}

/// The nearest double, and how far the component may be from it.
fn rounded<T: Real>(ball: Ball<T>, is_real: bool, end: f64) -> (Complex<f64>, f64) {
    let middle = ball.middle();
    // A part without a sign is 0.
    let part = |part: T| {
        if part.upper() <= ball.radius() {
            0.0
        } else {
            part.to_f64()
        }
    };
    let mut value = Complex::new(middle.re.to_f64(), middle.im.to_f64());
    if !ball.contains_zero() {
        value = Complex::new(part(middle.re), part(middle.im));
    } else if upper(ball) <= end {
        value = Complex::ZERO;
    }
    if is_real {
        value.im = 0.0;
    }
    let off = ball - exact(T::from(value.re), T::from(value.im));
    (value + Complex::ZERO, upper(off))
}

/// The shapes of one root.
#[derive(Clone, Debug)]
pub(crate) struct Shapes {
    pub(crate) right: Enclosed,
    /// y with y*Q = 0, where that does not follow from x by symmetry.
    pub(crate) left: Option<Enclosed>,
}

impl Shapes {
    fn both(&self) -> impl Iterator<Item = &Enclosed> {
        std::iter::once(&self.right).chain(&self.left)
    }
}

/// Of which roots shapes are sought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Relative, for each component.
    pub(crate) tolerance: f64,
    pub(crate) symmetric: bool,
    /// How many roots there are in all: what each may cost.
    pub(crate) roots: usize,
}

/// What is known of one root beside its disc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    pub(crate) is_simple: bool,
    /// Whether its shape is proved to be real.
    pub(crate) is_real: bool,
}

/// Searches the shapes of the roots of one pencil.
pub(crate) struct Shaper<'a> {
    pencil: &'a Pencil,
    unit: i32,
    goal: Goal,
    plain: PencilIn<DoubleDouble>,
}

type Search = fn(&Shaper<'_>, &mut Known, Kind) -> Option<Shapes>;

/// What one precision leaves to the next.
struct Known {
    disc: Disc,
    /// Null vectors of Q and Qᵀ, as the pencil scales them; empty where none was found.
    right: Vec<Disc>,
    left: Vec<Disc>,
}

/// Limbs, and the search with them.
const WIDER: [(usize, Search); 3] = [
    (4, in_precision::<Wide<4>>),
    (8, in_precision::<Wide<8>>),
    (16, in_precision::<Wide<16>>),
];

fn in_precision<T: Real>(shaper: &Shaper<'_>, known: &mut Known, kind: Kind) -> Option<Shapes> {
    let (precise, _) = shaper.pencil.precise::<T>(shaper.unit);
    shaper.search(&precise, known, kind)
}

impl<'a> Shaper<'a> {
    /// For discs of μ with λ = 2^unit·μ, or −ω² = 4^unit·μ.
    pub(crate) fn of(pencil: &'a Pencil, unit: i32, goal: Goal) -> Shaper<'a> {
        Shaper {
            pencil,
            unit,
            goal,
            plain: pencil.precise(unit).0,
        }
    }

    /// The shapes of every root in the disc, with as many digits as it takes; `None` where they are not
    /// proved to be one each.
    pub(crate) fn shapes(&self, disc: Disc, kind: Kind) -> Option<Shapes> {
        let mut known = Known {
            disc,
            right: Vec::new(),
            left: Vec::new(),
        };
        let mut best = self.search(&self.plain, &mut known, kind);
        // More digits do not separate what is one.
        if !kind.is_simple {
            return best;
        }
        let few = self.pencil.len() <= FEW;
        let mut limbs_used = 2;
        for (limbs, search) in WIDER {
            let enough = best.as_ref().is_some_and(|found| {
                let doubtful = few && limbs_used == 2 && found.both().any(Enclosed::is_doubtful);
                self.is_good(found) && !doubtful
            });
            if enough || !self.pencil.affords(limbs, self.goal.roots) {
                break;
            }
            best = search(self, &mut known, kind).or(best);
            limbs_used = limbs;
        }
        best
    }

    fn is_good(&self, found: &Shapes) -> bool {
        found.both().all(|shape| shape.meets(self.goal.tolerance))
    }

    fn search<T: Real>(
        &self,
        pencil: &PencilIn<T>,
        known: &mut Known,
        kind: Kind,
    ) -> Option<Shapes> {
        const STEPS: usize = 4;
        let balls = |discs: &[Disc]| discs.iter().map(Disc::ball).collect::<Vec<Ball<T>>>();
        let (mut x, mut y) = (balls(&known.right), balls(&known.left));
        let mut ball = known.disc.ball::<T>();
        let mut best = None;
        for step in 0..STEPS {
            if !x.is_empty() {
                let left = if self.goal.symmetric { &x } else { &y };
                let next = pencil.narrowed(ball, &x, left);
                let next = next.filter(|next| radius(*next) <= 0.5 * radius(ball));
                match next {
                    Some(next) => ball = next,
                    None if step > 0 => break,
                    None => {}
                }
            }
            let Some(found) = pencil.null_vector(ball, false) else {
                break;
            };
            x = found;
            if !self.goal.symmetric {
                y = pencil.null_vector(ball, true)?;
            }
            let enclosed = |x: &[Ball<T>]| Enclosed::of(&pencil.in_coordinates(x), kind.is_real);
            // y*Q = 0 is Qᵀȳ = 0.
            let left = (!self.goal.symmetric).then(|| enclosed(&y).map(Enclosed::conjugate));
            if let Some(right) = enclosed(&x)
                && left.as_ref().is_none_or(Option::is_some)
            {
                let left = left.flatten();
                let found = Shapes { right, left };
                let good = self.is_good(&found);
                best = Some(found);
                if good {
                    break;
                }
            }
        }
        let discs = |balls: &[Ball<T>]| balls.iter().map(|ball| Disc::of(*ball)).collect();
        *known = Known {
            disc: Disc::of(ball),
            right: discs(&x),
            left: discs(&y),
        };
        best
    }
}
