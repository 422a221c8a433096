//! Undamped modes as they were found, with what is proved of their system.

use eigentone_digits::sort_by_number;
use faer::Mat;
use num_complex::Complex;

use super::answer::Root;
use super::refine::Pair;
use crate::model::Names;
use crate::modes::Repeats;
use crate::structure::rayleigh::Proportion;
use crate::system::System;

/// What was asked for, and what is proved of the system.
#[derive(Clone, Debug)]
pub(crate) struct Facts {
    pub(crate) names: Names,
    pub(crate) target: f64,
    pub(crate) count: usize,
    /// Parts without mass that no spring ties to the ground.
    pub(crate) idle: Vec<Vec<usize>>,
    pub(crate) passive: bool,
    /// M ⪰ 0.
    pub(crate) has_sound_mass: bool,
    /// K ⪰ 0, but for what lies far from the target.
    pub(crate) semidefinite: bool,
    pub(crate) proportion: Option<Proportion>,
    pub(crate) zero_roots: Option<usize>,
    /// How many motions K lets go on without force.
    pub(crate) rigid: Option<usize>,
    /// How many roots are finite.
    pub(crate) finite: Option<usize>,
}

/// Eigenvalues ω² of K x = ω² M x with their shapes.
#[derive(Clone, Debug)]
pub(crate) struct Undamped {
    pub(crate) squares: Vec<f64>,
    pub(crate) errors: Vec<Option<f64>>,
    pub(crate) shapes: Mat<f64>,
    /// How many, with those that are not here, each is not separated from.
    pub(crate) clusters: Vec<usize>,
    /// Between which ω² the signs of pivots prove that none is missing.
    pub(crate) counted: Option<[f64; 2]>,
    pub(crate) facts: Facts,
}

impl Facts {
    /// What is proved of a system, with nothing asked for.
    pub(crate) fn of(system: &System) -> Facts {
        let structure = system.structure();
        Facts {
            names: system.coordinate_names().clone(),
            target: 0.0,
            count: 0,
            idle: Vec::new(),
            passive: structure.is_passive(),
            has_sound_mass: false,
            semidefinite: false,
            proportion: structure.proportion(),
            zero_roots: structure.zero_roots(),
            rigid: (!structure.is_large())
                .then(|| structure.rigid_motions_counted())
                .flatten(),
            finite: structure.finite_roots(),
        }
    }
}

impl Undamped {
    /// Those nearest to the target, as many as are wanted, rising.
    pub(crate) fn nearest(
        mut pairs: Vec<Pair>,
        counted: Option<[f64; 2]>,
        facts: Facts,
        n: usize,
    ) -> Undamped {
        let apart = |pair: &Pair| (pair.square.abs().sqrt() - facts.target).abs();
        sort_by_number(&mut pairs, apart);
        let clusters = clusters(&pairs);
        let mut clustered: Vec<(Pair, usize)> = pairs.into_iter().zip(clusters).collect();
        clustered.truncate(facts.count);
        sort_by_number(&mut clustered, |(pair, _)| pair.square);
        let (pairs, clusters): (Vec<Pair>, Vec<usize>) = clustered.into_iter().unzip();
        Undamped {
            squares: pairs.iter().map(|pair| pair.square).collect(),
            errors: pairs.iter().map(|pair| pair.error).collect(),
            shapes: Mat::from_fn(n, pairs.len(), |i, j| pairs[j].shape[i]),
            clusters,
            counted,
            facts,
        }
    }

    /// Whether a mode is separated from all others.
    pub(crate) fn repeats(&self, k: usize) -> Repeats {
        match self.clusters[k] {
            1 => Repeats::SIMPLE,
            count if self.counted.is_some() => Repeats::Cluster(count),
            count => Repeats::AtLeast(count),
        }
    }

    /// As roots of the whole equation without damping.
    pub(crate) fn roots(&self) -> Vec<Root> {
        let rigid = self.squares.iter().filter(|square| **square == 0.0).count();
        let mut roots = Vec::new();
        let mut listed = false;
        for (k, (&square, error)) in self.squares.iter().zip(&self.errors).enumerate() {
            let zeros = vec![0.0; self.shapes.nrows()];
            let shape = [self.shapes.col(k).iter().copied().collect(), zeros];
            let size = square.abs().sqrt();
            // Where ω² is not distinguished from 0, its root is 0 within that of the bound.
            let unclear = error.is_some_and(|error| square.abs() <= error);
            let error = error.map(|error| match unclear {
                true => (square.abs() + error).sqrt(),
                false => {
                    let least = (square.abs() - error).max(0.0).sqrt();
                    error / (size + least) + f64::EPSILON / 2.0 * size
                }
            });
            let root = |value, error, roots| Root {
                value,
                error,
                shape: shape.clone(),
                repeats: match roots {
                    1 => self.repeats(k),
                    count if error == Some((0.0, 0.0)) => Repeats::Exactly {
                        count: self.facts.zero_roots.unwrap_or(count),
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
}

/// Of each, how many there are that its error does not separate it from, itself included.
fn clusters(pairs: &[Pair]) -> Vec<usize> {
    const UNKNOWN: f64 = 1e-3;
    let error = |pair: &Pair| pair.error.unwrap_or(UNKNOWN * pair.square.abs());
    let near = |a: &Pair, b: &Pair| (a.square - b.square).abs() <= error(a) + error(b);
    let count = |a: &Pair| pairs.iter().filter(|b| near(a, b)).count();
    pairs.iter().map(count).collect()
}
