//! Meshes of finite elements, assembled in doubles as programs do.

use eigentone_modes::{Modes, Precision, System};
use faer::Mat;

/// M, C and K.
#[derive(Clone)]
pub struct Model {
    pub mass: Mat<f64>,
    pub damping: Mat<f64>,
    pub stiffness: Mat<f64>,
}

impl Model {
    fn new(n: usize) -> Model {
        let zero = Mat::zeros(n, n);
        Model {
            mass: zero.clone(),
            damping: zero.clone(),
            stiffness: zero,
        }
    }

    pub fn order(&self) -> usize {
        self.mass.nrows()
    }

    /// How far from the diagonal entries lie.
    pub fn band(&self) -> usize {
        let n = self.order();
        let is_set = |i: usize, j: usize| {
            let each = [&self.mass, &self.damping, &self.stiffness];
            each.iter().any(|matrix| matrix[(i, j)] != 0.0)
        };
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let set = pairs.filter(|(i, j)| is_set(*i, *j));
        set.map(|(i, j)| i.abs_diff(j)).max().unwrap_or(0)
    }

    pub fn modes(&self, precision: Precision) -> Modes {
        let [mass, damping, stiffness] =
            [&self.mass, &self.damping, &self.stiffness].map(|matrix| matrix.as_ref());
        let system = System::from_matrices(mass, damping, stiffness).expect("a regular system");
        system.modes_to(precision).expect("modes")
    }

    /// αM + βK as damping.
    pub fn rayleigh(mut self, alpha: f64, beta: f64) -> Model {
        let n = self.order();
        self.damping = Mat::from_fn(n, n, |i, j| {
            alpha * self.mass[(i, j)] + beta * self.stiffness[(i, j)]
        });
        self
    }

    /// A damper from a coordinate to the ground.
    pub fn damper(mut self, at: usize, damping: f64) -> Model {
        self.damping[(at, at)] += damping;
        self
    }

