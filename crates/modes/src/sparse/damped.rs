//! Modes with damping near those that were found without it.
//!
//! Rayleigh damping couples no shapes: λ² + (α + βω²)λ + ω² = 0 for each. Other damping takes shapes of its own:
//! roots near a few shifts come from Arnoldi's method on the whole equation, are refined one by one, and are
//! counted in a disc about 0 where a proof of that can be had.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use crate::modes::ModePlan;
use crate::modes::{Bounds, Eigenvalue, Mode, Modes, Repeats, listed, order};
use crate::solver::{ModesError, normalised};
use crate::structure::rayleigh::Proportion;
use crate::system::System;
use faer::Mat;

use super::arnoldi::{Approximate, Arnoldi};
use super::basis::dot;
use super::form::Form;
use super::newton;
use super::pencil::Pencil;
use super::winding::Winding;
use super::{SparseError, SparseModes};

/// A vector by its real and imaginary parts.
type Parts = [Vec<f64>; 2];

/// A root with its shape and what is known of its error.
struct Root {
    value: Complex<f64>,
    /// Estimated |λ̂ − λ| and that of the real part.
    error: Option<(f64, f64)>,
    shape: Parts,
    repeats: Repeats,
    /// How many roots it stands for.
    roots: usize,
}

/// Roots, and whether none is missing among them.
struct Answer {
    roots: Vec<Root>,
    complete: bool,
}

/// The modes of the whole equation.
pub(crate) fn modes(found: &SparseModes, damping: &Form) -> Result<Modes, SparseError> {
    let answer = if damping.is_zero() {
        Answer {
            roots: undamped(found),
            complete: found.is_counted(),
        }
    } else if let Some(proportion) = found.facts.proportion {
        proportional(found, proportion)
    } else {
        coupled(found, damping)?
    };
    let judge = Judge::of(found, damping);
    let roots = answer.roots.into_iter();
    let mut modes: Vec<Mode> = roots.map(|root| judge.mode(root)).collect();
    modes.sort_by(|a, b| order(&a.eigenvalue, &b.eigenvalue));
    Ok(Modes {
        eigenvalues: listed(&modes),
        modes,
        infinite: found.infinite,
        bounds: Bounds::Estimated,
        complete: answer.complete,
        plan: plan(found, damping, answer.complete),
    })
}

fn plan(found: &SparseModes, damping: &Form, complete: bool) -> ModePlan {
    let count = found.facts.count;
    let proportional = damping.is_zero() || found.facts.proportion.is_some();
    let counted = match (complete, proportional) {
        (true, true) => "the signs of pivots prove that none between them is missing",
        (true, false) => {
            "the turns of the determinant about a circle prove that none between them is missing"
        }
        (false, _) => "that none between them is missing is not proved",
    };
    ModePlan {
        solver: if proportional {
            "sparse Lanczos"
        } else {
            "sparse Arnoldi"
        },
        reason: "some modes, without dense matrices".to_owned(),
        bounds: "estimated from residuals".to_owned(),
        left_out: vec![("other modes", format!("{count} were asked for; {counted}"))],
    }
}

/// Whether a mode was told from all others.
fn told(found: &SparseModes, k: usize) -> Repeats {
    match found.clusters[k] {
        1 => Repeats::SIMPLE,
        count => Repeats::Cluster(count),
    }
}

fn undamped(found: &SparseModes) -> Vec<Root> {
    let rigid = found
        .squares
        .iter()
        .filter(|square| **square == 0.0)
        .count();
    let mut roots = Vec::new();
    let mut listed = false;
    for (k, (&square, error)) in found.squares.iter().zip(&found.errors).enumerate() {
        let zeros = vec![0.0; found.shapes.nrows()];
        let shape = [found.shapes.col(k).iter().copied().collect(), zeros];
        let size = square.abs().sqrt();
        // Where ω² is not told from 0, its root is 0 within that of the bound.
        let unclear = error.is_some_and(|error| square.abs() <= error);
        let error = error.map(|error| match unclear {
            true => (square.abs() + error).sqrt(),
            false => error / size / 2.0,
        });
        let root = |value, error, roots| Root {
            value,
            error,
            shape: shape.clone(),
            repeats: match roots {
                1 => told(found, k),
                count if error == Some((0.0, 0.0)) => Repeats::Exactly {
                    count: found.facts.zero_roots.unwrap_or(count),
                    defective: Some(true),
                },
                count => Repeats::Cluster(count),
            },
            roots,
        };
        if unclear {
            // One entry for all rigid motions, as every two roots of one share a shape.
            match square == 0.0 {
                true if !std::mem::replace(&mut listed, true) => {
                    roots.push(root(Complex::ZERO, Some((0.0, 0.0)), 2 * rigid));
                }
                true => {}
                false => roots.push(root(Complex::ZERO, error.map(|e| (e, e)), 2)),
            }
        } else if square > 0.0 {
            roots.push(root(Complex::new(0.0, size), error.map(|e| (e, 0.0)), 1));
        } else {
            for value in [size, -size] {
                roots.push(root(Complex::from(value), error.map(|e| (e, e)), 1));
            }
        }
    }
    roots
}

