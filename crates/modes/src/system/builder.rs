//! From named parameters to a checked [`System`].

use std::collections::HashMap;

use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatRef};
use thiserror::Error;

use super::System;
use super::beams::{Beam, Continua, Rod};
use super::damping::{ModalRatios, Rayleigh};
use super::given::{GivenPoint, Joint};
use super::places::{self, Places};
use crate::model::{
    Added, CoordinateKind, ElementKind, GROUND, MAX_COORDINATES, MAX_DENSE_COORDINATES, Machine,
    MatrixKind, Model,
};

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
    pub(super) masses: Vec<(String, f64)>,
    /// Indices of those that are inertias.
    pub(super) rotations: Vec<usize>,
    pub(super) beams: Vec<Beam>,
    pub(super) rods: Vec<Rod>,
    pub(super) rayleigh: Option<Rayleigh>,
    pub(super) modal: Option<ModalRatios>,
    pub(super) points: Vec<GivenPoint>,
    pub(super) supports: Vec<String>,
    pub(super) elements: Vec<Joint>,
    pub(super) matrices: Vec<(MatrixKind, Entries)>,
}

/// A matrix as it was given.
#[derive(Clone, Debug)]
pub(super) enum Entries {
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

    /// Adds a coordinate `name` that is an angle in rad, with an inertia in kg·m² (0: none). It is a
    /// [`mass`](Self::mass) in all else.
    pub fn rotation(mut self, name: impl Into<String>, inertia: f64) -> Self {
        self.rotations.push(self.masses.len());
        self.mass(name, inertia)
    }

    /// Adds a beam, whose coordinates come after those of all masses. Their names may stand wherever names of masses may.
    ///
    /// ```
    /// use eigentone_modes::{Beam, BeamEnd, System};
    ///
    /// let system = System::builder()
    ///     .beam(Beam {
    ///         name: "mast".to_owned(),
    ///         length: 2.0,
    ///         elements: 10,
    ///         flexural_rigidity: 100.0,
    ///         mass_per_length: 1.2,
    ///         ends: [BeamEnd::Clamped, BeamEnd::Free],
    ///         lumped: false,
    ///     })
    ///     .mass("tip", 0.5)
    ///     .spring("mast.10.w", "tip", 30.0)
    ///     .build()?;
    /// assert_eq!(system.names()[..3], ["tip", "mast.1.w", "mast.1.r"]);
    /// # Ok::<(), eigentone_modes::BuildError>(())
    /// ```
    pub fn beam(mut self, beam: Beam) -> Self {
        self.beams.push(beam);
        self
    }

    /// Adds a rod, whose coordinates come after those of all masses and beams.
    pub fn rod(mut self, rod: Rod) -> Self {
        self.rods.push(rod);
        self
    }

    /// Adds Rayleigh damping αM + βK of everything in the system, α = `mass_factor` in 1/s and β = `stiffness_factor`
    /// in s; a second call replaces the first. Exact: products are kept in two doubles.
    ///
    /// The part of β acts in the springs, so that supports that move pull by it too. The part of α acts on velocities
    /// relative to the ground, those of the masses that points carry too; or, with `relative_to` a support whose displacement is u, relative to the
    /// motion in which everything would follow that support without inertia: −αM r u′ is added to C x′, with
    /// K r = −K_s for the column K_s of [`coupling`](System::coupling) of that support. A carried mass that moves with the support itself adds nothing then,
    /// as its part of that motion is its own. r is 1 for every coordinate where K·1 = −K_s exactly, as in a building on
    /// its soil, and is else solved for and kept in three doubles an entry, within 2^-159 of its largest.
    pub fn rayleigh(
        mut self,
        mass_factor: f64,
        stiffness_factor: f64,
        relative_to: Option<&str>,
    ) -> Self {
        self.rayleigh = Some(Rayleigh {
            of_mass: mass_factor,
            of_stiffness: stiffness_factor,
            relative_to: relative_to.map(str::to_owned),
        });
        self
    }

