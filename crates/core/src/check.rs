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
mod curvature;
mod separable;
mod system;
mod uniform;

use crate::{InputError, Mask, Quantity, Scalar, Separable, System};
pub use curvature::curvature;
pub use separable::separable;
pub use system::system;
pub use uniform::uniform;

/// Is every mass positive and finite? O(N).
///
/// # Errors
/// [`InputError::Mass`], of the first that is not.
pub fn masses<T: Scalar>(system: &(impl Separable<T> + ?Sized)) -> Result<(), InputError> {
    for dof in 0..system.dof() {
        let mass = system.mass(dof);
        if !T::zero().lt(mass).and(mass.is_finite()).all() {
            return Err(InputError::Mass { dof, value: mass.to_f64() });
        }
    }
    Ok(())
}

/// What a system is at a state.
#[derive(Clone, Debug)]
struct Fields {
    h: f64,
    hq: Vec<f64>,
    hp: Vec<f64>,
    d: Vec<f64>,
}

impl Fields {
    fn at<S: System<f64> + ?Sized>(system: &S, q: &[f64], p: &[f64]) -> Self {
        let [mut hq, mut hp, mut d] = [0; 3].map(|_| vec![0.0; q.len()]);
        system.gradient(q, p, &mut hq, &mut hp);
        system.dissipation(q, p, &hp, &mut d);
        Self { h: system.energy(q, p), hq, hp, d }
    }

    fn finite(&self) -> Result<(), InputError> {
        let parts = [
            (Quantity::Energy, std::slice::from_ref(&self.h)),
            (Quantity::Slope, &self.hq),
            (Quantity::Velocity, &self.hp),
            (Quantity::Dissipation, &self.d),
        ];
        parts.into_iter().try_for_each(|(quantity, part)| finite(quantity, part))
    }
}

/// Are these numbers?
fn finite(quantity: Quantity, part: &[f64]) -> Result<(), InputError> {
    match part.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        Some((dof, &value)) => Err(InputError::NotFinite { quantity, dof, value }),
        None => Ok(()),
    }
}

/// The share of what enters that rounding may take from a formula of up to a thousand operations, summed over n.
fn rounding(n: usize) -> f64 {
    f64::EPSILON / 2.0 * (1000.0 + n as f64)
}

/// How far from the state claims are tested.
fn reach(x: &[f64]) -> f64 {
    x.iter().fold(1.0, |reach, x| x.abs().max(reach))
}

/// x with its entry j replaced.
fn moved(x: &[f64], j: usize, to: f64) -> Vec<f64> {
    x.iter().enumerate().map(|(i, &x)| if i == j { to } else { x }).collect()
}