/// The projected equation.
pub(crate) fn reduced(found: &SparseModes, damping: &Form) -> Result<System, ModesError> {
    let count = found.len();
    let column = |k| found.shapes.col(k).iter().copied().collect();
    let shapes: Vec<Vec<f64>> = (0..count).map(column).collect();
    let mut coupling = Mat::<f64>::zeros(count, count);
    if let Some(Proportion {
        of_mass,
        of_stiffness,
    }) = found.facts.proportion
    {
        for (i, square) in found.squares.iter().enumerate() {
            coupling[(i, i)] = (of_mass + of_stiffness * *square).to_f64();
        }
    } else if !damping.is_zero() {
        for j in 0..count {
            for i in 0..=j {
                coupling[(i, j)] = damping.bilinear(&shapes[i], &shapes[j]);
                coupling[(j, i)] = coupling[(i, j)];
            }
        }
    }
    let unit = Mat::<f64>::identity(count, count);
    let squares = Mat::from_fn(count, count, |i, j| match i == j {
        true => found.squares[i],
        false => 0.0,
    });
    System::from_matrices(unit.as_ref(), coupling.as_ref(), squares.as_ref()).map_err(|_| {
        ModesError::OutOfRange {
            method: "sparse Lanczos",
        }
    })
}

/// Those of Rayleigh damping: γ = α + βω² for each mode by itself.
fn proportional(found: &SparseModes, proportion: Proportion) -> Answer {
    let Proportion {
        of_mass: alpha,
        of_stiffness: beta,
    } = proportion;
    let here = found.squares.iter().filter(|s| **s == 0.0).count();
    let rigid = found.facts.rigid.unwrap_or(here);
    let mut roots = Vec::new();
    let mut listed = false;
    for (k, (&square, error)) in found.squares.iter().zip(&found.errors).enumerate() {
        let zeros = vec![0.0; found.shapes.nrows()];
        let shape: Parts = [found.shapes.col(k).iter().copied().collect(), zeros];
        let root = |value: Complex<f64>, error, repeats, roots| Root {
            value,
            error,
            shape: shape.clone(),
            repeats,
            roots,
        };
        let exactly = |count, defective| Repeats::Exactly {
            count,
            defective: Some(defective),
        };
        let alpha_rounded = alpha.to_f64();
        if square == 0.0 && *error == Some(0.0) {
            if alpha_rounded != 0.0 {
                let own = f64::EPSILON * alpha_rounded.abs();
                let own = Some((own, own));
                roots.push(root(
                    Complex::ZERO,
                    Some((0.0, 0.0)),
                    exactly(rigid, false),
                    1,
                ));
                roots.push(root(
                    Complex::from(-alpha_rounded),
                    own,
                    exactly(rigid, false),
                    1,
                ));
            } else if !std::mem::replace(&mut listed, true) {
                let exactly = exactly(2 * rigid, true);
                roots.push(root(Complex::ZERO, Some((0.0, 0.0)), exactly, 2 * here));
            }
            continue;
        }
        for (value, error) in quadratic(alpha, beta, square, *error) {
            roots.push(root(value, error, told(found, k), 1));
        }
    }
    let facts = &found.facts;
    let complete = keep_nearest(&mut roots, facts.target, facts.count).is_some_and(|apart| {
        let counted = found.counted.is_some();
        counted && others_lie_beyond(found, [alpha.to_f64(), beta.to_f64()], apart)
    });
    Answer { roots, complete }
}

/// A root, and how far it and its real part may be off.
type Scalar = (Complex<f64>, Option<(f64, f64)>);

