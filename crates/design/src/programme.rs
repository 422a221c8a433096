//! The least of t + ½dᵀBd with f_j + g_jᵀd ≤ t and limits of d, B positive definite, by active sets (Fletcher 1987,
//! *Practical methods of optimization*, §10.3). It starts at d = 0.

use faer::Mat;
use faer::linalg::solvers::Solve;

pub(crate) struct Programme<'a> {
    /// f_j.
    pub(crate) values: Vec<f64>,
    /// g_j.
    pub(crate) gradients: &'a [Vec<f64>],
    /// B.
    pub(crate) curvature: Mat<f64>,
    /// Limits of d, which 0 keeps.
    pub(crate) low: Vec<f64>,
    pub(crate) high: Vec<f64>,
}

pub(crate) struct Step {
    /// d.
    pub(crate) by: Vec<f64>,
    /// t + ½dᵀBd.
    pub(crate) value: f64,
    /// Multipliers of the functions, which add up to 1.
    pub(crate) weights: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Constraint {
    Function(usize),
    Low(usize),
    High(usize),
}

impl Programme<'_> {
    /// `None` where the numbers leave no step.
    pub(crate) fn solve(&self) -> Option<Step> {
        let n = self.low.len();
        let mut d = vec![0.0; n];
        let top =
            (0..self.values.len()).max_by(|a, b| self.values[*a].total_cmp(&self.values[*b]))?;
        let mut t = self.values[top];
        let mut kept = vec![Constraint::Function(top)];
        for _ in 0..200 {
            let (goal, goal_t, multipliers) = self.on(&kept)?;
            let step: Vec<f64> = goal.iter().zip(&d).map(|(to, from)| to - from).collect();
            let rise = goal_t - t;
            let (mut share, mut blocks) = (1.0, None);
            let functions = (0..self.values.len()).map(Constraint::Function);
            let limits = (0..n).flat_map(|i| [Constraint::Low(i), Constraint::High(i)]);
            for constraint in functions.chain(limits).filter(|c| !kept.contains(c)) {
                // How far it is from being met with equality, and how fast that shrinks.
                let (room, speed) = match constraint {
                    Constraint::Function(j) => {
                        let along = |d: &[f64]| dot(&self.gradients[j], d);
                        (t - self.values[j] - along(&d), along(&step) - rise)
                    }
                    Constraint::Low(i) => (d[i] - self.low[i], -step[i]),
                    Constraint::High(i) => (self.high[i] - d[i], step[i]),
                };
                if speed > 0.0 && room.max(0.0) < share * speed {
                    share = room.max(0.0) / speed;
                    blocks = Some(constraint);
                }
            }
            d.iter_mut().zip(&step).for_each(|(d, s)| *d += share * s);
            t += share * rise;
            if let Some(blocks) = blocks {
                kept.push(blocks);
                continue;
            }
            let worst =
                (0..kept.len()).min_by(|a, b| multipliers[*a].total_cmp(&multipliers[*b]))?;
            if multipliers[worst] < 0.0 && kept.len() > 1 {
                kept.remove(worst);
                continue;
            }
            let mut weights = vec![0.0; self.values.len()];
            for (constraint, multiplier) in kept.iter().zip(multipliers) {
                if let Constraint::Function(j) = constraint {
                    weights[*j] = multiplier;
                }
            }
            let bent = (0..n).map(|i| {
                (0..n)
                    .map(|k| d[i] * self.curvature[(i, k)] * d[k])
                    .sum::<f64>()
            });
            let value = t + bent.sum::<f64>() / 2.0;
            return d.iter().all(|d| d.is_finite()).then_some(Step {
                by: d,
                value,
                weights,
            });
        }
        None
    }

    /// d, t and the multipliers where these constraints hold with equality.
    fn on(&self, kept: &[Constraint]) -> Option<(Vec<f64>, f64, Vec<f64>)> {
        let n = self.low.len();
        let size = n + 1 + kept.len();
        let mut matrix = Mat::<f64>::zeros(size, size);
        let mut right = Mat::<f64>::zeros(size, 1);
        for i in 0..n {
            (0..n).for_each(|k| matrix[(i, k)] = self.curvature[(i, k)]);
        }
        right[(n, 0)] = -1.0;
        for (k, constraint) in kept.iter().enumerate() {
            let row = n + 1 + k;
            let mut put = |column: usize, value: f64| {
                matrix[(row, column)] = value;
                matrix[(column, row)] = value;
            };
            right[(row, 0)] = match *constraint {
                Constraint::Function(j) => {
                    (0..n).for_each(|i| put(i, self.gradients[j][i]));
                    put(n, -1.0);
                    -self.values[j]
                }
                Constraint::Low(i) => {
                    put(i, -1.0);
                    -self.low[i]
                }
                Constraint::High(i) => {
                    put(i, 1.0);
                    self.high[i]
                }
            };
        }
        let solved = matrix.full_piv_lu().solve(&right);
        let column: Vec<f64> = (0..size).map(|i| solved[(i, 0)]).collect();
        let finite = column.iter().all(|value| value.is_finite());
        finite.then(|| (column[..n].to_vec(), column[n], column[n + 1..].to_vec()))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
