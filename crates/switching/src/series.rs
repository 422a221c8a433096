//! The exact motion over a short step, as a power series with a bound of what is left out.

use eigentone_digits::Real;

use crate::configuration::Configuration;
use crate::rows::{Row, SLACK, length, unit};

/// A step is looked at a little beyond its end, so that no root there is missed or hidden by it.
pub(crate) const BEYOND: f64 = 1.0 + 1.0 / 64.0;

/// What is left out of a series, beside rounding.
const NEGLIGIBLE: f64 = 1.0 / 65_536.0;

/// ζ(t + θh) = Σ cₖ θᵏ for 0 ≤ θ ≤ `BEYOND`.
pub(crate) struct Series<T> {
    /// How many entries a term has.
    n: usize,
    /// One term after the other.
    terms: Vec<T>,
    /// The same, rounded.
    rounded: Vec<f64>,
    /// How far each entry of each term may be off by rounding.
    roundings: Vec<f64>,
    /// What is not known of each entry of all terms together but for rounding.
    rest: Vec<f64>,
    /// A bound of the length of ζ.
    pub(crate) size: f64,
    reach: f64,
}

impl<T: Real> Series<T> {
    pub(crate) fn of(configuration: &Configuration<T>, zeta: &[T]) -> Series<T> {
        /// About as many terms as there are.
        const TERMS: usize = 64;
        let n = zeta.len();
        let reach = configuration.reach * BEYOND;
        let scales = &configuration.scales;
        let mut rounded = Vec::with_capacity(TERMS * n);
        rounded.extend(zeta.iter().map(|entry| entry.to_f64()));
        let scaled = rounded
            .iter()
            .zip(scales)
            .map(|(entry, scale)| entry * scale);
        let start = length(&scaled.collect::<Vec<f64>>()) * SLACK;
        // Bounds of the sizes of the terms' entries, as sums of sizes.
        let mut bound: Vec<f64> = rounded.iter().map(|entry| entry.abs() * SLACK).collect();
        let mut before = bound.clone();
        let mut sizes = bound.clone();
        let mut roundings = Vec::with_capacity(TERMS * n);
        roundings.resize(n, 0.0);
        let mut terms = Vec::with_capacity(TERMS * n);
        terms.extend_from_slice(zeta);
        let unit = unit::<T>();
        let width = configuration.rows.iter().map(Vec::len).max().unwrap_or(0) as f64;
        // reachᵏ/k!
        let (mut left, mut power) = (1.0, 1.0);
        while left > unit * NEGLIGIBLE || terms.len() < 4 * n {
            let count = terms.len() / n;
            let k = count as f64;
            std::mem::swap(&mut bound, &mut before);
            for (bound, row) in bound.iter_mut().zip(&configuration.sizes) {
                let sum: f64 = row.iter().map(|(j, size)| size * before[*j]).sum();
                *bound = sum / k * SLACK;
            }
            left *= reach / k;
            if bound.iter().all(|entry| *entry == 0.0) {
                left = 0.0;
                break;
            }
            configuration.apply_to(&mut terms);
            let inverse = T::ONE / T::from(k);
            for entry in &mut terms[count * n..] {
                if !entry.is_zero() {
                    *entry = *entry * inverse;
                }
                rounded.push(entry.to_f64());
            }
            power *= BEYOND * SLACK;
            for (sum, size) in sizes.iter_mut().zip(&bound) {
                *sum += size * power;
            }
            let rounding = unit * k * (width + 3.0) * SLACK;
            roundings.extend(bound.iter().map(|size| rounding * size));
        }
        let all = reach.exp() * SLACK;
        let plain = length(&sizes) * SLACK;
        let rest = scales.iter().map(|scale| {
            let cut = 2.0 * left * all * start / scale;
            (cut + configuration.error * BEYOND * all * plain) * SLACK
        });
        let rest: Vec<f64> = rest.collect();
        Series {
            n,
            size: plain + length(&rest),
            terms,
            rounded,
            roundings,
            rest,
            reach,
        }
    }

    /// ζ at θ.
    pub(crate) fn at(&self, theta: T) -> Vec<T> {
        let mut terms = self.terms.chunks_exact(self.n).rev();
        let mut sum = terms.next().expect("the first term").to_vec();
        for term in terms {
            for (sum, entry) in sum.iter_mut().zip(term) {
                *sum = *sum * theta + *entry;
            }
        }
        sum
    }

    /// How far each entry of ζ at θ may be off, apart from what is not known of ζ at 0.
    pub(crate) fn error_at(&self, theta: f64) -> Vec<f64> {
        let mut errors: Vec<f64> = self.rest.iter().map(|rest| rest * theta.min(1.0)).collect();
        let mut power = 1.0;
        let roundings = self.roundings.chunks_exact(self.n);
        let terms = roundings.zip(self.rounded.chunks_exact(self.n));
        for (k, (roundings, term)) in terms.enumerate() {
            let sum = 2.0 * unit::<T>() * (k + 2) as f64;
            for ((error, rounding), entry) in errors.iter_mut().zip(roundings).zip(term) {
                *error += power * (rounding + sum * entry.abs());
            }
            power *= theta * SLACK;
        }
        errors
    }

    /// The coefficients of a function of ζ in θ.
    pub(crate) fn of_row(&self, row: &Row<T>) -> Vec<T> {
        let terms = self.terms.chunks_exact(self.n);
        terms.map(|term| row.at(term)).collect()
    }

    /// The same in doubles, and the sizes of what each is the sum of.
    pub(crate) fn of_row_rounded(&self, row: &Row<T>) -> (Vec<f64>, Vec<f64>) {
        let entry = |term: &[f64]| {
            let products = row.rounded.iter().zip(term).map(|(a, b)| a * b);
            products.fold((0.0, 0.0f64), |(sum, size), product| {
                (sum + product, size + product.abs())
            })
        };
        self.rounded.chunks_exact(self.n).map(entry).unzip()
    }

    /// Bounds of the errors of the coefficients of a function of ζ, where each is a sum of this size and ζ(t) times the
    /// scales of the configuration is known to `off`; of the first one as far as ζ(t) does not matter.
    pub(crate) fn coefficient_errors(
        &self,
        configuration: &Configuration<T>,
        row: &Row<T>,
        off: f64,
        sizes: &[f64],
    ) -> Vec<f64> {
        let off = configuration.norm_of(row) * off;
        let own = row.error * self.size;
        let rounding = unit::<T>() * (row.entries.len() + 2) as f64;
        let dot = |sizes: &[f64]| {
            row.rounded
                .iter()
                .zip(sizes)
                .map(|(a, b)| a.abs() * b)
                .sum::<f64>()
        };
        let mut factor = 1.0;
        let roundings = self.roundings.chunks_exact(self.n);
        let each = sizes.iter().zip(roundings).enumerate();
        let errors = each.map(|(k, (size, roundings))| {
            // What is left out begins with the first power of θ.
            let more = match k {
                0 => 0.0,
                1 => off * self.reach + dot(&self.rest),
                _ => off * factor * self.reach / k as f64,
            };
            if k > 0 {
                factor *= self.reach / k as f64;
            }
            (more + dot(roundings) + rounding * size + own * factor) * SLACK
        });
        errors.collect()
    }
}