/// The roots of λ² + (α + βω²)λ + ω² = 0 with Im λ ≥ 0, given ω² and its error.
fn quadratic(
    alpha: DoubleDouble,
    beta: DoubleDouble,
    square: f64,
    error: Option<f64>,
) -> Vec<Scalar> {
    let half = (alpha + beta * square) * 0.5;
    let rest = half * half - DoubleDouble::from(square);
    let size = rest.abs().to_f64();
    let root = rest.abs().sqrt();
    let (half_rounded, beta) = (half.to_f64().abs(), beta.to_f64().abs());
    let unit = f64::EPSILON;
    // By how much γ/2 and the square of the root below it may be off.
    let of_half = |error: f64| beta / 2.0 * error;
    let of_root = |error: f64| {
        let of_rest = (half_rounded * beta + 1.0) * error + 2.0 * of_half(error) * of_half(error);
        (of_rest <= 0.25 * size).then(|| of_rest / root.to_f64())
    };
    if rest.to_f64() < 0.0 {
        let value = Complex::new(-half.to_f64(), root.to_f64());
        let error = error.and_then(|error| {
            let (real, other) = (of_half(error), of_root(error)?);
            let real = real + unit * half_rounded;
            Some((real + other + unit * value.norm(), real))
        });
        return vec![(value, error)];
    }
    let large = match half.to_f64() < 0.0 {
        true => root - half,
        false => -(half + root),
    };
    let small = DoubleDouble::from(square) / large;
    let both = [small.to_f64(), large.to_f64()];
    both.into_iter()
        .enumerate()
        .map(|(k, value)| {
            let error = error.and_then(|error| {
                let of_large = of_half(error) + of_root(error)?;
                let part = of_large / both[1].abs();
                let own = match k {
                    0 => value.abs() * (2.0 * part + error / square.abs()),
                    _ => of_large,
                };
                let own = own + unit * value.abs();
                (part <= 0.1).then_some((own, own))
            });
            (Complex::from(value), error)
        })
        .collect()
}

/// Whether no root of a mode that was not found has a natural frequency so near to the target.
fn others_lie_beyond(found: &SparseModes, [alpha, beta]: [f64; 2], apart: f64) -> bool {
    const ROOM: f64 = 1e-9;
    let Some([low, high]) = found.counted else {
        return false;
    };
    if alpha < 0.0 || beta < 0.0 || !found.facts.semidefinite {
        return false;
    }
    let target = found.facts.target;
    let (low, high) = (low.max(0.0).sqrt(), high.max(0.0).sqrt());
    let [nearest, farthest] = [target - apart, (target + apart) * (1.0 + ROOM)];
    // Complex roots have |λ| = ω; real ones are there where α + βω² ≥ 2ω, and the smaller of two is at least
    // ω²/(α + βω²), which rises with ω.
    let least = |omega: f64| omega * omega / (alpha + beta * omega * omega);
    let slow = alpha / (1.0 + (1.0 - alpha * beta).max(0.0).sqrt());
    let fast = match beta > 0.0 {
        true if alpha * beta < 1.0 => (1.0 + (1.0 - alpha * beta).sqrt()) / beta,
        true => 0.0,
        false => f64::INFINITY,
    };
    let beyond = match fast.is_finite() || high <= slow {
        true if high <= slow => high.min(least(high)),
        true => high.min(least(high.max(fast))),
        false => high,
    };
    // Below, the larger of two real roots is no more than α + βω² where there are some.
    let slower = match fast < low {
        true => low,
        false => low.min(slow),
    };
    let larger = match slower > 0.0 {
        true => alpha + beta * slower * slower,
        false => 0.0,
    };
    farthest <= beyond && (low == 0.0 || larger < nearest * (1.0 - ROOM))
}

/// Keeps so many entries whose natural frequencies are nearest to the target; how far the last one is.
fn keep_nearest(roots: &mut Vec<Root>, target: f64, count: usize) -> Option<f64> {
    let apart = |root: &Root| (root.value.norm() - target).abs();
    roots.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
    roots.truncate(count);
    roots.last().map(apart)
}

/// Where roots are looked for, and how many of them are there.
struct Ring {
    /// Natural frequencies inside and outside of which none is wanted.
    within: [f64; 2],
    /// How many were found.
    found: usize,
}

