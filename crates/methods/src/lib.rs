//! One-step methods for dissipative Hamiltonian systems, one a file.
//!
//! Each file opens with the discrete equations, their source, the order, what is kept and when the
//! method fails. [`registry`] lists them all by name. [`Increment`] has two siblings that share its
//! [`Composition`]s: [`GeneralIncrement`] where H is not separable, [`Tiled`] for chains and rings
//! of equal members; the registry takes the one a system has. [`Compensated`] is for runs so long
//! that roundings add up.

mod adaptive;
mod adaptive_dop853;
mod balance;
mod bend;
mod collocation;
mod coordinate;
mod gonzalez;
mod increment;
mod leapfrog;
mod linear;
mod linear_exact;
mod linear_flow;
mod locally_exact;
pub mod moddg;
pub mod registry;
mod relaxed;
mod rk4;
mod runge_kutta;

pub use adaptive_dop853::AdaptiveDop853;
pub use collocation::{AdaptiveCollocation, Collocation};
pub use gonzalez::Gonzalez;
pub use increment::{Compensated, Composition, GeneralIncrement, Increment, Tiled};
pub use leapfrog::Leapfrog;
pub use linear::LinearSolver;
pub use linear_exact::LinearExact;
pub use locally_exact::LocallyExact;
pub use moddg::ModDg;
pub use relaxed::Relaxed;
pub use rk4::Rk4;

/// The README's code runs with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The guide's code runs with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide.md")]
struct Guide;
