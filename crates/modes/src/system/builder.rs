//! From named parameters to a checked [`System`].

use std::collections::HashMap;
use std::sync::Arc;

use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatRef};
use thiserror::Error;

use super::System;
use super::places::{self, Places};
use crate::model::{
    Added, ElementKind, GROUND, MAX_COORDINATES, MAX_DENSE_COORDINATES, MatrixKind, Model,
};
use crate::structure::determinant;

const KINDS: [MatrixKind; 3] = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];

/// Collects masses, points, supports, springs, dampers and matrices by name; [`build`](SystemBuilder::build) checks
/// them and returns the [`System`]. Made by [`System::builder`].
///
/// ```
/// use eigentone_modes::{GROUND, System};
///
/// let system = System::builder()
///     .mass("m1", 2.0)
///     .mass("m2", 1.0)
///     .spring(GROUND, "m1", 2.0)
///     .spring("m1", "m2", 0.2)
///     .damper("m1", "m2", 2.0)
///     .build()?;
/// assert_eq!(system.len(), 2);
/// # Ok::<(), eigentone_modes::BuildError>(())
/// ```
#[derive(Clone, Debug, Default)]
#[must_use = "a builder does nothing until `build` is called"]
pub struct SystemBuilder {
    masses: Vec<(String, f64)>,
    points: Vec<GivenPoint>,
    supports: Vec<String>,
    elements: Vec<Joint>,
    matrices: Vec<(MatrixKind, Entries)>,
}

/// A point as it was given.
#[derive(Clone, Debug)]
pub(super) struct GivenPoint {
    pub(super) name: String,
    pub(super) moves: Vec<(String, f64)>,
    pub(super) mass: f64,
}

/// A spring or a damper as it was given.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) kind: ElementKind,
    pub(super) ends: [String; 2],
    pub(super) coefficient: f64,
    pub(super) name: Option<String>,
}

/// A matrix as it was given.
#[derive(Clone, Debug)]
enum Entries {
    Dense(Mat<f64>),
    Sparse(SparseColMat<usize, f64>),
}

impl SystemBuilder {
    /// Adds a coordinate `name` with a mass in kg (or an inertia in kg·m²). A mass of 0 makes a
    /// massless node. The order of calls is the order of the coordinates.
    pub fn mass(mut self, name: impl Into<String>, mass: f64) -> Self {
        self.masses.push((name.into(), mass));
        self
    }

    /// Adds a point that moves with masses and supports: its displacement is the sum of each one's, times the number
    /// given with its name. Levers, rigid bodies, gears, belts and inclined springs are points. A `mass` in kg moves with
    /// it. Springs, dampers, loads and outputs take its name like any other.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    ///
    /// // A beam that heaves and pitches on two springs, 1 m before and 2 m behind its centre of mass.
    /// let system = System::builder()
    ///     .mass("heave", 1000.0)
    ///     .mass("pitch", 1200.0)
    ///     .point("front", [("heave", 1.0), ("pitch", -1.0)], 0.0)
    ///     .point("rear", [("heave", 1.0), ("pitch", 2.0)], 0.0)
    ///     .spring(GROUND, "front", 2e4)
    ///     .spring(GROUND, "rear", 1e4)
    ///     .build()?;
    /// assert_eq!(system.stiffness_matrix()[(0, 1)], 0.0);
    /// assert_eq!(system.stiffness_matrix()[(1, 1)], 6e4);
    /// # Ok::<(), eigentone_modes::BuildError>(())
    /// ```
    pub fn point<N: Into<String>>(
        mut self,
        name: impl Into<String>,
        moves: impl IntoIterator<Item = (N, f64)>,
        mass: f64,
    ) -> Self {
        let moves = moves.into_iter().map(|(name, times)| (name.into(), times));
        self.points.push(GivenPoint {
            name: name.into(),
            moves: moves.collect(),
            mass,
        });
        self
    }

    /// Adds a support: a place whose motion is prescribed. In modes it stands still; a response gives it a motion.
    pub fn support(mut self, name: impl Into<String>) -> Self {
        self.supports.push(name.into());
        self
    }

    /// Joins two different nodes by a spring of stiffness in N/m; [`GROUND`], a point or a support may be one of them.
    /// Parallel springs add up. A negative stiffness is allowed.
    pub fn spring(
        self,
        first: impl Into<String>,
        second: impl Into<String>,
        stiffness: f64,
    ) -> Self {
        self.join(
            ElementKind::Spring,
            [first.into(), second.into()],
            stiffness,
        )
    }

