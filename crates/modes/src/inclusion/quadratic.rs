//! The roots of λ² + γλ + σ for many pairs of real γ and σ, each known within a bound.
//!
//! For approximations z and w of the roots of p, each of the discs |λ − z| ≤ 2|p(z)|/|z − w| and
//! |λ − w| ≤ 2|p(w)|/|z − w| holds one root if they are disjoint (Smith 1970, *J. ACM* 17): that of
//! the true p as well. Those of a pair off the real axis have Re λ = −γ/2 exactly. Where the discs
//! meet, (λ + γ/2)² = γ²/4 − σ puts both roots into one disc about −γ/2.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, WideComplex};
use num_complex::Complex;

use super::bounded_shape::Shape;
use super::exactly::{exact, lower, real, upper};
use super::groups::groups;

/// A mode that moves by itself.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) gamma: Ball<DoubleDouble>,
    /// `None` where it is 0: then the only other root is −γ.
    pub(super) sigma: Option<Ball<DoubleDouble>>,
    pub(super) shape: Shape,
    /// Whether −γ is the same number as that of all others of which this is so.
    pub(super) is_common: bool,
}

/// A root, or several that the bounds do not separate, with Im ≥ 0, and its shape.
#[derive(Clone, Debug)]
pub(crate) struct Damped {
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    /// 0 where it is known to be imaginary.
    pub(crate) real_bound: f64,
    /// How many roots the bounds do not separate.
    pub(crate) multiplicity: usize,
    /// Whether these are one root with as many shapes.
    pub(crate) coincide: bool,
    /// How many of them this entry stands for: two may belong to one shape.
    pub(crate) roots: usize,
    pub(crate) shape: Shape,
}

/// The real number, exactly.
pub(super) fn at(value: DoubleDouble) -> WideComplex<DoubleDouble> {
    WideComplex {
        re: value,
        im: DoubleDouble::ZERO,
    }
}

/// All real numbers so near to one.
pub(super) fn around(value: DoubleDouble, reach: f64) -> Ball<DoubleDouble> {
    Ball::new(at(value), Magnitude::from(reach))
}

/// All nonzero roots of the modes; `None` where 0 or the real axis is not distinguished from one.
pub(super) fn roots(modes: &[Modal]) -> Option<Vec<Damped>> {
    let mut discs = Vec::new();
    for (owner, mode) in modes.iter().enumerate() {
        let found = match mode.sigma {
            Some(sigma) => pair(mode.gamma, sigma)?,
            None if mode.gamma.is_zero() => Vec::new(),
            None if mode.gamma.contains_zero() => return None,
            None => vec![Disc::real(-mode.gamma)],
        };
        discs.extend(found.into_iter().map(|disc| (owner, disc)));
    }
    let mut found = Vec::with_capacity(discs.len());
    for cluster in clusters(&discs) {
        found.extend(rounded(modes, &cluster)?);
    }
    Some(found)
}

/// Where one root or two lie.
#[derive(Clone, Copy, Debug)]
struct Disc {
    centre: WideComplex<DoubleDouble>,
    reach: f64,
    /// Of the real part.
    real_reach: f64,
    count: usize,
}

impl Disc {
    fn real(ball: Ball<DoubleDouble>) -> Disc {
        let reach = ball.radius().to_f64();
        Disc {
            centre: ball.middle(),
            reach,
            real_reach: reach,
            count: 1,
        }
    }

    fn is_real(&self) -> bool {
        self.centre.im == DoubleDouble::ZERO
    }

    fn meets(&self, other: &Disc) -> bool {
        let apart = Ball::from(self.centre) - Ball::from(other.centre);
        lower(apart) <= (self.reach + other.reach) * (1.0 + 1e-9)
    }
}

/// The roots with Im ≥ 0; `None` where not even a disc about −γ/2 avoids 0.
fn pair(gamma: Ball<DoubleDouble>, sigma: Ball<DoubleDouble>) -> Option<Vec<Disc>> {
    let half = gamma * real(0.5);
    let (centre, square) = (half.middle().re, sigma.middle().re);
    let discriminant = centre * centre - square;
    let (z, w) = if discriminant < DoubleDouble::ZERO {
        let im = (-discriminant).sqrt();
        (exact(-centre, im), exact(-centre, -im))
    } else {
        let root = discriminant.sqrt();
        let large = if centre > DoubleDouble::ZERO {
            -centre - root
        } else {
            root - centre
        };
        (around(large, 0.0), around(square / large, 0.0))
    };
    let reach = |at: Ball<DoubleDouble>| {
        let value = (at + gamma) * at + sigma;
        Some(2.0 * upper(value.checked_div(z - w)?) * (1.0 + 1e-9))
    };
    if let (Some(first), Some(second)) = (reach(z), reach(w))
        && (first + second) * (1.0 + 1e-9) < lower(z - w)
    {
        let disc = |z: Ball<DoubleDouble>, reach: f64, real_reach: f64| Disc {
            centre: z.middle(),
            reach,
            real_reach,
            count: 1,
        };
        return Some(if z.middle().im > DoubleDouble::ZERO {
            let real_reach = half.radius().to_f64();
            vec![disc(z, first, real_reach.min(first))]
        } else {
            vec![disc(z, first, first), disc(w, second, second)]
        });
    }
    let reach = upper(half * half - sigma).sqrt() * (1.0 + 1e-9) + half.radius().to_f64();
    (reach < centre.to_f64().abs()).then(|| {
        vec![Disc {
            centre: at(-centre),
            reach,
            real_reach: reach,
            count: 2,
        }]
    })
}

