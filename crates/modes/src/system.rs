//! A linear vibrating system: its elements, and M, C, K assembled from them.

use std::sync::{Arc, OnceLock};

use faer::sparse::{SparseColMat, SparseColMatRef};
use faer::{Mat, MatRef};

use crate::builder::{BuildError, MAX_DENSE_COORDINATES, SystemBuilder};
use crate::element::{Element, MatrixKind, Node};
use crate::modes::{Modes, Precision};
use crate::solver::{self, ModesError};
use crate::structure::Structure;
use eigentone_digits::DoubleDouble;

/// A linear vibrating system M x″ + C x′ + K x = f(t) with n coordinates, checked and immutable.
///
/// It keeps the elements it was built from. A spring of 1 beside one of 1e20 is lost as soon as K
/// is assembled in doubles, while every natural frequency is well determined by the springs and
/// masses themselves; solvers therefore work from the elements where they can.
#[derive(Clone, Debug)]
pub struct System {
    names: Arc<[String]>,
    masses: Vec<f64>,
    springs: Vec<Element>,
    dampers: Vec<Element>,
    added: Added,
    /// The coordinates by their names, sorted when first asked for.
    by_name: Arc<OnceLock<Vec<u32>>>,
    /// Proved when first asked for; clones share it.
    structure: Arc<OnceLock<Structure>>,
}

/// Matrices added to the elements: dense where the system is small, sparse where it is large.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    pub(crate) dense: [Option<Mat<f64>>; 3],
    pub(crate) sparse: [Option<Arc<SparseColMat<usize, f64>>>; 3],
}

impl From<[Option<Mat<f64>>; 3]> for Added {
    fn from(dense: [Option<Mat<f64>>; 3]) -> Added {
        Added {
            dense,
            ..Added::default()
        }
    }
}

impl System {
    /// Starts a system from named masses, springs, dampers and matrices.
    pub fn builder() -> SystemBuilder {
        SystemBuilder::default()
    }

    /// A system given by its three n × n matrices, with coordinates x1, x2, ….
    ///
    /// # Errors
    /// [`BuildError`] where shapes disagree, an entry is not finite, or the system is singular.
    pub fn from_matrices(
        mass: MatRef<'_, f64>,
        damping: MatRef<'_, f64>,
        stiffness: MatRef<'_, f64>,
    ) -> Result<System, BuildError> {
        System::builder()
            .matrix(MatrixKind::Mass, mass)
            .matrix(MatrixKind::Damping, damping)
            .matrix(MatrixKind::Stiffness, stiffness)
            .build()
    }

    pub(crate) fn assemble(
        names: Vec<String>,
        masses: Vec<f64>,
        springs: Vec<Element>,
        dampers: Vec<Element>,
        added: impl Into<Added>,
    ) -> System {
        System {
            names: names.into(),
            masses,
            springs,
            dampers,
            added: added.into(),
            by_name: Arc::default(),
            structure: Arc::default(),
        }
    }

