//! How alike shapes are, and how near a shape is to a real one.

use faer::Mat;
use num_complex::Complex;
use thiserror::Error;

/// The modal assurance criterion |x*y|² / ((x*x)(y*y)) of every shape x in `first` (rows) with every
/// shape y in `second` (columns): 1 if one is a multiple of the other, 0 if they are orthogonal
/// (Allemang & Brown 1982, *Proc. 1st IMAC*, 110–116). Shapes of one system are orthogonal with M
/// between them, so those of distinct modes give 0 only where all masses are alike.
///
/// # Errors
/// [`AssuranceError`] where shapes differ in length, vanish or are not finite.
///
/// ```
/// use eigentone_modes::{GROUND, Mode, System, modal_assurance};
///
/// let chain = System::builder().mass("a", 1.0).mass("b", 1.0);
/// let system = chain.spring(GROUND, "a", 1.0).spring("a", "b", 2.0).build()?;
/// let modes = system.modes()?;
/// let shapes: Vec<_> = modes.iter().map(Mode::shape).collect();
/// let assurance = modal_assurance(&shapes, &shapes)?;
/// assert!((assurance[(0, 0)] - 1.0).abs() < 1e-15);
/// assert!(assurance[(0, 1)] < 1e-30);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn modal_assurance(
    first: &[&[Complex<f64>]],
    second: &[&[Complex<f64>]],
) -> Result<Mat<f64>, AssuranceError> {
    let expected = first.iter().chain(second).next().map_or(0, |x| x.len());
    let unit = |shapes: &[&[Complex<f64>]]| -> Result<Vec<Vec<Complex<f64>>>, AssuranceError> {
        let shapes = shapes.iter().enumerate();
        shapes
            .map(|(shape, x)| {
                if x.len() != expected {
                    let found = x.len();
                    return Err(AssuranceError::Length {
                        shape,
                        expected,
                        found,
                    });
                }
                unit(x).ok_or(AssuranceError::NoDirection { shape })
            })
            .collect()
    };
    let (first, second) = (unit(first)?, unit(second)?);
    Ok(Mat::from_fn(first.len(), second.len(), |i, j| {
        let product: Complex<f64> = first[i]
            .iter()
            .zip(&second[j])
            .map(|(x, y)| x.conj() * y)
            .sum();
        product.norm_sqr()
    }))
}

/// The modal phase collinearity ((s₁ − s₂)/(s₁ + s₂))², s₁ and s₂ the eigenvalues of the scatter
/// matrix [a·a a·b; a·b b·b] of a = Re x and b = Im x, their means not removed (Pappa, Elliott &
/// Schenk 1993, *J. Guid. Control Dyn.* 16): 1 if all components move in phase or opposition, 0 for
/// a wave that travels evenly. A factor on the shape does not change it, for it is
/// |xᵀx|²/(x*x)², the assurance of the shape with its conjugate (Vacher, Jacquier & Bucharles 2010,
/// *Proc. ISMA*).
///
/// # Errors
/// [`AssuranceError::NoDirection`] where the shape is empty, vanishes or is not finite.
pub fn phase_collinearity(shape: &[Complex<f64>]) -> Result<f64, AssuranceError> {
    let unit = unit(shape).ok_or(AssuranceError::NoDirection { shape: 0 })?;
    let product: Complex<f64> = unit.iter().map(|x| x * x).sum();
    Ok(product.norm_sqr())
}

/// x/‖x‖, or `None` for a shape that has no such multiple.
fn unit(x: &[Complex<f64>]) -> Option<Vec<Complex<f64>>> {
    // Dividing by the largest part first keeps squares within range.
    let largest = x
        .iter()
        .flat_map(|entry| [entry.re, entry.im])
        .map(f64::abs)
        .fold(0.0, f64::max);
    let finite = x.iter().all(|entry| entry.is_finite());
    if largest == 0.0 || !finite {
        return None;
    }
    let scaled: Vec<Complex<f64>> = x.iter().map(|entry| entry / largest).collect();
    let norm = scaled
        .iter()
        .map(|entry| entry.norm_sqr())
        .sum::<f64>()
        .sqrt();
    Some(scaled.into_iter().map(|entry| entry / norm).collect())
}

