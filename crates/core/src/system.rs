//! Dissipative Hamiltonian systems and their states.
//!
//! Every system implements [`System`]. Further traits state what some systems add:
//!
//! | trait | what the system adds |
//! |---|---|
//! | [`Separable`] | H = Σ p_j²/(2 m_j) + V(q), with divided differences of V |
//! | [`PhasePlane`] | any H along one coordinate or momentum at a time |
//! | [`Curvature`] | second derivatives |
//! | [`Uniform`] | a chain or ring of equal members, eight at a time |
//! | [`Linear`] | constant stiffness and damping |
//! | [`ExactFlow`] | the exact solution |
//! | [`OrderRaising`], [`Misprinted`] | the corrected steps δ of the paper |
//!
//! A [`Drive`] adds forces F(q, t) to any of them, by [`Driven`]. V and D of a separable system may
//! depend on the time, by [`Clocked`].
//!
//! [`Abilities`] is a system whose concrete type is erased; it states which of these traits it has.
//! [`Formulas`] make a separable system from one potential and one dissipation.

mod abilities;
mod clock;
mod coupling;
mod dissipation;
mod drive;
mod exact_flow;
mod formulas;
mod hamiltonian;
mod harmonics;
mod hessian;
mod lattice;
mod linear;
mod motors;
mod nonseparable;
mod order_raising;
mod separable;
mod shared;
mod state;
mod state_ref;

pub use abilities::{Abilities, Entry, Flow, Members, SecondDerivatives};
pub use clock::Clocked;
pub use coupling::Coupling;
pub use dissipation::{Dissipation, DissipationForm, Passive};
pub use drive::{Drive, Driven};
pub use exact_flow::ExactFlow;
pub use formulas::{Formulas, FromFormulas};
pub use hamiltonian::System;
pub use harmonics::{Harmonic, Harmonics};
pub use hessian::Curvature;
pub use lattice::{EndMembers, Uniform};
pub use linear::Linear;
pub use motors::{Accounts, Motors, accounts, with_motors};
pub use nonseparable::{Mean, PhasePlane, PlaneDissipation, Slopes};
pub use order_raising::{Correction, Misprinted, OrderRaising};
pub use separable::{Separable, Supply, masses};
pub use state::State;
pub use state_ref::StateRef;
