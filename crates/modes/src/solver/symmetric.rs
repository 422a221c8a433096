//! Undamped modes of assembled symmetric matrices.

use eigentone_digits::{
    Cholesky, product, quick_definite_eigen, quick_symmetric_eigen, sort_by_number,
};
use faer::{ColRef, Mat};

use crate::first_order::FirstOrder;
use crate::inclusion::congruence;
use crate::model::{Element, MatrixKind, Node};
use crate::modes::Modes;
use crate::quality::pencil::Pencil;
use crate::quality::real_forms::{Entries, RealForms};
use crate::system::System;

use super::many_digits;
use super::mode_solver::{ModeSolver, ModesError, admit};
use super::real_mode::{RealMode, scale_to_one, unit_shapes};
use super::roots::collect;
use super::spring_factor::{refined, undamped_roots};

/// How near quotients may come to eigenvalues of whole matrices, relative, to be preferred.
const CONFIRMED: f64 = 1e-13;

/// Relative errors of squares beyond which shapes are refined with more digits.
const LOST: f64 = 1e-3;

/// What an error of a square is at which shapes that are to be right, and cannot be refined, count as unknown.
const HIDDEN: f64 = 1e-6;

/// The symmetric eigenproblem of L⁻¹KL⁻ᵀ with M = LLᵀ (Golub & Van Loan, *Matrix Computations*,
/// §8.7): for undamped systems with symmetric K and positive definite M. Its errors are small
/// against the largest ω², not against each; what that leaves without digits is refined in double-double.
#[derive(Clone, Copy, Debug)]
pub struct Symmetric;

impl ModeSolver for Symmetric {
    fn name(&self) -> &'static str {
        "symmetric eigenproblem"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        if !system.structure().is_undamped() {
            return Some("there is damping".to_owned());
        }
        refuses_matrices(system)
    }

    fn reason(&self) -> &'static str {
        "undamped, with symmetric M and K"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        admit(self, system)?;
        let modes = real_modes(self, system, Entries::Plain)?;
        Ok(collect(self, system, undamped_roots(modes)))
    }
}

/// Why M and K do not fit a symmetric eigenproblem, damping apart.
pub(crate) fn refuses_matrices(system: &System) -> Option<String> {
    let structure = system.structure();
    if !structure.is_symmetric() {
        return Some("a matrix is not symmetric".to_owned());
    }
    if structure.has_definite_mass() || lumped(system).is_some() {
        return None;
    }
    if !structure.massless().is_empty() && FirstOrder::of(system).is_err() {
        return Some("the mass matrix is singular".to_owned());
    }
    let massive = massive_block(system);
    let definite = Cholesky::of(massive.as_ref()).is_some() || many_digits::has_modes(system);
    (!definite).then(|| "the mass matrix is not positive definite".to_owned())
}

/// M without the coordinates that have no mass.
fn massive_block(system: &System) -> Mat<f64> {
    let (mass, massless) = (system.mass_matrix(), system.structure().massless());
    if massless.is_empty() {
        return mass;
    }
    let massive: Vec<usize> = (0..mass.nrows())
        .filter(|i| massless.binary_search(i).is_err())
        .collect();
    let count = massive.len();
    Mat::from_fn(count, count, |i, j| mass[(massive[i], massive[j])])
}

