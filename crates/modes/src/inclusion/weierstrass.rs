//! All roots of det Q at once: Weierstrass corrections, and the discs that they prove.
//!
//! For distinct points z_1 … z_N and W_i = P(z_i) / (ℓ Π_{j≠i} (z_i − z_j)), with P of degree N and
//! leading coefficient ℓ, the roots of P are the eigenvalues of diag(z) − W·1ᵀ (Smith 1970,
//! *J. ACM* 17; Börsch-Supan 1963). Gershgorin's theorem, with the rows of a group of m points
//! scaled by t, puts exactly m of them into discs about z_i − W_i of radius
//! |W_i|(m − 1 + (N − m)/t) as long as those avoid the other rows' discs.
//!
//! N is the exact degree. ℓ is a product of determinants where the masses, or dampers and springs in
//! place of those that vanish, determine every acceleration; where they do not, one more point decides.

use eigentone_digits::{Ball, Magnitude, Real};

use super::exactly::{lower, middle, radius, real, upper};
use super::groups::groups;
use super::pencil::{PencilIn, Scaled};

/// The polynomial P(μ)/μ^zeros with its leading coefficient, where that is known beforehand.
pub(crate) struct Polynomial<T> {
    pub(crate) pencil: PencilIn<T>,
    pub(crate) zeros: usize,
    pub(crate) leading: Option<Scaled<T>>,
}

/// Points and what is known of P there.
pub(crate) struct Points<T> {
    pub(crate) z: Vec<Ball<T>>,
    values: Vec<Option<Scaled<T>>>,
    pub(crate) corrections: Vec<Ball<T>>,
    /// How many products the corrections took.
    pub(crate) products: u64,
    /// A point far beyond all others, and P there.
    beyond: Option<(Ball<T>, Scaled<T>)>,
}

/// A group of points whose discs hold exactly as many roots: disc of all, about `centre`.
#[derive(Clone, Debug)]
pub(crate) struct Inclusion<T> {
    pub(crate) members: Vec<usize>,
    pub(crate) centre: Ball<T>,
}

impl<T: Real> Points<T> {
    pub(crate) fn new(z: Vec<Ball<T>>) -> Self {
        let n = z.len();
        Points {
            z,
            values: vec![None; n],
            corrections: vec![Ball::ZERO; n],
            products: 0,
            beyond: None,
        }
    }

    /// Moves point i.
    pub(crate) fn place(&mut self, i: usize, z: Ball<T>) {
        self.z[i] = middle(z);
        self.values[i] = None;
    }

    /// Computes every W_i; `None` where two points coincide or a number leaves its range.
    pub(crate) fn correct(&mut self, polynomial: &Polynomial<T>) -> Option<()> {
        let n = self.z.len();
        for i in 0..n {
            if self.values[i].is_some() {
                continue;
            }
            let conjugate = (0..n).find(|j| {
                *j != i
                    && self.values[*j].is_some()
                    && self.z[i].middle() == self.z[*j].middle().conj()
            });
            let value = match conjugate {
                Some(j) => self.values[j].expect("found above").conj(),
                None => {
                    let (value, products) = polynomial.pencil.determinant(self.z[i]);
                    self.products += products;
                    value
                }
            };
            self.values[i] = Some(value);
        }
        self.products += (n * n) as u64;
        let known = polynomial.leading.unwrap_or_else(Scaled::one);
        // Where every point has one at its conjugate, itself or another, so have the corrections: P is real.
        let at_conjugate =
            |i: usize| (0..n).find(|j| self.z[i].middle() == self.z[*j].middle().conj());
        let twins: Option<Vec<usize>> = (0..n).map(at_conjugate).collect();
        let mut shares: Vec<Scaled<T>> = Vec::with_capacity(n);
        for i in 0..n {
            let twin = twins.as_ref().map_or(i, |twins| twins[i]);
            if twin < i {
                shares.push(shares[twin].conj());
                continue;
            }
            let mut below = known;
            for j in (0..n).filter(|j| *j != i) {
                below = below.times(self.z[i] - self.z[j]);
            }
            for _ in 0..polynomial.zeros {
                below = below.times(self.z[i]);
            }
            let value = self.values[i].expect("computed above");
            shares.push(value.divided_by(below)?);
        }
        let leading = match polynomial.leading {
            Some(_) => None,
            None => Some(self.leading(polynomial, &shares)?),
        };
        for (correction, share) in self.corrections.iter_mut().zip(shares) {
            *correction = match leading {
                Some(leading) => share.divided_by(leading)?.value()?,
                None => share.value()?,
            };
            if !upper(*correction).is_finite() {
                return None;
            }
        }
        Some(())
    }

