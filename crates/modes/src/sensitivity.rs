//! How a root and its shape change with each mass, spring, damper and matrix entry. It knows `model`, `modes`, `quality` and
//! `system`.

use eigentone_digits::ComplexDoubleDouble;
use num_complex::Complex;
use thiserror::Error;

use crate::model::MatrixKind;
use crate::modes::Mode;
use crate::quality::bordered::{Resolved, conjugate};
use crate::system::System;
use crate::system::{Parameter, Place};

/// The derivatives of one mode with respect to every [`Parameter`] of its system.
///
/// With Q(λ) = λ²M + λC + K, the root λ, its shape x and left shape y, a parameter p changes
///
/// - the root by ∂λ/∂p = −y*(∂Q/∂p)x / (y*Q′(λ)x), a single term for each element: that of a spring
///   between a and b is −(ȳ_a − ȳ_b)(x_a − x_b) / (y*Q′(λ)x) (Lancaster 1964, *Numer. Math.* 6);
/// - the shape, whose largest component is held at 1, by the solution of
///   [Q(λ) Q′(λ)x; eᵀ 0] (∂x/∂p, ∂λ/∂p) = (−(∂Q/∂p)x, 0) (Nelson 1976, *AIAA J.* 14, with one matrix
///   for all parameters).
///
/// λ, x and y are first improved to double-doubles from the elements, which makes the derivatives
/// right to about the last digit even of terms that the elements cancel to far below rounding,
/// except where they cancel so far that 106 bits leave fewer digits than a double has: dampers of
/// 6.65e10 beside springs of 2 left a relative error of 1.8e-12. The
/// cost is that of two LU factorisations of order n + 1 in double-double, much less for systems
/// with few springs and dampers per mass.
///
/// ```
/// use eigentone_modes::{GROUND, Parameter, Sensitivity, System};
///
/// let system = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0).build()?;
/// let modes = system.modes()?;
/// let sensitivity = Sensitivity::of(&system, &modes.as_slice()[0])?;
/// let slope = sensitivity.to(Parameter::Spring(0))?.natural_frequency();
/// assert_eq!(slope, Some(2.0 / (2.0 * 8.0))); // ω/2k
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sensitivity<'a> {
    system: &'a System,
    root: Resolved,
    left: Vec<ComplexDoubleDouble>,
    /// y*Q′(λ)x.
    slope: ComplexDoubleDouble,
}

impl<'a> Sensitivity<'a> {
    /// Prepares the derivatives of a mode of `system`.
    ///
    /// # Errors
    /// [`SensitivityError`] where the root is defective or repeated, since it is then not
    /// differentiable in every parameter, and where it is not resolved.
    pub fn of(system: &'a System, mode: &Mode) -> Result<Sensitivity<'a>, SensitivityError> {
        let (expected, found) = (system.len(), mode.shape().len());
        if expected != found {
            return Err(SensitivityError::ForeignMode { expected, found });
        }
        let value = mode.eigenvalue().value;
        let unresolved = SensitivityError::Unresolved { root: value };
        match mode.multiplicity() {
            Some(1) => {}
            Some(multiplicity) if mode.is_defective() == Some(true) => {
                return Err(SensitivityError::Defective { multiplicity });
            }
            Some(multiplicity) => return Err(SensitivityError::Repeated { multiplicity }),
            None if mode.cluster() == Some(1) => {}
            None => return Err(unresolved),
        }
        let root = Resolved::of(system, value, mode.shape()).ok_or(unresolved.clone())?;
        let left = if system.structure().is_symmetric() {
            root.x.iter().map(|entry| conjugate(*entry)).collect()
        } else {
            root.left()
        };
        let slope = left
            .iter()
            .zip(&root.slope)
            .fold(ComplexDoubleDouble::ZERO, |sum, (y, slope)| {
                sum + conjugate(*y) * *slope
            });
        if !(slope.norm() > 0.0 && slope.norm().is_finite()) {
            return Err(unresolved);
        }
        Ok(Sensitivity {
            system,
            root,
            left,
            slope,
        })
    }

    /// The derivatives with respect to one parameter.
    ///
    /// # Errors
    /// [`SensitivityError::NoSuchParameter`].
    pub fn to(&self, parameter: Parameter) -> Result<Derivative<'_>, SensitivityError> {
        let place = parameter
            .place(self.system)
            .ok_or(SensitivityError::NoSuchParameter { parameter })?;
        let force = self.force(&place);
        let eigenvalue = -(conjugate(along(&self.left, &place.left)) * force) / self.slope;
        Ok(Derivative {
            sensitivity: self,
            place,
            eigenvalue,
        })
    }

