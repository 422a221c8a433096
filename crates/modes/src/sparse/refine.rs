//! From Ritz vectors to eigenvalues with their last digits.
//!
//! Each vector gets a step of inverse iteration whose solves are refined with residuals from the
//! elements in double-double. λ is its Rayleigh quotient, summed over the elements: an error ε of the
//! vector enters as ε². With ρ = ‖A x − μ x‖_M/|μ| and γ the distance from μ to the rest of the spectrum
//! of A relative to |μ|, the error of μ is at most min(ρ, ρ²/γ)·|μ| (Parlett 1998, *The Symmetric
//! Eigenvalue Problem*, theorem 11.7.1).

use eigentone_digits::sort_by_number;
use faer::Mat;

use eigentone_digits::{DoubleDouble, Real, definite_eigen};

use super::basis::{STRETCH, combine, dot, short_dot};
use super::form::Form;
use super::operator::ShiftInvert;
use super::pencil::Pencil;
use super::search::Vector;

/// An eigenpair with its quality.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    /// λ = ω².
    pub(crate) square: f64,
    /// Of M-norm 1.
    pub(crate) shape: Vec<f64>,
    /// Estimated |λ̂ − λ|.
    pub(crate) error: Option<f64>,
}

/// Above this ρ a vector gets another step.
const ROUGH: f64 = 1e-8;

/// Vectors whose μ is so many times another's are taken out of it.
const FAR: f64 = 1e3;

/// At most so many steps.
const STEPS: usize = 4;

/// Eigenpairs from the vectors that were found; `next` is the nearest to the shift of all others.
pub(crate) fn refined(
    operator: &ShiftInvert<'_>,
    vectors: Vec<Vector>,
    next: Option<f64>,
) -> Vec<Pair> {
    let mut shapes = Shapes {
        operator,
        inverses: vectors.iter().map(|vector| vector.inverse).collect(),
        residuals: vec![0.0; vectors.len()],
        vectors: vectors.into_iter().map(|vector| vector.shape).collect(),
        doubt: 0.0,
    };
    for step in 0..STEPS {
        if shapes.vectors.is_empty() {
            break;
        }
        shapes.improve();
        if step + 1 == STEPS || shapes.residuals.iter().all(|size| *size <= ROUGH) {
            break;
        }
        shapes.separate();
    }
    shapes.pairs(next)
}

/// Vectors on their way to eigenvectors, with μ and ρ of each.
struct Shapes<'a, 'b> {
    operator: &'a ShiftInvert<'b>,
    vectors: Vec<Vec<f64>>,
    inverses: Vec<f64>,
    residuals: Vec<f64>,
    /// The relative error of solves.
    doubt: f64,
}

/// Beyond that no error is estimated.
const SMALL: f64 = 1e-3;

impl Shapes<'_, '_> {
    /// One step of inverse iteration for each vector; ρ is that before the step. Solves are refined
    /// unless those for the first and the last need none.
    fn improve(&mut self) {
        let n = self.operator.pencil.len();
        let (mut product, mut work) = (vec![0.0; n], vec![0.0; n]);
        let doubt = if self.operator.never_cancels() {
            2.0 * f64::EPSILON * (n as f64).sqrt()
        } else {
            self.probe(&mut product, &mut work)
        };
        let plain = doubt <= ROUGH;
        // What refinement leaves is smaller than the square of what it corrected.
        self.doubt = if plain { doubt } else { doubt * doubt };
        for k in 0..self.vectors.len() {
            self.operator
                .apply(&self.vectors[k], &mut product, &mut work);
            if plain {
                self.remove_nearer(k, &mut product, &mut work);
            } else {
                let missing = self.refine(k, &mut product, &mut work);
                let pairs = product.iter_mut().zip(&missing);
                pairs.for_each(|(y, missing)| *y += missing);
            }
            let mass = &self.operator.pencil.mass;
            mass.apply(&self.vectors[k], &mut work);
            let inverse = dot(&work, &product) / dot(&work, &self.vectors[k]);
            for (x, y) in self.vectors[k].iter_mut().zip(&product) {
                *x = y - inverse * *x;
            }
            let residual = self.norm(&self.vectors[k], &mut work);
            let size = self.norm(&product, &mut work);
            for (x, y) in self.vectors[k].iter_mut().zip(&product) {
                *x = y / size;
            }
            self.inverses[k] = inverse;
            self.residuals[k] = residual / size + self.doubt;
        }
    }