/// Those of damping that couples shapes.
fn coupled(found: &SparseModes, damping: &Form) -> Result<Answer, SparseError> {
    const ROUNDS: usize = 6;
    let facts = &found.facts;
    let Pencil {
        stiffness, mass, ..
    } = &*found.pencil;
    let pencil = Pencil::of(stiffness.clone(), damping.clone(), mass.clone());
    let pencil = pencil.ok_or(SparseError::TooDense)?;
    let zeros = zeros(found, damping);
    // Motions that rounding alone holds are no measure.
    const HELD: f64 = 1e-4;
    let own = found.squares.iter().map(|square| square.abs().sqrt());
    let largest = own.clone().fold(0.0, f64::max);
    let held = own.filter(|rate| *rate > HELD * largest);
    let rate = match facts.target {
        0.0 => held.fold(f64::INFINITY, f64::min),
        target => target,
    };
    let rate = if rate.is_finite() { rate } else { 1.0 };
    let shifts = match facts.target {
        0.0 => vec![Complex::from(0.1 * rate)],
        target => [
            Complex::new(-1e-3, 1.0),
            Complex::new(-0.7, 0.7),
            Complex::new(-1.0, 0.0),
        ]
        .map(|direction| direction * target * (1.0 + 1e-4))
        .to_vec(),
    };
    let wanted = match facts.target {
        0.0 => 2 * facts.count + zeros.roots + 6,
        _ => facts.count + 4,
    };
    let winding = facts
        .passive
        .then(|| Winding::of(&found.pencil, damping, &facts.idle))
        .flatten();
    let about = shifts.into_iter();
    let mut searches: Vec<Arnoldi<'_>> = about
        .filter_map(|shift| Arnoldi::about(&pencil, shift, rate))
        .collect();
    if searches.is_empty() {
        return Err(SparseError::OutOfRange);
    }
    let mut more = wanted;
    let mut groups = Vec::new();
    let mut complete = false;
    for round in 0..ROUNDS {
        let mut came = 0;
        for search in &mut searches {
            came += search.run(more);
        }
        groups = grouped(&searches, &zeros);
        let all = groups.iter().flatten().map(pairs).sum::<usize>() + zeros.roots;
        if facts.finite == Some(all) {
            complete = true;
            break;
        }
        let Some(ring) = ring(&groups, zeros.roots, facts) else {
            if came == 0 {
                break;
            }
            continue;
        };
        let Some(winding) = &winding else {
            // A second run finds second shapes of multiple roots.
            if round > 0 {
                break;
            }
            more = 4;
            continue;
        };
        let [low, high] = ring.within;
        let inside = |radius: f64| match radius > 0.0 {
            true => winding.inside(radius),
            false => Some(0),
        };
        let count = || inside(high)?.checked_sub(inside(low)?);
        match count() {
            Some(count) if count == ring.found => {
                complete = true;
                break;
            }
            Some(count) if count > ring.found && came > 0 => more = count - ring.found + 2,
            _ => break,
        }
    }
    let mut roots = zeros.entries();
    let entries = |group: &Vec<Approximate>| (group[0].value.norm() - facts.target).abs();
    groups.sort_by(|a, b| entries(a).total_cmp(&entries(b)));
    let mut listed = roots.len();
    for group in groups {
        if listed >= facts.count && facts.target == 0.0
            || listed >= facts.count + zeros.entries().len()
        {
            break;
        }
        listed += group.len();
        roots.extend(refined(&pencil, group, facts.passive));
    }
    keep_nearest(&mut roots, facts.target, facts.count);
    let known = |root: &Root| root.error.is_some();
    let complete = complete && roots.iter().all(known);
    Ok(Answer { roots, complete })
}

/// Motions at λ = 0: K x = 0, with two roots where C x = 0 as well.
struct Zeros {
    shapes: Vec<Vec<f64>>,
    roots: usize,
    /// Whether some shape stands for two of them.
    double: bool,
}

fn zeros(found: &SparseModes, damping: &Form) -> Zeros {
    let still =
        (0..found.len()).filter(|&k| found.squares[k] == 0.0 && found.errors[k] == Some(0.0));
    let shapes: Vec<Vec<f64>> = still
        .map(|k| found.shapes.col(k).iter().copied().collect())
        .collect();
    let mut product = vec![0.0; found.shapes.nrows()];
    let roots = found.facts.zero_roots.unwrap_or_else(|| {
        let mut free = |shape: &Vec<f64>| {
            damping.apply(shape, &mut product);
            product.iter().all(|force| *force == 0.0)
        };
        shapes
            .iter()
            .map(|shape| if free(shape) { 2 } else { 1 })
            .sum()
    });
    let roots = if shapes.is_empty() { 0 } else { roots };
    let double = roots > found.facts.rigid.unwrap_or(shapes.len());
    Zeros {
        shapes,
        roots,
        double,
    }
}