/// The undamped modes of M and K, from the assembled matrices.
pub(crate) fn real_modes(
    solver: &dyn ModeSolver,
    system: &System,
    entries: Entries,
) -> Result<Vec<RealMode>, ModesError> {
    let structure = system.structure();
    let rigid = match structure.zero_roots() {
        Some(0) => 0,
        zeros => structure
            .rigid_motions_counted()
            .unwrap_or(zeros.unwrap_or(0) / 2),
    };
    let found = match lumped(system) {
        Some(masses) => lumped_modes(solver, system, &masses),
        None => assembled_modes(solver, system),
    };
    let Pairs {
        squares,
        shapes,
        spoiled,
    } = match found {
        Ok(found) => found,
        Err(error) => return with_digits(solver, system, rigid, entries).unwrap_or(Err(error)),
    };
    let nf = squares.len();
    // Shapes that no spring resists may outnumber those with mass, where dampers hold nodes without.
    if rigid > nf {
        let method = solver.name();
        return Err(ModesError::NoConvergence { method });
    }
    let mut order: Vec<usize> = (0..nf).collect();
    let square = |j: &usize| squares[*j];
    sort_by_number(&mut order, |j| square(j).abs());
    let largest = order.last().map_or(0.0, |j| square(j).abs());
    // Small against the largest square, so perhaps not against this one.
    let error = |largest: f64, square: f64| {
        8.0 * f64::EPSILON * (nf as f64).sqrt() * (largest / square.abs())
    };
    let mut found: Vec<(f64, f64, Vec<f64>)> = order
        .iter()
        .map(|j| {
            let error = spoiled[*j] + error(largest, square(j));
            (square(j), error, shapes.col(*j).iter().copied().collect())
        })
        .collect();
    let elastic = || found[rigid..].iter();
    let mut entries = entries;
    let mut known = false;
    if entries == Entries::Refined || elastic().any(|(_, error, _)| *error > LOST) {
        let shapes = elastic().map(|(.., shape)| shape.clone()).collect();
        if let Some(refined) = refined_shapes(system, shapes, entries) {
            (known, entries) = (true, Entries::Exact);
            found = refined;
        } else if let Some(modes) = with_digits(solver, system, rigid, entries) {
            return modes;
        }
    }
    let (values, shapes): (Vec<(f64, f64)>, Vec<Vec<f64>>) = found
        .into_iter()
        .map(|(square, error, shape)| ((square, error), shape))
        .unzip();
    let wanted = entries == Entries::Refined;
    let mut shapes = shapes;
    scale_to_one(&mut shapes);
    let columns: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let (forms, products) = RealForms::with_products(system, &columns, entries);
    // Beside dampers C has a share in the residuals.
    let judge = products
        .filter(|_| structure.is_undamped())
        .map(|products| (Pencil::of(system), products));
    let formed = shapes.into_iter().zip(forms).zip(values).enumerate();
    let modes = formed.map(|(rank, ((shape, mut forms), (square, reach)))| {
        let rigid = rank < rigid;
        // What massless nodes add may cancel.
        let largest = if structure.massless().is_empty() {
            largest
        } else {
            largest.max(gross_stiffness(system, &shape) / forms.m.to_f64())
        };
        let error = reach.max(error(largest, square)).max(CONFIRMED);
        let (square, doubt) = match square {
            _ if rigid => (0.0, 0.0),
            square if known => (square, reach),
            0.0 => (0.0, 0.0),
            square => {
                let upright = RealForms {
                    k: forms.k * square.signum(),
                    ..forms
                };
                let sigma = square.abs().sqrt();
                let (size, doubt) = refined(&upright, sigma, error);
                // An ill-conditioned M spoils either; quotients below the normal doubles have no digits to compare.
                let apart = if square.is_normal() {
                    (upright.quotient().max(0.0).sqrt() - sigma).abs()
                } else {
                    0.0
                };
                let mut doubt = doubt.max(2.0 * apart / sigma);
                // A shape that is lost so far may have the same wrong quotient as its square: it is off by the square of its error.
                if error > LOST {
                    doubt = doubt.max(error * error);
                }
                (
                    size.copysign(square),
                    doubt.max(0.5 * forms.quotient_error()),
                )
            }
        };
        let own = 2.0 * doubt * forms.k.to_f64().abs();
        forms.rounding[2] = forms.rounding[2].max(own);
        let of_products = |(pencil, [m, k]): &(Pencil, [Mat<f64>; 2])| {
            pencil.undamped_quality(square, &shape, m.col_as_slice(rank), k.col_as_slice(rank))
        };
        RealMode {
            square,
            quality: judge.as_ref().filter(|_| !rigid).map(of_products),
            shape,
            forms,
            rigid,
            doubt,
            is_exact: false,
        }
    });
    let modes: Vec<RealMode> = modes.collect();
    let is_hidden = |mode: &RealMode| !mode.rigid && mode.doubt > HIDDEN;
    if wanted && !known && modes.iter().any(is_hidden) {
        let method = solver.name();
        return Err(ModesError::OutOfRange { method });
    }
    Ok(modes)
}

/// All squares by rising size, how far each may be off, relative, and their shapes, in double-double from those of the elastic
/// modes. Shapes that are to be right are, where they are given.
fn refined_shapes(
    system: &System,
    elastic: Vec<Vec<f64>>,
    entries: Entries,
) -> Option<Vec<(f64, f64, Vec<f64>)>> {
    /// How far a shape that is right may lean towards another: by the error of its square over the distance of the two.
    const LEAN: f64 = 1e-12;
    const EQUAL: f64 = 1e-24;
    let wanted = entries == Entries::Refined;
    let goal = if wanted { 1e-27 } else { 1e-14 };
    let mut found = congruence::refined(system, elastic, goal)?;
    sort_by_number(&mut found, |pair| pair.0.abs());
    // Of squares that are equal in far more digits than doubles have any shapes serve.
    let is_apart = |pair: &[(f64, f64, Vec<f64>)]| {
        let [(one, reach, _), (other, more, _)] = pair else {
            return true;
        };
        let reach = reach * one.abs() + more * other.abs();
        reach <= LEAN * (one - other).abs() || reach <= EQUAL * (one.abs() + other.abs())
    };
    (!wanted || found.windows(2).all(is_apart)).then_some(found)
}

