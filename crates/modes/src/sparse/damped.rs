//! Modes of the whole equation from those that were found without damping.

use faer::Mat;
use num_complex::Complex;

use super::SparseModes;
use super::answer::{Answer, NOT_COUNTED, Root, told};
use super::coupled::coupled;
use super::error::SparseError;
use super::form::Form;
use super::judge::Judge;
use super::proportional::proportional;
use crate::modes::{Bounds, Mode, ModePlan, Modes, Repeats, listed, order};
use crate::solver::ModesError;
use crate::structure::rayleigh::Proportion;
use crate::system::System;

/// The modes of the whole equation.
pub(crate) fn modes(found: &SparseModes, damping: &Form) -> Result<Modes, SparseError> {
    let answer = if damping.is_zero() {
        Answer {
            roots: undamped(found),
            complete: found.counted.map(drop).ok_or(NOT_COUNTED),
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
        complete: answer.complete.is_ok(),
        plan: plan(found, damping, answer.complete),
    })
}

fn plan(found: &SparseModes, damping: &Form, complete: Result<(), &'static str>) -> ModePlan {
    let count = found.facts.count;
    let proportional = damping.is_zero() || found.facts.proportion.is_some();
    let counted = match (complete, proportional) {
        (Ok(()), true) => "the signs of pivots prove that none between them is missing",
        (Ok(()), false) => {
            "the turns of the determinant about a circle prove that none between them is missing"
        }
        (Err(_), _) => "that none between them is missing is not proved",
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
        incomplete: complete.err(),
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