    /// The relative error of plain solves, by what the first and the last vector's lack.
    fn probe(&self, product: &mut [f64], work: &mut [f64]) -> f64 {
        let last = self.vectors.len() - 1;
        let probes = if last == 0 { vec![0] } else { vec![0, last] };
        let doubts = probes.into_iter().map(|k| {
            self.operator.apply(&self.vectors[k], product, work);
            let missing = self.refine(k, product, work);
            self.norm(&missing, work) / self.norm(product, work)
        });
        doubts.fold(0.0, f64::max)
    }

    /// What the product of vector k with A lacks; the product and this without what is nearer to the shift.
    fn refine(&self, k: usize, product: &mut [f64], work: &mut [f64]) -> Vec<f64> {
        let mut missing = self.operator.correction(&self.vectors[k], product, work);
        self.remove_nearer(k, product, work);
        self.remove_nearer(k, &mut missing, work);
        missing
    }

    /// A makes what rounding has left of vectors much nearer to the shift than vector k grow: makes a product
    /// orthogonal to them again.
    fn remove_nearer(&self, k: usize, product: &mut [f64], work: &mut [f64]) {
        let own = self.inverses[k].abs();
        for (nearer, inverse) in self.vectors[..k].iter().zip(&self.inverses) {
            if inverse.abs() > FAR * own {
                self.operator.pencil.mass.apply(product, work);
                let along = dot(nearer, work);
                let pairs = product.iter_mut().zip(nearer);
                pairs.for_each(|(y, x)| *y -= along * x);
            }
        }
    }

    /// The M-norm.
    fn norm(&self, x: &[f64], work: &mut [f64]) -> f64 {
        self.operator.pencil.mass.apply(x, work);
        dot(x, work).max(0.0).sqrt()
    }

    /// Rotates the vectors to the eigenvectors of the pencil in their span, those together whose μ lie not far
    /// apart.
    fn separate(&mut self) {
        let mut start = 0;
        for end in 1..=self.vectors.len() {
            let far = |k: usize| self.inverses[k - 1].abs() > FAR * self.inverses[k].abs();
            if end == self.vectors.len() || far(end) {
                rotate(self.operator, &mut self.vectors[start..end]);
                start = end;
            }
        }
    }

    /// Eigenvalues as Rayleigh quotients; but as σ + 1/μ where the rounding of the shape spoils the
    /// quotient, as that of very stiff systems does; and from shapes in double-double where neither is good
    /// to the last digits.
    fn pairs(mut self, next: Option<f64>) -> Vec<Pair> {
        const U: f64 = f64::EPSILON;
        const GOOD: f64 = 16.0 * U;
        let pencil = self.operator.pencil;
        let (stiffness, mass, shift) = (&pencil.stiffness, &pencil.mass, self.operator.shift);
        let diagonal = stiffness.diagonal();
        let mut pairs = Vec::with_capacity(self.vectors.len());
        for k in 0..self.vectors.len() {
            let part = self.relative_error(k, next);
            let shape = &self.vectors[k];
            let norm = mass.quadratic(shape);
            let quotient = stiffness.quadratic(shape) / norm;
            let terms = shape.iter().zip(&diagonal);
            let noise: f64 = terms.map(|(x, k)| k.abs() * x * x).sum::<f64>() * U * U / norm;
            let distance = (quotient - shift).abs();
            let of_quotient = 2.0 * part * distance + noise + 4.0 * U * quotient.abs();
            let inverted = shift + 1.0 / self.inverses[k];
            let of_inverted = 2.0 * (part + self.doubt + 4.0 * U) * distance
                + 4.0 * U * (shift.abs() + inverted.abs());
            let (square, error) = if of_quotient <= 2.0 * of_inverted {
                (quotient, of_quotient)
            } else {
                (inverted, of_inverted)
            };
            pairs.push(Pair {
                square,
                shape: Vec::new(),
                error: (part <= SMALL && error.is_finite()).then_some(error),
            });
        }
        let poor = |pair: &Pair| {
            pair.error
                .is_none_or(|error| error > GOOD * pair.square.abs())
        };
        if pairs.iter().any(poor) {
            self.sharpen(next, &mut pairs);
        }
        for (pair, shape) in pairs.iter_mut().zip(self.vectors) {
            pair.shape = shape;
        }
        pairs
    }

