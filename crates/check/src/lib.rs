//! Closed forms, numerical integrators and error against run time for linear vibrating systems
