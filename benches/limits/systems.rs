//! The chains that `benches/peers.py` uses too.

use eigentone::prelude::*;
use faer::Mat;

/// Springs, dampers and masses, and the step h.
pub struct Chain {
    pub springs: Vec<f64>,
    pub dampers: Vec<f64>,
    pub masses: Vec<f64>,
    pub step: f64,
}

impl Chain {
    /// Unit masses, springs from 1e3 to 1.1e4, dampers from 0 to 1, h = 0.01; the one of three masses has
    /// h = 1.
    pub fn of(n: usize) -> Chain {
        let fraction = |i: usize, factor: f64| (i as f64 * factor).fract();
        if n == 3 {
            return Chain {
                springs: vec![6.0, 7.0, 4.0, 1.0],
                dampers: vec![1.0, 0.2, 0.1, 2.0],
                masses: vec![6.0, 9.0, 5.0],
                step: 1.0,
            };
        }
        Chain {
            springs: (0..=n)
                .map(|i| 1e3 + 1e4 * fraction(i, 0.618_033_988_749_894_9))
                .collect(),
            dampers: (0..=n)
                .map(|i| fraction(i, 0.414_213_562_373_095_1))
                .collect(),
            masses: vec![1.0; n],
            step: 0.01,
        }
    }

    pub fn system(&self) -> System {
        let n = self.masses.len();
        let name = |i: usize| match i {
            i if i == 0 || i == n + 1 => GROUND.to_owned(),
            i => format!("m{i}"),
        };
        let mut builder = System::builder();
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(name(i + 1), *mass);
        }
        for (i, (k, c)) in self.springs.iter().zip(&self.dampers).enumerate() {
            builder = builder.spring(name(i), name(i + 1), *k);
            if *c > 0.0 {
                builder = builder.damper(name(i), name(i + 1), *c);
            }
        }
        builder.build().expect("a chain is a system")
    }

    /// A·t of z′ = A z, z displacements and then velocities.
    pub fn state_matrix(&self, t: f64) -> Mat<f64> {
        let n = self.masses.len();
        let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
        for i in 0..n {
            a[(i, n + i)] = t;
        }
        for (values, first) in [(&self.springs, 0), (&self.dampers, n)] {
            for (s, value) in values.iter().enumerate() {
                let ends = [s.checked_sub(1), (s < n).then_some(s)];
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    if let (Some(row), Some(column)) = (ends[i], ends[j]) {
                        let sign = if i == j { -1.0 } else { 1.0 };
                        a[(n + row, first + column)] += sign * value / self.masses[row] * t;
                    }
                }
            }
        }
        a
    }
}
