//! Modes in double-double, by what modes in doubles leave of their equations.
//!
//! With E = RU of the residual R = WK + ΛWC + Λ²WM (see `modal_sum`) the rows of a block k change by ΣYₖⱼWⱼ over all others, where
//! ΛₖYₖⱼ − YₖⱼΛⱼ = −Eₖⱼ, and by −RₖD, and the block by −Eₖₖ: a step of Newton's method for all modes at once, which leaves what is
//! of second order in E (Dongarra, Moler & Wilkinson 1983, *SIAM J. Numer. Anal.* 20; Ogita & Aishima 2018, *Japan J. Indust.
//! Appl. Math.* 35). U is to be what makes the first two powers of s vanish in I − SZ, and changes by what is left of them.
//! Nothing is proved here.

use eigentone_digits::{DoubleDouble, product};
use faer::Mat;

/// A matrix in double-double, row by row.
pub(super) type Rows = Vec<Vec<DoubleDouble>>;

/// One or two rows of Λ.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) start: usize,
    /// By rows.
    pub(super) generator: Vec<DoubleDouble>,
}

impl Block {
    pub(super) fn width(&self) -> usize {
        self.generator.len().isqrt()
    }
}

/// Corrects W and the blocks, where modes are apart.
pub(super) fn corrected_weights(
    weights: &mut Rows,
    blocks: &mut [Block],
    shapes: &Mat<f64>,
    direct: Option<&Mat<f64>>,
    residual: &Rows,
) {
    /// Larger parts of other modes are those of nearly the same roots, of which a step of Newton's method knows nothing.
    const LARGEST: f64 = 0.01;
    let states = weights.len();
    let n = shapes.nrows();
    let residual = Mat::from_fn(states, n, |k, j| residual[k][j].to_f64());
    let left = product(residual.as_ref(), shapes.as_ref());
    let norms: Vec<f64> = weights
        .iter()
        .map(|row| row.iter().fold(0.0, |top, x| x.to_f64().abs().max(top)))
        .collect();
    let mut parts = Mat::<f64>::zeros(states, states);
    for own in blocks.iter() {
        let size = (0..own.width()).fold(0.0, |top, a| norms[own.start + a].max(top));
        for other in blocks.iter().filter(|other| other.start != own.start) {
            let at = |a: usize, b: usize| -left[(own.start + a, other.start + b)];
            let part = between(own, other, at);
            let reaches = |row: &[f64; 2]| -> f64 {
                let terms = row.iter().zip(&norms[other.start..]);
                terms.map(|(part, norm)| part.abs() * norm).sum()
            };
            if part.iter().all(|row| reaches(row) <= LARGEST * size) {
                for a in 0..own.width() {
                    for b in 0..other.width() {
                        parts[(own.start + a, other.start + b)] = part[a][b];
                    }
                }
            }
        }
    }
    let doubles = Mat::from_fn(states, n, |k, j| weights[k][j].to_f64());
    let mut change = product(parts.as_ref(), doubles.as_ref());
    if let Some(direct) = direct {
        change -= product(residual.as_ref(), direct.as_ref());
    }
    add(weights, &change);
    for block in blocks {
        let width = block.width();
        for (at, entry) in block.generator.iter_mut().enumerate() {
            let off = left[(block.start + at / width, block.start + at % width)];
            if off.is_finite() {
                *entry -= off.into();
            }
        }
    }
}

/// Y with ΛY − YΛ′ = G, by rows, of two blocks; not finite where they have a root in common.
fn between(own: &Block, other: &Block, g: impl Fn(usize, usize) -> f64) -> [[f64; 2]; 2] {
    let (p, q) = (own.width(), other.width());
    let at = |block: &Block, i: usize, j: usize| block.generator[i * block.width() + j];
    let g = |i: usize, j: usize| if i < p && j < q { g(i, j) } else { 0.0 };
    // With the polynomial x² − tx + d of Λ′, or x − t, it times Y at Λ is ΛG + GΛ′ − tG, or G: distances of roots need more
    // digits than these do.
    let (trace, determinant) = match q {
        1 => (at(other, 0, 0), DoubleDouble::ZERO),
        _ => (
            at(other, 0, 0) + at(other, 1, 1),
            at(other, 0, 0) * at(other, 1, 1) - at(other, 0, 1) * at(other, 1, 0),
        ),
    };
    let matrix = |i: usize, j: usize| -> f64 {
        if i >= p || j >= p {
            return if i == j { 1.0 } else { 0.0 };
        }
        let linear = at(own, i, j);
        let same = |value: DoubleDouble| if i == j { value } else { DoubleDouble::ZERO };
        let value = match q {
            1 => linear - same(trace),
            _ => {
                let square = (0..p).fold(DoubleDouble::ZERO, |sum, l| {
                    sum + at(own, i, l) * at(own, l, j)
                });
                square - linear * trace + same(determinant)
            }
        };
        value.to_f64()
    };
    let right = |i: usize, j: usize| -> f64 {
        if q == 1 || i >= p {
            return g(i, j);
        }
        let own = (0..p)
            .map(|l| at(own, i, l).to_f64() * g(l, j))
            .sum::<f64>();
        let others = (0..q)
            .map(|l| g(i, l) * at(other, l, j).to_f64())
            .sum::<f64>();
        own + others - trace.to_f64() * g(i, j)
    };
    let [a, b, c, d] = [matrix(0, 0), matrix(0, 1), matrix(1, 0), matrix(1, 1)];
    let inverse = (a * d - b * c).recip();
    let column = |j: usize| {
        let (first, second) = (right(0, j), right(1, j));
        [
            (d * first - b * second) * inverse,
            (a * second - c * first) * inverse,
        ]
    };
    let (first, second) = (column(0), if q == 1 { [0.0; 2] } else { column(1) });
    [[first[0], second[0]], [first[1], second[1]]]
}

/// Corrects U, given by rows, by what it leaves of 1 and of 0.
pub(super) fn corrected_shapes(shapes: &mut Rows, blocks: &[Block], left: [&Rows; 2]) {
    let n = shapes.len();
    let states = shapes.first().map_or(0, Vec::len);
    let doubles = Mat::from_fn(n, states, |i, k| shapes[i][k].to_f64());
    let mut turned = Mat::<f64>::zeros(n, states);
    for block in blocks {
        let width = block.width();
        for (at, entry) in block.generator.iter().enumerate() {
            let (a, b) = (block.start + at / width, block.start + at % width);
            (0..n).for_each(|i| turned[(i, b)] += doubles[(i, a)] * entry.to_f64());
        }
    }
    let [zeroth, first] = left.map(|left| Mat::from_fn(n, n, |i, j| -left[i][j].to_f64()));
    let mut change = product(zeroth.as_ref(), doubles.as_ref());
    change += product(first.as_ref(), turned.as_ref());
    add(shapes, &change);
}

/// Adds what is a number.
fn add(rows: &mut Rows, change: &Mat<f64>) {
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            if change[(i, j)].is_finite() {
                *entry += change[(i, j)].into();
            }
        }
    }
}
