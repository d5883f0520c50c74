//! Tests for authors of systems: derivatives, divided differences and D against the energy H.
//!
//! ```text
//! H(b) - H(a) = ∫ ∂H/∂q_j dq_j along an edge from a to b
//! ```
//!
//! and likewise for ∂H/∂p_j, divided differences and second derivatives.
//!
//! A derivative is compared with *increments* of its function and not with difference quotients.
//! The integral is computed by Clenshaw-Curtis quadrature, so that there is no truncation error to
//! balance against rounding, and a slope that is 0 at the given state is tested, too. Edges lead in
//! both directions from the given state and from one that is displaced in every coordinate and
//! momentum, because products such as q1² q2² are 0 along all edges from a state at rest. An edge
//! is as long as the largest coordinate (momentum), at least 1, and is shortened until two
//! quadratures agree to rounding. A discrepancy must persist on shorter edges, so that a narrow
//! feature between the nodes is not taken for an error. Properties that are claimed for all states
//! are tested at a fixed set of states around the given one.
//!
//! The rounding allowed is 1000 + N roundings of the terms: the size of the function and, because
//! every argument may be rounded, of each argument times its slope. A relative error of 1e-9 in a
//! slope is found if the energy is not much larger than its changes. Smaller ones are not found,
//! such as an error in terms that are 1e-13 of the others at a displacement of 1. The cost is O(N)
//! evaluations of the system. Systems are taken as trait objects, so that these tests are compiled
//! once and not for each system.

mod along;
mod around;
mod coupling;
mod dissipation;
mod drive;
mod gradient;
mod hessian;
mod lattice;
mod separable;
mod system;

pub use crate::system::masses;
pub use drive::drive;
pub use hessian::curvature;
pub use lattice::uniform;
pub use separable::separable;
pub use system::{finite_at, system};