/// Discs that touch each other, directly or through others.
fn clusters(discs: &[(usize, Disc)]) -> Vec<Vec<(usize, Disc)>> {
    let groups = groups(discs.len(), |i, j| discs[i].1.meets(&discs[j].1));
    let members = |group: Vec<usize>| group.into_iter().map(|i| discs[i]).collect();
    groups.into_iter().map(members).collect()
}

/// One double for the roots of a cluster, and how far each may lie from it: an entry for every disc.
fn rounded(modes: &[Modal], cluster: &[(usize, Disc)]) -> Option<Vec<Damped>> {
    let pairs = cluster.iter().filter(|(_, disc)| !disc.is_real()).count();
    if pairs != 0 && pairs != cluster.len() {
        return None;
    }
    let middle = cluster[cluster.len() / 2].1;
    let mut value = Complex::new(middle.centre.re.to_f64(), middle.centre.im.to_f64());
    let hidden = |disc: &Disc| disc.centre.re.to_f64().abs() <= disc.real_reach;
    if pairs > 0 && cluster.iter().all(|(_, disc)| hidden(disc)) {
        value.re = 0.0;
    }
    let (mut bound, mut real_bound) = (0.0, 0.0);
    for (_, disc) in cluster {
        let off = |part: DoubleDouble, double: f64| upper(real(double) - Ball::from(at(part)));
        let re = off(disc.centre.re, value.re);
        let im = off(disc.centre.im, value.im);
        bound = (re.hypot(im) + disc.reach).max(bound);
        real_bound = (re + disc.real_reach).max(real_bound);
    }
    let enlarged = |bound: f64| {
        if bound > 0.0 {
            (bound * (1.0 + 1e-9)).max(f64::from_bits(1))
        } else {
            0.0
        }
    };
    let multiplicity = cluster.iter().map(|(_, disc)| disc.count).sum();
    let coincide = cluster.iter().all(|(owner, _)| modes[*owner].is_common);
    let entry = |(owner, disc): &(usize, Disc)| Damped {
        value,
        coincide,
        bound: enlarged(bound),
        real_bound: enlarged(real_bound),
        multiplicity,
        roots: disc.count,
        // What shares a root with others has no shape of its own.
        shape: if cluster.len() == 1 {
            modes[*owner].shape.clone()
        } else {
            modes[*owner].shape.clone().without_bounds()
        },
    };
    Some(cluster.iter().map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// γ and σ known to within a reach, and the ends of what that leaves open: each root there lies in the
    /// disc that is near it.
    #[test]
    fn what_is_known_of_the_coefficients_widens_the_discs() {
        for (gamma, sigma) in [
            ((0.0, 0.0), (1.0, 0.1)),
            ((1.0, 0.1), (1.0, 0.0)),
            ((1.0, 0.05), (2.0, 0.1)),
            ((5.0, 0.0), (4.0, 0.2)),
            ((-5.0, 0.1), (4.0, 0.1)),
            ((2.0, 0.0), (1.0, 0.01)),
            // Two discs that meet, above each other and beside each other.
            ((2.0, 1e-3), (1.0001, 0.0)),
            ((2.0, 1e-3), (0.9999, 0.0)),
        ] {
            let ball = |(value, reach): (f64, f64)| around(DoubleDouble::from(value), reach);
            let discs = pair(ball(gamma), ball(sigma)).unwrap();
            assert_eq!(discs[0].count == 2, gamma.0 == 2.0);
            for (up, over) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let half = Complex::from((gamma.0 + up * gamma.1) / 2.0);
                let root = (half * half - (sigma.0 + over * sigma.1)).sqrt();
                for value in [-half - root, root - half] {
                    // Discs below the real axis are not listed.
                    let value = Complex::new(value.re, value.im.abs());
                    let inside = discs.iter().filter(|disc| {
                        let (re, im) = (disc.centre.re.to_f64(), disc.centre.im.to_f64());
                        let off = (value - Complex::new(re, im)).norm();
                        let slack = 1e-15;
                        off <= disc.reach + slack
                            && (value.re - re).abs() <= disc.real_reach + slack
                    });
                    assert_eq!(
                        inside.count(),
                        1,
                        "{value} of {gamma:?}, {sigma:?}: {discs:?}"
                    );
                }
            }
        }
    }
}