/// Why shapes cannot be compared.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssuranceError {
    /// A shape has another number of components than the first.
    #[error("shape {shape} has {found} components, the first one has {expected}")]
    Length {
        /// Which shape of its set, counted from 0.
        shape: usize,
        /// The components of the first shape.
        expected: usize,
        /// Its own.
        found: usize,
    },
    /// A shape is empty, zero or not finite.
    #[error("shape {shape} is zero or not finite: it has no direction")]
    NoDirection {
        /// Which shape of its set, counted from 0.
        shape: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, turns: f64) -> Vec<Complex<f64>> {
        let step = std::f64::consts::TAU * turns / n as f64;
        (0..n).map(|j| Complex::cis(step * j as f64)).collect()
    }

    #[test]
    fn harmonics_on_a_circle_are_orthogonal() {
        let waves: Vec<_> = (1..4).map(|turns| wave(7, turns.into())).collect();
        let waves: Vec<_> = waves.iter().map(Vec::as_slice).collect();
        let assurance = modal_assurance(&waves, &waves[1..]).unwrap();
        assert_eq!((assurance.nrows(), assurance.ncols()), (3, 2));
        for i in 0..3 {
            for j in 0..2 {
                let expected = f64::from(i == j + 1);
                assert!((assurance[(i, j)] - expected).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_factor_changes_nothing_however_large() {
        let x = [(1.0, 0.5), (-0.25, 2.0), (0.0, -1.0)].map(|(re, im)| Complex::new(re, im));
        let y = [(0.5, 0.0), (1.0, 1.0), (3.0, -2.0)].map(|(re, im)| Complex::new(re, im));
        let factor = Complex::new(3e200, -4e200);
        let scaled = x.map(|entry| entry * factor);
        let assurance = modal_assurance(&[&x, &scaled], &[&y, &x]).unwrap();
        for j in 0..2 {
            assert!((assurance[(0, j)] - assurance[(1, j)]).abs() < 1e-15);
        }
        // x*y = (0.5 − 0.25i) + (1.75 − 2.25i) + (2 + 3i), x*x = 1.25 + 4.0625 + 1, y*y = 0.25 + 2 + 13.
        let expected = (4.25f64.powi(2) + 0.5f64.powi(2)) / (6.3125 * 15.25);
        assert!((assurance[(0, 0)] - expected).abs() < 1e-15);
        let collinear = [x.as_slice(), &scaled].map(|x| phase_collinearity(x).unwrap());
        assert!((collinear[0] - collinear[1]).abs() < 1e-15);
    }

    #[test]
    fn collinearity_distinguishes_standing_from_travelling() {
        assert!(phase_collinearity(&wave(9, 1.0)).unwrap() < 1e-30);
        let standing: Vec<_> = wave(9, 1.0)
            .iter()
            .map(|x| x.im * Complex::new(0.6, -0.8))
            .collect();
        assert!((phase_collinearity(&standing).unwrap() - 1.0).abs() < 1e-15);
        // Scatter matrix diag(1, r²) for components 1 and ir.
        let r: f64 = 0.5;
        let between = [Complex::ONE, Complex::new(0.0, r)];
        let expected = ((1.0 - r * r) / (1.0 + r * r)).powi(2);
        assert!((phase_collinearity(&between).unwrap() - expected).abs() < 1e-15);
    }

    #[test]
    fn what_has_no_direction_is_refused() {
        let (zero, one) = ([Complex::ZERO; 2], [Complex::ONE; 2]);
        let refused = AssuranceError::NoDirection { shape: 1 };
        assert_eq!(modal_assurance(&[&one, &zero], &[&one]), Err(refused));
        let nan = [Complex::from(f64::NAN)];
        for shape in [&zero[..], &[], &nan] {
            assert!(phase_collinearity(shape).is_err());
        }
        let refused = AssuranceError::Length {
            shape: 0,
            expected: 2,
            found: 1,
        };
        assert_eq!(modal_assurance(&[&one], &[&one[..1]]), Err(refused));
    }
}
