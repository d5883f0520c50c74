//! One-step methods for dissipative Hamiltonian systems, and the parts that they share.
//!
//! The module of each method states its discrete equations, their source, the order, the quantities
//! the method conserves and the conditions under which a step fails. [`registry`] lists all methods
//! by name. Two variants of [`Increment`] share its [`Composition`]s: [`GeneralIncrement`] for H
//! that is not separable, and [`Tiled`] for chains and rings of equal members; the registry chooses
//! the variant that fits a system. [`Compensated`] prevents rounding errors from accumulating over
//! very long runs.

// The unit tests leave out the table of methods (`registry`), so that items used by it alone are
// dead code there.
#![cfg_attr(test, allow(dead_code, unused_imports))]

// Methods.
mod adaptive_collocation;
mod adaptive_dop853;
mod adaptive_radau;
mod adaptive_verner;
mod collocation;
mod explicit_dop853;
mod force_rounding;
mod gonzalez;
mod implicit_midpoint;
mod increment;
mod leapfrog;
mod linear_exact;
mod locally_exact;
pub mod moddg;
mod relaxed;
mod rk4;
mod splitting;

// Parts that several methods use.
mod adaptive;
mod adaptive_explicit;
mod balance;
mod commit;
mod coordinate;
mod gradient_check;
mod hidden_coupling;
mod iteration;
mod kernels;
mod kick;
mod legendre;
mod linear;
mod linear_flow;
mod measured_rounding;
mod points;
mod radau;
mod ray;
pub mod registry;
mod rounding;
mod runge_kutta;
mod second_derivatives;

pub use adaptive_collocation::AdaptiveCollocation;
pub use adaptive_dop853::AdaptiveDop853;
pub use adaptive_radau::AdaptiveRadau;
pub use adaptive_verner::{AdaptiveVerner87, AdaptiveVerner98};
pub use collocation::Collocation;
pub use gonzalez::Gonzalez;
pub use implicit_midpoint::ImplicitMidpoint;
pub use increment::{Compensated, Composition, GeneralIncrement, Increment};
pub use kernels::Tiled;
pub use leapfrog::Leapfrog;
pub use linear::LinearSolver;
pub use linear_exact::LinearExact;
pub use locally_exact::LocallyExact;
pub use moddg::ModDg;
pub use relaxed::Relaxed;
pub use rk4::Rk4;
pub use splitting::Splitting;

/// Runs the code of the README as doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// Runs the code of the guide as doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide.md")]
struct Guide;
