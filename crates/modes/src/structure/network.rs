//! A symmetric matrix read as a network: node i is joined to node j by −A_ij and to the ground by
//! the sum of row i. Built from springs, it gives them back, parallel ones added up; a matrix that
//! was given whole is read in the same way.

use std::cmp::Ordering;

use crate::exact::matrix::ExactMatrix;
use crate::exact::sum::ExactSum;

/// Which nodes are joined, by exact sums that are not 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Network {
    joins: Vec<(usize, usize)>,
    grounded: Vec<bool>,
    non_negative: bool,
}

impl Network {
    /// Of a symmetric matrix.
    pub(crate) fn of(matrix: &ExactMatrix) -> Network {
        let n = matrix.len();
        let mut network = Network {
            joins: Vec::new(),
            grounded: vec![false; n],
            non_negative: true,
        };
        for i in 0..n {
            for (j, terms) in matrix.row(i) {
                if j > i {
                    network.joins.push((i, j));
                    network.non_negative =
                        network.non_negative && ExactSum::sign_of(terms) == Ordering::Less;
                }
            }
            let ground = ExactSum::sign_of(matrix.row_terms(i));
            network.grounded[i] = ground != Ordering::Equal;
            network.non_negative &= ground != Ordering::Less;
        }
        network
    }

    /// Whether no join is negative. Then the matrix is positive semidefinite, and x with A x = 0
    /// are exactly those that are constant on each floating part and 0 elsewhere.
    pub(crate) fn is_non_negative(&self) -> bool {
        self.non_negative
    }

    /// Whether node `i` has a join to the ground.
    pub(crate) fn is_grounded(&self, i: usize) -> bool {
        self.grounded[i]
    }

    /// How many nodes there are besides the ground.
    pub(crate) fn len(&self) -> usize {
        self.grounded.len()
    }

    /// The joins between nodes, each once.
    pub(crate) fn joins(&self) -> &[(usize, usize)] {
        &self.joins
    }
}
