//! Chains of any length whose modes and motion are known in closed form.

use eigentone::prelude::*;
use num_complex::Complex;

/// n masses of 1 kg between two walls, joined by springs of 1 N/m and dampers of `damping` N·s/m.
///
/// C is `damping` times K, so that each mode moves by itself: the j-th has the shape
/// sin(i·jπ/(n + 1)), ω = 2 sin(jπ/(2n + 2)) and ζ = ω·`damping`/2 (Rayleigh, *Theory of Sound*,
/// §120).
pub struct Chain {
    pub masses: usize,
    pub damping: f64,
}

impl Chain {
    pub fn system(&self) -> System {
        let n = self.masses;
        let name = |i: usize| match i {
            i if i == 0 || i == n + 1 => GROUND.to_owned(),
            i => format!("m{i}"),
        };
        let builder = (1..=n).fold(System::builder(), |builder, i| builder.mass(name(i), 1.0));
        let builder = (0..=n).fold(builder, |builder, i| {
            let builder = builder.spring(name(i), name(i + 1), 1.0);
            if self.damping == 0.0 {
                builder
            } else {
                builder.damper(name(i), name(i + 1), self.damping)
            }
        });
        builder.build().expect("a chain is a system")
    }

    /// sin(angle) at mass i = 1 … n, for mode j = 1 … n.
    pub fn shape(&self, j: usize, i: usize) -> f64 {
        (std::f64::consts::PI * (i * j) as f64 / (self.masses + 1) as f64).sin()
    }

    /// The root with Im λ > 0 of mode j.
    pub fn root(&self, j: usize) -> Complex<f64> {
        let angle = std::f64::consts::PI * j as f64 / (2 * self.masses + 2) as f64;
        let omega = 2.0 * angle.sin();
        let zeta = omega * self.damping / 2.0;
        assert!(zeta < 1.0);
        Complex::new(-zeta, (1.0 - zeta * zeta).sqrt()) * omega
    }

    /// The chain displaced by the shape of mode j, at rest.
    #[allow(dead_code)] // not every bench moves it
    pub fn state(&self, j: usize) -> State {
        (1..=self.masses).fold(State::at_rest(), |state, i| {
            state.displace(format!("m{i}"), self.shape(j, i))
        })
    }

    /// How much of the shape is left after `t` seconds, and its rate.
    #[allow(dead_code)] // not every bench moves it
    pub fn motion(&self, j: usize, t: f64) -> (f64, f64) {
        let root = self.root(j);
        let decayed = (root.re * t).exp();
        let (sine, cosine) = (root.im * t).sin_cos();
        let displacement = decayed * (cosine - root.re / root.im * sine);
        let velocity = -decayed * root.norm_sqr() / root.im * sine;
        (displacement, velocity)
    }
}
