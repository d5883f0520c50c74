//! Dissipative Hamiltonian systems with N degrees of freedom and an energy reservoir,
//!
//! ```text
//! q' = ∂H/∂p        p' = -∂H/∂q - D(q,p)        w_j' = D_j(q,p) ∂H/∂p_j      (j = 1..N)
//! ```
//!
//! so that `K = H(q,p) + Σ w_j` is constant. This crate says what a [`System`] is and what some
//! know besides ([`Separable`], [`PhasePlane`], [`Curvature`], [`Uniform`], [`Linear`],
//! [`OrderRaising`], [`ExactFlow`]), what a [`State`], a [`Method`] and a failure are, and which
//! numbers there are ([`Scalar`]: `f64`, [`Quad`], [`Series`], lanes [`f64x4`] and [`f64x8`],
//! [`Corrected`] numbers). It holds the time loops ([`integrate`], and [`integrate_within`] a
//! [`Tolerance`]), divided differences without cancellation ([`divided`], [`Slope`], [`edge`]),
//! systems from their formulas alone ([`Formulas`]), the solvers of scalar equations ([`solver`]),
//! solutions by Taylor series ([`taylor`]) and a check of what a system says of itself ([`validate`]).
//! It knows no method and no system by name.

mod abilities;
mod adaptive;
pub mod check;
mod coupling;
mod curvature;
pub mod divided;
pub mod edge;
mod exact;
mod failure;
mod formulas;
mod grid;
mod integrate;
mod method;
mod observer;
mod order_raising;
mod phase_plane;
mod scalar;
mod shared;
pub mod solver;
mod state;
mod system;
pub mod taylor;
mod tolerance;
mod uniform;
mod vector;
mod view;

pub use abilities::{Abilities, Entry, Flow, Members, SecondDerivatives};
pub use adaptive::{Adaptive, Attempt, Statistics, integrate_within, sample_within};
pub use coupling::Coupling;
pub use curvature::{Block, Curvature};
pub use exact::ExactFlow;
pub use failure::{InputError, IntegrateError, Quantity, RunError, StepFailure};
pub use formulas::{Formulas, FromFormulas};
pub use grid::Grid;
pub use integrate::{integrate, integrate_in};
pub use method::{Effort, Method};
pub use observer::{Every, Observer};
pub use order_raising::{Correction, Misprinted, OrderRaising};
pub use phase_plane::{Mean, PhasePlane, PlaneDissipation, Slopes};
pub use qd::Quad;
pub use scalar::{Certainty, Corrected, Ends, Interval, Lanewise, Mask, Scalar, Series, Slope};
pub use state::State;
pub use system::{Dissipation, DissipationForm, Line, Linear, Passive, Separable, System};
pub use tolerance::Tolerance;
pub use uniform::Uniform;
pub use vector::Vector;
pub use view::StateRef;
pub use wide::{f64x4, f64x8};
