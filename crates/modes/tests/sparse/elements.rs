//! Finite elements: beams, rods, membranes, frames, as matrices of doubles.

use eigentone_modes::{MatrixKind, System};
use faer::sparse::{SparseColMat, Triplet};
use std::collections::BTreeMap;

/// A symmetric matrix under assembly, its entries summed in doubles.
#[derive(Clone, Debug, Default)]
pub struct Assembly {
    pub entries: BTreeMap<(usize, usize), f64>,
}

impl Assembly {
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        *self.entries.entry((i, j)).or_default() += value;
    }

    fn element<const N: usize>(&mut self, places: [Option<usize>; N], matrix: [[f64; N]; N]) {
        for (a, row) in places.iter().zip(&matrix) {
            for (b, value) in places.iter().zip(row) {
                if let (Some(a), Some(b)) = (a, b) {
                    self.add(*a, *b, *value);
                }
            }
        }
    }

    pub fn sparse(&self, n: usize) -> SparseColMat<usize, f64> {
        let entries = self.entries.iter();
        let entries: Vec<_> = entries
            .map(|(&(i, j), &value)| Triplet::new(i, j, value))
            .collect();
        SparseColMat::try_new_from_triplets(n, n, &entries).expect("a matrix")
    }
}

/// K and M of order n, and C.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub n: usize,
    pub stiffness: Assembly,
    pub mass: Assembly,
    pub damping: Assembly,
}

impl Model {
    pub fn system(&self) -> System {
        let mut builder = System::builder()
            .sparse_matrix(MatrixKind::Mass, self.mass.sparse(self.n))
            .sparse_matrix(MatrixKind::Stiffness, self.stiffness.sparse(self.n));
        if !self.damping.entries.is_empty() {
            builder = builder.sparse_matrix(MatrixKind::Damping, self.damping.sparse(self.n));
        }
        builder.build().expect("a system")
    }

    /// The same with C = αM + βK, each entry rounded once: exactly that where both are powers of two.
    pub fn proportional(mut self, alpha: f64, beta: f64) -> Model {
        for (part, factor) in [(&self.mass, alpha), (&self.stiffness, beta)] {
            for (&(i, j), value) in &part.entries {
                self.damping.add(i, j, factor * value);
            }
        }
        self
    }
}

#[derive(Clone, Copy, Debug)]
pub enum Ends {
    Free,
    Clamped,
    Pinned,
    Cantilever,
}

/// An Euler–Bernoulli beam of Hermite's cubic elements with consistent masses.
pub fn beam(ends: Ends, elements: usize, length: f64, rigidity: f64, mass: f64) -> Model {
    let h = length / elements as f64;
    let k = rigidity / (h * h * h);
    let m = mass * h / 420.0;
    let stiffness = [
        [12.0 * k, 6.0 * h * k, -12.0 * k, 6.0 * h * k],
        [6.0 * h * k, 4.0 * h * h * k, -6.0 * h * k, 2.0 * h * h * k],
        [-12.0 * k, -6.0 * h * k, 12.0 * k, -6.0 * h * k],
        [6.0 * h * k, 2.0 * h * h * k, -6.0 * h * k, 4.0 * h * h * k],
    ];
    let inertia = [
        [156.0 * m, 22.0 * h * m, 54.0 * m, -13.0 * h * m],
        [
            22.0 * h * m,
            4.0 * h * h * m,
            13.0 * h * m,
            -3.0 * h * h * m,
        ],
        [54.0 * m, 13.0 * h * m, 156.0 * m, -22.0 * h * m],
        [
            -13.0 * h * m,
            -3.0 * h * h * m,
            -22.0 * h * m,
            4.0 * h * h * m,
        ],
    ];
    let last = 2 * elements;
    let held: &[usize] = match ends {
        Ends::Free => &[],
        Ends::Clamped => &[0, 1, last, last + 1],
        Ends::Pinned => &[0, last],
        Ends::Cantilever => &[0, 1],
    };
    let place =
        |i: usize| (!held.contains(&i)).then(|| i - held.iter().filter(|&&held| held < i).count());
    let mut model = Model {
        n: last + 2 - held.len(),
        ..Model::default()
    };
    for element in 0..elements {
        let places = [0, 1, 2, 3].map(|i| place(2 * element + i));
        model.stiffness.element(places, stiffness);
        model.mass.element(places, inertia);
    }
    model
}

/// A square membrane of side × side inner nodes held at its rim: bilinear elements, consistent masses. Most of
/// its eigenvalues are double.
pub fn membrane(side: usize) -> Model {
    let stiffness = [
        [4.0, -1.0, -1.0, -2.0],
        [-1.0, 4.0, -2.0, -1.0],
        [-1.0, -2.0, 4.0, -1.0],
        [-2.0, -1.0, -1.0, 4.0],
    ];
    let inertia = [
        [4.0, 2.0, 2.0, 1.0],
        [2.0, 4.0, 1.0, 2.0],
        [2.0, 1.0, 4.0, 2.0],
        [1.0, 2.0, 2.0, 4.0],
    ];
    let inside = |i: usize| (1..=side).contains(&i);
    let node = |i: usize, j: usize| (inside(i) && inside(j)).then(|| (i - 1) * side + j - 1);
    let mut model = Model {
        n: side * side,
        ..Model::default()
    };
    for i in 0..=side {
        for j in 0..=side {
            let places = [
                node(i, j),
                node(i, j + 1),
                node(i + 1, j),
                node(i + 1, j + 1),
            ];
            model.stiffness.element(places, stiffness);
            model.mass.element(places, inertia);
        }
    }
    model
}