    /// Adds damping by ratios ζ of the undamped modes, those with the supports at rest: MΦ diag(2ζω) ΦᵀM for shapes Φ
    /// of modal mass 1. The ratios are those of the lowest mode, the next one, …, rigid ones counted, and the last ratio is that of all others; a second
    /// call replaces the first. It acts on velocities relative to the ground or to what follows a support, as the
    /// part of α of [`rayleigh`](Self::rayleigh).
    ///
    /// The matrix is full, and is computed with more than forty-eight digits, of which three doubles an entry are kept. Roots,
    /// shapes and motions are those of that matrix, and differ from those of the ideal one by about 2^-159 of the largest entry, far
    /// below the last digit unless frequencies are more than 1e30 apart: what would be exactly 0 may be as little instead. Where
    /// M is positive definite but for coordinates without mass, and K and the rest of C are positive semidefinite, what the
    /// [structure](System::structure) states is that of the ideal one: rigid motions are not damped, ratios of 0 leave their modes
    /// undamped, and damping by ratios alone is classical.
    pub fn modal_damping(mut self, ratios: impl Into<Vec<f64>>, relative_to: Option<&str>) -> Self {
        self.modal = Some(ModalRatios {
            ratios: ratios.into(),
            relative_to: relative_to.map(str::to_owned),
            in_double_double: false,
        });
        self
    }

