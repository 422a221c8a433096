//! Exact arithmetic on sums and products of doubles: every double is an integer times a power of two, so that signs
//! are decided by integers and vanishing by arithmetic modulo primes. It knows `model`.
pub(crate) mod elimination;
pub(crate) mod envelope;
pub(crate) mod matrix;
pub(crate) mod null_space;
pub(crate) mod prime_field;
pub(crate) mod rank;
pub(crate) mod recurrence;
pub(crate) mod sum;
