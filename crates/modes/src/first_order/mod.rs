//! The system as first-order equations z′ = A z + B f, with massless nodes eliminated. It knows `exact`, `linear`,
//! `model` and `system`.

mod elimination;
mod enclosed_form;
mod error;
mod massless;

use eigentone_digits::{DoubleDouble, Lu, Real};
use faer::{Mat, MatRef};

use crate::linear::plain_matrix::PlainMatrix;
use crate::linear::wide::Number;
use crate::model::MatrixKind;
use crate::system::System;
use elimination::Eliminated;
pub(crate) use massless::Massless;

pub use enclosed_form::EnclosedFirstOrder;
pub use error::FirstOrderError;

/// z′ = A z + B f(t), x = X z + D f, with n coordinates and N = 2·(massive) + (relaxing) states.
///
/// z holds the displacements of the coordinates with mass, then their velocities, then one state
/// for each independent damper between massless nodes. Massless nodes that no damper holds have no
/// state: they follow from equilibrium. The elimination does not round the count of states. It is done in double-double, so
/// that doubles keep all their digits in what springs and dampers on massless nodes leave of each other; where every
/// coordinate has mass, A = −M⁻¹(K, C) is that of an LU factorisation in doubles, unless these lose M⁻¹.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    massive: Vec<usize>,
    a: Mat<f64>,
    b: Mat<f64>,
    x: Mat<f64>,
    d: Option<Mat<f64>>,
    /// What doubles leave of B and D, if anything is known of it.
    rest: [Option<Mat<f64>>; 2],
    initial: Mat<f64>,
}

impl FirstOrder {
    /// The first-order form of a system.
    ///
    /// # Errors
    /// [`FirstOrderError`] for a singular mass matrix without massless nodes, for massless
    /// nodes whose springs or dampers cancel, and for [large](System::is_large) systems.
    pub fn of(system: &System) -> Result<FirstOrder, FirstOrderError> {
        let n = system.len();
        if system.is_large() {
            return Err(FirstOrderError::TooLarge { coordinates: n });
        }
        if is_lumped(system) {
            return FirstOrder::without_massless(system);
        }
        let massless = Massless::of_system(system);
        let (form, digits) = match massless.is_empty() {
            true => (FirstOrder::without_massless(system), 1),
            false => (FirstOrder::eliminated::<DoubleDouble>(system, &massless), 2),
        };
        let form = match form {
            Ok(form) if form.keeps_masses(system, f64::EPSILON.powi(digits)) => form,
            Ok(form) => FirstOrder::with_digits(system, &massless).unwrap_or(form),
            Err(FirstOrderError::SingularMass) => FirstOrder::with_digits(system, &massless)?,
            Err(error) => return Err(error),
        };
        // Rounding may hide that a block is singular.
        let certain = massless.is_empty() && system.added(MatrixKind::Mass).is_none();
        let finite = |system: &System| system.structure().finite_roots();
        if !certain && finite(system).is_some_and(|degree| degree != massless.degree()) {
            return Err(if system.added(MatrixKind::Mass).is_some() {
                FirstOrderError::SingularMass
            } else if massless.following() > 0 {
                FirstOrderError::Constraint
            } else {
                FirstOrderError::SingularDamping
            });
        }
        Ok(form)
    }

    /// Of a system in which every coordinate has mass.
    fn without_massless(system: &System) -> Result<FirstOrder, FirstOrderError> {
        let n = system.len();
        let mass = match system.added(MatrixKind::Mass) {
            None => Some(Factored::Diagonal(system.masses().to_vec())),
            Some(_) => Factored::of(system.mass_matrix().as_ref()),
        };
        let mass = mass.ok_or(FirstOrderError::SingularMass)?;
        let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
        for (block, matrix) in [system.stiffness_matrix(), system.damping_matrix()]
            .iter()
            .enumerate()
        {
            let divided = mass.solve((-matrix).as_ref());
            a.submatrix_mut(n, n * block, n, n).copy_from(divided);
        }
        let unit = Mat::<f64>::identity(n, n);
        let mut b = Mat::<f64>::zeros(2 * n, n);
        b.submatrix_mut(n, 0, n, n)
            .copy_from(mass.solve(unit.as_ref()));
        a.submatrix_mut(0, n, n, n).copy_from(&unit);
        Ok(FirstOrder {
            massive: (0..n).collect(),
            a,
            b,
            x: Mat::identity(n, 2 * n),
            d: None,
            rest: [None, None],
            initial: unit,
        })
    }

    /// With as many digits as leave masses what they are beside others that are far heavier; double-doubles where that would
    /// take long.
    fn with_digits(system: &System, massless: &Massless) -> Result<FirstOrder, FirstOrderError> {
        const LARGEST: usize = 64;
        match system.len() <= LARGEST {
            true => FirstOrder::eliminated::<Number>(system, massless),
            false => FirstOrder::eliminated::<DoubleDouble>(system, massless),
        }
    }

    /// Whether the condition of M leaves some digits of its inverse, given the unit of rounding: by the trace of M⁻¹ in units
    /// in which M has 1 on its diagonal.
    fn keeps_masses(&self, system: &System, unit: f64) -> bool {
        const LOST: f64 = 1e-6;
        let (nf, mass) = (self.massive.len(), system.mass_matrix());
        let share = |(row, i): (usize, &usize)| (self.b[(nf + row, *i)] * mass[(*i, *i)]).abs();
        let condition: f64 = self.massive.iter().enumerate().map(share).sum();
        condition * unit <= LOST
    }