    /// Has the matrix of [`modal_damping`](Self::modal_damping) with some thirty digits instead, which takes about a tenth of the time: for
    /// many designs, of which answers in doubles are wanted.
    pub fn quick_modal_damping(mut self) -> Self {
        if let Some(modal) = &mut self.modal {
            modal.in_double_double = true;
        }
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
            kind: None,
        });
        self
    }

    /// Says what the point given last measures. One that moves with any displacement is a displacement by itself, its
    /// numbers of rotations being arms; one that moves with rotations alone, a lever or a gear, has the kind of what
    /// springs and dampers join to it. Numbers do not change. Where no point was given, nothing is said.
    pub fn measuring(mut self, kind: CoordinateKind) -> Self {
        if let Some(last) = self.points.last_mut() {
            last.kind = Some(kind);
        }
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
        #[cfg(feature = "serde")]
        let given = std::sync::Arc::new(self.clone());
        let continua = Continua::of(&self.beams, &self.rods, self.masses.len())?;
        let (names, masses) = self.coordinates(&continua)?;
        let n = names.len();
        let places = Places::of(&names, self.points, self.supports)?;
        let is_rotation = |i: &usize| self.rotations.binary_search(i).is_ok();
        let mut is_rotation: Vec<bool> = (0..self.masses.len()).map(|i| is_rotation(&i)).collect();
        is_rotation.extend(continua.is_rotation);
        let damping = [self.rayleigh.is_some(), self.modal.is_some()];
        let is_plain = !is_rotation.contains(&true)
            && !damping.contains(&true)
            && (self.beams.is_empty() && self.rods.is_empty());
        let mut joined = places::join(&places, self.elements, is_plain, &is_rotation)?;
        joined.springs.extend(continua.springs);
        for (kind, sum) in [
            (MatrixKind::Mass, continua.mass),
            (MatrixKind::Stiffness, continua.stiffness),
        ] {
            joined.terms[kind as usize].extend(sum.terms);
            joined.squares[kind as usize].extend(sum.squares);
        }

        let mut added = joined.squares.map(Added::from);
        for (kind, matrix) in self.matrices {
            matrix.check(kind, n)?;
            let added = &mut added[kind as usize];
            if n > MAX_DENSE_COORDINATES || matrix.is_thin() {
                added.give_sparse(matrix.sparse());
            } else {
                added.give_dense(matrix.dense());
            }
        }
        for (added, terms) in added.iter_mut().zip(joined.terms) {
            added.add(n, terms);
        }
        let mut model = Model::new(names, masses, joined.springs, joined.dampers, added);
        if let Some(machine) = joined.machine {
            model = model.with_machine(Machine {
                is_rotation,
                held: continua.held,
                ..machine
            });
        }
        let more = [
            self.rayleigh.map(|rayleigh| rayleigh.of(&model)),
            self.modal.map(|modal| modal.of(&model)),
        ];
        for more in more.into_iter().flatten() {
            model = model.with_damping(more?);
        }
        for kind in KINDS {
            if let Some((row, column)) = overflow(&model, kind) {
                return Err(BuildError::Overflow { kind, row, column });
            }
        }
        let system = System::from(model);
        if system.is_singular() {
            return Err(BuildError::Singular);
        }
        #[cfg(feature = "serde")]
        let system = System {
            given: Some(given),
            ..system
        };
        Ok(system)
    }

    /// Names and masses of the coordinates: of the masses, then of beams and rods; without any, from the matrices'
    /// order.
    fn coordinates(&self, continua: &Continua) -> Result<(Vec<String>, Vec<f64>), BuildError> {
        if self.masses.is_empty() && continua.names.is_empty() {
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
        check_count(self.masses.len() + continua.names.len())?;
        let beside = continua.names.iter().zip(&continua.masses);
        let all = self.masses.iter().map(|(name, mass)| (name, mass));
        let all = all.chain(beside);
        let mut seen = HashMap::new();
        for (index, (name, mass)) in all.clone().enumerate() {
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
        Ok(all.map(|(name, mass)| (name.clone(), mass.abs())).unzip())
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

    /// Whether it was given as a sparse matrix, of so few entries that it is better kept so.
    fn is_thin(&self) -> bool {
        match self {
            Entries::Dense(_) => false,
            Entries::Sparse(matrix) => matrix.compute_nnz() <= matrix.nrows() * matrix.ncols() / 8,
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

fn circle(point: &str, name: &str) -> String {
    match point == name {
        true => {
            format!("point {point:?} moves with itself: give the masses and supports that move it")
        }
        false => format!(
            "points {point:?} and {name:?} move with each other: give the masses and supports that move them"
        ),
    }
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
        "{kind} {index} ends at {name:?}, which is not a coordinate: known: {known} and ground"
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
        "point {point:?} moves with {name:?}, which is neither a mass nor a support: known: {known}"
    )]
    PointMoves {
        /// The point.
        point: String,
        /// The name that was not found.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A point moves with itself, or with one that moves with it in turn.
    #[error("{}", circle(point, name))]
    PointCircle {
        /// The point.
        point: String,
        /// The point it moves with.
        name: String,
    },
    /// A point moves with another point.
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
    /// A number of a beam or a rod is out of range.
    #[error(
        "the {what} of {name:?} is {value:?}: a length and a rigidity must be finite numbers > 0, a mass per length a finite number ≥ 0, and there must be an element"
    )]
    Continuum {
        /// The beam or the rod.
        name: String,
        /// Which number.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// What the elements of a beam or a rod are made of is beyond the range of doubles.
    #[error(
        "the elements of {name:?} leave the range of doubles: choose units that make the numbers neither so large nor so small"
    )]
    ContinuumRange {
        /// The beam or the rod.
        name: String,
    },
    /// A factor of Rayleigh damping or a ratio is infinite or NaN.
    #[error("a factor or ratio of the damping is {value:?}: it must be a finite number")]
    DampingNotFinite {
        /// The value given.
        value: f64,
    },
    /// What a factor makes of a mass or a spring is beyond the range of doubles.
    #[error(
        "the products of damping factors with masses and springs leave the range of doubles: choose units that make the numbers neither so large nor so small"
    )]
    DampingRange,
    /// Damping is relative to a name that is no support.
    #[error("damping is relative to {name:?}, which is not a support: supports are [{known}]")]
    NotASupport {
        /// The name given.
        name: String,
        /// The supports.
        known: String,
    },
    /// Nothing determines how the structure follows a support, as springs do not hold it.
    #[error(
        "damping is relative to {name:?}, but springs do not determine how everything follows it: K is singular"
    )]
    NotHeld {
        /// The support.
        name: String,
    },
    /// The motion that follows a support takes too long to compute.
    #[error(
        "damping is relative to a support that {count} coordinates do not all follow alike: at most {most} may"
    )]
    FollowSize {
        /// How many coordinates there are.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// Modal damping without a ratio.
    #[error("modal damping has no ratio: give at least one")]
    NoRatios,
    /// Modal damping with a ratio for which there is no mode.
    #[error(
        "modal damping has {count} ratios, more than there are modes ({modes}): give at most one for each"
    )]
    ManyRatios {
        /// How many ratios.
        count: usize,
        /// How many modes.
        modes: usize,
    },
    /// Modal damping takes too long to compute.
    #[error("modal damping takes all modes of {count} coordinates: at most {most} are possible")]
    ModalSize {
        /// How many coordinates there are.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// The undamped modes are no real oscillations.
    #[error("modal damping needs real undamped modes, but {reason}")]
    NoModes {
        /// Why not.
        reason: &'static str,
    },
    /// Modes of one frequency, whose shapes are not determined, have different ratios.
    #[error(
        "modes {} and {} have the same frequency, {frequency} rad/s, but the ratios {} and {}: their damping is not determined; give both the same ratio", mode + 1, mode + 2, ratios[0], ratios[1]
    )]
    EqualModes {
        /// The first of them, from 0.
        mode: usize,
        /// In rad/s.
        frequency: f64,
        /// The two ratios.
        ratios: [f64; 2],
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
