//! Where a constant force leaves the coordinates once nothing moves: K x = f.
//!
//! Where K is built from springs that are not negative, nodes are eliminated one after the other as
//! in a star–mesh transformation of a resistor network: the springs of the node are replaced by
//! equivalent ones between its neighbours. No difference is ever formed (Grassmann, Taksar & Heyman
//! 1985, *Oper. Res.* 33), so that a spring of 1 beside one of 1e20 keeps its digits. What floats
//! comes out of it as a part whose last node has no spring left.

use eigentone_digits::{Lu, svd};
use eigentone_modes::{MatrixKind, System};
use faer::Mat;

/// The motions that K does not resist.
#[derive(Clone, Debug)]
pub(crate) struct Floating {
    /// n × d: displacements x with K x = 0.
    pub(crate) right: Mat<f64>,
    /// n × d: y with yᵀK = 0.
    pub(crate) left: Mat<f64>,
}

impl Floating {
    /// The parts of the proved structure; where `rigid` says that there are some, and these are not all, the singular
    /// vectors of K of the smallest singular values: as many as are proved, or where that is not proved as
    /// have rounding errors for values.
    pub(crate) fn of(system: &System, rigid: bool) -> Floating {
        let (n, structure) = (system.len(), system.structure());
        let parts = structure.spring_floating();
        let counted = match rigid {
            true => structure.rigid_motions_counted(),
            false => Some(0),
        };
        if !parts.is_empty() && counted.is_none_or(|count| count <= parts.len()) {
            let mut right = Mat::zeros(n, parts.len());
            for (column, part) in parts.iter().enumerate() {
                part.iter().for_each(|&i| right[(i, column)] = 1.0);
            }
            return Floating {
                left: right.clone(),
                right,
            };
        }
        let none = Floating {
            right: Mat::zeros(n, 0),
            left: Mat::zeros(n, 0),
        };
        if counted == Some(0) {
            return none;
        }
        let Some(svd) = svd(system.stiffness_matrix().as_ref()) else {
            return none;
        };
        let values = svd.S().column_vector();
        let limit = n as f64 * f64::EPSILON * values[0];
        let above = || (0..n).take_while(|&i| values[i] > limit).count();
        let rank = counted.map_or_else(above, |count| n - count);
        Floating {
            right: svd.V().subcols(rank, n - rank).to_owned(),
            left: svd.U().subcols(rank, n - rank).to_owned(),
        }
    }
}

/// A solution x in m of K x = `force`, with each floating part at an arbitrary place. There is none
/// where a net force acts on one of them; then its net force is taken up at an arbitrary node.
pub(crate) fn equilibrium(system: &System, floating: &Floating, force: &[f64]) -> Vec<f64> {
    if is_network(system) {
        by_elimination(system, force)
    } else {
        by_factors(system, floating, force)
    }
}

/// What rounding may have moved each coordinate of an [`equilibrium`], about: where no difference is formed, in parts of
/// what the sizes of the forces do to it, else in parts of the largest.
pub(crate) fn equilibrium_rounding(
    system: &System,
    floating: &Floating,
    force: &[f64],
) -> Vec<f64> {
    let sizes: Vec<f64> = force.iter().map(|force| force.abs()).collect();
    let unit = 4.0 * system.len() as f64 * f64::EPSILON;
    let most = equilibrium(system, floating, &sizes);
    let largest = most.iter().fold(0.0f64, |top, x| top.max(x.abs()));
    let each = most.iter().map(|x| match is_network(system) {
        true => unit * x.abs(),
        false => 16.0 * unit * largest,
    });
    each.collect()
}

/// Where the springs hold every coordinate under this constant force, for a motion to be computed as a deviation from
/// there: what decays towards it then keeps its digits. `None` where K is not proved to be regular, and
/// where nothing acts.
pub(crate) fn rest(system: &System, force: &[f64]) -> Option<Vec<f64>> {
    if force.iter().all(|force| *force == 0.0) || system.structure().zero_roots() != Some(0) {
        return None;
    }
    let nothing = Floating::of(system, false);
    let rest = equilibrium(system, &nothing, force);
    rest.iter().all(|x| x.is_finite()).then_some(rest)
}

/// Whether K is that of springs that are not negative.
fn is_network(system: &System) -> bool {
    let mut springs = system.springs().iter();
    system.added(MatrixKind::Stiffness).is_none() && springs.all(|spring| spring.coefficient >= 0.0)
}

