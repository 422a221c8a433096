//! M x″ + C x′ + K x = f as first-order equations, with coordinates without mass eliminated exactly.
//!
//! Let p be the coordinates whose rows and columns of M vanish, m the others. With N and L the right
//! and left null spaces of C_pp, R the unit vectors of its independent columns and S those of its
//! independent rows, x_p = N a + R b, where a is what no damper holds. The equations of p then read
//!
//! - L: a = (L K_pp N)⁻¹ L (f_p − K_pm x_m − K_pp R b), a part in equilibrium with its springs;
//! - S: b′ = (S C_pp R)⁻¹ S (f_p − C_pm v_m − K_pm x_m − K_pp x_p), a part that relaxes.
//!
//! This needs C_mp N = 0 and L C_pm = 0 (dampers between p and m pull on b only), which every system
//! of springs and dampers with C ⪰ 0 fulfils.

use eigentone_modes::System;
use num_rational::BigRational;
use num_traits::Zero;

use super::equation::{Equation, exactly};
use super::error::ReferenceError;
use super::rational_matrix::RationalMatrix;

/// z′ = A z + B f and x = X z + D f with z = (x_m, v_m, b), all exact.
pub(super) struct FirstOrderForm {
    /// A beside B: r × (r + n) for r states and n forces.
    pub(super) motion: RationalMatrix,
    /// X beside D: n × (r + n).
    pub(super) output: RationalMatrix,
    /// What impulses displace without limit, from those on all coordinates.
    yields: RationalMatrix,
    /// z at t = 0 from all displacements and velocities: r × 2n.
    start: RationalMatrix,
}

impl FirstOrderForm {
    pub(super) fn of(system: &System) -> Result<FirstOrderForm, ReferenceError> {
        let n = system.len();
        let Equation {
            mass,
            damping,
            stiffness,
        } = Equation::of(system);
        let empty =
            |i: &usize| (0..n).all(|j| mass.at(*i, j).is_zero() && mass.at(j, *i).is_zero());
        let (p, m): (Vec<usize>, Vec<usize>) = (0..n).partition(empty);
        let [c_mm, c_mp] = [&m, &p].map(|columns| damping.block(&m, columns));
        let [c_pm, c_pp] = [&m, &p].map(|columns| damping.block(&p, columns));
        let [k_mm, k_mp] = [&m, &p].map(|columns| stiffness.block(&m, columns));
        let [k_pm, k_pp] = [&m, &p].map(|columns| stiffness.block(&p, columns));
        let (still, moving) = c_pp.null_space();
        let (left, rows) = c_pp.transposed().null_space();
        let left = left.transposed();
        if !c_mp.times(&still).is_zero() || !left.times(&c_pm).is_zero() {
            return Err(ReferenceError::MasslessDampers);
        }

        // Everything as a linear function of (x_m, v_m, b, f): a matrix with as many columns.
        let states = 2 * m.len() + moving.len();
        let width = states + n;
        let pick = |offset: usize, count: usize| {
            let chosen: Vec<usize> = (offset..offset + count).collect();
            RationalMatrix::selection(&chosen, width)
        };
        let (x_m, v_m) = (pick(0, m.len()), pick(m.len(), m.len()));
        let b = pick(2 * m.len(), moving.len());
        let force = |on: &[usize]| {
            let chosen: Vec<usize> = on.iter().map(|i| states + i).collect();
            RationalMatrix::selection(&chosen, width)
        };
        let (f_m, f_p) = (force(&m), force(&p));
        let r = RationalMatrix::selection(&moving, p.len()).transposed();
        let s = RationalMatrix::selection(&rows, p.len());

        let pull = f_p.minus(&k_pm.times(&x_m));
        let rest = pull.clone().minus(&k_pp.times(&r).times(&b));
        let a = (left.times(&k_pp).times(&still))
            .solve(&left.times(&rest))
            .ok_or(ReferenceError::MasslessConstraint)?;
        let x_p = still.times(&a).plus(&r.times(&b));
        let relaxing = s.times(&c_pp).times(&r);
        let relax = |right: &RationalMatrix| {
            let solution = relaxing.solve(right);
            solution.expect("independent rows and columns meet in an invertible block")
        };
        let drive = pull.minus(&c_pm.times(&v_m)).minus(&k_pp.times(&x_p));
        let b_rate = relax(&s.times(&drive));
        let drive = f_m
            .minus(&c_mm.times(&v_m))
            .minus(&c_mp.times(&r).times(&b_rate))
            .minus(&k_mm.times(&x_m))
            .minus(&k_mp.times(&x_p));
        let v_rate = mass.block(&m, &m).solve(&drive);
        let v_rate = v_rate.ok_or(ReferenceError::SingularMass)?;

        let mut output = RationalMatrix::zeros(n, width);
        for (nodes, rows) in [(&m, &x_m), (&p, &x_p)] {
            for (row, j, entry) in rows.nonzeros() {
                *output.at_mut(nodes[row], j) = entry.clone();
            }
        }
        let mut start = RationalMatrix::zeros(states, 2 * n);
        let relaxed = relax(&s.times(&c_pp));
        for (row, &i) in m.iter().enumerate() {
            *start.at_mut(row, i) = exactly(1.0);
            *start.at_mut(m.len() + row, n + i) = exactly(1.0);
        }
        for (row, column, entry) in relaxed.nonzeros() {
            *start.at_mut(2 * m.len() + row, p[column]) = entry.clone();
        }
        let yields = left.times(&RationalMatrix::selection(&p, n));
        Ok(FirstOrderForm {
            motion: v_m.over(v_rate).over(b_rate),
            output,
            yields,
            start,
        })
    }

    /// Whether an impulse of these parts on coordinates would displace without limit: no damper resists it.
    pub(super) fn gives_way(&self, direction: &[(usize, f64)]) -> bool {
        (0..self.yields.nrows()).any(|i| {
            let parts = direction.iter();
            let parts = parts.map(|(row, factor)| self.yields.at(i, *row) * exactly(*factor));
            !parts.sum::<BigRational>().is_zero()
        })
    }

    /// The number r of states.
    pub(super) fn states(&self) -> usize {
        self.motion.nrows()
    }

    /// z at t = 0.
    pub(super) fn start(&self, displacement: &[f64], velocity: &[f64]) -> Vec<BigRational> {
        let given: Vec<BigRational> = displacement
            .iter()
            .chain(velocity)
            .map(|x| exactly(*x))
            .collect();
        let given = RationalMatrix::from_fn(given.len(), 1, |i, _| given[i].clone());
        let state = self.start.times(&given);
        (0..state.nrows()).map(|i| state.at(i, 0).clone()).collect()
    }
}
