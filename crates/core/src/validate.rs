//! Is a system what it says it is? For whoever writes one, before the first run and in its tests.
//!
//! ```text
//! H(b) - H(a) = ∫ ∂H/∂q_j dq_j along an edge from a to b        likewise of ∂H/∂p_j, edge, curvature
//! ```
//!
//! A derivative is checked against the *increments* of its function, not against difference quotients: the integral comes
//! from Clenshaw and Curtis' quadrature, so nothing is truncated, there is no step to choose between truncation
//! and rounding, and a slope that is 0 at the state hides nothing. The edges lead from the state given, and from one
//! displaced in every coordinate and momentum, in both directions: from a state at rest alone, products such as q1² q2² are 0
//! along all of them. They are as long as the largest coordinate (momentum), at least 1, or shorter, until two quadratures
//! agree to rounding; and what disagrees must do so on shorter edges too, so that no narrow feature between the nodes
//! is taken for a lie. What is claimed for all states is checked at some around the state given, the same ones each time.
//!
//! Allowed are 1000 + N roundings of what enters: the size of the function and, as every argument may be rounded, of
//! each argument times its slope. A slope that is 1e-9 of itself off is seen where the energy is not much larger than
//! its changes. What lies below is not, for instance the small terms of an energy in units in which the large ones are
//! 1e13 times larger at a displacement of 1. The cost is O(N) evaluations of the system.

mod along;
mod around;
mod coupling;
mod dissipation;
mod gradient;
mod hessian;
mod lattice;
mod separable;
mod system;

pub use hessian::curvature;
pub use lattice::uniform;
pub use separable::{masses, separable};
pub use system::system;
