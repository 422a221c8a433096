//! Frequencies that show every peak.

use eigentone_digits::sort_by_number;
use eigentone_modes::{Modes, System};

/// Frequencies in rad/s, rising, that show every peak of the system's frequency responses: evenly spread on a logarithmic
/// scale from a tenth of the least to ten times the largest natural frequency, and closer around each root, from
/// its own decay rate on. Loss factors, one for each of the springs as they were given, or none, widen peaks by the share
/// that each spring has in the energy of the mode.
pub fn peak_grid(system: &System, modes: &Modes, loss_factors: &[f64]) -> Vec<f64> {
    /// Points of the even grid.
    const EVEN: usize = 400;
    /// Where there are more modes than this, each has fewer points of its own.
    const MANY: usize = 50;
    /// The narrowest peak that is drawn, relative to its frequency.
    const NARROW: f64 = 1e-5;
    let roots = modes.eigenvalues().iter().map(|root| root.value);
    let sizes = roots.map(|value| value.norm()).filter(|size| *size > 0.0);
    let sizes: Vec<f64> = sizes.filter(|size| size.is_finite()).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let (low, high) = match least <= largest {
        true => (least / 10.0, largest * 10.0),
        // Nothing but rigid motions.
        false => (0.01, 100.0),
    };
    let span = (high / low).ln();
    let even = |k: usize| low * (span * k as f64 / (EVEN - 1) as f64).exp();
    let mut grid: Vec<f64> = (0..EVEN).map(even).collect();
    let spacing = span / EVEN as f64;
    let springs = system.elements(eigentone_modes::ElementKind::Spring);
    let factor = if modes.iter().count() > MANY {
        8.0
    } else {
        3.0
    };
    for mode in modes {
        let root = mode.eigenvalue().value;
        let center = root.im.abs();
        if center == 0.0 || !center.is_finite() {
            continue;
        }
        grid.push(center);
        let energy = |weigh: &dyn Fn(usize) -> f64| -> f64 {
            let each = springs.iter().enumerate().map(|(i, spring)| {
                let stretch = spring.stretch.coordinates.iter();
                let stretch = stretch.map(|&(k, a)| mode.shape()[k] * a);
                let stretch: num_complex::Complex<f64> = stretch.sum();
                weigh(i) * spring.coefficient.abs() * stretch.norm_sqr()
            });
            each.sum()
        };
        let lost = match loss_factors.is_empty() {
            true => 0.0,
            false => {
                let lost = energy(&|i| loss_factors.get(i).copied().unwrap_or(0.0));
                lost / energy(&|_| 1.0) / 2.0
            }
        };
        let width = root.re.abs() / center + if lost.is_finite() { lost } else { 0.0 };
        let mut offset = width.max(NARROW) / 4.0;
        while offset < spacing {
            grid.push(center * (1.0 - offset));
            grid.push(center * (1.0 + offset));
            offset *= factor;
        }
    }
    grid.retain(|frequency| frequency.is_finite() && *frequency > 0.0);
    sort_by_number(&mut grid, |omega| *omega);
    grid.dedup();
    grid
}