    /// How the root changes, in 1/s, on the way to another system with as many coordinates: the derivative at t = 0 where
    /// M, C and K go straight there from t = 0 to 1, −y*Q₁(λ)x / (y*Q′(λ)x) with the other's Q₁. It is linear in the matrices of
    /// the other, so that its derivative by any number that they depend on is that of the root.
    ///
    /// # Errors
    /// [`SensitivityError::ForeignMode`] for another number of coordinates.
    pub fn toward(&self, other: &System) -> Result<Complex<f64>, SensitivityError> {
        let (expected, found) = (self.system.len(), other.len());
        if expected != found {
            return Err(SensitivityError::ForeignMode { expected, found });
        }
        let (mut sum, mut power) = (
            ComplexDoubleDouble::ZERO,
            ComplexDoubleDouble::new(1.0, 0.0),
        );
        for kind in [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass] {
            let mut part = ComplexDoubleDouble::ZERO;
            for term in other.terms(kind) {
                part += conjugate(self.left[term.row]) * self.root.x[term.column] * term.value;
            }
            sum += part * power;
            power = power * self.root.lambda;
        }
        Ok(rounded(-sum / self.slope))
    }

    /// λ^power·rᵀx: what the parameter multiplies.
    fn force(&self, place: &Place) -> ComplexDoubleDouble {
        (0..place.power).fold(along(&self.root.x, &place.right), |force, _| {
            force * self.root.lambda
        })
    }
}

/// The derivatives of one mode with respect to one parameter p.
#[derive(Clone, Debug)]
pub struct Derivative<'a> {
    sensitivity: &'a Sensitivity<'a>,
    place: Place,
    eigenvalue: ComplexDoubleDouble,
}

impl Derivative<'_> {
    /// ∂λ/∂p, in 1/s per unit of p.
    pub fn eigenvalue(&self) -> Complex<f64> {
        rounded(self.eigenvalue)
    }

    /// ∂ω_n/∂p for ω_n = |λ|, in rad/s per unit of p; `None` at λ = 0, where |λ| has a corner.
    pub fn natural_frequency(&self) -> Option<f64> {
        let (lambda, change) = (self.sensitivity.root.lambda, self.eigenvalue);
        let along = lambda.re * change.re + lambda.im * change.im;
        (lambda.norm() != 0.0).then(|| along.to_f64() / lambda.norm() + 0.0)
    }

    /// ∂ζ/∂p for ζ = −Re λ/|λ|, per unit of p; `None` for real roots, which have no ζ.
    pub fn damping_ratio(&self) -> Option<f64> {
        let (lambda, change) = (self.sensitivity.root.lambda, self.eigenvalue);
        let size = lambda.norm();
        let turn = lambda.re * change.im - lambda.im * change.re;
        let im = lambda.im.to_f64();
        (im != 0.0).then(|| turn.to_f64() / size / size * (im / size) + 0.0)
    }

    /// ∂x/∂p for the shape x of [`Mode::shape`], whose largest component stays 1: n entries per
    /// unit of p. It costs one solution with the factorised matrix.
    pub fn shape(&self) -> Vec<Complex<f64>> {
        let force = self.sensitivity.force(&self.place);
        let mut right = vec![ComplexDoubleDouble::ZERO; self.sensitivity.system.len()];
        for (i, times) in &self.place.left {
            right[*i] += force * -times;
        }
        let (shape, _) = self.sensitivity.root.solve(&right);
        shape.into_iter().map(rounded).collect()
    }
}

