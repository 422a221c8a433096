//! Shapes of roots that lie in known discs, with a proven bound for each component.
//!
//! Q(λ) is eliminated with complete pivoting in balls that hold it for every λ of the disc. Where
//! n − 1 pivots are certainly not zero, its rank is n − 1 at least, and at a root no more: what the
//! last row leaves is 0 there, and back substitution gives balls about the components of the one
//! shape (Rump 2010, *Acta Numerica* 19, §10).
//!
//! Where the disc is too wide for that to be enough, it is narrowed. With the root λ, its shape x, a
//! point z of the disc and any w,
//!
//! 0 = wᵀQ(λ)x = wᵀQ(z)x + (λ − z)·wᵀ((λ + z)M + C)x,
//!
//! and all but the first λ is known in balls. Near a left shape w the row wᵀQ(z) is nearly 0, so that
//! what is not known of x multiplies what is not known of λ: the digits double.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide, WideComplex};
use num_complex::Complex;

use super::exactly::{Terms, exact, radius, real, terms, upper};
use super::gram::UPWARD;
use super::pencil::{Pencil, PencilIn};

/// Up to so many coordinates, twice the digits are quick enough to decide whether a component that 32
/// digits leave at 0 is 0.
const FEW: usize = 12;

/// Beside a largest component of 1 so many coordinates leave open whether a smaller one is 0.
fn hidden(coordinates: usize) -> f64 {
    if coordinates <= FEW { 1e-28 } else { 1e-22 }
}

