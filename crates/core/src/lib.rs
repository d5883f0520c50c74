//! Dissipative Hamiltonian systems with N degrees of freedom and an energy reservoir,
//!
//! ```text
//! q' = ∂H/∂p        p' = -∂H/∂q - D(q,p)        w_j' = D_j(q,p) ∂H/∂p_j      (j = 1..N)
//! ```
//!
//! so that `K = H(q,p) + Σ w_j` is constant. This crate says what a [`System`], a [`State`], a [`Method`] and a
//! failure are, holds the only time loop ([`integrate`]), the divided differences without cancellation
//! ([`Separable::edge`]) and the solvers of scalar equations ([`solver`]). It knows no method and no system by name.

pub mod check;
mod coupling;
mod curvature;
pub mod edge;
mod exact;
mod failure;
mod grid;
mod integrate;
mod method;
mod observer;
mod order_raising;
mod phase_plane;
mod scalar;
pub mod solver;
mod state;
mod system;
pub mod taylor;
mod uniform;
mod vector;
mod view;

pub use coupling::Coupling;
pub use curvature::{Block, Curvature};
pub use exact::ExactFlow;
pub use failure::{InputError, IntegrateError, Quantity, RunError, StepFailure};
pub use grid::Grid;
pub use integrate::integrate;
pub use method::{Effort, Method};
pub use observer::{Every, Observer};
pub use order_raising::{Correction, Misprinted, OrderRaising};
pub use phase_plane::{Mean, PhasePlane, Resistance, Slopes};
pub use qd::Quad;
pub use scalar::{Mask, Scalar, Series};
pub use state::State;
pub use system::{Damping, Drag, Line, Linear, Passive, Separable, System};
pub use uniform::Uniform;
pub use vector::Vector;
pub use view::View;
pub use wide::f64x8;
