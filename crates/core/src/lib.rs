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
//! [`Tolerance`]), divided differences without cancellation ([`divided`], [`Slope`]),
//! systems from their formulas alone ([`Formulas`]), the solvers of scalar equations ([`solver`]),
//! solutions by Taylor series ([`taylor`]) and a check of what a system says of itself ([`validate`]).
//! It knows no method and no system by name.

mod error;
mod numbers;
mod quantity;
mod run;
pub mod solver;
mod system;
pub mod taylor;
pub mod validate;

pub use error::{InputError, IntegrateError, RunError, StepFailure};
pub use numbers::{
    Certainty, Corrected, Ends, Interval, Lanewise, Line, Mask, Quad, Scalar, Series, Slope, Vector, divided,
    f64x4, f64x8, quadrature,
};
pub use quantity::{Block, Quantity};
pub use run::{
    Adaptive, Attempt, Effort, Every, Grid, Method, Observer, Statistics, Tolerance, integrate, integrate_in,
    integrate_within, sample_within,
};
pub use system::{
    Correction, Coupling, Curvature, Dissipation, DissipationForm, ExactFlow, Formulas, FromFormulas, Linear,
    Mean, Misprinted, OrderRaising, Passive, PhasePlane, PlaneDissipation, Separable, Slopes, State,
    StateRef, System, Uniform,
};
