//! What an integration took.

/// What an integration took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// How often the acceleration, or one of its time derivatives, was evaluated for the steps and
    /// for the instants between them.
    pub evaluations: u64,
    /// Steps taken.
    pub accepted: u64,
    /// Steps tried and found too inaccurate.
    pub rejected: u64,
    /// Matrices factorised, each n × n, real or complex; 2n × 2n by the methods of `diffsol`.
    pub factorisations: u64,
    /// Right-hand sides solved for with them.
    pub solves: u64,
}