    /// The number n of coordinates.
    #[allow(clippy::len_without_is_empty)] // a system is never empty
    pub fn len(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn shared_names(&self) -> &Arc<[String]> {
        &self.names
    }

    /// The names of the coordinates, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The index of the coordinate `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        let by_name = self.by_name.get_or_init(|| {
            let mut order: Vec<u32> = (0..self.names.len() as u32).collect();
            order.sort_unstable_by_key(|&i| self.names[i as usize].as_str());
            order
        });
        let at = |i: &u32| self.names[*i as usize].as_str();
        let place = by_name.binary_search_by(|i| at(i).cmp(name)).ok()?;
        Some(by_name[place] as usize)
    }

    /// The lumped mass on each coordinate, in kg; an added mass matrix is not included.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// The springs, in the order given.
    pub fn springs(&self) -> &[Element] {
        &self.springs
    }

    /// The dampers, in the order given.
    pub fn dampers(&self) -> &[Element] {
        &self.dampers
    }

    /// Whether there are more than [`MAX_DENSE_COORDINATES`] coordinates: then only
    /// [`SparseModes`](crate::SparseModes) and what builds on them apply.
    pub fn is_large(&self) -> bool {
        self.len() > MAX_DENSE_COORDINATES
    }

    /// The matrix that was added to the elements, if any; of a [large](Self::is_large) system it is
    /// [sparse](Self::added_sparse) instead.
    pub fn added(&self, kind: MatrixKind) -> Option<MatRef<'_, f64>> {
        self.added.dense[kind as usize].as_ref().map(Mat::as_ref)
    }

    /// The matrix that was added to the elements of a [large](Self::is_large) system, if any.
    pub fn added_sparse(&self, kind: MatrixKind) -> Option<SparseColMatRef<'_, usize, f64>> {
        let matrix = self.added.sparse[kind as usize].as_ref()?;
        Some(matrix.as_ref().as_ref())
    }

    /// M (n × n, kg): the lumped masses and the added mass matrix, each entry summed in
    /// double-double and rounded once.
    pub fn mass_matrix(&self) -> Mat<f64> {
        let lumped = self.masses.iter().enumerate();
        let diagonal: Vec<Element> = lumped
            .filter(|(_, mass)| **mass != 0.0)
            .map(|(i, mass)| Element {
                first: Node::Ground,
                second: Node::Coordinate(i),
                coefficient: *mass,
            })
            .collect();
        self.sum(&diagonal, MatrixKind::Mass)
    }

    /// C (n × n, N·s/m), summed as [`mass_matrix`](Self::mass_matrix) is.
    pub fn damping_matrix(&self) -> Mat<f64> {
        self.sum(&self.dampers, MatrixKind::Damping)
    }

    /// K (n × n, N/m), summed as [`mass_matrix`](Self::mass_matrix) is.
    pub fn stiffness_matrix(&self) -> Mat<f64> {
        self.sum(&self.springs, MatrixKind::Stiffness)
    }

    fn sum(&self, elements: &[Element], kind: MatrixKind) -> Mat<f64> {
        let n = self.len();
        let mut total = match &self.added.dense[kind as usize] {
            Some(matrix) => matrix.clone(),
            None => Mat::zeros(n, n),
        };
        let mut low = Mat::<f64>::zeros(n, n);
        let mut add = |i: usize, j: usize, value: f64| {
            let sum = DoubleDouble::new(total[(i, j)], low[(i, j)]) + value;
            (total[(i, j)], low[(i, j)]) = (sum.high(), sum.low());
        };
        for element in elements {
            for (end, other) in [
                (element.first, element.second),
                (element.second, element.first),
            ] {
                let Node::Coordinate(i) = end else { continue };
                add(i, i, element.coefficient);
                if let Node::Coordinate(j) = other {
                    add(i, j, -element.coefficient);
                }
            }
        }
        total
    }

    /// What can be proved of the system from its parameters alone, in exact arithmetic. Proved when
    /// first asked for, and remembered.
    pub fn structure(&self) -> &Structure {
        self.structure.get_or_init(|| Structure::of(self))
    }

    /// Natural frequencies, damping ratios and mode shapes with proven bounds, by the solver that
    /// the [plan](crate::ModePlan) picks: [`modes_to`](Self::modes_to) with the default precision.
    ///
    /// # Errors
    /// [`ModesError`] where no solver reaches an answer.
    pub fn modes(&self) -> Result<Modes, ModesError> {
        self.modes_to(Precision::default())
    }

    /// Modes to the given precision. Where a proof is not reached, the answer has estimated bounds
    /// and its plan says why.
    ///
    /// # Errors
    /// [`ModesError`] where no solver reaches an answer.
    pub fn modes_to(&self, precision: Precision) -> Result<Modes, ModesError> {
        solver::solve(self, precision)
    }
}