impl Zeros {
    fn entries(&self) -> Vec<Root> {
        let count = self.roots;
        let root = |shape: &Vec<f64>, defective, roots| Root {
            value: Complex::ZERO,
            error: Some((0.0, 0.0)),
            shape: [shape.clone(), vec![0.0; shape.len()]],
            repeats: Repeats::Exactly {
                count,
                defective: Some(defective),
            },
            roots,
        };
        let shapes = self.shapes.iter();
        match self.double {
            true => shapes
                .take(1)
                .map(|shape| root(shape, true, count))
                .collect(),
            false => shapes.map(|shape| root(shape, false, 1)).collect(),
        }
    }
}

/// The roots that all searches found, those together that nearly coincide, without those at 0.
fn grouped(searches: &[Arnoldi<'_>], zeros: &Zeros) -> Vec<Vec<Approximate>> {
    const SMALL: f64 = 1e-3;
    let mut groups: Vec<Vec<Approximate>> = Vec::new();
    for search in searches {
        let mut roots = search.roots();
        roots.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        let still = roots
            .iter()
            .take(zeros.roots)
            .filter(|root| root.value.norm() <= SMALL * search.rate())
            .count();
        let mut own: Vec<Vec<Approximate>> = Vec::new();
        for root in roots.drain(still..) {
            let near = |group: &&mut Vec<Approximate>| {
                let apart = |other: &Approximate| (other.value - root.value).norm();
                group
                    .iter()
                    .any(|other| apart(other) <= newton::NEAR * root.value.norm())
            };
            match own.iter_mut().find(near) {
                Some(group) => group.push(root),
                None => own.push(vec![root]),
            }
        }
        // Of what several searches found the one that found most is taken.
        for group in own {
            let centre = group[0].value;
            let near = |other: &&mut Vec<Approximate>| {
                let apart = |other: &Approximate| (other.value - centre).norm();
                other
                    .iter()
                    .any(|other| apart(other) <= 2.0 * newton::NEAR * centre.norm())
            };
            match groups.iter_mut().find(near) {
                Some(other) if other.len() >= group.len() => {}
                Some(other) => *other = group,
                None => groups.push(group),
            }
        }
    }
    groups
}

/// How many roots an approximate one stands for: with its conjugate, unless it is real.
fn pairs(root: &Approximate) -> usize {
    match root.value.im.abs() <= 1e-7 * root.value.norm() {
        true => 1,
        false => 2,
    }
}

/// A ring of natural frequencies about the target with at least so many entries as are wanted, its rims between
/// roots; `None` where too few were found.
fn ring(groups: &[Vec<Approximate>], zeros: usize, facts: &super::Facts) -> Option<Ring> {
    const APART: f64 = 1e-6;
    let mut sizes: Vec<(f64, usize)> = groups
        .iter()
        .flatten()
        .map(|root| (root.value.norm(), pairs(root)))
        .collect();
    sizes.extend((0..zeros).map(|_| (0.0, 1)));
    let apart = |size: f64| (size - facts.target).abs();
    sizes.sort_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
    let last = facts.count.min(sizes.len()).checked_sub(1)?;
    let whole = facts.target.max(sizes[last].0);
    let at = (last..sizes.len() - 1)
        .find(|&at| apart(sizes[at + 1].0) - apart(sizes[at].0) > APART * whole)?;
    let reach = 0.5 * (apart(sizes[at].0) + apart(sizes[at + 1].0));
    let within = [(facts.target - reach).max(0.0), facts.target + reach];
    Some(Ring {
        within,
        found: sizes[..=at].iter().map(|(_, roots)| roots).sum(),
    })
}

/// Roots with the digits that the matrices determine.
fn refined(pencil: &Pencil, group: Vec<Approximate>, passive: bool) -> Vec<Root> {
    let roots = newton::refined(pencil, group);
    let values: Vec<Complex<f64>> = roots.iter().map(|root| root.value).collect();
    let told = |k: usize, error: f64| {
        let others = values.iter().enumerate().filter(|(j, _)| *j != k);
        others
            .map(|(_, other)| (values[k] - other).norm())
            .all(|apart| apart > 4.0 * error)
    };
    let mut all = Vec::new();
    for (k, root) in roots.into_iter().enumerate() {
        let mut value = root.value;
        let mut error = root.error;
        let mut repeats = Repeats::SIMPLE;
        if let Some((whole, real)) = &mut error {
            if !told(k, *whole) {
                repeats = Repeats::Cluster(values.len());
            } else if value.im.abs() <= *whole {
                // The conjugate would be another root as near.
                value.im = 0.0;
            }
            if value.re.abs() <= *real || passive && value.re > 0.0 {
                *real += value.re.abs();
                *whole += value.re.abs();
                value.re = 0.0;
            }
        }
        if value.im < 0.0 {
            let whole = error.map_or(0.0, |(whole, _)| whole);
            let mate = |other: &Complex<f64>| (other.conj() - value).norm() <= 4.0 * whole;
            if values.iter().any(mate) {
                continue;
            }
            value = value.conj();
        }
        let (re, im) = root.shape.iter().map(|x| (x.re, x.im)).unzip();
        all.push(Root {
            value,
            error,
            shape: [re, im],
            repeats,
            roots: 1,
        });
    }
    all
}

/// Measures residuals in the whole equation.
struct Judge<'a> {
    found: &'a SparseModes,
    damping: &'a Form,
    /// Frobenius norms of M, C and K.
    norms: [f64; 3],
}

