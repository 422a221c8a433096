//! Modes of the whole equation from those that were found without damping.

use faer::Mat;

use super::SparseModes;
use super::answer::{Answer, NOT_COUNTED, Root};
use super::coupled::coupled;
use super::error::SparseError;
use super::form::Form;
use super::judge::Judge;
use super::proportional::proportional;
use super::undamped::{Facts, Undamped};
use crate::modes::{Bounds, Mode, ModePlan, Modes, listed, sort};
use crate::solver::ModesError;
use crate::structure::rayleigh::Proportion;
use crate::system::System;

/// The modes of the whole equation.
pub(crate) fn modes(sparse: &SparseModes, damping: &Form) -> Result<Modes, SparseError> {
    let (found, pencil) = (&sparse.found, &*sparse.pencil);
    let (answer, solver) = match uncoupled(found, damping) {
        Some(answer) => (answer, "sparse Lanczos"),
        None => (coupled(found, pencil, damping)?, "sparse Arnoldi"),
    };
    let counted = how_counted(&answer.complete, solver == "sparse Arnoldi");
    let count = found.facts.count;
    let plan = ModePlan {
        solver,
        reason: "some modes, without dense matrices".to_owned(),
        bounds: "estimated from residuals".to_owned(),
        left_out: vec![("other modes", format!("{count} were asked for; {counted}"))],
        incomplete: answer.complete.err(),
    };
    let forms = [&pencil.mass, damping, &pencil.stiffness];
    Ok(judged(answer.roots, forms, &found.facts, plan))
}

/// Whether some are missing, and how that was counted.
pub(crate) fn how_counted(complete: &Result<(), &'static str>, couples: bool) -> &'static str {
    match (complete, couples) {
        (Ok(()), false) => "the signs of pivots prove that none between them is missing",
        (Ok(()), true) => {
            "the turns of the determinant about a circle prove that none between them is missing"
        }
        (Err(_), _) => "that none between them is missing is not proved",
    }
}

/// Roots of damping that couples no shapes; `None` of any other.
pub(crate) fn uncoupled(found: &Undamped, damping: &Form) -> Option<Answer> {
    if damping.is_zero() {
        return Some(Answer {
            roots: found.roots(),
            complete: found.counted.map(drop).ok_or(NOT_COUNTED),
        });
    }
    let proportion = found.facts.proportion?;
    Some(proportional(found, proportion))
}

/// Roots with their residuals and conditions in the whole equation.
pub(crate) fn judged(roots: Vec<Root>, forms: [&Form; 3], facts: &Facts, plan: ModePlan) -> Modes {
    let judge = Judge::of(forms);
    let mut modes: Vec<Mode> = roots
        .into_iter()
        .map(|root| judge.mode(root, &facts.names))
        .collect();
    sort(&mut modes);
    let n = forms[0].len();
    Modes {
        eigenvalues: listed(&modes),
        modes,
        infinite: facts.finite.map_or(0, |finite| 2 * n - finite),
        bounds: Bounds::Estimated,
        complete: plan.incomplete.is_none(),
        plan,
    }
}

/// The projected equation.
pub(crate) fn reduced(found: &Undamped, damping: &Form) -> Result<System, ModesError> {
    let count = found.squares.len();
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
