//! The system as first-order equations z′ = A z + B f, with massless nodes eliminated. It knows `exact`, `linear`,
//! `model` and `system`.

mod elimination;
mod enclosed_form;

use eigentone_digits::{DoubleDouble, Real};
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, MatRef};
use thiserror::Error;

use crate::linear::plain_matrix::PlainMatrix;
use crate::model::{Element, MatrixKind};
use crate::system::System;
use elimination::Eliminated;

pub use enclosed_form::EnclosedFirstOrder;

/// z′ = A z + B f(t), x = X z + D f, with n coordinates and N = 2·(massive) + (relaxing) states.
///
/// z holds the displacements of the coordinates with mass, then their velocities, then one state
/// for each independent damper between massless nodes. Massless nodes that no damper holds have no
/// state: they follow from equilibrium. The elimination does not round the count of states. It is done in double-double, so
/// that doubles keep all their digits in what springs and dampers on massless nodes leave of each other; where every
/// coordinate has mass, A = −M⁻¹(K, C) is that of an LU factorisation in doubles.
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

/// Why a system has no first-order form with the states described in [`FirstOrder`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FirstOrderError {
    /// The masses that are there do not determine all accelerations: loads on what has no inertia act
    /// through its derivatives, and not every initial state is consistent.
    #[error(
        "the mass matrix is singular although no row of it vanishes, so that only modes can be computed; \
         a motion needs coordinates in which what has no mass is a row and column of zeros"
    )]
    SingularMass,
    /// The stiffness seen by undamped massless nodes is singular: they form a constraint.
    #[error(
        "the springs on the massless nodes cancel, which makes them a constraint, so that only modes \
         can be computed; a motion needs coordinates without that constraint"
    )]
    Constraint,
    /// Dampers on massless nodes cancel or act in one direction only.
    #[error(
        "the dampers on the massless nodes do not determine how they relax, so that only modes can \
         be computed; a motion needs dampers whose matrix is not singular on the nodes that they meet"
    )]
    SingularDamping,
    /// The system is [large](System::is_large).
    #[error(
        "a dense state matrix of {coordinates} coordinates is too large: look at some of its modes, as SparseModes"
    )]
    TooLarge {
        /// How many coordinates there are.
        coordinates: usize,
    },
}

