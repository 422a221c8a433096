//! A checked system: a model, and what is proved of it when first asked for. Modes are computed above it. It knows
//! `linear`, `model`, `exact` and `structure`.

mod beams;
mod builder;
mod condensed;
mod damping;
mod given;
mod gyroscopic;
mod kinds;
mod parameter;
mod places;
#[cfg(feature = "serde")]
mod serial;

use std::sync::{Arc, OnceLock};

use faer::sparse::SparseColMatRef;
use faer::{Mat, MatRef};

use crate::model::{
    Added, CoordinateKind, Element, ElementKind, Form, GROUND, GivenElement, MatrixKind, Model,
    Names, NoCoordinate, Point, Term,
};
use crate::structure::coefficients::Coefficients;
use crate::structure::{Structure, determinant};

pub use beams::{Beam, BeamEnd, Rod, RodEnd};
pub use builder::{BuildError, SystemBuilder};
pub(crate) use condensed::{Condensed, dense};
pub use parameter::Parameter;
pub(crate) use parameter::Place;

/// A linear vibrating system M x″ + C x′ + K x = f(t) with n coordinates, checked and immutable.
///
/// It keeps the elements it was built from. A spring of 1 beside one of 1e20 is lost as soon as K
/// is assembled in doubles, while every natural frequency is well determined by the springs and
/// masses themselves; solvers therefore work from the elements where they can.
#[derive(Clone, Debug)]
pub struct System {
    model: Model,
    /// Both are made when first asked for; clones share them.
    coefficients: Arc<OnceLock<Arc<Coefficients>>>,
    structure: Arc<OnceLock<Structure>>,
    /// What it was built from, to be written down.
    #[cfg(feature = "serde")]
    given: Option<Arc<SystemBuilder>>,
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
        added: [impl Into<Added>; 3],
    ) -> System {
        Model::new(names, masses, springs, dampers, added).into()
    }

    pub(crate) fn model(&self) -> &Model {
        &self.model
    }

    /// The number n of coordinates.
    #[allow(clippy::len_without_is_empty)] // a system is never empty
    pub fn len(&self) -> usize {
        self.model.len()
    }

    /// The names of the coordinates, in order.
    pub fn names(&self) -> &[String] {
        self.model.names()
    }

    /// The same as a list that finds places by name, and that modes and trajectories share.
    pub fn coordinate_names(&self) -> &Names {
        self.model.names()
    }

    /// The index of the coordinate `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.model.names().index_of(name)
    }

    /// The same, where a name that is none is an error: rows of trajectories and components of shapes are found by it.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    ///
    /// let system = System::builder().mass("body", 1.0).spring(GROUND, "body", 4.0).build()?;
    /// let body = system.coordinate("body")?;
    /// assert_eq!(system.modes()?[0].shape()[body].re, 1.0);
    /// let wrong = system.coordinate("bdoy").unwrap_err();
    /// assert_eq!(wrong.to_string(), "there is no coordinate \"bdoy\": there is \"body\"");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`NoCoordinate`], which names those that there are.
    pub fn coordinate(&self, name: &str) -> Result<usize, NoCoordinate> {
        self.model.names().find(name)
    }

    /// What the coordinate of this index measures: a displacement, or an angle if it was given by
    /// [`rotation`](SystemBuilder::rotation) or is that of a node of a [`Beam`].
    pub fn kind_of(&self, index: usize) -> CoordinateKind {
        self.model.kind_of(index)
    }

    /// What the coordinate, point or support of this name measures, if it is known: see [`Point::kind`].
    pub fn kind_at(&self, name: &str) -> Option<CoordinateKind> {
        if let Some(index) = self.index_of(name) {
            return Some(self.kind_of(index));
        }
        let supports = self.supports().iter();
        let support = supports.zip(&self.model.machine()?.support_kinds);
        let mut support = support.filter(|(support, _)| *support == name);
        let point = || self.points().iter().find(|point| point.name == name);
        match support.next() {
            Some((_, kind)) => Some(*kind),
            None => point()?.kind,
        }
    }

    /// The points, in the order given.
    pub fn points(&self) -> &[Point] {
        self.model.machine().map_or(&[], |machine| &machine.points)
    }

    /// The names of the supports, in the order given.
    pub fn supports(&self) -> &[String] {
        self.model.supports()
    }

    /// The displacement of a coordinate, point or support by its name, or of the ground, which has none.
    pub fn form(&self, name: &str) -> Option<Form> {
        if name == GROUND {
            return Some(Form::default());
        }
        let coordinate = self.index_of(name).map(Form::coordinate);
        let support = || self.supports().iter().position(|support| support == name);
        let point = || self.points().iter().find(|point| point.name == name);
        coordinate
            .or_else(|| support().map(Form::support))
            .or_else(|| point().map(|point| point.form.clone()))
    }

    /// All springs, or all dampers, as they were given: those at points and supports too.
    pub fn elements(&self, kind: ElementKind) -> Vec<GivenElement> {
        let all = 0..self.model.element_count(kind);
        all.filter_map(|i| self.model.element(kind, i)).collect()
    }

    /// The spring or damper of this name: its kind and its index among [`elements`](Self::elements) of that kind.
    pub fn element_of(&self, name: &str) -> Option<(ElementKind, usize)> {
        let machine = self.model.machine()?;
        [ElementKind::Spring, ElementKind::Damper]
            .into_iter()
            .find_map(|kind| {
                let named = |element: &GivenElement| element.name.as_deref() == Some(name);
                let index = machine.elements(kind).iter().position(named)?;
                Some((kind, index))
            })
    }

    /// What unit motions of the supports add to M x″ (accelerations), C x′ (velocities) or K x (displacements): terms
    /// whose columns are the [supports](Self::supports), each entry being the exact sum of those in its place.
    pub fn coupling(&self, kind: MatrixKind) -> &[Term] {
        self.model.coupling(kind)
    }

    /// The forces at the supports, whose indices are the rows, that unit motions of the supports take by themselves: with
    /// [`terms`](Self::terms) and [`coupling`](Self::coupling) they make M, C or K of coordinates and supports together. Each
    /// entry is the exact sum of those in its place.
    pub fn between_supports(&self, kind: MatrixKind) -> &[Term] {
        self.model.between_supports(kind)
    }

    /// The lumped mass on each coordinate, in kg; an added mass matrix is not included.
    pub fn masses(&self) -> &[f64] {
        self.model.masses()
    }

    /// The springs between coordinates, and those from one to the ground or a support, which stands still in modes; in
    /// the order given, and after them those that rods are made of. What acts at points, and beams, are part of the
    /// [added](Self::added) matrices. [`elements`](Self::elements) has the ones that were given.
    pub fn springs(&self) -> &[Element] {
        self.model.springs()
    }

    /// The dampers, as [`springs`](Self::springs), and after them those that
    /// [Rayleigh damping](SystemBuilder::rayleigh) makes of springs and masses. [`elements`](Self::elements) has the ones
    /// that were given.
    pub fn dampers(&self) -> &[Element] {
        self.model.dampers()
    }

    /// Whether there are more than [`MAX_DENSE_COORDINATES`](crate::MAX_DENSE_COORDINATES) coordinates: then only
    /// [`SparseModes`](crate::SparseModes) and what builds on them apply.
    pub fn is_large(&self) -> bool {
        self.model.is_large()
    }

    /// The matrix that was added to the elements, if any, together with what elements and masses at points make of it,
    /// rounded to doubles; [`terms`](Self::terms) has all of it; of a [large](Self::is_large) system it is
    /// [sparse](Self::added_sparse) instead.
    pub fn added(&self, kind: MatrixKind) -> Option<MatRef<'_, f64>> {
        self.model.added(kind)
    }

    /// The matrix that was added to the elements of a [large](Self::is_large) system, if any.
    pub fn added_sparse(&self, kind: MatrixKind) -> Option<SparseColMatRef<'_, usize, f64>> {
        let large = self.is_large().then_some(&self.model);
        large.and_then(|model| model.added_sparse(kind))
    }

    /// The terms of M (kg), C (N·s/m) or K (N/m), each entry being the exact sum of those in its place: of the
    /// added matrix first, then of the elements in their order. Terms that are 0 are left out.
    pub fn terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        self.model.terms(kind)
    }

    /// M (n × n, kg): the lumped masses and the added mass matrix, each entry summed in
    /// double-double and rounded once.
    pub fn mass_matrix(&self) -> Mat<f64> {
        self.model.matrix(MatrixKind::Mass)
    }

    /// C (n × n, N·s/m), summed as [`mass_matrix`](Self::mass_matrix) is.
    pub fn damping_matrix(&self) -> Mat<f64> {
        self.model.matrix(MatrixKind::Damping)
    }

    /// K (n × n, N/m), summed as [`mass_matrix`](Self::mass_matrix) is.
    pub fn stiffness_matrix(&self) -> Mat<f64> {
        self.model.matrix(MatrixKind::Stiffness)
    }

    /// What can be proved of the system from its parameters alone, in exact arithmetic. Proved when
    /// first asked for, and remembered.
    pub fn structure(&self) -> &Structure {
        self.structure
            .get_or_init(|| Structure::of(&self.model, self.coefficients().clone()))
    }

    /// M, C and K in exact arithmetic.
    fn coefficients(&self) -> &Arc<Coefficients> {
        self.coefficients
            .get_or_init(|| Arc::new(Coefficients::of(&self.model)))
    }

    /// Whether det(λ²M + λC + K) [vanishes](determinant::vanishes) for every λ.
    pub(crate) fn is_singular(&self) -> bool {
        determinant::vanishes(&self.model, || self.coefficients())
    }
}

impl From<Model> for System {
    fn from(model: Model) -> System {
        System {
            model,
            coefficients: Arc::default(),
            structure: Arc::default(),
            #[cfg(feature = "serde")]
            given: None,
        }
    }
}