/// A linear form of a shape.
fn along(x: &[ComplexDoubleDouble], form: &[(usize, f64)]) -> ComplexDoubleDouble {
    form.iter()
        .fold(ComplexDoubleDouble::ZERO, |sum, (i, times)| {
            sum + x[*i] * *times
        })
}

fn rounded(z: ComplexDoubleDouble) -> Complex<f64> {
    Complex::new(z.re.to_f64() + 0.0, z.im.to_f64() + 0.0)
}

/// Why a mode has no derivatives.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SensitivityError {
    /// The root is defective: it moves like a root of the parameter's change, with infinite slope.
    #[error(
        "the root is defective, of multiplicity {multiplicity}: no derivative exists; ask for a simple root"
    )]
    Defective {
        /// How many roots coincide.
        multiplicity: usize,
    },
    /// Several modes share the root: a change splits it, and their shapes jump.
    #[error(
        "{multiplicity} modes share this root, which a change splits: no derivative exists; ask for a simple root"
    )]
    Repeated {
        /// How many roots coincide.
        multiplicity: usize,
    },
    /// The bordered system is singular to the 106 bits it is solved with, or the mode does not
    /// solve it.
    #[error(
        "the mode at {root} is not resolved: another root is too near, the parameters are too far apart for 106 bits, or the mode is of another system"
    )]
    Unresolved {
        /// λ.
        root: Complex<f64>,
    },
    /// The mode is of a system of another size.
    #[error("the shape has length {found}: it must be {expected}, the number of coordinates")]
    ForeignMode {
        /// The system's coordinates.
        expected: usize,
        /// The shape's components.
        found: usize,
    },
    /// The system does not have the parameter asked for.
    #[error("the system has no {parameter}")]
    NoSuchParameter {
        /// What was asked for.
        parameter: Parameter,
    },
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::modes::Repeats;
    use crate::structure::samples::{chain, network, with_matrices};

    fn close(a: Complex<f64>, b: Complex<f64>, tolerance: f64) -> bool {
        (a - b).norm() <= tolerance
    }

    fn one_mass(m: f64, c: f64, k: f64) -> System {
        chain(&[m], &[k], &[c])
    }

    /// Three masses and a massless node, damped without pattern.
    fn damped() -> System {
        let springs = [
            (0, 1, 3.0),
            (1, 2, 40.0),
            (2, 3, 5.0),
            (3, 4, 7.0),
            (4, 0, 2.0),
        ];
        let dampers = [(0, 1, 0.3), (2, 3, 1.1), (4, 1, 0.8)];
        network(&[2.0, 1.0, 0.5, 0.0], &springs, &dampers)
    }

    /// The same with a circulatory K, a full M and an asymmetric C added.
    fn nonsymmetric() -> System {
        let entry = |i: usize, j: usize| (1.0 + (7 * i + 3 * j) as f64).sin();
        let mass = Mat::from_fn(3, 3, |i, j| if i == j { 3.0 } else { 0.3 * entry(i, j) });
        let damping = Mat::from_fn(3, 3, |i, j| 0.2 * entry(j, i));
        let stiffness = Mat::from_fn(3, 3, |i, j| 2.0 * entry(i, 2 * j));
        let springs = [(0, 1, 11.0), (1, 2, 5.0), (2, 3, 8.0)];
        let added = [Some(mass), Some(damping), Some(stiffness)];
        with_matrices(&[1.0, 0.0, 2.0], &springs, &[(3, 0, 0.7)], added)
    }

    /// The system with one parameter changed.
    fn changed(system: &System, parameter: Parameter, by: f64) -> System {
        let mut masses = system.masses().to_vec();
        let mut springs = system.springs().to_vec();
        let mut dampers = system.dampers().to_vec();
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let mut added = kinds.map(|kind| system.added(kind).map(|matrix| matrix.to_owned()));
        match parameter {
            Parameter::Mass(i) => masses[i] += by,
            Parameter::Spring(i) => springs[i].coefficient += by,
            Parameter::Damper(i) => dampers[i].coefficient += by,
            Parameter::PointMass(_) => unreachable!("there are no points"),
            Parameter::Entry { kind, row, column } => {
                let matrix = added[kind as usize].as_mut().unwrap();
                matrix[(row, column)] += by;
            }
        }
        System::assemble(system.names().to_vec(), masses, springs, dampers, added)
    }

    #[test]
    fn one_mass_follows_its_formulas() {
        let (m, c, k) = (2.0, 0.4, 8.0);
        let system = one_mass(m, c, k);
        let modes = system.modes().unwrap();
        let sensitivity = Sensitivity::of(&system, &modes.as_slice()[0]).unwrap();
        let omega = f64::sqrt(k / m);
        let zeta = c / (2.0 * m * omega);
        let expected = [
            (Parameter::Mass(0), -omega / (2.0 * m), -zeta / (2.0 * m)),
            (Parameter::Spring(0), omega / (2.0 * k), -zeta / (2.0 * k)),
            (Parameter::Damper(0), 0.0, zeta / c),
        ];
        for (parameter, frequency, ratio) in expected {
            let derivative = sensitivity.to(parameter).unwrap();
            assert!((derivative.natural_frequency().unwrap() - frequency).abs() < 1e-16);
            assert!((derivative.damping_ratio().unwrap() - ratio).abs() < 1e-16);
            assert_eq!(derivative.shape(), [Complex::ZERO]);
        }
    }

    #[test]
    fn a_soft_spring_beside_one_of_1e16_keeps_all_digits() {
        // With ε = k1/k2: ω₋² = k1/2 − k1ε/8 + …, ω₊² = 2k2 + k1/2 + k1ε/8 + …
        let (k1, k2) = (1.0, 1e16);
        let system = chain(&[1.0; 2], &[k1, k2], &[]);
        let modes = system.modes().unwrap();
        let ratio: f64 = k1 / k2;
        let expected = [[0.5, ratio / 8.0], [ratio / 8.0, 0.5]];
        for (mode, expected) in modes.iter().zip(expected) {
            let sensitivity = Sensitivity::of(&system, mode).unwrap();
            let omega = mode.natural_frequency().radians_per_second();
            let relative: Vec<f64> = [k1, k2]
                .iter()
                .enumerate()
                .map(|(i, k)| {
                    let derivative = sensitivity.to(Parameter::Spring(i)).unwrap();
                    assert_eq!(derivative.damping_ratio(), Some(0.0));
                    derivative.natural_frequency().unwrap() * k / omega
                })
                .collect();
            for (found, expected) in relative.iter().zip(expected) {
                let off = (found - expected).abs();
                assert!(off < 1e-15 * expected, "{found:e} {expected:e}");
            }
            assert!((relative.iter().sum::<f64>() - 0.5).abs() < 1e-15);
        }
    }

    #[test]
    fn springs_share_half_of_each_frequency() {
        let n = 30;
        let masses: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64).cos().abs()).collect();
        let springs = (0..n).map(|i| 10f64.powi((i as i32 * 7) % 13));
        let system = chain(&masses, &springs.collect::<Vec<_>>(), &[]);
        for mode in &system.modes().unwrap() {
            let sensitivity = Sensitivity::of(&system, mode).unwrap();
            let omega = mode.natural_frequency().radians_per_second();
            let share = |parameter: Parameter| {
                let slope = sensitivity
                    .to(parameter)
                    .unwrap()
                    .natural_frequency()
                    .unwrap();
                slope * parameter.value(&system).unwrap() / omega
            };
            let springs: Vec<f64> = (0..n).map(|i| share(Parameter::Spring(i))).collect();
            let masses: Vec<f64> = (0..n).map(|i| share(Parameter::Mass(i))).collect();
            assert!(springs.iter().all(|share| *share >= 0.0));
            assert!(masses.iter().all(|share| *share <= 0.0));
            assert!((springs.iter().sum::<f64>() - 0.5).abs() < 1e-14);
            assert!((masses.iter().sum::<f64>() + 0.5).abs() < 1e-14);
        }
    }

    #[test]
    fn a_common_factor_and_the_unit_of_time_change_what_they_must() {
        for system in [damped(), nonsymmetric()] {
            for mode in &system.modes().unwrap() {
                let sensitivity = Sensitivity::of(&system, mode).unwrap();
                let lambda = mode.eigenvalue().value;
                let (mut common, mut time) = (Complex::ZERO, Complex::ZERO);
                let mut shapes = vec![[Complex::ZERO; 2]; system.len()];
                let (mut size, mut shape_size) = (0.0, 0.0);
                for parameter in Parameter::all(&system) {
                    let value = parameter.value(&system).unwrap();
                    // K ~ 1/time², C ~ 1/time, M ~ 1.
                    let power = match parameter {
                        Parameter::Mass(_)
                        | Parameter::Entry {
                            kind: MatrixKind::Mass,
                            ..
                        } => 0.0,
                        Parameter::Damper(_)
                        | Parameter::Entry {
                            kind: MatrixKind::Damping,
                            ..
                        } => 1.0,
                        _ => 2.0,
                    };
                    let derivative = sensitivity.to(parameter).unwrap();
                    let term = derivative.eigenvalue() * value;
                    size += term.norm();
                    common += term;
                    time += term * power;
                    for (sum, change) in shapes.iter_mut().zip(derivative.shape()) {
                        shape_size += change.norm() * value.abs();
                        sum[0] += change * value;
                        sum[1] += change * value * power;
                    }
                }
                assert!(close(common, Complex::ZERO, 1e-15 * size));
                assert!(close(time, lambda, 2e-15 * size));
                for sum in shapes.iter().flatten() {
                    assert!(close(*sum, Complex::ZERO, 2e-15 * shape_size));
                }
            }
        }
    }

    #[test]
    fn differences_agree() {
        // Central differences of step h lose h² and 2^-53/h.
        const STEP: f64 = 1e-5;
        for system in [damped(), nonsymmetric()] {
            let modes = system.modes().unwrap();
            for (index, mode) in modes.iter().enumerate() {
                let sensitivity = Sensitivity::of(&system, mode).unwrap();
                for parameter in Parameter::all(&system) {
                    let derivative = sensitivity.to(parameter).unwrap();
                    if parameter.value(&system) == Some(0.0) && system.len() == 4 {
                        continue; // a massless node that gets mass gets modes too
                    }
                    let [above, below] = [STEP, -STEP].map(|by| {
                        let system = changed(&system, parameter, by);
                        system.modes().unwrap().as_slice()[index].clone()
                    });
                    let slope = |pick: &dyn Fn(&Mode) -> Complex<f64>| {
                        (pick(&above) - pick(&below)) / (2.0 * STEP)
                    };
                    let found = derivative.eigenvalue();
                    assert!(
                        close(found, slope(&|m| m.eigenvalue().value), 1e-8),
                        "{parameter}"
                    );
                    let found = derivative.natural_frequency().unwrap();
                    let frequency = |m: &Mode| m.natural_frequency().radians_per_second().into();
                    assert!(close(found.into(), slope(&frequency), 1e-8), "{parameter}");
                    if let Some(found) = derivative.damping_ratio() {
                        let ratio = |m: &Mode| m.damping_ratio().unwrap().into();
                        assert!(close(found.into(), slope(&ratio), 1e-8), "{parameter}");
                    }
                    for (i, found) in derivative.shape().into_iter().enumerate() {
                        assert!(close(found, slope(&|m| m.shape()[i]), 1e-8), "{parameter}");
                    }
                }
            }
        }
    }

    #[test]
    fn left_shapes_are_left_shapes() {
        for system in [damped(), nonsymmetric()] {
            let (m, c, k) = (
                system.mass_matrix(),
                system.damping_matrix(),
                system.stiffness_matrix(),
            );
            for mode in &system.modes().unwrap() {
                let lambda = mode.eigenvalue().value;
                let y = mode.left_shape().unwrap();
                let largest = y.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
                assert!(y.contains(&Complex::ONE) && largest < 1.0 + 1e-12);
                for j in 0..system.len() {
                    let terms = (0..system.len()).map(|i| {
                        let entry = (lambda * m[(i, j)] + c[(i, j)]) * lambda + k[(i, j)];
                        y[i].conj() * entry
                    });
                    let size = lambda.norm_sqr() * 10.0 + 100.0;
                    assert!(close(terms.sum(), Complex::ZERO, 1e-14 * size));
                }
            }
        }
    }

    #[test]
    fn near_roots_turn_their_shapes_fast() {
        // Two equal oscillators, coupled by κ: with x_a = 1, ∂x_b/∂k_a = 1/2κ in phase and out of it.
        let coupling = 1e-10;
        let springs = [(0, 1, 1.0), (0, 2, 1.0), (1, 2, coupling)];
        let system = network(&[1.0; 2], &springs, &[]);
        for mode in &system.modes().unwrap() {
            let sensitivity = Sensitivity::of(&system, mode).unwrap();
            let derivative = sensitivity.to(Parameter::Spring(0)).unwrap();
            let turn = derivative.shape()[1].re;
            assert!((turn * 2.0 * coupling - 1.0).abs() < 1e-14);
            let frequency = derivative.natural_frequency().unwrap();
            let omega = mode.natural_frequency().radians_per_second();
            assert!((frequency - 0.25 / omega).abs() < 1e-15);
        }
    }

    #[test]
    fn a_simple_root_at_zero_relaxes_under_a_first_spring() {
        // λ = 0 of m x″ + c x′ becomes −k/c; there is no spring yet.
        let system = chain(&[3.0], &[], &[4.0]);
        let modes = system.modes().unwrap();
        let sensitivity = Sensitivity::of(&system, &modes.as_slice()[0]).unwrap();
        let kind = MatrixKind::Stiffness;
        let stiffness = Parameter::Entry {
            kind,
            row: 0,
            column: 0,
        };
        let derivative = sensitivity.to(stiffness).unwrap();
        assert_eq!(derivative.eigenvalue(), Complex::from(-0.25));
        assert_eq!(derivative.natural_frequency(), None);
        assert_eq!(derivative.damping_ratio(), None);
        for parameter in [Parameter::Mass(0), Parameter::Damper(0)] {
            let derivative = sensitivity.to(parameter).unwrap();
            assert_eq!(derivative.eigenvalue(), Complex::ZERO);
        }
    }

    #[test]
    fn roots_without_derivatives_are_refused() {
        let critical = one_mass(1.0, 2.0, 1.0);
        let mode = critical.modes().unwrap().as_slice()[0].clone();
        let error = Sensitivity::of(&critical, &mode).err();
        assert_eq!(error, Some(SensitivityError::Defective { multiplicity: 2 }));

        let twins = network(&[1.0; 2], &[(0, 1, 1.0), (0, 2, 1.0)], &[]);
        let mode = twins.modes().unwrap().as_slice()[1].clone();
        let error = Sensitivity::of(&twins, &mode).err();
        assert_eq!(error, Some(SensitivityError::Repeated { multiplicity: 2 }));
        let foreign = Sensitivity::of(&critical, &mode).err();
        let (expected, found) = (1, 2);
        assert_eq!(
            foreign,
            Some(SensitivityError::ForeignMode { expected, found })
        );
    }

    #[test]
    fn double_roots_are_reported_without_being_counted() {
        // A ring has its frequencies in pairs, and so do decoupled oscillators of one k/m. Rounding
        // may part such roots by a digit; then each is listed as simple.
        let ring = |n: usize| {
            let held = (1..=n).map(|i| (0, i, 0.3));
            let joined = (1..=n).map(|i| (i, i % n + 1, 1.1));
            network(&vec![0.7; n], &held.chain(joined).collect::<Vec<_>>(), &[])
        };
        let apart = network(&[3.0, 21.0], &[(0, 1, 11.0), (0, 2, 77.0)], &[]);
        for (system, simple) in [(ring(3), 1), (ring(5), 1), (ring(8), 2), (apart, 0)] {
            let mut count = 0;
            for mode in &system.modes().unwrap() {
                let expected = mode.multiplicity() == Some(1);
                let mut mode = mode.clone();
                mode.repeats = Repeats::SIMPLE;
                mode.eigenvalue.value.im *= 1.0 + f64::EPSILON;
                let root = mode.eigenvalue.value;
                match Sensitivity::of(&system, &mode) {
                    Ok(_) => count += 1,
                    Err(error) => assert_eq!(error, SensitivityError::Unresolved { root }),
                }
                assert_eq!(Sensitivity::of(&system, &mode).is_ok(), expected);
            }
            assert_eq!(count, simple);
        }
    }

    #[test]
    fn the_way_to_another_system_is_that_of_its_parameters() {
        for system in [damped(), nonsymmetric()] {
            for mode in &system.modes().unwrap() {
                let sensitivity = Sensitivity::of(&system, mode).unwrap();
                let size = mode.eigenvalue().value.norm();
                let stay = sensitivity.toward(&system).unwrap();
                assert!(stay.norm() < 1e-25 * size, "{stay}");
                let mut together = system.clone();
                let mut sum = Complex::ZERO;
                for (parameter, by) in [
                    (Parameter::Mass(0), 0.5),
                    (Parameter::Spring(1), -2.0),
                    (Parameter::Damper(0), 0.125),
                ] {
                    together = changed(&together, parameter, by);
                    sum += sensitivity.to(parameter).unwrap().eigenvalue() * by;
                }
                let found = sensitivity.toward(&together).unwrap();
                assert!(close(found, sum, 1e-14 * size), "{found} {sum}");
            }
            let mode = one_mass(1.0, 0.1, 1.0).modes().unwrap().as_slice()[0].clone();
            let one = one_mass(1.0, 0.1, 1.0);
            let sensitivity = Sensitivity::of(&one, &mode).unwrap();
            let foreign = sensitivity.toward(&system).unwrap_err();
            let found = system.len();
            assert_eq!(
                foreign,
                SensitivityError::ForeignMode { expected: 1, found }
            );
        }
    }

    #[test]
    fn a_mode_of_another_system_is_refused() {
        let mode = one_mass(1.0, 0.1, 1.0).modes().unwrap().as_slice()[0].clone();
        let other = one_mass(1.0, 0.1, 2.0);
        let error = Sensitivity::of(&other, &mode).err();
        let root = mode.eigenvalue().value;
        assert_eq!(error, Some(SensitivityError::Unresolved { root }));
    }

    #[test]
    fn unknown_parameters_are_refused() {
        let system = one_mass(1.0, 0.1, 1.0);
        let modes = system.modes().unwrap();
        let sensitivity = Sensitivity::of(&system, &modes.as_slice()[0]).unwrap();
        let entry = |row, column| Parameter::Entry {
            kind: MatrixKind::Mass,
            row,
            column,
        };
        let unknown = [
            Parameter::Mass(1),
            Parameter::Spring(1),
            Parameter::Damper(1),
            entry(1, 0),
            entry(0, 1),
        ];
        for parameter in unknown {
            assert_eq!(parameter.value(&system), None);
            let error = sensitivity.to(parameter).err();
            assert_eq!(error, Some(SensitivityError::NoSuchParameter { parameter }));
        }
        assert!(sensitivity.to(entry(0, 0)).is_ok());
    }
}
