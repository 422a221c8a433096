//! Undamped modes where doubles and double-doubles lose them: Jacobi's rotations of L⁻¹KL⁻ᵀ in 384 bits.

use eigentone_digits::{DoubleDouble, Real, sort_by_number};

use crate::linear::wide::{Number, Rows, is_definite, pairs, solve};
use crate::model::MatrixKind;
use crate::quality::real_forms::RealForms;
use crate::system::{Condensed, System, dense};

use super::real_mode::RealMode;

/// More coordinates take more than some tenths of a second.
const MOST: usize = 32;

/// Whether M is positive definite but for coordinates without mass that springs hold.
pub(super) fn has_modes(system: &System) -> bool {
    system.len() <= MOST
        && Condensed::<Number>::of(system.model())
            .is_some_and(|condensed| is_definite(&condensed.mass))
}

/// All of them by rising |ω²|, of which so many are rigid; their forms are those of the shapes before they are rounded. `None` where
/// there are too many coordinates, M is not positive definite, or even these digits do not do.
pub(super) fn undamped_modes(system: &System, rigid: usize) -> Option<Vec<RealMode>> {
    const KNOWN: f64 = 1e-16;
    let n = system.len();
    if n > MOST {
        return None;
    }
    let condensed = Condensed::<Number>::of(system.model())?;
    let (squares, forces) = pairs(&condensed.mass, &condensed.stiffness)?;
    let count = squares.len();
    let columns: Rows<Number> = (0..count)
        .map(|i| forces.iter().map(|force| force[i]).collect())
        .collect();
    // X = M⁻¹(MX), by rows.
    let massive = solve(condensed.mass.clone(), columns)?;
    let damping = dense::<Number>(system.model(), MatrixKind::Damping);
    let mut modes = Vec::with_capacity(count);
    for (j, &square) in squares.iter().enumerate() {
        let mut shape = vec![Number::ZERO; n];
        for (row, i) in massive.iter().zip(&condensed.massive) {
            shape[*i] = row[j];
        }
        for (row, i) in condensed.follow.iter().zip(&condensed.massless) {
            let each = row.iter().zip(&massive);
            shape[*i] = each.fold(Number::ZERO, |sum, (follow, x)| sum - *follow * x[j]);
        }
        let larger = |a: Number, b: &Number| if b.abs() > a.abs() { *b } else { a };
        let unit = Number::from(1.0) / shape.iter().fold(Number::ZERO, larger);
        shape.iter_mut().for_each(|x| *x = *x * unit);
        let mass = unit * unit;
        let resisted = shape.iter().zip(&damping).map(|(x, row)| {
            let each = row.iter().zip(&shape);
            *x * each.fold(Number::ZERO, |sum, (c, y)| sum + *c * *y)
        });
        let resisted = resisted.fold(Number::ZERO, |sum, share| sum + share);
        let short = |x: Number| {
            let high = x.to_f64();
            DoubleDouble::new(high, (x - Number::from(high)).to_f64())
        };
        let forms = RealForms {
            m: short(mass),
            c: short(resisted),
            k: short(mass * square),
            rounding: [0.0; 3],
        };
        let square = square.to_f64();
        modes.push(RealMode {
            square,
            shape: shape.iter().map(|x| x.to_f64()).collect(),
            forms,
            rigid: false,
            doubt: left(&condensed, &massive, &squares, j),
            quality: None,
            is_exact: true,
        });
    }
    sort_by_number(&mut modes, |mode| mode.square.abs());
    for mode in modes.iter_mut().take(rigid) {
        (mode.square, mode.doubt, mode.rigid) = (0.0, 0.0, true);
        mode.forms.k = DoubleDouble::ZERO;
    }
    let is_known = |mode: &RealMode| {
        let sizes = [mode.square, mode.forms.m.to_f64(), mode.forms.c.to_f64()];
        mode.doubt <= KNOWN && sizes.iter().chain(&mode.shape).all(|x| x.is_finite())
    };
    modes.iter().all(is_known).then_some(modes)
}

/// How far ω² may be off, relative: an eigenvalue lies within the length of the residual r = Kx − ω²Mx by M⁻¹ = XXᵀ, where
/// xᵀMx = 1 (Parlett, *The Symmetric Eigenvalue Problem*, §15.9).
fn left(condensed: &Condensed<Number>, x: &Rows<Number>, squares: &[Number], j: usize) -> f64 {
    let dot = |row: &[Number], of: &dyn Fn(usize) -> Number| {
        let each = row.iter().enumerate();
        each.fold(Number::ZERO, |sum, (i, entry)| sum + *entry * of(i))
    };
    let count = squares.len();
    let column = |i: usize| x[i][j];
    let inertia: Vec<Number> = condensed.mass.iter().map(|row| dot(row, &column)).collect();
    let residual: Vec<Number> = condensed
        .stiffness
        .iter()
        .zip(&inertia)
        .map(|(row, inertia)| dot(row, &column) - squares[j] * *inertia)
        .collect();
    let along = |k: usize| (0..count).fold(Number::ZERO, |sum, i| sum + x[i][k] * residual[i]);
    let length = (0..count).map(along);
    let length = length.fold(Number::ZERO, |sum, part| sum + part * part);
    let mass = (0..count).fold(Number::ZERO, |sum, i| sum + x[i][j] * inertia[i]);
    (length.sqrt() / (squares[j] * mass).abs()).to_f64()
}
