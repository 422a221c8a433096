//! Why there is no first-order form.

use thiserror::Error;

/// Why a system has no first-order form with the states described in [`FirstOrder`](crate::FirstOrder).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FirstOrderError {
    /// The masses that are there do not determine all accelerations, or not as far as digits show: loads on what has no
    /// inertia act through its derivatives, and not every initial state is consistent.
    #[error(
        "the mass matrix is singular, or too nearly so to be told from it, although no row of it vanishes, so that only modes can be computed; \
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
    /// The system is [large](crate::System::is_large).
    #[error(
        "a dense state matrix of {coordinates} coordinates is too large: look at some of its modes, as SparseModes"
    )]
    TooLarge {
        /// How many coordinates there are.
        coordinates: usize,
    },
}