    /// ℓ, from w_i = ℓ·W_i: interpolating P at the points and at one more, z_0,
    ///
    /// P(z_0)/Π(z_0 − z_i) = ℓ + Σ w_i/(z_0 − z_i).
    fn leading(&mut self, polynomial: &Polynomial<T>, shares: &[Scaled<T>]) -> Option<Scaled<T>> {
        /// Far out the sum is small even where the points are not yet near their roots.
        const FAR: i32 = 6;
        let largest = self.z.iter().map(|z| upper(*z)).fold(0.0, f64::max);
        let (far, value) = *self.beyond.get_or_insert_with(|| {
            let far = real(2f64.powi(largest.log2().ceil() as i32 + FAR));
            (far, polynomial.pencil.determinant(far).0)
        });
        let mut below = Scaled::one();
        for factor in self.z.iter().map(|z| far - *z) {
            below = below.times(factor);
        }
        for _ in 0..polynomial.zeros {
            below = below.times(far);
        }
        let whole = value.divided_by(below)?;
        let mut rest = real(1.0);
        for (share, z) in shares.iter().zip(&self.z) {
            let part = share.divided_by(whole)?.value()?;
            rest = rest - part.checked_div(far - *z)?;
        }
        Some(whole.times(rest))
    }

    /// z_i − W_i.
    pub(crate) fn improved(&self, i: usize) -> Ball<T> {
        self.z[i] - self.corrections[i]
    }

    /// Groups of points that do not stand clear of each other.
    pub(crate) fn groups(&self) -> Vec<Vec<usize>> {
        let n = self.z.len();
        let reach = self.corrections.iter().map(|w| 2.5 * n as f64 * upper(*w));
        let reach: Vec<f64> = reach.collect();
        let improved: Vec<Ball<T>> = (0..n).map(|i| self.improved(i)).collect();
        groups(n, |i, j| {
            lower(improved[i] - improved[j]) <= reach[i] + reach[j]
        })
    }

    /// A disc for each group that provably holds exactly as many roots as the group has points, all
    /// discs apart from each other; `None` where that cannot be shown.
    pub(crate) fn include(&self, groups: &[Vec<usize>]) -> Option<Vec<Inclusion<T>>> {
        let n = self.z.len();
        let improved: Vec<Ball<T>> = (0..n).map(|i| self.improved(i)).collect();
        let sizes: Vec<f64> = self.corrections.iter().map(|w| upper(*w)).collect();
        let mut discs = Vec::with_capacity(groups.len());
        for members in groups {
            let m = members.len();
            // The largest t for which the group's discs avoid all others.
            let mut t = f64::INFINITY;
            for &i in members {
                let own = sizes[i] * n as f64;
                for j in (0..n).filter(|j| !members.contains(j)) {
                    let distance = lower(improved[i] - improved[j]);
                    let other = sizes[j];
                    if other > 0.0 {
                        let room = 0.9 * (distance - own) / other - n as f64;
                        t = t.min(room / m as f64);
                    } else if distance <= own {
                        return None;
                    }
                }
            }
            if t < 1.0 {
                return None;
            }
            let mut centre = Ball::ZERO;
            for &i in members {
                centre = centre + middle(improved[i]);
            }
            let share = real(1.0).checked_div(real(m as f64))?;
            let centre = centre * share;
            let centre = middle(centre);
            let mut reach = 0f64;
            for &i in members {
                let spread = if m == 1 {
                    0.0
                } else {
                    upper(improved[i] - centre)
                };
                let own = sizes[i] * ((m - 1) as f64 + (n - m) as f64 / t);
                reach = reach.max((own + radius(improved[i]) + spread) * (1.0 + 1e-9));
            }
            discs.push(Inclusion {
                members: members.clone(),
                centre: Ball::new(centre.middle(), Magnitude::from(reach)),
            });
        }
        for (i, a) in discs.iter().enumerate() {
            for b in &discs[..i] {
                if (a.centre - b.centre).contains_zero() {
                    return None;
                }
            }
        }
        Some(discs)
    }
}