    /// Joins two different nodes by a damper of damping in N·s/m; [`GROUND`], a point or a support may be one of them.
    /// Parallel dampers add up. A negative damping is allowed.
    pub fn damper(self, first: impl Into<String>, second: impl Into<String>, damping: f64) -> Self {
        self.join(ElementKind::Damper, [first.into(), second.into()], damping)
    }

    fn join(mut self, kind: ElementKind, ends: [String; 2], coefficient: f64) -> Self {
        self.elements.push(Joint {
            kind,
            ends,
            coefficient,
            name: None,
        });
        self
    }

    /// Names the spring or damper given last, so that outputs and sensitivities can ask for it. Where none was given,
    /// nothing is named.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        if let Some(last) = self.elements.last_mut() {
            last.name = Some(name.into());
        }
        self
    }

    /// Adds a whole mass, damping or stiffness matrix (n × n) to what the elements give; a second
    /// matrix of the same kind replaces the first. Without any [`mass`](Self::mass) the
    /// coordinates are named x1, x2, ….
    pub fn matrix(self, kind: MatrixKind, entries: MatRef<'_, f64>) -> Self {
        self.replace(kind, Entries::Dense(entries.to_owned()))
    }

    /// The same with a sparse matrix, whose entries that are not stored are 0.
    pub fn sparse_matrix(self, kind: MatrixKind, entries: SparseColMat<usize, f64>) -> Self {
        self.replace(kind, Entries::Sparse(entries))
    }

    fn replace(mut self, kind: MatrixKind, entries: Entries) -> Self {
        self.matrices.retain(|(present, _)| *present != kind);
        self.matrices.push((kind, entries));
        self
    }

    /// Checks everything and returns the system.
    ///
    /// # Errors
    /// A [`BuildError`] naming the first thing that is wrong.
    pub fn build(self) -> Result<System, BuildError> {
        let (names, masses) = self.coordinates()?;
        let n = names.len();
        let places = Places::of(&names, self.points, self.supports)?;
        let joined = places::join(&places, self.elements)?;

        let mut added = joined.squares.map(|squares| Added {
            squares,
            ..Added::default()
        });
        for (kind, matrix) in self.matrices {
            matrix.check(kind, n)?;
            let added = &mut added[kind as usize];
            added.is_given = true;
            if n > MAX_DENSE_COORDINATES {
                added.sparse = Some(Arc::new(matrix.sparse()));
            } else {
                added.dense = Some(matrix.dense());
            }
        }
        for (added, terms) in added.iter_mut().zip(joined.terms) {
            added.add(n, terms);
        }
        let mut model = Model::new(names, masses, joined.springs, joined.dampers, added);
        if let Some(machine) = joined.machine {
            model = model.with_machine(machine);
        }
        for kind in KINDS {
            if let Some((row, column)) = overflow(&model, kind) {
                return Err(BuildError::Overflow { kind, row, column });
            }
        }
        if determinant::vanishes(&model) {
            return Err(BuildError::Singular);
        }
        Ok(model.into())
    }

    /// Names and masses of the coordinates, from the masses or else from the matrices' order.
    fn coordinates(&self) -> Result<(Vec<String>, Vec<f64>), BuildError> {
        if self.masses.is_empty() {
            let n = match self.matrices.first() {
                Some((kind, matrix)) => match matrix.shape() {
                    (rows, columns) if rows != columns => {
                        return Err(BuildError::MatrixShape {
                            kind: *kind,
                            rows,
                            columns,
                            expected: rows.max(columns),
                        });
                    }
                    (rows, _) => rows,
                },
                None => 0,
            };
            check_count(n)?;
            return Ok(((1..=n).map(|i| format!("x{i}")).collect(), vec![0.0; n]));
        }
        check_count(self.masses.len())?;
        let mut seen = HashMap::new();
        for (index, (name, mass)) in self.masses.iter().enumerate() {
            if name.is_empty() {
                return Err(BuildError::EmptyName { index });
            }
            if name == GROUND {
                return Err(BuildError::ReservedName { index });
            }
            if let Some(first) = seen.insert(name, index) {
                return Err(BuildError::DuplicateName {
                    name: name.clone(),
                    first,
                    second: index,
                });
            }
            if mass.is_nan() || *mass < 0.0 || mass.is_infinite() {
                return Err(BuildError::InvalidMass {
                    index,
                    name: name.clone(),
                    value: *mass,
                });
            }
        }
        Ok(self
            .masses
            .iter()
            .map(|(name, mass)| (name.clone(), mass.abs()))
            .unzip())
    }
}