    /// Whether their residuals do not separate two values.
    fn together(&self, k: usize, j: usize) -> bool {
        let part = |k: usize| self.residuals[k] * self.inverses[k].abs();
        (self.inverses[k] - self.inverses[j]).abs() <= 4.0 * part(k).max(part(j))
    }

    /// All that hang together with a vector.
    fn group(&self, first: usize) -> Vec<usize> {
        let mut group = vec![first];
        let mut at = 0;
        while let Some(&k) = group.get(at) {
            for j in 0..self.vectors.len() {
                if !group.contains(&j) && self.together(k, j) {
                    group.push(j);
                }
            }
            at += 1;
        }
        group
    }

    /// More steps for all vectors in double-double, and the eigenvectors in their span, as long as that makes
    /// errors less.
    fn sharpen(&mut self, next: Option<f64>, pairs: &mut [Pair]) {
        const STEPS: usize = 16;
        const GOOD: f64 = 2.0 * f64::EPSILON;
        let operator = self.operator;
        let Pencil {
            stiffness, mass, ..
        } = operator.pencil;
        // How much what the last correction left can add, if it is of the fastest motion.
        let rates = stiffness.sizes().into_iter().zip(mass.diagonal());
        let rate = rates
            .filter(|(_, mass)| *mass > 0.0)
            .map(|(stiffness, mass)| stiffness / mass)
            .fold(0.0, f64::max);
        let long = |x: &Vec<f64>| x.iter().map(|&x| x.into()).collect();
        let mut vectors: Vec<[Vec<DoubleDouble>; 2]> =
            self.vectors.iter().map(|x| [long(x), Vec::new()]).collect();
        for step in 0..STEPS {
            let mut last: f64 = 0.0;
            for [vector, before] in &mut vectors {
                operator.project_long(vector);
                let (product, left) = operator.apply_long(vector);
                let norm = mass.quadratic_long(&product).0.sqrt().to_f64();
                last = last.max(left / norm);
                *before = std::mem::replace(vector, product);
            }
            if !ritz(stiffness, mass, &mut vectors) {
                return;
            }
            let mut squares = Vec::new();
            for (k, [product, before]) in vectors.iter().enumerate() {
                let resisted = times(mass, before);
                let along = short_dot(&resisted, product) / short_dot(&resisted, before);
                let terms = product.iter().zip(before);
                let rest: Vec<DoubleDouble> = terms.map(|(&y, &x)| y - x * along).collect();
                let residual = short_dot(&times(mass, &rest), &rest).abs().sqrt().to_f64();
                let (energy, of_energy) = stiffness.quadratic_long(product);
                let (norm, of_norm) = mass.quadratic_long(product);
                let square = (energy / norm).to_f64();
                squares.push((
                    square,
                    of_energy + of_norm * square.abs() + rate * last * last,
                ));
                self.residuals[k] = residual + last;
                self.inverses[k] = 1.0 / (square - operator.shift);
            }
            let mut gaining = false;
            for (k, (square, rounding)) in squares.into_iter().enumerate() {
                let group = self.group(k);
                let joint = group.iter().map(|&j| self.residuals[j] * self.residuals[j]);
                let joint = joint.sum::<f64>().sqrt();
                let others = self.inverses.iter().enumerate();
                let others = others.filter(|(j, _)| !group.contains(j));
                let gap = others
                    .map(|(_, inverse)| *inverse)
                    .chain(next)
                    .map(|other| (1.0 - other / self.inverses[k]).abs())
                    .fold(f64::INFINITY, f64::min);
                let part = joint.min(joint * joint / gap);
                let distance = (square - operator.shift).abs();
                let error = 2.0 * part * distance + rounding + f64::EPSILON * square.abs();
                let pair = &mut pairs[k];
                if part > SMALL {
                    gaining |= step == 0;
                } else if pair.error.is_none_or(|before| error < before) {
                    let enough = GOOD * square.abs();
                    gaining |=
                        error > enough && pair.error.is_none_or(|before| error < 0.5 * before);
                    pair.square = square;
                    pair.error = Some(error);
                    self.vectors[k] = vectors[k][0].iter().map(|x| x.to_f64()).collect();
                }
            }
            if !gaining {
                return;
            }
        }
    }