#[cfg(test)]
mod tests {
    use super::super::exactly::exact;
    use super::*;
    use eigentone_digits::DoubleDouble;

    /// Points with given corrections, each known to within a radius.
    fn points(given: &[(f64, f64, f64)]) -> Points<DoubleDouble> {
        let at = |x: f64| exact(DoubleDouble::from(x), DoubleDouble::from(0.0));
        let mut points = Points::new(given.iter().map(|(z, ..)| at(*z)).collect());
        let corrections = given
            .iter()
            .map(|(_, w, radius)| Ball::new(at(*w).middle(), Magnitude::from(*radius)));
        points.corrections = corrections.collect();
        points
    }

    /// What a correction leaves open the disc must hold.
    #[test]
    fn uncertain_corrections_widen_the_disc() {
        let discs = points(&[(1.0, 0.1, 0.05)]).include(&[vec![0]]).unwrap();
        assert!((discs[0].centre.middle().re.to_f64() - 0.9).abs() < 1e-15);
        let reach = radius(discs[0].centre);
        assert!((0.05..0.0501).contains(&reach), "{reach}");
    }

    /// Approximations with the corrections that the polynomial of the roots gives.
    fn corrected(roots: [f64; 3], z: [f64; 3]) -> Points<DoubleDouble> {
        let point = |i: usize| {
            let value: f64 = roots.iter().map(|root| z[i] - root).product();
            let others = (0..3).filter(|j| *j != i).map(|j| z[i] - z[j]);
            (z[i], value / others.product::<f64>(), 0.0)
        };
        points(&[0, 1, 2].map(point))
    }

    /// Approximations of 1, 2 and 4 with the corrections that their polynomial gives: each root in its
    /// disc, which is not on its centre.
    #[test]
    fn discs_hold_the_roots() {
        let roots = [1.0, 2.0, 4.0];
        for off in [1e-2, 3e-3, -1e-2] {
            let z = [1.0 + off, 2.0 - 0.7 * off, 4.0 + 1.3 * off];
            let groups = [vec![0], vec![1], vec![2]];
            let discs = corrected(roots, z).include(&groups).unwrap();
            for (disc, root) in discs.iter().zip(roots) {
                let distance = (disc.centre.middle().re.to_f64() - root).abs();
                assert!(
                    distance > 1e-8,
                    "the corrections are too good for this test"
                );
                assert!(distance <= radius(disc.centre), "{root}: {distance:e}");
                assert!(radius(disc.centre) < 1e-2);
            }
        }
    }

    /// 1 ± 10⁻³ in one disc, from points that are off by a tenth of that, beside 3.
    #[test]
    fn a_disc_of_several_holds_them_all() {
        let roots = [1.0 - 1e-3, 1.0 + 1e-3, 3.0];
        let z = [1.0 - 1.1e-3, 1.0 + 0.9e-3, 3.001];
        let groups = [vec![0, 1], vec![2]];
        let discs = corrected(roots, z).include(&groups).unwrap();
        for root in &roots[..2] {
            let distance = (discs[0].centre.middle().re.to_f64() - root).abs();
            assert!(distance <= radius(discs[0].centre), "{root}: {distance:e}");
        }
        assert_eq!(discs[0].members, [0, 1]);
        assert!(radius(discs[0].centre) < 1e-2);
    }
}
