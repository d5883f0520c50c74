//! Implicit methods for large systems: Newton's iteration, its stopping criteria, and the flags of
//! the registry on chains of 2000, dense systems of 50 and 300, and nonlinear, coupled and skew
//! friction.

mod flags;
mod linear_exact;
mod newton;
mod passive;
mod projection;
mod scenes;
mod stopping;