/// How far the largest component may be off, relative.
const RESOLVED: f64 = 1e-6;

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

    pub(super) fn ball<T: Real>(&self) -> Ball<T> {
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

/// A shape whose largest component is 1, the first one of those that doubles do not distinguish.
#[derive(Clone, Debug)]
pub(crate) struct Enclosed {
    pub(crate) shape: Vec<Complex<f64>>,
    /// How far each component may be off.
    pub(crate) bounds: Vec<f64>,
}

impl Enclosed {
    /// From balls about the components of any multiple; with `is_real`, of a real one. `None` where they do not give the
    /// largest one to six digits.
    pub(crate) fn of<T: Real>(components: &[Ball<T>], is_real: bool) -> Option<Enclosed> {
        let middles: Vec<_> = components.iter().map(|x| x.middle()).collect();
        let pivot = largest(&middles)?;
        let divisor = components[pivot];
        if divisor.contains_zero() || divisor.radius() > divisor.upper() * Magnitude::from(RESOLVED)
        {
            return None;
        }
        let end = hidden(components.len());
        let inverse = Ball::ONE.checked_div(divisor)?;
        let mut enclosed = Enclosed {
            shape: Vec::with_capacity(components.len()),
            bounds: Vec::with_capacity(components.len()),
        };
        for (i, component) in components.iter().enumerate() {
            let (value, bound) = if i == pivot {
                (Complex::ONE, 0.0)
            } else {
                rounded(*component * inverse, is_real, end)
            };
            if !value.is_finite() || !bound.is_finite() {
                return None;
            }
            enclosed.shape.push(value);
            enclosed.bounds.push(bound);
        }
        Some(enclosed)
    }

    /// From a real shape in double-double and how far each component may be off, which is more than what underflow takes.
    pub(crate) fn real(shape: &[DoubleDouble], errors: &[f64]) -> Option<Enclosed> {
        let middle = |re: &DoubleDouble| WideComplex {
            re: *re,
            im: DoubleDouble::ZERO,
        };
        let middles: Vec<_> = shape.iter().map(middle).collect();
        let pivot = largest(&middles)?;
        let (divisor, doubt) = (shape[pivot], errors[pivot]);
        let size = divisor.to_f64().abs();
        if !(size > 0.0 && doubt <= RESOLVED * size) {
            return None;
        }
        let end = hidden(shape.len());
        let component = |(i, (x, error)): (usize, (&DoubleDouble, &f64))| {
            if i == pivot {
                return (Complex::ONE, 0.0);
            }
            let quotient = *x / divisor;
            let value = quotient.to_f64();
            // Of the components, and of the quotient and all that is summed here.
            let off = (error + value.abs() * doubt) / (size - doubt) * UPWARD;
            let radius = off + 2f64.powi(-96) * value.abs();
            let is_hidden = value.abs() <= radius && (value.abs() + radius) * UPWARD <= end;
            let value = if is_hidden { 0.0 } else { value };
            let rounding = (quotient - DoubleDouble::from(value)).to_f64().abs();
            // Never −0.
            (Complex::from(value + 0.0), (rounding + radius) * UPWARD)
        };
        let (shape, bounds): (Vec<_>, Vec<_>) =
            shape.iter().zip(errors).enumerate().map(component).unzip();
        let is_finite = |(x, bound): (&Complex<f64>, &f64)| x.is_finite() && bound.is_finite();
        let are_finite = shape.iter().zip(&bounds).all(is_finite);
        are_finite.then_some(Enclosed { shape, bounds })
    }

    /// The shape that is known exactly.
    pub(crate) fn exactly(shape: Vec<Complex<f64>>) -> Enclosed {
        Enclosed {
            bounds: vec![0.0; shape.len()],
            shape,
        }
    }

    /// Whether every bound is within half of a relative tolerance, which leaves the other half to those who
    /// compute with the shape.
    pub(crate) fn meets(&self, tolerance: f64) -> bool {
        self.looseness() <= 0.5 * tolerance
    }

    /// The largest relative bound, but for components that may stay hidden.
    pub(crate) fn looseness(&self) -> f64 {
        let each = self.shape.iter().zip(&self.bounds);
        let end = hidden(self.shape.len());
        let visible = each.filter(|(x, bound)| x.norm() > 0.0 || **bound > end);
        let relative = visible.map(|(x, bound)| match *bound {
            0.0 => 0.0,
            bound => bound / x.norm(),
        });
        relative.fold(0.0, f64::max)
    }

    /// Whether a component is given as 0 that need not be 0.
    fn is_doubtful(&self) -> bool {
        let mut each = self.shape.iter().zip(&self.bounds);
        each.any(|(x, bound)| x.norm() == 0.0 && *bound > 0.0)
    }

    pub(crate) fn conjugate(mut self) -> Enclosed {
        self.shape
            .iter_mut()
            .for_each(|x| *x = x.conj() + Complex::ZERO);
        self
    }
}

/// Which component is the largest: the first of those whose sizes are equal as doubles, so that it is the first
/// in what is shown.
fn largest<T: Real>(components: &[WideComplex<T>]) -> Option<usize> {
    /// Of squares: half of the distance from 1 to the double below it, twice.
    const TIE: f64 = f64::EPSILON / 2.0;
    /// Sizes in doubles err by far less.
    const NEAR: f64 = 1.0 - 1e-12;
    let square = |x: &WideComplex<T>| x.re * x.re + x.im * x.im;
    let sizes: Vec<f64> = components.iter().map(|x| x.norm()).collect();
    let most = sizes.iter().fold(0.0, |most: f64, size| most.max(*size));
    let is_large = |at: &usize| sizes[*at] >= NEAR * most || !most.is_normal();
    let large = || (0..components.len()).filter(is_large);
    let larger = |a: T, b: T| if a < b { b } else { a };
    let top = large()
        .map(|at| square(&components[at]))
        .fold(T::ZERO, larger);
    let least = top - top.mul_f64(TIE);
    large().find(|at| square(&components[*at]) >= least)
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
    // Most are, by far.
    let twice = 2.0 * ball.radius().to_f64();
    let is_clear = value.re.abs() > twice && (value.im.abs() > twice || middle.im.is_zero());
    if !is_clear && !ball.contains_zero() {
        value = Complex::new(part(middle.re), part(middle.im));
    } else if !is_clear && upper(ball) <= end {
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

    /// Whether every bound is within half of a relative tolerance.
    pub(crate) fn meet(&self, tolerance: f64) -> bool {
        self.both().all(|shape| shape.meets(tolerance))
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
    /// Null vectors of Q and Qᵀ; empty where none was found.
    right: Vec<Disc>,
    left: Vec<Disc>,
    /// The units of their entries.
    exponents: Vec<i32>,
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

impl Goal {
    /// The shapes of a symmetric system from balls about the components of one, if they are all that more digits would show.
    pub(crate) fn known(&self, components: &[Ball<DoubleDouble>], kind: Kind) -> Option<Shapes> {
        let right = Enclosed::of(components, kind.is_real).filter(|_| self.symmetric)?;
        let found = Shapes { right, left: None };
        let open = components.len() <= FEW && found.both().any(Enclosed::is_doubtful);
        (found.meet(self.tolerance) && !open).then_some(found)
    }
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
            exponents: Vec::new(),
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
        found.meet(self.goal.tolerance)
    }

    fn search<T: Real>(
        &self,
        pencil: &PencilIn<T>,
        known: &mut Known,
        kind: Kind,
    ) -> Option<Shapes> {
        const STEPS: usize = 4;
        let same_units = known.exponents == pencil.exponents();
        let balls = |discs: &[Disc]| -> Vec<Ball<T>> {
            let each = discs.iter().filter(|_| same_units);
            each.map(Disc::ball).collect()
        };
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
                // Then no other precision goes on from here.
                let is_last = good && !found.both().any(Enclosed::is_doubtful);
                best = Some(found);
                if is_last {
                    return best;
                }
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
            exponents: pencil.exponents().to_vec(),
        };
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(value: f64, reach: f64) -> Ball<DoubleDouble> {
        Ball::new(exact(value.into(), 0.0.into()).middle(), reach.into())
    }

    #[test]
    fn the_largest_component_is_known_to_six_digits_or_refused() {
        let found = |reach: f64| Enclosed::of(&[around(1.0, 0.0), around(-2.0, reach)], true);
        assert!(found(1e-5).is_none());
        let enclosed = found(1e-7).unwrap();
        assert_eq!(enclosed.shape, [-0.5, 1.0].map(Complex::from));
        // 1/(2 − 1e-7) is 2.5e-8 further away than a half.
        assert!(enclosed.bounds[1] == 0.0 && (2.5e-8..1e-7).contains(&enclosed.bounds[0]));
    }

    #[test]
    fn looseness_is_that_of_the_loosest_component() {
        let enclosed = Enclosed {
            shape: [1.0, 0.5, -0.25].map(Complex::from).to_vec(),
            bounds: vec![0.0, 1e-10, 1e-10],
        };
        assert_eq!(enclosed.looseness(), 4e-10);
        assert!(enclosed.meets(8.1e-10) && !enclosed.meets(7.9e-10));
    }
}