fn check_count(n: usize) -> Result<(), BuildError> {
    match n {
        0 => Err(BuildError::Empty),
        n if n > MAX_COORDINATES => Err(BuildError::TooLarge { count: n }),
        _ => Ok(()),
    }
}

impl Entries {
    fn shape(&self) -> (usize, usize) {
        match self {
            Entries::Dense(matrix) => (matrix.nrows(), matrix.ncols()),
            Entries::Sparse(matrix) => (matrix.nrows(), matrix.ncols()),
        }
    }

    fn check(&self, kind: MatrixKind, n: usize) -> Result<(), BuildError> {
        let (rows, columns) = self.shape();
        if rows != n || columns != n {
            return Err(BuildError::MatrixShape {
                kind,
                rows,
                columns,
                expected: n,
            });
        }
        let wrong = match self {
            Entries::Dense(matrix) => first_not_finite(matrix.as_ref()).map(|at| (at, matrix[at])),
            Entries::Sparse(matrix) => matrix
                .triplet_iter()
                .find(|entry| !entry.val.is_finite())
                .map(|entry| ((entry.row, entry.col), *entry.val)),
        };
        match wrong {
            Some(((row, column), value)) => Err(BuildError::MatrixNotFinite {
                kind,
                row,
                column,
                value,
            }),
            None => Ok(()),
        }
    }

    fn dense(self) -> Mat<f64> {
        match self {
            Entries::Dense(matrix) => matrix,
            Entries::Sparse(matrix) => matrix.to_dense(),
        }
    }

    fn sparse(self) -> SparseColMat<usize, f64> {
        match self {
            Entries::Sparse(matrix) => matrix,
            Entries::Dense(matrix) => {
                let n = matrix.nrows();
                let entries: Vec<_> = (0..n)
                    .flat_map(|j| (0..n).map(move |i| (i, j)))
                    .filter(|&at| matrix[at] != 0.0)
                    .map(|at| Triplet::new(at.0, at.1, matrix[at]))
                    .collect();
                SparseColMat::try_new_from_triplets(n, n, &entries)
                    .expect("indices are within the matrix they came from")
            }
        }
    }
}

/// An entry of an assembled matrix that is not finite. The matrix is not assembled where the sizes
/// of its terms show that none can be.
fn overflow(model: &Model, kind: MatrixKind) -> Option<(usize, usize)> {
    let mut sums = vec![0.0; model.len()];
    for term in model.terms(kind) {
        sums[term.row] += term.value.abs();
    }
    let row = sums.iter().position(|sum| !sum.is_finite())?;
    if model.is_large() {
        return Some((row, row));
    }
    first_not_finite(model.matrix(kind).as_ref())
}

fn first_not_finite(matrix: MatRef<'_, f64>) -> Option<(usize, usize)> {
    (0..matrix.nrows())
        .flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)))
        .find(|&at| !matrix[at].is_finite())
}

