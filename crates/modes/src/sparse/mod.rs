//! Some modes of systems that are too large for dense matrices. It knows `model`, `modes`, `solver`,
//! `structure` and `system`.

mod answer;
mod arnoldi;
mod basis;
mod coupled;
mod damped;
mod dynamic;
mod eigenpair;
mod entry;
mod error;
mod factor;
mod form;
mod front;
mod given;
mod impedance;
mod inertia;
mod inverse_diagonal;
mod judge;
mod lanczos;
mod newton;
mod operator;
mod ordering;
mod pencil;
mod proportional;
mod quotients;
mod random;
mod refine;
mod search;
mod setting;
mod undamped;
mod winding;

use std::sync::Arc;

use eigentone_digits::DoubleDouble;
use faer::MatRef;

use crate::model::MatrixKind;
use crate::modes::{Frequency, Modes};
use crate::system::System;
pub use dynamic::{Amplitudes, SparseDynamicStiffness};
pub use eigenpair::Eigenpair;
pub use error::SparseError;
pub use given::{ExaminedPairs, examine_pairs};

use factor::Factor;
use form::Form;
use pencil::Pencil;
use setting::Setting;
use undamped::Undamped;

/// The undamped modes K x = ω²M x of a symmetric system nearest to a frequency, found without any dense
/// matrix: time and memory grow with the entries of a sparse factor of K − σM, for chains with n.
///
/// They come from Lanczos' method on (K − σM)⁻¹M (Ericsson & Ruhe 1980, *Math. Comp.* 35) and keep
/// their last digits where the elements determine them, as Rayleigh quotients summed over the elements:
/// K itself, assembled, has lost the lowest eigenvalue of a chain of a million masses to 1e-5. Dampers
/// are left out; [`modes`](Self::modes) takes them in. Bounds are first-order estimates.
///
/// ```
/// use eigentone_modes::{GROUND, SparseModes, System};
///
/// let mut chain = System::builder();
/// let name = |i: usize| format!("m{i}");
/// for i in 0..1000 {
///     let before = if i == 0 { GROUND.to_owned() } else { name(i - 1) };
///     chain = chain.mass(name(i), 1.0).spring(before, name(i), 1.0);
/// }
/// let modes = SparseModes::lowest(&chain.build()?, 3)?;
/// let exact = 2.0 * (std::f64::consts::PI / 2001.0 / 2.0).sin();
/// assert!((modes.frequencies()[0].radians_per_second() / exact - 1.0).abs() < 1e-14);
/// assert!(modes.is_counted());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SparseModes {
    found: Undamped,
    work: SparseWork,
    pencil: Arc<Pencil>,
    /// `None` where C is not symmetric.
    damping: Option<Form>,
    /// Where K − σM was factorised.
    shift: f64,
}

/// What sparse modes took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SparseWork {
    /// How often (K − σM)⁻¹ was applied by Lanczos' method.
    pub products: usize,
    /// How often K − σM was factorised.
    pub factorisations: usize,
    /// The entries of a factor below its diagonal.
    pub entries: usize,
}

impl SparseModes {
    /// The `count` modes of the smallest ω², or all where there are not so many. Motions that nothing
    /// holds, counted on the graph of the springs, come first, with ω = 0 exactly.
    ///
    /// Where K is not positive semidefinite, they are those of the smallest |ω²|.
    ///
    /// # Errors
    /// [`SparseError`].
    pub fn lowest(system: &System, count: usize) -> Result<SparseModes, SparseError> {
        SparseModes::find(system, 0.0, count)
    }

    /// The `count` modes whose natural frequency √|ω²| is nearest to `target`, or all where there are not so
    /// many; in the order of ω².
    ///
    /// # Errors
    /// [`SparseError`].
    pub fn nearest(
        system: &System,
        target: Frequency,
        count: usize,
    ) -> Result<SparseModes, SparseError> {
        let target = target.radians_per_second();
        let square = target * target;
        if target < 0.0 || !square.is_finite() {
            return Err(SparseError::Target { target });
        }
        SparseModes::find(system, if square == 0.0 { 0.0 } else { target }, count)
    }

