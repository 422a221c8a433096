//! Signals that act on several coordinates at once: forces on points, and motions of supports.

use eigentone_modes::{Form, MatrixKind, System};

/// Which derivative of a place's motion is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// In m, or rad.
    Displacement,
    /// In m/s, or rad/s.
    Velocity,
    /// In m/s², or rad/s².
    Acceleration,
}

/// A signal w(t) that is no force on a single coordinate. With u being w, integrated from rest at t = 0 as often as
/// [`integrals`](Self::integrals) says, the force on the coordinates is the sum of `directions[k]`·u⁽ᵏ⁾, k = 0, 1, 2.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// By order k of the derivative: index of a coordinate and factor. Exact: an index may come more than once, and its
    /// factors add up.
    pub directions: [Vec<(usize, f64)>; 3],
    /// 0 for a force or a displacement, 1 for a velocity, 2 for an acceleration; more for the powers of time in polynomials.
    pub integrals: usize,
    /// The index of the support whose displacement u is; `None` for a force on a point.
    pub support: Option<usize>,
}

impl Channel {
    /// A force on a point: each coordinate takes its share of it.
    pub(super) fn of_point(form: &Form) -> Channel {
        Channel {
            directions: [form.coordinates.clone(), Vec::new(), Vec::new()],
            integrals: 0,
            support: None,
        }
    }

    /// The motion of a support, given by one of its derivatives: f = −(K_s u + C_s u′ + M_s u″).
    pub(super) fn of_support(system: &System, support: usize, quantity: Quantity) -> Channel {
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
        let directions = kinds.map(|kind| {
            let terms = system.coupling(kind).iter();
            let own = terms.filter(|term| term.column == support);
            own.map(|term| (term.row, -term.value)).collect()
        });
        Channel {
            directions,
            integrals: quantity as usize,
            support: Some(support),
        }
    }

    /// The same where the signal is integrated so many times more.
    pub(super) fn integrated(&self, times: usize) -> Channel {
        Channel {
            integrals: self.integrals + times,
            ..self.clone()
        }
    }

    /// The orders of the signal's own derivatives, beginning with the signal itself, that act directly: as forces, or on
    /// what is integrated; and the motion of a support itself, for sums that ask for it.
    pub(crate) fn orders(&self) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(|order| {
            let direction = self.directions.get(order + self.integrals);
            let acts = direction.is_some_and(|direction| !direction.is_empty());
            acts || *order == 0 && (self.integrals > 0 || self.support.is_some())
        })
    }

    /// Whether a jump of the signal (order 0) or of its slope (order 1) is an impulse.
    pub(crate) fn passes_on(&self, order: usize) -> bool {
        let direction = self.directions.get(self.integrals + order + 1);
        direction.is_some_and(|direction| !direction.is_empty())
    }
}