/// What can be wrong with the parameters of a system. Indices count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Neither masses nor matrices were given.
    #[error("the system has no coordinates: give at least one mass or a matrix")]
    Empty,
    /// More coordinates than [`MAX_COORDINATES`].
    #[error("{count} coordinates are more than the {MAX_COORDINATES} that a system may have")]
    TooLarge {
        /// How many were given.
        count: usize,
    },
    /// A mass has the empty name.
    #[error("the name of mass {index} is empty: give it a name")]
    EmptyName {
        /// Which mass.
        index: usize,
    },
    /// A mass is named like the ground.
    #[error(
        "mass {index} is named \"ground\", which is reserved for the fixed frame: choose another name"
    )]
    ReservedName {
        /// Which mass.
        index: usize,
    },
    /// Two masses share a name.
    #[error("masses {first} and {second} are both named {name:?}: names must differ")]
    DuplicateName {
        /// The shared name.
        name: String,
        /// The earlier mass.
        first: usize,
        /// The later mass.
        second: usize,
    },
    /// A mass is negative, infinite or NaN.
    #[error("the mass of {name:?} is {value:?}: it must be a finite number ≥ 0")]
    InvalidMass {
        /// Which mass.
        index: usize,
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A spring's stiffness or a damper's damping is infinite or NaN.
    #[error("the coefficient of {kind} {index} is {value:?}: it must be a finite number")]
    ElementNotFinite {
        /// Spring or damper.
        kind: ElementKind,
        /// Which of its kind.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// A spring or damper ends at a name that nothing has.
    #[error(
        "{kind} {index} ends at {name:?}, which is not a coordinate: known are {known} and ground"
    )]
    UnknownNode {
        /// Spring or damper.
        kind: ElementKind,
        /// Which of its kind.
        index: usize,
        /// The name that was not found.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A spring or damper has both ends at one node.
    #[error("{kind} {index} joins {name:?} to itself: its ends must differ")]
    SelfJoined {
        /// Spring or damper.
        kind: ElementKind,
        /// Which of its kind.
        index: usize,
        /// The node.
        name: String,
    },
    /// A point or a support has the empty name, that of the ground, or one that is taken.
    #[error(
        "{what} {index} is named {name:?}: give it a name of its own, which no mass, point or support has, and not \"ground\""
    )]
    PlaceName {
        /// "point" or "support".
        what: &'static str,
        /// Which of its kind.
        index: usize,
        /// The name given.
        name: String,
    },
    /// A point moves with a name that is neither a mass nor a support.
    #[error(
        "point {point:?} moves with {name:?}, which is neither a mass nor a support: known are {known}"
    )]
    PointMoves {
        /// The point.
        point: String,
        /// The name that was not found.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A point moves with another point, or with itself.
    #[error("point {point:?} moves with {name:?}, which is a point: give what that one moves with")]
    PointOnPoint {
        /// The point.
        point: String,
        /// The point it moves with.
        name: String,
    },
    /// A point moves with nothing.
    #[error("point {point:?} moves with nothing: name at least one mass or support")]
    PointStill {
        /// The point.
        point: String,
    },
    /// How a point moves is infinite or NaN.
    #[error("point {point:?} moves {value:?} times with {name:?}: it must be a finite number")]
    PointNotFinite {
        /// The point.
        point: String,
        /// What it moves with.
        name: String,
        /// The value given.
        value: f64,
    },
    /// Two springs or dampers share a name, or one has the empty name.
    #[error(
        "{kind} {index} is named {name:?}: names of springs and dampers must not be empty, and must differ"
    )]
    ElementName {
        /// Spring or damper.
        kind: ElementKind,
        /// Which of its kind.
        index: usize,
        /// The name.
        name: String,
    },
    /// What points make of an element or a mass is beyond the range of doubles.
    #[error(
        "{what} acts through points, and its products with how they move leave the range of doubles: choose units that make the numbers neither so large nor so small"
    )]
    PointRange {
        /// Which spring, damper or mass.
        what: String,
    },
    /// A matrix does not have one row and one column for each coordinate.
    #[error("the {kind} matrix is {rows} × {columns}: it must be {expected} × {expected}")]
    MatrixShape {
        /// Which matrix.
        kind: MatrixKind,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// The number of coordinates.
        expected: usize,
    },
    /// A matrix entry is infinite or NaN.
    #[error("entry ({row}, {column}) of the {kind} matrix is {value:?}: it must be finite")]
    MatrixNotFinite {
        /// Which matrix.
        kind: MatrixKind,
        /// The entry's row.
        row: usize,
        /// The entry's column.
        column: usize,
        /// The value given.
        value: f64,
    },
    /// Elements that are each finite add up to more than the largest double.
    #[error(
        "entry ({row}, {column}) of the {kind} matrix overflows when its elements are added up: choose units that make the numbers smaller"
    )]
    Overflow {
        /// Which matrix.
        kind: MatrixKind,
        /// The entry's row.
        row: usize,
        /// The entry's column.
        column: usize,
    },
    /// det(λ²M + λC + K) vanishes for every λ: the motion is not determined.
    #[error(
        "the system is singular: det(λ²M + λC + K) = 0 for every λ, so nothing determines the motion; give a free node a mass, or join it to something, or look for dependent rows of the matrices"
    )]
    Singular,
}
