//! One root with its shape by a Newton step that is proved to contract (Krawczyk 1969, *Computing* 4; for eigenpairs Rump 2010,
//! *Acta Numerica* 19, §13).
//!
//! With v_p held, Q(μ)v = 0 are n equations for the other components and μ. For the exact solution (v + w, μ + δ), with w_p = 0,
//!
//! 0 = Q(μ)v + J·e + δ·Q′(μ)w + δ²·M(v + w),
//!
//! where e is w with δ in place of w_p, and J is Q(μ) with Q′(μ)v in place of its column p. For any R, close to J⁻¹, and d ≈ −R·Q(μ)v
//! therefore
//!
//! e − d = −(d + R·Q(μ)v) + (I − RJ)e − R(δ·Q′(μ)w + δ²·M(v + w)).
//!
//! The right side maps all e with |e − d| ≤ g, component by component, into themselves where its size is below g for the largest of
//! them. Then one is mapped onto itself (Brouwer), R is not singular since |I − RJ|·(|d| + g) < |d| + g, and Q(μ + δ)(v + w) = 0. The
//! residual is found with 32 digits, and all else in doubles with bounds of every rounding error: d is off by about as much as the
//! square of itself. Sizes are |re| + |im|, for which |ab| ≤ |a||b|. What is real stays real.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, WideComplex};
use num_complex::Complex;

use super::approximate_inverse::{Inverse, size};
use super::pencil::PencilIn;

/// Of a coefficient whose digits a double-double holds.
struct Coefficient {
    row: usize,
    column: usize,
    value: DoubleDouble,
    size: f64,
}

/// The equations of one pencil.
pub(super) struct Equations {
    n: usize,
    /// The coefficients of 1, μ and μ².
    parts: [Vec<Coefficient>; 3],
    /// What a residual may be off by, relative to the sum of the sizes of its terms.
    uncertain: f64,
    /// The same for what is computed in doubles.
    rounding: f64,
}

/// Approximations of a root and its shape.
pub(super) struct Approximate {
    pub(super) root: Complex<f64>,
    /// In the pencil's own units.
    pub(super) shape: Vec<Complex<f64>>,
}

/// A root and its shape, one component of which is held.
pub(super) struct Enclosure {
    pub(super) root: Ball<DoubleDouble>,
    pub(super) shape: Vec<Ball<DoubleDouble>>,
}

/// More than all that underflows.
const FLOOR: f64 = 1e-280;

/// A little more than the roundings of sums of bounds.
const UPWARD: f64 = 1.0 + 1e-9;

impl Equations {
    /// `None` where a coefficient is not known to the digits of a double-double.
    pub(super) fn of(pencil: &PencilIn<DoubleDouble>) -> Option<Equations> {
        const DIGITS: f64 = 1.0 / (1u128 << 90) as f64;
        /// All coefficients of a row come to less than the floor.
        const NOTHING: f64 = 1e-290;
        let mut parts = [const { Vec::new() }; 3];
        let mut uncertain = 0f64;
        for (row, column, coefficients) in pencil.entries() {
            for (part, ball) in parts.iter_mut().zip(coefficients) {
                let (value, radius) = (ball.middle().re, ball.radius().to_f64());
                let size = value.to_f64().abs();
                if radius > NOTHING {
                    uncertain = uncertain.max(radius / size);
                }
                if size > 0.0 {
                    part.push(Coefficient {
                        row: *row,
                        column: *column,
                        value,
                        size: size * UPWARD,
                    });
                }
            }
        }
        let n = pencil.size();
        let rounding = (4 * n + 40) as f64;
        let unit = 2f64.powi(DoubleDouble::UNIT_LOG2);
        (uncertain < DIGITS).then_some(Equations {
            n,
            parts,
            uncertain: uncertain + rounding * unit,
            rounding: rounding * f64::EPSILON,
        })
    }