/// The same modes with shapes that are right to the last digit.
pub(super) fn with_right_shapes(
    solver: &dyn ModeSolver,
    system: &System,
    modes: Vec<RealMode>,
) -> Result<Vec<RealMode>, ModesError> {
    let (mut rigid, elastic): (Vec<RealMode>, Vec<RealMode>) =
        modes.into_iter().partition(|mode| mode.rigid);
    let count = rigid.len();
    let shapes = elastic.into_iter().map(|mode| mode.shape).collect();
    let Some(mut found) = refined_shapes(system, shapes, Entries::Refined) else {
        let method = solver.name();
        return with_digits(solver, system, count, Entries::Refined)
            .unwrap_or(Err(ModesError::OutOfRange { method }));
    };
    let elastic = found.split_off(count);
    let (values, shapes): (Vec<(f64, f64)>, Vec<Vec<f64>>) = elastic
        .into_iter()
        .map(|(square, error, shape)| ((square, error), shape))
        .unzip();
    let formed = unit_shapes(system, shapes, Entries::Exact).zip(values);
    rigid.extend(formed.map(|((shape, forms), (square, doubt))| RealMode {
        square,
        shape,
        forms,
        rigid: false,
        doubt,
        quality: None,
        is_exact: false,
    }));
    Ok(rigid)
}

/// The undamped modes by far more digits, where these do. Shapes that are to be right, and whose frequencies rounding to
/// doubles spoils, are refused.
fn with_digits(
    solver: &dyn ModeSolver,
    system: &System,
    rigid: usize,
    entries: Entries,
) -> Option<Result<Vec<RealMode>, ModesError>> {
    let modes = many_digits::undamped_modes(system, rigid)?;
    let shapes: Vec<&[f64]> = modes.iter().map(|mode| mode.shape.as_slice()).collect();
    let rounded = RealForms::of(system, &shapes, Entries::Exact);
    let is_hidden = |(mode, rounded): (&RealMode, RealForms)| {
        !mode.rigid && (rounded.quotient() / mode.square - 1.0).abs() > HIDDEN
    };
    if entries == Entries::Refined && modes.iter().zip(rounded).any(is_hidden) {
        let method = solver.name();
        return Some(Err(ModesError::OutOfRange { method }));
    }
    Some(Ok(modes))
}

/// What all springs and entries of K add to xᵀKx, by size.
fn gross_stiffness(system: &System, x: &[f64]) -> f64 {
    let at = |node: Node| node.coordinate().map_or(0.0, |i| x[i]);
    let spring = |spring: &Element| {
        let stretch = at(spring.first) - at(spring.second);
        spring.coefficient.abs() * stretch * stretch
    };
    let springs: f64 = system.springs().iter().map(spring).sum();
    let added = system.added(MatrixKind::Stiffness);
    let entries = added.map_or(0.0, |k| {
        let column = |(j, column): (usize, ColRef<'_, f64>)| -> f64 {
            let each = column.iter().zip(x).map(|(entry, x)| (entry * x).abs());
            each.sum::<f64>() * x[j].abs()
        };
        k.col_iter().enumerate().map(column).sum()
    });
    springs + entries
}

/// The masses, where M has nothing but them on its diagonal, and all are positive.
fn lumped(system: &System) -> Option<Vec<f64>> {
    if let Some(added) = system.added(MatrixKind::Mass) {
        let mut columns = added.col_iter().enumerate();
        let alone = |(j, column): (usize, ColRef<'_, f64>)| {
            let mut entries = column.iter().enumerate();
            entries.all(|(i, entry)| i == j || *entry == 0.0)
        };
        if !columns.all(alone) {
            return None;
        }
    }
    let added = |i: usize| {
        let matrix = system.added(MatrixKind::Mass);
        matrix.map_or(0.0, |matrix| matrix[(i, i)])
    };
    let lumped = system.masses().iter().enumerate();
    let masses: Vec<f64> = lumped.map(|(i, mass)| mass + added(i)).collect();
    masses.iter().all(|mass| *mass > 0.0).then_some(masses)
}

/// All ω² with their shapes, column by column, and what the condition of M adds to the relative error of each ω².
struct Pairs {
    squares: Vec<f64>,
    shapes: Mat<f64>,
    spoiled: Vec<f64>,
}

