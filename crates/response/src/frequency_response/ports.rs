//! What acts and what is read off, by coordinate, and as sums by powers of s.

use faer::{Mat, MatRef};
use num_complex::Complex;

use super::dynamic_stiffness::Part;
use super::phasor::Phase;

/// What acts on a coordinate: a part of the right-hand side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    /// Its index in the system.
    pub(super) coordinate: usize,
    pub(super) part: Part,
    pub(super) phase: Phase,
}

/// A sum of amplitudes that is asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Reading {
    /// Indices of coordinates, and what their amplitudes are multiplied by; those that nothing reaches stand still.
    pub(super) of: Vec<(usize, Part)>,
    /// What is added to it.
    pub(super) more: Vec<Part>,
}

/// Coordinates, and what they are multiplied by.
type Factors = Vec<(usize, Part)>;

/// What acts and what is read off, as sums by powers of s = iΩ; losses of springs make some of their factors imaginary.
pub(super) struct Ports {
    /// By power of s, what acts on the coordinates.
    pub(super) acts: Vec<(i32, Factors)>,
    /// Of each sum of coordinates which output it belongs to, by which power of s, and its coordinates with factors.
    pub(super) sums: Vec<(usize, i32, Factors)>,
    /// What is added to the outputs: which, and the coefficient.
    pub(super) direct: Vec<(usize, Part)>,
    /// How many outputs there are.
    pub(super) count: usize,
}

/// Sums of factors by coordinate, n of them.
pub(super) fn dense(n: usize, factors: &Factors) -> Vec<Complex<f64>> {
    let mut sums = vec![Complex::ZERO; n];
    for (coordinate, part) in factors {
        sums[*coordinate] += part.factor().1;
    }
    sums
}

impl Ports {
    pub(super) fn of(pushes: &[Push], readings: &[Reading]) -> Ports {
        let mut ports = Ports {
            acts: Vec::new(),
            sums: Vec::new(),
            direct: Vec::new(),
            count: readings.len(),
        };
        for push in pushes {
            let (power, _) = push.part.factor();
            let acts = &mut ports.acts;
            let at = acts.iter().position(|(known, _)| *known == power);
            let at = at.unwrap_or_else(|| {
                acts.push((power, Vec::new()));
                acts.len() - 1
            });
            acts[at].1.push((push.coordinate, push.part));
        }
        for (index, reading) in readings.iter().enumerate() {
            let own = ports.sums.len();
            for (coordinate, part) in &reading.of {
                let (power, _) = part.factor();
                let sums = &mut ports.sums;
                let known = sums[own..].iter().position(|(_, known, _)| *known == power);
                let at = own + known.unwrap_or(sums.len() - own);
                if at == sums.len() {
                    sums.push((index, power, Vec::new()));
                }
                sums[at].2.push((*coordinate, *part));
            }
            let direct = reading.more.iter().map(|part| (index, *part));
            ports.direct.extend(direct);
        }
        ports
    }

    /// The sums of rows that belong to the coordinates, by one part of the factors.
    pub(super) fn outputs(
        &self,
        shapes: MatRef<'_, f64>,
        part: fn(&Complex<f64>) -> f64,
    ) -> Mat<f64> {
        let mut outputs = Mat::<f64>::zeros(self.sums.len(), shapes.ncols());
        for k in 0..shapes.ncols() {
            for (row, (.., parts)) in self.sums.iter().enumerate() {
                let terms = parts
                    .iter()
                    .map(|(i, factor)| part(&factor.factor().1) * shapes[(*i, k)]);
                outputs[(row, k)] = terms.sum();
            }
        }
        outputs
    }
}