    /// The root and the shape near given ones, as closely as is asked for if a few steps lead there; `None` where none is proved.
    pub(super) fn solve(
        &self,
        mut at: Approximate,
        is_close: impl Fn(Ball<DoubleDouble>) -> bool,
    ) -> Option<Enclosure> {
        const STEPS: usize = 3;
        let largest = |a: &usize, b: &usize| size(at.shape[*a]).total_cmp(&size(at.shape[*b]));
        let held = (0..self.n).max_by(largest)?;
        let scale = at.shape[held];
        at.shape.iter_mut().for_each(|x| *x /= scale);
        at.shape[held] = Complex::ONE;
        let mut found = None;
        for _ in 0..STEPS {
            let (step, enclosure) = self.step(&at, held)?;
            found = enclosure.or(found);
            if found.as_ref().is_some_and(|found| is_close(found.root)) {
                break;
            }
            at.root += step[held];
            let others = (0..self.n).filter(|i| *i != held);
            others.for_each(|i| at.shape[i] += step[i]);
        }
        found
    }

    /// The Newton step, and what it proves; `None` where J cannot be inverted.
    fn step(
        &self,
        at: &Approximate,
        held: usize,
    ) -> Option<(Vec<Complex<f64>>, Option<Enclosure>)> {
        let n = self.n;
        let residual = self.residual(at);
        let jacobian = self.jacobian(at, held);
        let inverse = Inverse::of(&jacobian, n)?;
        let nearest = |r: &[DoubleDouble; 2]| Complex::new(-r[0].high(), -r[1].high());
        let nearest: Vec<Complex<f64>> = residual.iter().map(nearest).collect();
        let step = inverse.times(&nearest);

        let root = size(at.root);
        let whole = |[k, c, m]: &[f64; 3]| k + root * (c + root * m);
        let slope = |[_, c, m]: &[f64; 3]| c + 2.0 * root * m;
        let shape = self.sizes(|i| size(at.shape[i]));
        let mut known: Vec<f64> = nearest
            .iter()
            .map(|nearest| self.rounding * size(*nearest))
            .collect();
        for ((known, [re, im]), shape) in known.iter_mut().zip(&residual).zip(&shape) {
            *known += re.low().abs() + im.low().abs() + self.uncertain * whole(shape) + FLOOR;
        }
        // How far e may be from d, for all e of these sizes.
        let reach = |e: &[f64]| -> Vec<f64> {
            let delta = e[held];
            let moved = self.sizes(|i| if i == held { 0.0 } else { e[i] });
            let terms = known.iter().zip(&shape).zip(&moved).map(|((known, v), w)| {
                let rounded = self.rounding * (whole(w) + delta * slope(v));
                known + rounded + delta * (slope(w) + delta * (v[2] + w[2]))
            });
            let terms: Vec<f64> = terms.collect();
            let mut reached = inverse.sizes(&terms, e);
            let upward = |bound: &mut f64| *bound = *bound * UPWARD + f64::MIN_POSITIVE;
            reached.iter_mut().for_each(upward);
            reached
        };
        let mut all: Vec<f64> = step.iter().map(|d| size(*d)).collect();
        let mut room = reach(&all);
        for (all, room) in all.iter_mut().zip(&mut room) {
            *room = 2.0 * *room + FLOOR;
            *all = (*all + *room) * UPWARD;
        }
        let bounds = reach(&all);
        let contracts = bounds.iter().zip(&room).all(|(bound, room)| bound < room);
        let enclosure = contracts.then(|| {
            let ball = |z: Complex<f64>, d: Complex<f64>, bound: f64| {
                let [re, im] = [(z.re, d.re), (z.im, d.im)].map(|(z, d)| DoubleDouble::new(z, d));
                Ball::new(WideComplex { re, im }, Magnitude::from(bound))
            };
            let component = |i: usize| match i == held {
                true => ball(Complex::ONE, Complex::ZERO, 0.0),
                false => ball(at.shape[i], step[i], bounds[i]),
            };
            Enclosure {
                root: ball(at.root, step[held], bounds[held]),
                shape: (0..n).map(component).collect(),
            }
        });
        Some((step, enclosure))
    }

    /// Q(μ)v, each entry's real and imaginary part.
    fn residual(&self, at: &Approximate) -> Vec<[DoubleDouble; 2]> {
        let mut sums = vec![[DoubleDouble::ZERO; 2]; self.n];
        for (power, part) in self.parts.iter().enumerate().rev() {
            if power < 2 {
                for [re, im] in &mut sums {
                    let z = at.root;
                    (*re, *im) = (*re * z.re - *im * z.im, *re * z.im + *im * z.re);
                }
            }
            for entry in part {
                let ([re, im], v) = (&mut sums[entry.row], at.shape[entry.column]);
                *re += entry.value * v.re;
                *im += entry.value * v.im;
            }
        }
        sums
    }