impl<'a> Judge<'a> {
    fn of(found: &'a SparseModes, damping: &'a Form) -> Judge<'a> {
        let pencil = &*found.pencil;
        Judge {
            found,
            damping,
            norms: [&pencil.mass, damping, &pencil.stiffness].map(Form::norm),
        }
    }

    /// Q(λ)x.
    fn residual(&self, value: Complex<f64>, shape: &Parts) -> Parts {
        let n = shape[0].len();
        let mut rest = [vec![0.0; n], vec![0.0; n]];
        let mut product = vec![0.0; n];
        let pencil = &self.found.pencil;
        let one = Complex::ONE;
        for (form, factor) in [
            (&pencil.mass, value * value),
            (self.damping, value),
            (&pencil.stiffness, one),
        ] {
            for (part, unit) in shape.iter().zip([one, Complex::I]) {
                form.apply(part, &mut product);
                let factor = factor * unit;
                for (rest, factor) in rest.iter_mut().zip([factor.re, factor.im]) {
                    let pairs = rest.iter_mut().zip(&product);
                    pairs.for_each(|(rest, value)| *rest += factor * value);
                }
            }
        }
        rest
    }

    fn mode(&self, root: Root) -> Mode {
        let Root {
            value,
            error,
            shape,
            repeats,
            roots,
        } = root;
        let rest = self.residual(value, &shape);
        let squared = |x: &Parts| dot(&x[0], &x[0]) + dot(&x[1], &x[1]);
        let [mass, damping, stiffness] = self.norms;
        let size = value.norm();
        let scale = (size * mass + damping) * size + stiffness;
        let condition = (roots == 1 && size != 0.0)
            .then(|| scale * squared(&shape) / (size * self.slope(value, &shape)));
        let backward_error = (squared(&rest) / squared(&shape)).sqrt() / scale;
        let pairs = shape[0].iter().zip(&shape[1]);
        let shape: Vec<Complex<f64>> = pairs.map(|(re, im)| Complex::new(*re, *im)).collect();
        let shape = normalised(&shape);
        Mode {
            eigenvalue: Eigenvalue {
                value,
                bound: error.map(|(whole, _)| whole),
                real_bound: error.map(|(_, real)| real),
            },
            repeats,
            roots,
            left_shape: Some(shape.iter().map(|entry| entry.conj()).collect()),
            left_shape_bound: None,
            shape,
            shape_bound: None,
            backward_error,
            condition: condition.filter(|condition| condition.is_finite()),
        }
    }

    /// |xᵀ(2λM + C)x|.
    fn slope(&self, value: Complex<f64>, [re, im]: &Parts) -> f64 {
        let form = |form: &Form| {
            let real = form.bilinear(re, re) - form.bilinear(im, im);
            Complex::new(real, 2.0 * form.bilinear(re, im))
        };
        (form(&self.found.pencil.mass) * value * 2.0 + form(self.damping)).norm()
    }
}