/// Star–mesh elimination from the last coordinate to the first.
fn by_elimination(system: &System, force: &[f64]) -> Vec<f64> {
    let n = system.len();
    // Springs between coordinates, and in column n those to the ground.
    let mut springs = Mat::<f64>::zeros(n, n + 1);
    for spring in system.springs() {
        match (spring.first.coordinate(), spring.second.coordinate()) {
            (Some(i), Some(j)) => {
                springs[(i, j)] += spring.coefficient;
                springs[(j, i)] += spring.coefficient;
            }
            (Some(i), None) | (None, Some(i)) => springs[(i, n)] += spring.coefficient,
            (None, None) => {}
        }
    }
    let mut force = force.to_vec();
    let mut sums = vec![0.0; n];
    for k in (0..n).rev() {
        let joined: Vec<usize> = (0..k).filter(|&j| springs[(k, j)] != 0.0).collect();
        let sum = joined.iter().map(|&j| springs[(k, j)]).sum::<f64>() + springs[(k, n)];
        sums[k] = sum;
        if sum == 0.0 {
            continue;
        }
        for &i in &joined {
            let share = springs[(k, i)] / sum;
            force[i] += share * force[k];
            springs[(i, n)] += share * springs[(k, n)];
            for &j in joined.iter().filter(|&&j| j != i) {
                springs[(i, j)] += share * springs[(k, j)];
            }
        }
    }
    let mut displacement = vec![0.0; n];
    for k in 0..n {
        if sums[k] != 0.0 {
            let pulled: f64 = (0..k).map(|j| springs[(k, j)] * displacement[j]).sum();
            displacement[k] = (force[k] + pulled) / sums[k];
        }
    }
    displacement
}

/// LU factors of K, bordered by what floats so that they exist: [K W; Nᵀ 0] [x; q] = [f; 0].
fn by_factors(system: &System, floating: &Floating, force: &[f64]) -> Vec<f64> {
    let n = system.len();
    let d = floating.right.ncols();
    let stiffness = system.stiffness_matrix();
    let scale = stiffness.norm_max();
    let bordered = Mat::from_fn(n + d, n + d, |i, j| match (i < n, j < n) {
        (true, true) => stiffness[(i, j)],
        (true, false) => scale * floating.left[(i, j - n)],
        (false, true) => scale * floating.right[(j, i - n)],
        (false, false) => 0.0,
    });
    let right = Mat::from_fn(n + d, 1, |i, _| if i < n { force[i] } else { 0.0 });
    let solution = Lu::of(bordered.as_ref()).solve(right);
    (0..n).map(|i| solution[(i, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::GROUND;

    fn rest(system: &System, force: &[f64]) -> Vec<f64> {
        let floating = Floating::of(system, true);
        equilibrium(system, &floating, force)
    }

    #[test]
    fn a_spring_of_1_beside_one_of_1e20_keeps_its_digits() {
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .mass("c", 1.0)
            .spring(GROUND, "a", 1e20)
            .spring("a", "b", 3.0)
            .spring("b", "c", 1e20)
            .build()
            .expect("a system");
        let x = rest(&system, &[0.0, 0.0, 1.5]);
        // Springs in a row: their extensions add up.
        let wanted = [1.5e-20, 0.5 + 1.5e-20, 0.5 + 3e-20];
        for (x, wanted) in x.iter().zip(wanted) {
            assert!((x - wanted).abs() <= 4.0 * f64::EPSILON * wanted, "{x:e}");
        }
    }

    #[test]
    fn springs_and_their_assembled_matrix_agree() {
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .mass("c", 1.0)
            .spring(GROUND, "a", 6.0)
            .spring("a", "b", 7.0)
            .spring("b", "c", 4.0)
            .spring("c", "a", 2.0)
            .build()
            .expect("a system");
        let whole = System::from_matrices(
            system.mass_matrix().as_ref(),
            system.damping_matrix().as_ref(),
            system.stiffness_matrix().as_ref(),
        )
        .expect("a system");
        let force = [3.0, -9.0, 12.0];
        let (a, b) = (rest(&system, &force), rest(&whole, &force));
        let k = system.stiffness_matrix();
        for i in 0..3 {
            assert!((a[i] - b[i]).abs() < 1e-14);
            let pulled: f64 = (0..3).map(|j| k[(i, j)] * a[j]).sum();
            assert!((pulled - force[i]).abs() < 1e-13);
        }
    }

    #[test]
    fn what_floats_is_still_stretched() {
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 2.0)
            .spring("a", "b", 5.0)
            .build()
            .expect("a system");
        let x = rest(&system, &[-10.0, 10.0]);
        assert_eq!(x[1] - x[0], 2.0);
        let free = Floating::of(&system, true);
        assert_eq!(free.right.ncols(), 1);
    }

    /// A lever, 5(a − 2b)²: it moves freely with a = 2b, which no node shows, so that what floats comes from
    /// singular vectors.
    #[test]
    fn what_floats_by_its_matrix_is_still_stretched() {
        let stiffness = faer::mat![[5.0, -10.0], [-10.0, 20.0]];
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 2.0)
            .matrix(MatrixKind::Stiffness, stiffness.as_ref())
            .build()
            .expect("a system");
        let free = Floating::of(&system, true);
        for shapes in [&free.right, &free.left] {
            assert_eq!(shapes.ncols(), 1);
            assert!((shapes[(0, 0)] - 2.0 * shapes[(1, 0)]).abs() < 1e-15);
        }
        let x = equilibrium(&system, &free, &[-10.0, 20.0]);
        assert!((x[0] - 2.0 * x[1] + 2.0).abs() < 1e-14);
        // What is held has nothing that floats.
        let free = Floating::of(&system, false);
        assert_eq!((free.right.ncols(), free.left.ncols()), (0, 0));
    }
}