    /// With entries of K below the diagonal off by a last digit or not, as sums of elements in another order are.
    pub fn unsymmetric(mut self) -> Model {
        let n = self.order();
        for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let units = ((7 * i + 5 * j) % 3) as f64 - 1.0;
            self.stiffness[(i, j)] *= 1.0 + units * f64::EPSILON;
        }
        self
    }

    /// The same shape in two planes, which a rotation at `speed` couples.
    pub fn rotating(&self, speed: f64) -> Model {
        self.in_two_planes(|i, j| 2.0 * speed * self.mass[(i, j)])
    }

    /// The same beam in two planes, which discs at every second node couple: those of angular momentum `momentum` about the
    /// axis turn one slope by the other's velocity.
    pub fn with_discs(&self, ends: Ends, momentum: f64) -> Model {
        let first = if ends == Ends::Pinned { 0 } else { 1 };
        let is_disc = |i: usize| i >= first && (i - first).is_multiple_of(4);
        self.in_two_planes(|i, j| if i == j && is_disc(i) { momentum } else { 0.0 })
    }

    /// Two planes that damping couples, given from the first to the second.
    fn in_two_planes(&self, across: impl Fn(usize, usize) -> f64) -> Model {
        let n = self.order();
        let place = |i: usize| (i / 2, i % 2);
        let both = |matrix: &Mat<f64>| {
            Mat::from_fn(2 * n, 2 * n, |i, j| {
                let ((i, p), (j, q)) = (place(i), place(j));
                if p == q { matrix[(i, j)] } else { 0.0 }
            })
        };
        let damping = Mat::from_fn(2 * n, 2 * n, |i, j| {
            let ((i, p), (j, q)) = (place(i), place(j));
            (q as f64 - p as f64) * across(i, j)
        });
        Model {
            mass: both(&self.mass),
            damping,
            stiffness: both(&self.stiffness),
        }
    }

    fn add(&mut self, at: &[usize], mass: &[&[f64]], stiffness: &[&[f64]]) {
        for (p, i) in at.iter().enumerate() {
            for (q, j) in at.iter().enumerate() {
                self.mass[(*i, *j)] += mass[p][q];
                self.stiffness[(*i, *j)] += stiffness[p][q];
            }
        }
    }

    /// A beam held at its ends.
    fn at(self, ends: Ends) -> Model {
        let n = self.order();
        match ends {
            Ends::Free => self,
            Ends::Clamped => self.held(&[0, 1, n - 2, n - 1]),
            Ends::Pinned => self.held(&[0, n - 2]),
            Ends::Cantilever => self.held(&[0, 1]),
        }
    }

    /// Without some coordinates.
    fn held(&self, fixed: &[usize]) -> Model {
        let kept: Vec<usize> = (0..self.order()).filter(|i| !fixed.contains(i)).collect();
        let part = |matrix: &Mat<f64>| {
            Mat::from_fn(kept.len(), kept.len(), |i, j| matrix[(kept[i], kept[j])])
        };
        Model {
            mass: part(&self.mass),
            damping: part(&self.damping),
            stiffness: part(&self.stiffness),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ends {
    Free,
    Clamped,
    Pinned,
    Cantilever,
}

/// An Euler–Bernoulli beam of 2 m with EI = 1500 N·m² and 3.1 kg/m: deflection and slope at each node, consistent mass.
pub fn beam(elements: usize, ends: Ends) -> Model {
    let h = 2.0 / elements as f64;
    let (k, m) = (1500.0 / (h * h * h), 3.1 * h / 420.0);
    let s = |x: f64| k * x;
    let t = |x: f64| m * x;
    let stiffness = [
        [s(12.0), s(6.0 * h), s(-12.0), s(6.0 * h)],
        [s(6.0 * h), s(4.0 * h * h), s(-6.0 * h), s(2.0 * h * h)],
        [s(-12.0), s(-6.0 * h), s(12.0), s(-6.0 * h)],
        [s(6.0 * h), s(2.0 * h * h), s(-6.0 * h), s(4.0 * h * h)],
    ];
    let mass = [
        [t(156.0), t(22.0 * h), t(54.0), t(-13.0 * h)],
        [t(22.0 * h), t(4.0 * h * h), t(13.0 * h), t(-3.0 * h * h)],
        [t(54.0), t(13.0 * h), t(156.0), t(-22.0 * h)],
        [t(-13.0 * h), t(-3.0 * h * h), t(-22.0 * h), t(4.0 * h * h)],
    ];
    let n = 2 * elements + 2;
    let mut model = Model::new(n);
    for e in 0..elements {
        let at: Vec<usize> = (2 * e..2 * e + 4).collect();
        model.add(
            &at,
            &mass.each_ref().map(|r| &r[..]),
            &stiffness.each_ref().map(|r| &r[..]),
        );
    }
    model.at(ends)
}

/// The same with all mass at the nodes, none of which resists rotation.
pub fn lumped_beam(elements: usize, ends: Ends) -> Model {
    let mut model = beam(elements, Ends::Free);
    model.mass.fill(0.0);
    let each = 3.1 * 2.0 / elements as f64;
    for node in 0..=elements {
        let is_end = node == 0 || node == elements;
        model.mass[(2 * node, 2 * node)] = if is_end { 0.5 * each } else { each };
    }
    model.at(ends)
}

/// A membrane of 1 m × 1 m with unit tension and mass, bilinear elements; its edge held or free.
pub fn membrane(columns: usize, rows: usize, held: bool) -> Model {
    let (a, b) = (1.0 / columns as f64, 1.0 / rows as f64);
    let (p, q) = (b / (6.0 * a), a / (6.0 * b));
    let stiffness = [
        [2.0 * p + 2.0 * q, -2.0 * p + q, -p - q, p - 2.0 * q],
        [-2.0 * p + q, 2.0 * p + 2.0 * q, p - 2.0 * q, -p - q],
        [-p - q, p - 2.0 * q, 2.0 * p + 2.0 * q, -2.0 * p + q],
        [p - 2.0 * q, -p - q, -2.0 * p + q, 2.0 * p + 2.0 * q],
    ];
    let m = a * b / 36.0;
    let mass = [
        [4.0 * m, 2.0 * m, m, 2.0 * m],
        [2.0 * m, 4.0 * m, 2.0 * m, m],
        [m, 2.0 * m, 4.0 * m, 2.0 * m],
        [2.0 * m, m, 2.0 * m, 4.0 * m],
    ];
    let node = |i: usize, j: usize| i * (rows + 1) + j;
    let mut model = Model::new((columns + 1) * (rows + 1));
    let mut edge = Vec::new();
    for i in 0..=columns {
        for j in 0..=rows {
            if i == 0 || j == 0 || i == columns || j == rows {
                edge.push(node(i, j));
            }
            if i < columns && j < rows {
                let at = [
                    node(i, j),
                    node(i + 1, j),
                    node(i + 1, j + 1),
                    node(i, j + 1),
                ];
                model.add(
                    &at,
                    &mass.each_ref().map(|r| &r[..]),
                    &stiffness.each_ref().map(|r| &r[..]),
                );
            }
        }
    }
    if held { model.held(&edge) } else { model }
}

/// A plane truss of so many square bays with both diagonals, bars of EA = 1e7 N, lumped masses; pinned at its left end, or
/// free.
pub fn truss(bays: usize, held: bool) -> Model {
    let n = 4 * bays + 4;
    let mut model = Model::new(n);
    let node = |column: usize, row: usize| 2 * column + row;
    let mut bar = |(c, r): (usize, usize), (d, s): (usize, usize)| {
        let (x, y) = (d as f64 - c as f64, s as f64 - r as f64);
        let length = x.hypot(y);
        let k = 1e7 / length;
        let along = [-x / length, -y / length, x / length, y / length];
        let (first, second) = (node(c, r), node(d, s));
        let at = [2 * first, 2 * first + 1, 2 * second, 2 * second + 1];
        for (p, i) in at.iter().enumerate() {
            model.mass[(*i, *i)] += 3.9 * length;
            for (q, j) in at.iter().enumerate() {
                model.stiffness[(*i, *j)] += k * along[p] * along[q];
            }
        }
    };
    for c in 0..=bays {
        bar((c, 0), (c, 1));
        if c < bays {
            bar((c, 0), (c + 1, 0));
            bar((c, 1), (c + 1, 1));
            bar((c, 0), (c + 1, 1));
            bar((c, 1), (c + 1, 0));
        }
    }
    if held {
        model.held(&[0, 1, 2, 3])
    } else {
        model
    }
}

/// Integrals of products of cubic Hermite polynomials over a length: values, slopes, curvatures, and curvatures by values.
fn hermite(h: f64) -> [[[f64; 4]; 4]; 4] {
    let shapes = [
        [1.0, 0.0, -3.0, 2.0],
        [0.0, h, -2.0 * h, h],
        [0.0, 0.0, 3.0, -2.0],
        [0.0, 0.0, -h, h],
    ];
    let derivative = |p: [f64; 4]| [p[1] / h, 2.0 * p[2] / h, 3.0 * p[3] / h, 0.0];
    let integral = |p: [f64; 4], q: [f64; 4]| {
        let terms = (0..16).map(|k| p[k / 4] * q[k % 4] / (k / 4 + k % 4 + 1) as f64);
        h * terms.sum::<f64>()
    };
    let all =
        |left: [[f64; 4]; 4], right: [[f64; 4]; 4]| left.map(|p| right.map(|q| integral(p, q)));
    let slopes = shapes.map(derivative);
    let curvatures = slopes.map(derivative);
    [
        all(shapes, shapes),
        all(slopes, slopes),
        all(curvatures, curvatures),
        all(curvatures, shapes),
    ]
}

/// A free plate of 1.2 m × 0.9 m, Dν = 180 N·m and 7.8 kg/m², of Bogner, Fox and Schmit's elements.
pub fn plate(columns: usize, rows: usize) -> Model {
    const POISSON: f64 = 0.3;
    let [value, slope, curvature, mixed] = hermite(1.2 / columns as f64);
    let across = hermite(0.9 / rows as f64);
    let mut model = Model::new(4 * (columns + 1) * (rows + 1));
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let place = |k: usize| {
            let (p, q) = (k / 4, k % 4);
            4 * ((i + p / 2) * (rows + 1) + j + q / 2) + p % 2 + 2 * (q % 2)
        };
        let at: Vec<usize> = (0..16).map(place).collect();
        for (k, l) in (0..16).flat_map(|k| (0..16).map(move |l| (k, l))) {
            // Symmetric to the last bit.
            let (a, b) = (k.min(l), k.max(l));
            let (p, q, r, s) = (a / 4, a % 4, b / 4, b % 4);
            let bending = curvature[p][r] * across[0][q][s] + value[p][r] * across[2][q][s];
            let coupling = mixed[p][r] * across[3][s][q] + mixed[r][p] * across[3][q][s];
            let twist = 2.0 * (1.0 - POISSON) * slope[p][r] * across[1][q][s];
            model.stiffness[(at[k], at[l])] += 180.0 * (bending + POISSON * coupling + twist);
            model.mass[(at[k], at[l])] += 7.8 * value[p][r] * across[0][q][s];
        }
    }
    model
}

/// A free plane frame of one bay of 5 m and storeys of 3.2 m, steel members of so many elements: two displacements and a
/// rotation at each node, level by level.
pub fn frame(storeys: usize, elements: usize) -> Model {
    const AXIAL: f64 = 2.1e11 * 5.4e-3;
    const BENDING: f64 = 2.1e11 * 3.7e-5;
    const MASS: f64 = 7850.0 * 5.4e-3;
    // Above the feet each storey has the nodes of both columns, then those of its beam.
    let each = 3 * elements - 1;
    let joint = |storey: usize, side: usize| match storey {
        0 => side,
        _ => 2 + (storey - 1) * each + 2 * (elements - 1) + side * elements,
    };
    let mut model = Model::new(3 * (2 + storeys * each));
    let mut add = |first: usize, second: usize, length: f64, upright: bool| {
        // Along and across the member, and the rotation, in global axes.
        let axis = if upright { [1, 0, 2] } else { [0, 1, 2] };
        let turned = if upright { -1.0 } else { 1.0 };
        let place = |node: usize, part: usize| 3 * node + axis[part];
        let bar = [first, second].map(|node| place(node, 0));
        let bend = [(first, 1), (first, 2), (second, 1), (second, 2)];
        let bend = bend.map(|(node, part)| place(node, part));
        let [value, _, curvature, _] = hermite(length);
        let sign = |k: usize| if k.is_multiple_of(2) { turned } else { 1.0 };
        for (k, l) in (0..4).flat_map(|k| (0..4).map(move |l| (k, l))) {
            let (a, b) = (k.min(l), k.max(l));
            let sign = sign(a) * sign(b);
            model.stiffness[(bend[k], bend[l])] += sign * BENDING * curvature[a][b];
            model.mass[(bend[k], bend[l])] += sign * MASS * value[a][b];
        }
        for (k, l) in (0..2).flat_map(|k| (0..2).map(move |l| (k, l))) {
            let (spring, mass) = if k == l { (1.0, 3.0) } else { (-1.0, 6.0) };
            model.stiffness[(bar[k], bar[l])] += spring * AXIAL / length;
            model.mass[(bar[k], bar[l])] += MASS * length / mass;
        }
    };
    for storey in 1..=storeys {
        let start = 2 + (storey - 1) * each;
        for side in 0..2 {
            let nodes = (0..elements - 1).map(|k| start + 2 * k + side);
            let nodes = nodes.chain([joint(storey, side)]);
            let mut below = joint(storey - 1, side);
            for node in nodes {
                add(below, node, 3.2 / elements as f64, true);
                below = node;
            }
        }
        let left = joint(storey, 0);
        for k in 0..elements {
            add(left + k, left + k + 1, 5.0 / elements as f64, false);
        }
    }
    model
}

/// A plane ring of eight steel members of 1 m, 10 mm square, with lumped masses and rotations that have none; one displacement of its
/// first node is held, and two rigid motions are not.
pub fn octagon() -> Model {
    const AXIAL: f64 = 2.1e7;
    const BENDING: f64 = 175.0;
    const MASS: f64 = 0.785;
    let half = 2f64.sqrt() / 2.0;
    let directions = [
        [1.0, 0.0],
        [half, half],
        [0.0, 1.0],
        [-half, half],
        [-1.0, 0.0],
        [-half, -half],
        [0.0, -1.0],
        [half, -half],
    ];
    let mut model = Model::new(24);
    for (node, along) in directions.into_iter().enumerate() {
        let across = [-along[1], along[0]];
        let place = |end: usize, part: usize| 3 * ((node + end) % 8) + part;
        for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let sign = |end: usize| if end == 0 { 1.0 } else { -1.0 };
            let stiffness = &mut model.stiffness;
            for i in 0..2 {
                for j in 0..2 {
                    let bar = AXIAL * (along[i] * along[j]);
                    let beam = 12.0 * BENDING * (across[i] * across[j]);
                    stiffness[(place(p, i), place(q, j))] += sign(p) * sign(q) * (bar + beam);
                }
                let lever = sign(p) * 6.0 * BENDING * across[i];
                stiffness[(place(p, i), place(q, 2))] += lever;
                stiffness[(place(q, 2), place(p, i))] += lever;
            }
            let slope = if p == q { 4.0 } else { 2.0 };
            stiffness[(place(p, 2), place(q, 2))] += slope * BENDING;
        }
        for (end, part) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let at = place(end, part);
            model.mass[(at, at)] += 0.5 * MASS;
        }
    }
    model.held(&[0])
}

/// Masses of 1 kg in a row with springs of 1 N/m between them, and 2⁻⁵⁰ N/m more at one end than nothing, less at the other.
pub fn chain(n: usize) -> Model {
    let mut model = Model::new(n);
    for i in 0..n {
        model.mass[(i, i)] = 1.0;
    }
    for i in 1..n {
        let spring: [&[f64]; 2] = [&[1.0, -1.0], &[-1.0, 1.0]];
        let nothing: [&[f64]; 2] = [&[0.0; 2]; 2];
        model.add(&[i - 1, i], &nothing, &spring);
    }
    let more = 2f64.powi(-50);
    model.stiffness[(0, 0)] += more;
    model.stiffness[(n - 1, n - 1)] -= more;
    model
}