    /// Of μ_k: ρ, or ρ²/γ where that is less. Values that their residuals do not separate are judged
    /// together: then what couples their vectors is added.
    fn relative_error(&self, k: usize, next: Option<f64>) -> f64 {
        let (inverses, residuals) = (&self.inverses, &self.residuals);
        let own = inverses[k];
        let mut residual = residuals[k] * residuals[k];
        let mut gap = next.map_or(f64::INFINITY, |next| (own - next).abs());
        let mut coupling = 0.0;
        for (j, (other, size)) in inverses.iter().zip(residuals).enumerate() {
            let apart = (own - other).abs();
            if !self.together(k, j) {
                gap = gap.min(apart);
            } else if j != k {
                residual += size * size;
                coupling += self.coupling(k, j);
            }
        }
        let gap = gap / own.abs();
        let residual = residual.sqrt();
        residual.min(residual * residual / gap + coupling)
    }

    /// |xᵀ(K − θM)y| for two of the vectors, θ the quotient of the first, relative to its distance from the
    /// shift.
    fn coupling(&self, k: usize, j: usize) -> f64 {
        let Pencil {
            stiffness, mass, ..
        } = self.operator.pencil;
        let (x, y) = (&self.vectors[k], &self.vectors[j]);
        let square = self.operator.shift + 1.0 / self.inverses[k];
        let beside = if stiffness.is_non_negative() && mass.is_non_negative() {
            stiffness.bilinear(x, y) - square * mass.bilinear(x, y)
        } else {
            let long = |x: &[f64]| x.iter().map(|&x| x.into()).collect::<Vec<DoubleDouble>>();
            let (x, y) = (long(x), long(y));
            let square = DoubleDouble::from(square);
            (stiffness.bilinear_long(&x, &y).0 - mass.bilinear_long(&x, &y).0 * square).to_f64()
        };
        (beside * self.inverses[k]).abs()
    }
}

