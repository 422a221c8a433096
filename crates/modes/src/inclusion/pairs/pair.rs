//! Approximate roots with their shapes.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use faer::c64;
use num_complex::Complex;

use crate::inclusion::gram::Form;
use crate::modes::Mode;
use crate::structure::Structure;
use crate::system::System;

/// A complex vector.
#[derive(Clone)]
pub(super) struct Parts {
    pub(super) re: Vec<DoubleDouble>,
    /// Nothing for real roots.
    pub(super) im: Vec<DoubleDouble>,
}

impl Parts {
    fn real(re: Vec<DoubleDouble>) -> Parts {
        Parts { re, im: Vec::new() }
    }

    /// A component in doubles.
    pub(super) fn at(&self, row: usize) -> Complex<f64> {
        let im = self.im.get(row).map_or(0.0, |im| im.to_f64());
        Complex::new(self.re[row].to_f64(), im)
    }
}

/// An approximate root with Im ≥ 0, and its shapes.
#[derive(Clone)]
pub(super) struct Pair {
    pub(super) value: ComplexDoubleDouble,
    pub(super) right: Parts,
    /// y with yᵀQ = 0, where that is not x by symmetry.
    pub(super) left: Option<Parts>,
    /// Of which of the given modes; `None` for λ = 0 exactly, with an exact shape.
    pub(super) mode: Option<usize>,
}

impl Pair {
    pub(super) fn is_real(&self) -> bool {
        self.right.im.is_empty()
    }

    pub(super) fn right(&self) -> &Parts {
        &self.right
    }

    pub(super) fn left(&self) -> &Parts {
        self.left.as_ref().unwrap_or(&self.right)
    }
}

/// The roots and shapes, with the forms that they are to diagonalise.
pub(super) struct Pairs<'a> {
    pub(super) system: &'a System,
    pub(super) pairs: Vec<Pair>,
    /// The motion that nothing holds.
    pub(super) drifting: Option<Vec<DoubleDouble>>,
}

/// Which of the 2n columns: that of a pair, or its conjugate.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Column {
    pub(super) pair: usize,
    pub(super) conjugate: bool,
}

pub(super) fn plain(z: ComplexDoubleDouble) -> c64 {
    c64::new(z.re.to_f64(), z.im.to_f64())
}

impl<'a> Pairs<'a> {
    pub(super) fn of(
        system: &'a System,
        structure: &Structure,
        modes: &[Mode],
    ) -> Option<Pairs<'a>> {
        let n = system.len();
        let is_symmetric = structure.is_symmetric();
        let applies = structure.finite_roots() == Some(2 * n)
            && (is_symmetric || structure.zero_roots() == Some(0));
        if !applies {
            return None;
        }
        let indicator = |part: &Vec<usize>| -> Vec<DoubleDouble> {
            let within = |i| f64::from(u8::from(part.contains(&i)));
            (0..n).map(|i| DoubleDouble::from(within(i))).collect()
        };
        let (loose, free) = (structure.spring_floating(), structure.floating());
        let (drifting, creeping) = match (loose, free) {
            (creeping, []) => (None, creeping),
            ([_], [drifting]) => (Some(indicator(drifting)), &[][..]),
            _ => return None,
        };
        let drifts = if drifting.is_some() { 2 } else { 0 };
        if structure.zero_roots() != Some(creeping.len() + drifts) {
            return None;
        }
        let mut pairs: Vec<Pair> = creeping
            .iter()
            .map(|part| Pair {
                value: ComplexDoubleDouble::ZERO,
                right: Parts::real(indicator(part)),
                left: None,
                mode: None,
            })
            .collect();
        for (index, mode) in modes.iter().enumerate() {
            let value = mode.eigenvalue().value;
            if value.norm() == 0.0 {
                continue;
            }
            if mode.roots() > 1 {
                return None;
            }
            let parts = |shape: &[Complex<f64>], sign: f64| {
                let re = shape.iter().map(|z| DoubleDouble::from(z.re));
                let im = shape.iter().map(|z| DoubleDouble::from(sign * z.im));
                let is_real = value.im == 0.0;
                Parts {
                    re: re.collect(),
                    im: im.filter(|_| !is_real).collect(),
                }
            };
            let left = if is_symmetric {
                None
            } else {
                // y*Q = 0 there.
                Some(parts(mode.left_shape()?, -1.0))
            };
            pairs.push(Pair {
                value: ComplexDoubleDouble::new(value.re, value.im),
                right: parts(mode.shape(), 1.0),
                left,
                mode: Some(index),
            });
        }
        let count: usize = pairs
            .iter()
            .map(|pair| if pair.is_real() { 1 } else { 2 })
            .sum();
        (count + drifts == 2 * n).then_some(Pairs {
            system,
            pairs,
            drifting,
        })
    }

    /// The real columns of all shapes on one side, and where each pair has its own.
    pub(super) fn real_columns(
        &self,
        side: fn(&Pair) -> &Parts,
    ) -> (Vec<Vec<DoubleDouble>>, Vec<usize>) {
        let mut columns = Vec::new();
        let mut places = Vec::with_capacity(self.pairs.len());
        for pair in &self.pairs {
            places.push(columns.len());
            columns.push(side(pair).re.clone());
            if !pair.is_real() {
                columns.push(side(pair).im.clone());
            }
        }
        (columns, places)
    }

    /// Takes what drifts out of all other shapes, as far as rounding goes.
    pub(super) fn project(&mut self) -> Option<()> {
        let Some(drifting) = &self.drifting else {
            return Some(());
        };
        let (mut columns, places) = self.real_columns(Pair::right);
        let last = columns.len();
        columns.push(drifting.clone());
        let mass = Form::mass(self.system).gram(&columns);
        let own = mass.at(last, last);
        for (pair, place) in self.pairs.iter_mut().zip(places) {
            for (offset, column) in [&mut pair.right.re, &mut pair.right.im]
                .into_iter()
                .enumerate()
            {
                if column.is_empty() {
                    continue;
                }
                let share = mass.at(place + offset, last) / own;
                if !share.to_f64().is_finite() {
                    return None;
                }
                for (entry, rigid) in column.iter_mut().zip(drifting) {
                    *entry -= share * *rigid;
                }
            }
        }
        Some(())
    }

    pub(super) fn has_left(&self) -> bool {
        self.pairs.iter().any(|pair| pair.left.is_some())
    }

    /// All 2n columns, less those that drift.
    pub(super) fn columns(&self) -> Vec<Column> {
        let both = |(pair, found): (usize, &Pair)| {
            let column = |conjugate| Column { pair, conjugate };
            if found.is_real() {
                vec![column(false)]
            } else {
                vec![column(false), column(true)]
            }
        };
        self.pairs.iter().enumerate().flat_map(both).collect()
    }
}