    /// J, by rows with all real parts first.
    fn jacobian(&self, at: &Approximate, held: usize) -> Vec<f64> {
        let n = self.n;
        let mut jacobian = vec![0.0; 2 * n * n];
        let powers = [Complex::ONE, at.root, at.root * at.root];
        let slopes = [Complex::ZERO, Complex::ONE, 2.0 * at.root];
        for ((part, power), slope) in self.parts.iter().zip(powers).zip(slopes) {
            for entry in part {
                let row = &mut jacobian[entry.row * 2 * n..][..2 * n];
                let mut add = |column: usize, value: Complex<f64>| {
                    row[column] += value.re;
                    row[n + column] += value.im;
                };
                let value = entry.value.high();
                if entry.column != held {
                    add(entry.column, power * value);
                }
                add(held, slope * value * at.shape[entry.column]);
            }
        }
        jacobian
    }

    /// Σ |coefficient|·x for K, C and M, over the coefficients of each row.
    fn sizes(&self, x: impl Fn(usize) -> f64) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.n];
        for (power, part) in self.parts.iter().enumerate() {
            for entry in part {
                sums[entry.row][power] += entry.size * x(entry.column);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use eigentone_digits::Wide;
    use proptest::prelude::*;

    use super::super::pencil::Pencil;
    use super::super::{Approximation, Certified, certify};
    use super::*;
    use crate::Precision;
    use crate::structure::samples::{chain, matrices};
    use crate::system::System;

    /// The system with more damping, without symmetry.
    fn turned(system: &System, turn: f64) -> System {
        let other =
            |i: usize, j: usize| turn * (i as f64 - j as f64) + if i == j { 0.3 } else { 0.0 };
        let n = system.len();
        let damping = system.damping_matrix() + faer::Mat::from_fn(n, n, other);
        matrices(system.mass_matrix(), damping, system.stiffness_matrix())
    }

    /// The discs of all roots, by the shapes of modes in doubles where they are given.
    fn proven(system: &System, with_shapes: bool, tolerance: f64) -> Option<Vec<Certified>> {
        let modes = system.modes_to(Precision::Double).ok()?;
        let moving = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.norm() > 0.0);
        let both = moving.flat_map(|mode| {
            let value = mode.eigenvalue().value;
            let count = if value.im == 0.0 { 1 } else { 2 };
            [value, value.conj()]
                .into_iter()
                .take(count)
                .map(|value| Approximation {
                    value,
                    is_wanted: true,
                    shape: if with_shapes { mode.shape() } else { &[] },
                })
        });
        let start: Vec<Approximation<'_>> = both.collect();
        Some(certify(system, &start, tolerance, 1e9)?.0)
    }

    /// det Q has the same roots, and adjugates the same shapes.
    fn agree(system: &System) -> Result<(), TestCaseError> {
        let (Some(found), Some(known)) =
            (proven(system, true, 1e-15), proven(system, false, 1e-24))
        else {
            return Ok(());
        };
        for root in &found {
            let met = |other: &&Certified| {
                let reach = (root.bound + other.bound) * UPWARD;
                (root.value - other.value).norm() <= reach
            };
            let met: Vec<&Certified> = known.iter().filter(met).collect();
            prop_assert!(met.len() == 1, "{root:?} beside {known:?}");
            let apart = (root.value.re - met[0].value.re).abs();
            prop_assert!(apart <= (root.real_bound + met[0].real_bound) * UPWARD);
            let (Some(ours), Some(theirs)) = (&root.shapes, &met[0].shapes) else {
                continue;
            };
            let (ours, theirs) = (&ours.right, &theirs.right);
            for i in 0..ours.shape.len() {
                let reach = (ours.bounds[i] + theirs.bounds[i]) * UPWARD;
                let apart = (ours.shape[i] - theirs.shape[i]).norm();
                prop_assert!(apart <= reach, "{root:?} beside {:?}", met[0]);
            }
        }
        Ok(())
    }

    fn any_size(reach: i32) -> impl Strategy<Value = f64> {
        (0.5..2.0f64, -reach..=reach).prop_map(|(fraction, power)| fraction * 2f64.powi(power))
    }

    /// With some masses and dampers of 0.
    fn any_row(reach: i32) -> impl Strategy<Value = System> {
        let maybe = |reach| prop_oneof![1 => Just(0.0), 3 => any_size(reach)];
        (1..6usize).prop_flat_map(move |n| {
            let masses = prop::collection::vec(maybe(reach), n);
            let springs = prop::collection::vec(any_size(reach), n + 1);
            let dampers = prop::collection::vec(maybe(reach), n + 1);
            let other = prop_oneof![2 => Just(None), 1 => (-1.0..1.0f64).prop_map(Some)];
            (masses, springs, dampers, other).prop_map(|(masses, springs, dampers, other)| {
                let system = chain(&masses, &springs, &dampers);
                match other {
                    Some(turn) => turned(&system, turn),
                    None => system,
                }
            })
        })
    }

    proptest! {
        #[test]
        fn determinants_have_the_same_roots(near in any_row(3), far in any_row(30)) {
            for system in [near, far] {
                agree(&system)?;
            }
        }

        /// However far the approximations are off, what is proved holds the truth.
        #[test]
        fn bounds_hold_far_from_the_root(system in any_row(3), off in 1..70i32, turn in 0.0..6.0f64) {
            let Ok(modes) = system.modes_to(Precision::Double) else { return Ok(()) };
            let Some(known) = proven(&system, false, 1e-60) else { return Ok(()) };
            let sizes = modes.iter().map(|mode| mode.eigenvalue().value.norm());
            let largest = sizes.fold(0.0, f64::max);
            // The discs of undamped systems are those of λ².
            if largest == 0.0 || system.structure().is_undamped() { return Ok(()) }
            let unit = largest.log2().round() as i32;
            let pencil = Pencil::of(&system, false).precise::<DoubleDouble>(unit).0;
            let equations = Equations::of(&pencil).expect("doubles are known");
            let moved = |z: Complex<f64>, turn: f64| z + Complex::from_polar(2f64.powi(-off), turn);
            for mode in modes.iter() {
                let shape: Vec<Complex<f64>> = mode.shape().iter().map(|x| moved(*x, turn)).collect();
                let at = Approximate {
                    root: moved(mode.eigenvalue().value * 2f64.powi(-unit), 2.0 * turn),
                    shape: pencil.in_units(&shape).expect("as many"),
                };
                let Some(found) = equations.solve(at, |_| true) else { continue };
                let wide = |part: DoubleDouble| Wide::<4>::from(part.high()) + part.low().into();
                let centre = found.root.middle();
                let root = |turn: f64| {
                    let middle = WideComplex { re: wide(centre.re), im: wide(centre.im).mul_f64(turn) };
                    Ball::new(middle, found.root.radius())
                };
                let meets = |disc: &Certified| {
                    let disc = disc.disc.ball::<Wide<4>>();
                    (disc - root(1.0)).contains_zero() || (disc - root(-1.0)).contains_zero()
                };
                let at_rest = root(1.0).contains_zero();
                prop_assert!(at_rest || known.iter().any(meets), "{:?} of {known:?}", found.root);
            }
        }
    }

    /// λ = 0 is none of the roots that are sought, though it is one of the system.
    #[test]
    fn a_root_at_rest_stands_for_no_other() {
        let system = chain(&[2.0], &[], &[3.0]);
        let prove = |value: f64| {
            let start = Approximation {
                value: value.into(),
                is_wanted: false,
                shape: &[Complex::ONE],
            };
            certify(&system, &[start], 1e-15, 0.0)
        };
        assert!(prove(-1.5).is_some());
        assert!(prove(1e-9).is_none());
    }

    /// Two approximations of one root leave another without any.
    #[test]
    fn a_root_that_is_found_twice_proves_nothing() {
        let system = chain(&[1.0, 2.0], &[1.0, 2.0, 3.0], &[0.1, 0.0, 0.4]);
        let modes = system.modes_to(Precision::Double).expect("modes");
        let of = |i: usize| {
            let mode = &modes.as_slice()[i];
            let value = mode.eigenvalue().value;
            [value, value.conj()].map(|value| Approximation {
                value,
                is_wanted: true,
                shape: mode.shape(),
            })
        };
        let prove =
            |start: [[Approximation<'_>; 2]; 2]| certify(&system, start.as_flattened(), 1e-15, 0.0);
        assert!(prove([of(0), of(1)]).is_some());
        assert!(prove([of(0), of(0)]).is_none());
    }
}
