//! Dissipative Hamiltonian systems with N degrees of freedom and an energy reservoir,
//!
//! ```text
//! q' = ∂H/∂p        p' = -∂H/∂q - D(q,p)        w_j' = D_j(q,p) ∂H/∂p_j      (j = 1..N)
//! ```
//!
//! so that `K = H(q,p) + Σ w_j` is constant.
//!
//! This crate defines what a system, a state, a run and a failure are. It knows no method and no
//! system by name. Its layers, each of which uses only those above it:
//!
//! - numbers: [`Scalar`] (`f64`, [`Quad`], SIMD lanes [`f64x8`], [`Corrected`],
//!   [`Series`], [`Slope`], [`Interval`]), storage ([`Vector`]), divided differences ([`divided`])
//!   and [`quadrature`];
//! - error: [`InputError`], [`StepFailure`], [`RunError`], with the names of [`Quantity`] and
//!   [`Block`];
//! - system: [`System`] and the traits of some systems ([`Separable`], [`PhasePlane`],
//!   [`Curvature`], [`Uniform`], [`Linear`], [`ExactFlow`], [`OrderRaising`]), systems from
//!   formulas ([`Formulas`]), and the [`State`];
//! - [`solver`]: the equations of an implicit step in one or two unknowns: Newton's method, fixed
//!   points, the test of convergence, and continuation;
//! - run: [`Method`] and [`Adaptive`], [`Grid`] and [`Tolerance`], [`Observer`], and the time loops
//!   [`integrate`] and [`integrate_within`];
//! - [`taylor`]: solutions by Taylor series, as references;
//! - [`validate`]: tests of a system against its own energy, and of a drive against its forces.

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
    Corrected, Ends, Interval, Lanewise, Line, Mask, Quad, Scalar, Series, Single, Slope, Vector,
    divided, f64x8, larger_or_nan, quadrature, singularity, two_sum,
};
pub use quantity::{Block, Quantity};
pub use run::{
    Adaptive, AdaptiveRun, Attempt, Direction, Effort, Event, EventState, Every, Grid, Method,
    Observer, OnEvent, STEPS_OF_BLOCK, Statistics, StepControl, TakeStep, Tolerance, Watch,
    integrate, integrate_controlled, integrate_in, integrate_with_events, integrate_within,
    sample_within, step_in_parts,
};
pub use system::{
    Abilities, Accounts, Clocked, Correction, Coupling, Curvature, Dissipation, DissipationForm,
    Drive, Driven, EndMembers, Entry, ExactFlow, Flow, Formulas, FromFormulas, Harmonic, Harmonics,
    Linear, Mean, Members, Misprinted, Motors, OrderRaising, Passive, PhasePlane, PlaneDissipation,
    SecondDerivatives, Separable, Slopes, State, StateRef, Supply, System, Uniform, accounts,
    with_motors,
};