/// The coordinates with mass, and the massless ones: new coordinates (w, a) with x_p = T (w, a), where w relaxes through
/// dampers and a follows at once.
pub(crate) struct Massless {
    massive: Vec<usize>,
    nodes: Vec<usize>,
    /// T, of entries 0 and 1.
    change: Mat<f64>,
    /// w = S x_p, of entries 0, 1 and −1.
    states: Mat<f64>,
    relaxing: usize,
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
        let form = match massless.nodes.is_empty() {
            true => FirstOrder::without_massless(system)?,
            false => FirstOrder::without_nodes(system, &massless)?,
        };
        // Rounding may hide that a block is singular.
        let certain = massless.nodes.is_empty() && system.added(MatrixKind::Mass).is_none();
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
        let mass = match is_lumped(system) {
            true => Some(Factored::Diagonal(system.masses().to_vec())),
            false => Factored::of(system.mass_matrix().as_ref()),
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

    /// Of a system with massless nodes. Springs on them may cancel in what they leave, so that it takes more digits than
    /// doubles have.
    fn without_nodes(system: &System, massless: &Massless) -> Result<FirstOrder, FirstOrderError> {
        let form = Eliminated::<PlainMatrix<DoubleDouble>>::of(system, massless)?;
        let rounded = |matrix: &PlainMatrix<DoubleDouble>| {
            let [rows, columns] = matrix.size();
            Mat::from_fn(rows, columns, |i, j| matrix.get(i, j).to_f64())
        };
        let rest = |matrix: &PlainMatrix<DoubleDouble>| {
            let [rows, columns] = matrix.size();
            let rest = |entry: DoubleDouble| (entry - DoubleDouble::from(entry.to_f64())).to_f64();
            Some(Mat::from_fn(rows, columns, |i, j| rest(matrix.get(i, j))))
        };
        let (n, nf) = (system.len(), massless.massive.len());
        let mut initial = Mat::<f64>::zeros(nf + massless.relaxing, n);
        for (row, &i) in massless.massive.iter().enumerate() {
            initial[(row, i)] = 1.0;
        }
        for (row, i, sign) in massless.state_entries() {
            initial[(nf + row, i)] = sign;
        }
        Ok(FirstOrder {
            massive: massless.massive.clone(),
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

/// Whether every coordinate has a lumped mass, and there is no other inertia.
fn is_lumped(system: &System) -> bool {
    system.added(MatrixKind::Mass).is_none() && system.masses().iter().all(|mass| *mass > 0.0)
}

impl Massless {
    /// Groups massless nodes that only dampers among themselves hold: such a group relaxes in its
    /// differences and follows at once as a whole.
    pub(crate) fn of_system(system: &System) -> Massless {
        Massless::of(
            system,
            system.mass_matrix().as_ref(),
            system.damping_matrix().as_ref(),
        )
    }

    /// The coordinates with mass.
    pub(crate) fn massive(&self) -> &[usize] {
        &self.massive
    }

    /// The degree of det(λ²M + λC + K) if the masses of coordinates that have any, the dampers on those
    /// that relax, and the springs on those that follow are nonsingular blocks; less if not.
    pub(crate) fn degree(&self) -> usize {
        2 * self.massive.len() + self.relaxing
    }

    /// How many coordinates relax.
    pub(crate) fn relaxing(&self) -> usize {
        self.relaxing
    }

    /// How many coordinates follow at once.
    pub(crate) fn following(&self) -> usize {
        self.nodes.len() - self.relaxing
    }

    /// Where T is 1: the node, and the column.
    pub(crate) fn change(&self) -> impl Iterator<Item = (usize, usize)> {
        let entries = (0..self.nodes.len())
            .flat_map(|row| (0..self.nodes.len()).map(move |column| (row, column)));
        entries
            .filter(|at| self.change[*at] != 0.0)
            .map(|(row, column)| (self.nodes[row], column))
    }

    /// Where S is not 0: the row, the node, and the entry.
    pub(crate) fn state_entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let entries = (0..self.relaxing)
            .flat_map(|row| (0..self.nodes.len()).map(move |column| (row, column)));
        entries
            .map(|(row, column)| (row, self.nodes[column], self.states[(row, column)]))
            .filter(|(.., entry)| *entry != 0.0)
    }

    /// The nodes whose displacements, less that of the group they float with, relax.
    pub(crate) fn relaxing_nodes(&self) -> Vec<usize> {
        let row =
            |state: usize| (0..self.nodes.len()).find(|row| self.states[(state, *row)] == 1.0);
        (0..self.relaxing)
            .filter_map(|state| row(state).map(|row| self.nodes[row]))
            .collect()
    }

    /// The groups of nodes that follow at once as wholes.
    pub(crate) fn following_groups(&self) -> Vec<Vec<usize>> {
        let member = |row: &usize, column: usize| self.change[(*row, column)] == 1.0;
        (self.relaxing..self.nodes.len())
            .map(|column| {
                let rows = (0..self.nodes.len()).filter(|row| member(row, column));
                rows.map(|row| self.nodes[row]).collect()
            })
            .collect()
    }

    /// Groups massless nodes, given M and C.
    fn of(system: &System, m: MatRef<'_, f64>, c: MatRef<'_, f64>) -> Massless {
        let n = c.nrows();
        let has_mass = |i: &usize| (0..n).any(|j| m[(*i, j)] != 0.0 || m[(j, *i)] != 0.0);
        let (massive, nodes): (Vec<usize>, Vec<usize>) = (0..n).partition(has_mass);
        let p = nodes.len();
        let mut group: Vec<usize> = (0..p).collect();
        for (row, &i) in nodes.iter().enumerate() {
            for (column, &j) in nodes.iter().enumerate().take(row) {
                if c[(i, j)] != 0.0 || c[(j, i)] != 0.0 {
                    let (from, to) = (group[row], group[column]);
                    for member in group.iter_mut().filter(|member| **member == from) {
                        *member = to;
                    }
                }
            }
        }
        // A group floats if no damper leaves it. Where a damping matrix was added, only nodes that
        // it does not touch count as floating.
        let inside = |label: usize, i: usize| {
            nodes
                .iter()
                .position(|node| *node == i)
                .is_some_and(|at| group[at] == label)
        };
        let floats = |label: usize| {
            let members = nodes.iter().zip(&group).filter(|(_, g)| **g == label);
            let untouched = members
                .clone()
                .all(|(&i, _)| (0..n).all(|j| c[(i, j)] == 0.0 && c[(j, i)] == 0.0));
            let leaves = |element: &Element| {
                let ends = [element.first, element.second]
                    .map(|end| end.coordinate().is_some_and(|i| inside(label, i)));
                element.coefficient != 0.0 && ends[0] != ends[1]
            };
            let closed =
                system.added(MatrixKind::Damping).is_none() && !system.dampers().iter().any(leaves);
            untouched || closed
        };
        let mut roots = Vec::new();
        let mut relaxing = Vec::new();
        for row in 0..p {
            let label = group[row];
            let first = group
                .iter()
                .position(|g| *g == label)
                .expect("row is in its own group");
            if first == row && floats(label) {
                roots.push(row);
            } else {
                relaxing.push((row, roots.contains(&first).then_some(first)));
            }
        }
        let mut change = Mat::<f64>::zeros(p, p);
        let mut states = Mat::<f64>::zeros(relaxing.len(), p);
        for (column, (row, root)) in relaxing.iter().enumerate() {
            change[(*row, column)] = 1.0;
            states[(column, *row)] = 1.0;
            if let Some(root) = root {
                states[(column, *root)] = -1.0;
            }
        }
        for (column, root) in roots.iter().enumerate() {
            for row in (0..p).filter(|row| group[*row] == group[*root]) {
                change[(row, relaxing.len() + column)] = 1.0;
            }
        }
        Massless {
            massive,
            nodes,
            change,
            states,
            relaxing: relaxing.len(),
        }
    }
}

/// A square matrix ready to be divided by: by its diagonal where it has nothing else.
enum Factored {
    Diagonal(Vec<f64>),
    Lu(PartialPivLu<f64>),
}

impl Factored {
    /// `None` if it is singular.
    fn of(matrix: MatRef<'_, f64>) -> Option<Factored> {
        let n = matrix.nrows();
        let is_diagonal = (0..n).all(|i| (0..n).all(|j| i == j || matrix[(i, j)] == 0.0));
        if is_diagonal {
            let diagonal: Vec<f64> = (0..n).map(|i| matrix[(i, i)]).collect();
            return diagonal
                .iter()
                .all(|d| *d != 0.0)
                .then_some(Factored::Diagonal(diagonal));
        }
        let lu = matrix.partial_piv_lu();
        let nonsingular = (0..n).all(|i| lu.U()[(i, i)] != 0.0 && lu.U()[(i, i)].is_finite());
        nonsingular.then_some(Factored::Lu(lu))
    }

    fn solve(&self, right: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Factored::Diagonal(diagonal) => Mat::from_fn(right.nrows(), right.ncols(), |i, j| {
                right[(i, j)] / diagonal[i]
            }),
            Factored::Lu(lu) => lu.solve(right),
        }
    }
}