/// Rotates vectors to the eigenvectors of the pencil in their span, with all forms summed over the
/// elements.
fn rotate(operator: &ShiftInvert<'_>, shapes: &mut [Vec<f64>]) {
    let (stiffness, mass) = (&operator.pencil.stiffness, &operator.pencil.mass);
    let count = shapes.len();
    let form = |i: usize, j: usize| {
        let mass = mass.bilinear(&shapes[i], &shapes[j]);
        (
            stiffness.bilinear(&shapes[i], &shapes[j]) - operator.shift * mass,
            mass,
        )
    };
    let mut k = Mat::<f64>::zeros(count, count);
    let mut m = Mat::<f64>::zeros(count, count);
    for j in 0..count {
        for i in 0..=j {
            (k[(i, j)], m[(i, j)]) = form(i, j);
            (k[(j, i)], m[(j, i)]) = (k[(i, j)], m[(i, j)]);
        }
    }
    // Scaled to a unit diagonal, which keeps the digits of the small ones.
    let scale: Vec<f64> = (0..count).map(|i| k[(i, i)].abs().sqrt().recip()).collect();
    let scaled = |a: &Mat<f64>| Mat::from_fn(count, count, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let (k, m) = (scaled(&k), scaled(&m));
    let Some((values, vectors)) = definite_eigen(&k, &m) else {
        return;
    };
    let value = |k: &usize| values[*k].abs();
    let mut order: Vec<usize> = (0..count).collect();
    sort_by_number(&mut order, value);
    let factors = Mat::from_fn(count, count, |i, j| vectors[(i, order[j])] * scale[i]);
    if factors.norm_max().is_finite() {
        combine(shapes, factors.as_ref());
    }
}

/// The eigenvectors of (K, M) in the span of the first vector of each pair, of M-norm 1, with the second ones
/// combined in the same way, by Jacobi's method (Golub & Van Loan 2013, *Matrix Computations*, §8.5), all in
/// double-double. `false` where they are not independent.
pub(crate) fn ritz(stiffness: &Form, mass: &Form, vectors: &mut [[Vec<DoubleDouble>; 2]]) -> bool {
    const SWEEPS: usize = 20;
    let mut resisted: Vec<Vec<DoubleDouble>> = Vec::new();
    for k in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(k);
        let own = &mut rest[0];
        for _ in 0..2 {
            for (other, resisted) in before.iter().zip(&resisted) {
                let along = short_dot(resisted, &own[0]);
                for (own, other) in own.iter_mut().zip(other) {
                    DoubleDouble::add_multiple(own, -along, other);
                }
            }
        }
        let mut product = times(mass, &own[0]);
        let norm = short_dot(&product, &own[0]).sqrt();
        if norm.to_f64() <= 0.0 || norm.to_f64().is_nan() {
            return false;
        }
        let inverse = DoubleDouble::from(1.0) / norm;
        product.iter_mut().for_each(|x| *x = *x * inverse);
        for own in own {
            own.iter_mut().for_each(|x| *x = *x * inverse);
        }
        resisted.push(product);
    }
    let count = vectors.len();
    let mut form = vec![vec![DoubleDouble::ZERO; count]; count];
    for i in 0..count {
        let product = times(stiffness, &vectors[i][0]);
        for j in 0..=i {
            form[i][j] = short_dot(&product, &vectors[j][0]);
            form[j][i] = form[i][j];
        }
    }
    // The eigenvectors of the form, one a row.
    let one = DoubleDouble::from(1.0);
    let mut turns = vec![vec![DoubleDouble::ZERO; count]; count];
    (0..count).for_each(|k| turns[k][k] = one);
    for _ in 0..SWEEPS {
        let mut turned = false;
        for p in 0..count {
            for q in p + 1..count {
                let beside = form[p][q];
                let size = form[p][p].abs().to_f64().max(form[q][q].abs().to_f64());
                if beside.abs().to_f64() <= 1e-30 * size || beside.to_f64().is_nan() {
                    continue;
                }
                turned = true;
                let theta = (form[q][q] - form[p][p]) / (beside + beside);
                let root = (theta * theta + one).sqrt();
                let tangent = match theta.to_f64() < 0.0 {
                    true => -(one / (root - theta)),
                    false => one / (root + theta),
                };
                let cosine = one / (tangent * tangent + one).sqrt();
                let sine = cosine * tangent;
                for row in &mut form {
                    (row[p], row[q]) = (
                        row[p] * cosine - row[q] * sine,
                        row[p] * sine + row[q] * cosine,
                    );
                }
                for rows in [&mut form, &mut turns] {
                    let (first, second) = rows.split_at_mut(q);
                    for (a, b) in first[p].iter_mut().zip(&mut second[0]) {
                        (*a, *b) = (*a * cosine - *b * sine, *a * sine + *b * cosine);
                    }
                }
            }
        }
        if !turned {
            break;
        }
    }
    for part in 0..2 {
        let rows = vectors.first().map_or(0, |vector| vector[part].len());
        for start in (0..rows).step_by(STRETCH) {
            let stretch = start..rows.min(start + STRETCH);
            let given: Vec<Vec<DoubleDouble>> = vectors
                .iter()
                .map(|vector| vector[part][stretch.clone()].to_vec())
                .collect();
            for (vector, turn) in vectors.iter_mut().zip(&turns) {
                let own = &mut vector[part][stretch.clone()];
                own.fill(DoubleDouble::ZERO);
                let terms = turn.iter().zip(&given);
                let terms: Vec<_> = terms.map(|(factor, given)| (*factor, &given[..])).collect();
                DoubleDouble::add_multiples(own, &terms);
            }
        }
    }
    true
}

/// A x.
fn times(form: &Form, x: &[DoubleDouble]) -> Vec<DoubleDouble> {
    let mut product = vec![DoubleDouble::ZERO; x.len()];
    form.accumulate_long(1.0, x, &mut product);
    product
}