    /// By elimination of massless nodes. Springs on them may cancel in what they leave, so that it takes more digits than
    /// doubles have.
    fn eliminated<T: Real>(
        system: &System,
        massless: &Massless,
    ) -> Result<FirstOrder, FirstOrderError> {
        let form = Eliminated::<PlainMatrix<T>>::of(system, massless)?;
        let rounded = |matrix: &PlainMatrix<T>| {
            let [rows, columns] = matrix.size();
            Mat::from_fn(rows, columns, |i, j| matrix.get(i, j).to_f64())
        };
        let rest = |matrix: &PlainMatrix<T>| {
            let [rows, columns] = matrix.size();
            let rest = |entry: T| (entry - T::from(entry.to_f64())).to_f64();
            Some(Mat::from_fn(rows, columns, |i, j| rest(matrix.get(i, j))))
        };
        let (n, nf) = (system.len(), massless.massive().len());
        let mut initial = Mat::<f64>::zeros(nf + massless.relaxing(), n);
        for (row, &i) in massless.massive().iter().enumerate() {
            initial[(row, i)] = 1.0;
        }
        for (row, i, sign) in massless.state_entries() {
            initial[(nf + row, i)] = sign;
        }
        Ok(FirstOrder {
            massive: massless.massive().to_vec(),
            a: rounded(&form.a),
            b: rounded(&form.b),
            x: rounded(&form.x),
            d: (massless.following() > 0).then(|| rounded(&form.d)),
            rest: [rest(&form.b), rest(&form.d)],
            initial,
        })
    }

    /// Whether a system certainly has this form.
    pub(crate) fn is_certain(system: &System) -> bool {
        !system.is_large() && is_lumped(system)
    }

    /// The number N of states.
    pub fn states(&self) -> usize {
        self.a.nrows()
    }

    /// The coordinates that have mass, whose displacements and velocities come first in z.
    pub fn massive(&self) -> &[usize] {
        &self.massive
    }

    /// A (N × N).
    pub fn a(&self) -> MatRef<'_, f64> {
        self.a.as_ref()
    }

    /// B (N × n). It is also the change of z that unit impulses make.
    pub fn b(&self) -> MatRef<'_, f64> {
        self.b.as_ref()
    }

    /// X (n × N).
    pub fn x(&self) -> MatRef<'_, f64> {
        self.x.as_ref()
    }

    /// D (n × n), what forces on undamped massless nodes displace at once; `None` if there are no
    /// such nodes.
    pub fn d(&self) -> Option<MatRef<'_, f64>> {
        self.d.as_ref().map(Mat::as_ref)
    }

    /// B f and D f of a sum of forces, each on a coordinate. They are rounded once: forces may cancel in what massless nodes
    /// take up of them.
    pub fn driven(&self, forces: &[(usize, f64)]) -> [Vec<f64>; 2] {
        let of = |matrix: &Mat<f64>, rest: &Option<Mat<f64>>| {
            let entry = |i: usize, j: usize| {
                let rest = rest.as_ref().map_or(0.0, |rest| rest[(i, j)]);
                DoubleDouble::from(matrix[(i, j)]) + DoubleDouble::from(rest)
            };
            let row = |i: usize| {
                let terms = forces.iter().map(|(j, force)| entry(i, *j).mul_f64(*force));
                terms.fold(DoubleDouble::ZERO, |sum, term| sum + term)
            };
            (0..matrix.nrows()).map(|i| row(i).to_f64()).collect()
        };
        let at_once = self.d.as_ref();
        [
            of(&self.b, &self.rest[0]),
            at_once.map_or_else(|| vec![0.0; self.x.nrows()], |d| of(d, &self.rest[1])),
        ]
    }

    /// z from displacements and velocities of all n coordinates; what massless nodes cannot be
    /// given is passed over.
    pub fn state(&self, displacement: &[f64], velocity: &[f64]) -> Vec<f64> {
        let nf = self.massive.len();
        let mut z = vec![0.0; self.states()];
        for row in 0..self.initial.nrows() {
            let at = if row < nf { row } else { nf + row };
            z[at] = (0..displacement.len())
                .map(|j| self.initial[(row, j)] * displacement[j])
                .sum();
        }
        for (row, &i) in self.massive.iter().enumerate() {
            z[nf + row] = velocity[i];
        }
        z
    }
}

/// Whether M is diagonal, with a mass at every coordinate.
fn is_lumped(system: &System) -> bool {
    match system.added(MatrixKind::Mass) {
        None => system.masses().iter().all(|mass| *mass > 0.0),
        Some(matrix) => is_diagonal(matrix) && (0..matrix.nrows()).all(|i| matrix[(i, i)] > 0.0),
    }
}

fn is_diagonal(matrix: MatRef<'_, f64>) -> bool {
    let n = matrix.nrows();
    (0..n).all(|j| (0..n).all(|i| i == j || matrix[(i, j)] == 0.0))
}

/// A square matrix ready to be divided by: by its diagonal where it has nothing else.
enum Factored {
    Diagonal(Vec<f64>),
    Lu(Lu<f64>),
}

impl Factored {
    /// `None` if it is singular.
    fn of(matrix: MatRef<'_, f64>) -> Option<Factored> {
        let n = matrix.nrows();
        if is_diagonal(matrix) {
            let diagonal: Vec<f64> = (0..n).map(|i| matrix[(i, i)]).collect();
            return diagonal
                .iter()
                .all(|d| *d != 0.0)
                .then_some(Factored::Diagonal(diagonal));
        }
        Lu::regular(matrix).map(Factored::Lu)
    }

    fn solve(&self, right: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Factored::Diagonal(diagonal) => Mat::from_fn(right.nrows(), right.ncols(), |i, j| {
                right[(i, j)] / diagonal[i]
            }),
            Factored::Lu(lu) => lu.solve(right.to_owned()),
        }
    }
}
