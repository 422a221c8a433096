//! Modes again and again in the same memory.

use eigentone_digits::settle;
use num_complex::Complex;

use super::design::{Design, DesignError};
use super::shape::{Shifted, improved};
use crate::linear::small;

/// The modes of one [`Design`] after another, in doubles, without allocating after the first.
///
/// The eigenvalues are those of the balanced state matrix by the QR algorithm, O((2n)³), each
/// improved by the Rayleigh functional of its shape, summed over the elements. That suits systems
/// of up to some tens of coordinates whose springs, dampers and masses lie within about ten orders
/// of magnitude; there are no bounds. [`System::modes`](crate::System::modes) proves its answers,
/// whatever the system.
///
/// ```
/// use eigentone_modes::{Design, GROUND, ModesWorkspace, Parameter, System};
///
/// let system = System::builder()
///     .mass("m1", 2.0)
///     .mass("m2", 1.0)
///     .spring(GROUND, "m1", 2.0)
///     .spring("m1", "m2", 0.2)
///     .damper("m1", "m2", 0.1)
///     .build()?;
/// let mut design = Design::of(&system)?;
/// let mut workspace = ModesWorkspace::of(&design);
/// for stiffness in [0.2, 0.3, 0.4] {
///     design.set(Parameter::Spring(1), stiffness)?;
///     workspace.solve(&design)?;
///     let lowest = workspace.eigenvalues()[0];
///     println!("{stiffness} N/m: {} rad/s", lowest.norm());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModesWorkspace {
    n: usize,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
    state: Vec<f64>,
    roots: Vec<Complex<f64>>,
    eigenvalues: Vec<Complex<f64>>,
    shapes: Vec<Complex<f64>>,
    sorted: Vec<Complex<f64>>,
    order: Vec<usize>,
    reached: Vec<bool>,
    shifted: Shifted,
}

impl ModesWorkspace {
    /// Memory for designs of as many coordinates as this one.
    pub fn of(design: &Design) -> ModesWorkspace {
        let n = design.len();
        ModesWorkspace {
            n,
            damping: vec![0.0; n * n],
            stiffness: vec![0.0; n * n],
            state: vec![0.0; 4 * n * n],
            roots: vec![Complex::ZERO; 2 * n],
            eigenvalues: Vec::with_capacity(2 * n),
            shapes: vec![Complex::ZERO; 2 * n * n],
            sorted: vec![Complex::ZERO; 2 * n * n],
            order: Vec::with_capacity(2 * n),
            reached: vec![false; n],
            shifted: Shifted::new(n),
        }
    }

    /// Finds the modes of a design; [`eigenvalues`](Self::eigenvalues) and [`shape`](Self::shape)
    /// then give them.
    ///
    /// # Errors
    /// [`DesignError::NotHeld`], [`DesignError::Layout`] for a design of another number of
    /// coordinates, and [`DesignError::OutOfRange`].
    pub fn solve(&mut self, design: &Design) -> Result<(), DesignError> {
        let n = self.n;
        self.eigenvalues.clear();
        if design.len() != n {
            return Err(DesignError::Layout);
        }
        settle();
        if !design.is_held(&mut self.reached) {
            return Err(DesignError::NotHeld);
        }
        design.stiffness_matrix(&mut self.stiffness);
        design.damping_matrix(&mut self.damping);
        self.fill_state(design);
        small::eigenvalues(&mut self.state, 2 * n, &mut self.roots)
            .ok_or(DesignError::OutOfRange)?;
        let is_undamped = design
            .dampers()
            .iter()
            .all(|damper| damper.coefficient == 0.0);
        let upper = self.roots.iter().filter(|root| {
            // Without dampers the pairs come back as they are, but for rounding.
            root.im > 0.0 || (root.im == 0.0 && !is_undamped)
        });
        for (j, root) in upper.enumerate() {
            let x = &mut self.shapes[n * j..n * (j + 1)];
            let matrices = [self.damping.as_slice(), self.stiffness.as_slice()];
            self.shifted.shape(design, matrices, *root, j, x);
            self.eigenvalues
                .push(improved(design, x, *root, is_undamped));
        }
        let all = self
            .eigenvalues
            .iter()
            .map(|root| if root.im > 0.0 { 2 } else { 1 });
        if all.sum::<usize>() != 2 * n || !self.eigenvalues.iter().all(|root| root.is_finite()) {
            self.eigenvalues.clear();
            return Err(DesignError::OutOfRange);
        }
        self.sort();
        Ok(())
    }

    /// [0 I; −M⁻¹K −M⁻¹C].
    fn fill_state(&mut self, design: &Design) {
        let n = self.n;
        let rows = 2 * n;
        self.state.fill(0.0);
        for j in 0..n {
            self.state[j + rows * (n + j)] = 1.0;
            for (i, mass) in design.masses().iter().enumerate() {
                self.state[n + i + rows * j] = -self.stiffness[i + n * j] / mass;
                self.state[n + i + rows * (n + j)] = -self.damping[i + n * j] / mass;
            }
        }
    }

    /// By |λ|, then Re λ.
    fn sort(&mut self) {
        let n = self.n;
        let key = |j: usize| (self.eigenvalues[j].norm_sqr(), self.eigenvalues[j].re);
        self.order.clear();
        for j in 0..self.eigenvalues.len() {
            let place = self.order.partition_point(|other| key(*other) <= key(j));
            self.order.insert(place, j);
        }
        for (place, &j) in self.order.iter().enumerate() {
            let from = &self.shapes[n * j..n * (j + 1)];
            self.sorted[n * place..n * (place + 1)].copy_from_slice(from);
            self.roots[place] = self.eigenvalues[j];
        }
        let count = self.eigenvalues.len();
        self.eigenvalues.copy_from_slice(&self.roots[..count]);
        std::mem::swap(&mut self.shapes, &mut self.sorted);
    }

    /// λ of each mode in 1/s, with Im λ ≥ 0, sorted by |λ|, then Re λ: one for each conjugate pair
    /// and for each real root. A critically damped root comes as two that are close. Empty after an
    /// error.
    pub fn eigenvalues(&self) -> &[Complex<f64>] {
        &self.eigenvalues
    }

    /// The shape of mode j, one entry for each coordinate, the largest of them 1.
    ///
    /// # Panics
    /// If there is no mode j.
    pub fn shape(&self, j: usize) -> &[Complex<f64>] {
        assert!(
            j < self.eigenvalues.len(),
            "mode {j} of {}",
            self.eigenvalues.len()
        );
        &self.shapes[self.n * j..self.n * (j + 1)]
    }
}