impl Pairs {
    /// Of shapes X with XᵀMX = I. In units in which M has 1 on its diagonal, rounding of M moves each ω² by as much as
    /// ‖M‖‖M⁻¹‖ allows, M⁻¹ being XXᵀ, and that of K by ‖K‖‖x‖².
    fn of(mass: &Mat<f64>, stiffness: &Mat<f64>, (squares, shapes): (Vec<f64>, Mat<f64>)) -> Pairs {
        const UNITS: f64 = 4.0 * f64::EPSILON;
        let own: Vec<f64> = (0..mass.nrows()).map(|i| mass[(i, i)]).collect();
        let norm = |matrix: &Mat<f64>| {
            let column = |(column, by): (ColRef<'_, f64>, &f64)| -> f64 {
                let each = column.iter().zip(&own);
                each.map(|(entry, own)| (entry / own) * (entry / by)).sum()
            };
            let columns = matrix.col_iter().zip(&own).map(column);
            columns.sum::<f64>().sqrt()
        };
        let size = |x: ColRef<'_, f64>| -> f64 {
            let each = x.iter().zip(&own);
            each.map(|(x, own)| own * x * x).sum()
        };
        let sizes: Vec<f64> = shapes.col_iter().map(size).collect();
        let inverse: f64 = sizes.iter().sum();
        let (mass, stiffness) = (norm(mass), norm(stiffness));
        let each = squares.iter().zip(&sizes);
        let spoiled = each.map(|(square, size)| {
            let of_stiffness = stiffness / square.abs() * size;
            UNITS * (mass * inverse + of_stiffness)
        });
        Pairs {
            spoiled: spoiled.collect(),
            squares,
            shapes,
        }
    }
}

/// Of M^{-1/2} K M^{-1/2}.
fn lumped_modes(
    solver: &dyn ModeSolver,
    system: &System,
    masses: &[f64],
) -> Result<Pairs, ModesError> {
    let n = system.len();
    let roots: Vec<f64> = masses.iter().map(|mass| mass.sqrt()).collect();
    let stiffness = system.stiffness_matrix();
    let scaled = Mat::from_fn(n, n, |i, j| stiffness[(i, j)] / roots[i] / roots[j]);
    let (squares, vectors) = eigen(solver, &scaled, None)?;
    let shapes = Mat::from_fn(n, n, |i, j| vectors[(i, j)] / roots[i]);
    Ok(Pairs {
        spoiled: vec![0.0; squares.len()],
        squares,
        shapes,
    })
}

/// Of L⁻¹KL⁻ᵀ, K without the coordinates that have no mass.
fn assembled_modes(solver: &dyn ModeSolver, system: &System) -> Result<Pairs, ModesError> {
    let massless = !system.structure().massless().is_empty();
    let mut mass = massive_block(system);
    let nf = mass.nrows();
    // Units in which every mass on the diagonal is about 1, so that rotations beside translations cost no digits.
    let unit = |i: usize| match mass[(i, i)] {
        own if own > 0.0 && !massless => (-0.5 * own.log2()).round().exp2(),
        _ => 1.0,
    };
    let units: Vec<f64> = (0..nf).map(unit).collect();
    let in_units = |matrix: &mut Mat<f64>, columns: bool| {
        for (j, column) in matrix.col_iter_mut().enumerate() {
            let unit = if columns { units[j] } else { 1.0 };
            let each = column.iter_mut().zip(&units);
            each.for_each(|(entry, own)| *entry *= own * unit);
        }
    };
    in_units(&mut mass, true);
    if !massless {
        let mut stiffness = system.stiffness_matrix();
        in_units(&mut stiffness, true);
        let found = eigen(solver, &stiffness, Some(&mass))?;
        let mut found = Pairs::of(&mass, &stiffness, found);
        in_units(&mut found.shapes, false);
        return Ok(found);
    }
    let form = FirstOrder::of(system)?;
    // A₂₁ = −M⁻¹K.
    let stiffness = -product(mass.as_ref(), form.a().submatrix(nf, 0, nf, nf));
    let found = eigen(solver, &stiffness, Some(&mass))?;
    let mut found = Pairs::of(&mass, &stiffness, found);
    let extended = form.x().submatrix(0, 0, system.len(), nf);
    found.shapes = product(extended, found.shapes.as_ref());
    Ok(found)
}

/// Eigenvalues and eigenvectors of a symmetric K, with M or with masses of 1.
fn eigen(
    solver: &dyn ModeSolver,
    stiffness: &Mat<f64>,
    mass: Option<&Mat<f64>>,
) -> Result<(Vec<f64>, Mat<f64>), ModesError> {
    let method = solver.name();
    if !stiffness.norm_max().is_finite() {
        return Err(ModesError::OutOfRange { method });
    }
    let found = match mass {
        Some(mass) => quick_definite_eigen(stiffness, mass),
        None => quick_symmetric_eigen(stiffness),
    };
    found.ok_or(ModesError::NoConvergence { method })
}