/// A free plane frame: bars of axial stiffness and bending between nodes, u, w and the rotation of each node.
pub fn frame(nodes: &[[f64; 2]], bars: &[[usize; 2]], [axial, bending, mass]: [f64; 3]) -> Model {
    let mut model = Model {
        n: 3 * nodes.len(),
        ..Model::default()
    };
    for &[a, b] in bars {
        let [dx, dy] = [nodes[b][0] - nodes[a][0], nodes[b][1] - nodes[a][1]];
        let h = dx.hypot(dy);
        let (c, s) = (dx / h, dy / h);
        // Local displacements from global ones.
        let turn = |local: [[f64; 6]; 6]| {
            let mut t = [[0.0; 6]; 6];
            for end in [0, 3] {
                t[end][end] = c;
                t[end][end + 1] = s;
                t[end + 1][end] = -s;
                t[end + 1][end + 1] = c;
                t[end + 2][end + 2] = 1.0;
            }
            let mut turned = [[0.0; 6]; 6];
            for i in 0..6 {
                for j in i..6 {
                    let mut sum = 0.0;
                    for p in 0..6 {
                        for q in 0..6 {
                            sum += t[p][i] * local[p][q] * t[q][j];
                        }
                    }
                    turned[i][j] = sum;
                    turned[j][i] = sum;
                }
            }
            turned
        };
        let (e, k, m) = (axial / h, bending / (h * h * h), mass * h / 420.0);
        let (k1, k2, k4) = (6.0 * h * k, 2.0 * h * h * k, 4.0 * h * h * k);
        let stiffness = [
            [e, 0.0, 0.0, -e, 0.0, 0.0],
            [0.0, 12.0 * k, k1, 0.0, -12.0 * k, k1],
            [0.0, k1, k4, 0.0, -k1, k2],
            [-e, 0.0, 0.0, e, 0.0, 0.0],
            [0.0, -12.0 * k, -k1, 0.0, 12.0 * k, -k1],
            [0.0, k1, k2, 0.0, -k1, k4],
        ];
        let (m1, m2, m3) = (22.0 * h * m, 13.0 * h * m, 4.0 * h * h * m);
        let m4 = -3.0 * h * h * m;
        let inertia = [
            [140.0 * m, 0.0, 0.0, 70.0 * m, 0.0, 0.0],
            [0.0, 156.0 * m, m1, 0.0, 54.0 * m, -m2],
            [0.0, m1, m3, 0.0, m2, m4],
            [70.0 * m, 0.0, 0.0, 140.0 * m, 0.0, 0.0],
            [0.0, 54.0 * m, m2, 0.0, 156.0 * m, -m1],
            [0.0, -m2, m4, 0.0, -m1, m3],
        ];
        let places = [3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + 1, 3 * b + 2].map(Some);
        model.stiffness.element(places, turn(stiffness));
        model.mass.element(places, turn(inertia));
    }
    model
}

/// A pin-jointed bar structure with lumped masses: a mechanism where bars are few.
pub fn truss(nodes: &[[f64; 2]], bars: &[[usize; 2]], axial: f64, mass: f64) -> Model {
    let mut model = Model {
        n: 2 * nodes.len(),
        ..Model::default()
    };
    for i in 0..model.n {
        model.mass.add(i, i, mass);
    }
    for &[a, b] in bars {
        let [dx, dy] = [nodes[b][0] - nodes[a][0], nodes[b][1] - nodes[a][1]];
        let h = dx.hypot(dy);
        let direction = [-dx / h, -dy / h, dx / h, dy / h];
        let mut matrix = [[0.0; 4]; 4];
        for i in 0..4 {
            for j in 0..4 {
                matrix[i][j] = axial / h * direction[i] * direction[j];
            }
        }
        let places = [2 * a, 2 * a + 1, 2 * b, 2 * b + 1].map(Some);
        model.stiffness.element(places, matrix);
    }
    model
}

/// A rod of linear elements, its stiffness growing by a factor from each element to the next.
pub fn rod(elements: usize, first: f64, factor: f64, held: bool) -> Model {
    let skipped = usize::from(held);
    let place = |i: usize| i.checked_sub(skipped);
    let mut model = Model {
        n: elements + 1 - skipped,
        ..Model::default()
    };
    let mut k = first;
    for element in 0..elements {
        let places = [place(element), place(element + 1)];
        model.stiffness.element(places, [[k, -k], [-k, k]]);
        model.mass.element(places, [[2.0, 1.0], [1.0, 2.0]]);
        k *= factor;
    }
    model
}