    fn find(system: &System, target: f64, count: usize) -> Result<SparseModes, SparseError> {
        if count == 0 {
            return Err(SparseError::NoneWanted);
        }
        let setting = Setting::of(system, target, count, f64::INFINITY)?;
        let wanted = setting.wanted();
        let mut answer = match target {
            0.0 => search::lowest(&wanted)?,
            _ => search::nearest(&wanted)?,
        };
        let found = setting.undamped(system, &mut answer);
        let work = SparseWork {
            products: answer.applied,
            factorisations: answer.factorised,
            entries: setting.pencil.ordering.rows.len(),
        };
        Ok(SparseModes {
            found,
            work,
            damping: Form::of(system, MatrixKind::Damping),
            shift: answer.operator.shift,
            pencil: setting.pencil.clone(),
        })
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty)] // at least one was asked for
    pub fn len(&self) -> usize {
        self.found.squares.len()
    }

    /// λ = ω² in 1/s², rising. Negative where K pushes away and the motion grows.
    pub fn squares(&self) -> &[f64] {
        &self.found.squares
    }

    /// ω of each; 0 where ω² is negative.
    pub fn frequencies(&self) -> Vec<Frequency> {
        let squares = self.found.squares.iter();
        let root = |square: &f64| Frequency::from_radians_per_second(square.max(0.0).sqrt());
        squares.map(root).collect()
    }

    /// How far each ω² may be off, in 1/s²: a first-order estimate, `None` where none can be given.
    pub fn square_bounds(&self) -> &[Option<f64>] {
        &self.found.errors
    }

    /// The shapes: an n × m matrix, column j for mode j, with xᵀMx = 1.
    pub fn shapes(&self) -> MatRef<'_, f64> {
        self.found.shapes.as_ref()
    }

    /// Whether the number of negative pivots of K − τM on both sides of what was found, by Sylvester's law
    /// of inertia, confirms that no mode between them is missing.
    pub fn is_counted(&self) -> bool {
        self.found.counted.is_some()
    }

    /// The modes with damping, as roots of λ²M + λC + K: as many as were asked for, those whose natural frequency
    /// |λ| is lowest, or nearest to the target, with bounds that are estimates.
    /// [`Modes::is_complete`](crate::Modes::is_complete) says whether it is proved that none of them is missing:
    /// by the count of undamped modes without damping and with Rayleigh damping, else by the turns of the
    /// determinant about a circle where the system is passive and dampers move at most 48 coordinates.
    ///
    /// # Errors
    /// [`SparseError::NotSymmetric`] where C is not symmetric, [`SparseError::OutOfRange`] where the equation has no
    /// factor in doubles near the roots looked for.
    pub fn modes(&self) -> Result<Modes, SparseError> {
        let Some(damping) = &self.damping else {
            let kind = MatrixKind::Damping;
            return Err(SparseError::NotSymmetric { kind });
        };
        damped::modes(self, damping)
    }

    /// The equation of the amplitudes q of the shapes, q″ + ΦᵀCΦ q′ + ΦᵀKΦ q = Φᵀf, as a dense system with
    /// coordinates x1, x2, ….
    ///
    /// # Errors
    /// As for [`modes`](Self::modes).
    pub fn reduced(&self) -> Result<System, SparseError> {
        let Some(damping) = &self.damping else {
            let kind = MatrixKind::Damping;
            return Err(SparseError::NotSymmetric { kind });
        };
        Ok(damped::reduced(&self.found, damping)?)
    }

    /// M x, for a vector of n entries.
    ///
    /// # Panics
    /// Unless x has n entries.
    pub fn mass_times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.found.shapes.nrows()];
        self.pencil.mass.apply(x, &mut product);
        product
    }

    /// xᵀKx, summed over the elements, for a vector of n entries.
    ///
    /// # Panics
    /// Unless x has n entries.
    pub fn twice_potential_energy(&self, x: &[f64]) -> f64 {
        self.pencil.stiffness.quadratic(x)
    }

    /// What is missing in the equation of a mode, Kφ − ω²Mφ, each sum in double-double.
    ///
    /// # Panics
    /// If there is no such mode.
    pub fn residual(&self, mode: usize) -> Vec<f64> {
        let shape: Vec<f64> = self.found.shapes.col(mode).iter().copied().collect();
        let mut rest = vec![DoubleDouble::ZERO; shape.len()];
        self.pencil.stiffness.accumulate(1.0, &shape, &mut rest);
        let square = self.found.squares[mode];
        self.pencil.mass.accumulate(-square, &shape, &mut rest);
        rest.into_iter().map(DoubleDouble::to_f64).collect()
    }

    /// Cφ − d Mφ of a mode, each sum in double-double: what the damping of a mode, d = 2ζω, leaves of its forces. `None` where C
    /// is not symmetric.
    ///
    /// # Panics
    /// If there is no such mode.
    pub fn damping_residual(&self, mode: usize, d: f64) -> Option<Vec<f64>> {
        let shape: Vec<f64> = self.found.shapes.col(mode).iter().copied().collect();
        let mut rest = vec![DoubleDouble::ZERO; shape.len()];
        self.damping.as_ref()?.accumulate(1.0, &shape, &mut rest);
        self.pencil.mass.accumulate(-d, &shape, &mut rest);
        Some(rest.into_iter().map(DoubleDouble::to_f64).collect())
    }

    /// What a constant force moves besides these shapes: R f with R = K⁻¹ − Φ Ω⁻² Φᵀ, the residual
    /// flexibility (MacNeal 1971, *Comput. Struct.* 1). `None` where these are not the modes of the smallest
    /// ω², or were not found from a factor of K as it is.
    ///
    /// # Panics
    /// Unless the force has n entries.
    pub fn residual_flexibility(&self, force: &[f64]) -> Option<Vec<f64>> {
        if self.shift != 0.0 {
            return None;
        }
        let mut rest = force.to_vec();
        for k in 0..self.len() {
            let shape: Vec<f64> = self.found.shapes.col(k).iter().copied().collect();
            let along = basis::dot(&shape, force);
            let resisted = self.mass_times(&shape);
            let pairs = rest.iter_mut().zip(&resisted);
            pairs.for_each(|(rest, value)| *rest -= along * value);
        }
        let mut work = vec![0.0; rest.len()];
        Factor::of(&self.pencil, 0.0).solve(&mut rest, &mut work);
        // A part that nothing holds was pinned at a node: its shapes are taken out again.
        let resisted = self.mass_times(&rest);
        for k in 0..self.len() {
            let shape: Vec<f64> = self.found.shapes.col(k).iter().copied().collect();
            let along = basis::dot(&shape, &resisted);
            let pairs = rest.iter_mut().zip(&shape);
            pairs.for_each(|(rest, value)| *rest -= along * value);
        }
        Some(rest)
    }

    /// The diagonal of the residual flexibility R: how far each coordinate can be moved by what has xᵀKx = 1
    /// and none of these shapes, squared. `None` where R is not there, or some part is held by nothing.
    pub fn residual_flexibility_diagonal(&self) -> Option<Vec<f64>> {
        let factor = (self.shift == 0.0).then(|| Factor::of(&self.pencil, 0.0))?;
        if factor.zeros > 0 || factor.negative > 0 {
            return None;
        }
        let mut diagonal = inverse_diagonal::of(&factor);
        for (k, square) in self.found.squares.iter().enumerate() {
            for (rest, x) in diagonal.iter_mut().zip(self.found.shapes.col(k).iter()) {
                *rest -= x * x / square;
            }
        }
        diagonal.iter_mut().for_each(|rest| *rest = rest.max(0.0));
        Some(diagonal)
    }

    /// What they took.
    pub fn work(&self) -> SparseWork {
        self.work
    }
}
