//! A step that begins at rest, from which only a drive moves the system.
//!
//! If the force begins within the step, the relative errors of the energy supplied and of the
//! energy of the motion may be near 1. Then no γ near 1 restores K. The step keeps the direction d
//! of the motion, and gives it the energy that was supplied:
//!
//! ```text
//! H(z0 + σ d) + Σ w1_j = K        σ ≥ 0
//! ```
//!
//! The change is of the size of the error of the step. Time, w and the energy supplied are those of
//! γ = 1.

use super::direction::Direction;
use super::root::{Chord, MET_ROUNDINGS, STALLED_K_ROUNDINGS, along};
use afterbay_core::{Scalar, State, StepFailure, System, Vector};

/// The largest σ. A choice.
const LONGEST: f64 = 4.0;
/// The largest number of points evaluated. Two are enough where H is quadratic.
const MOST_POINTS: u32 = 12;

impl<V: Vector> Chord<V> {
    /// Moves (q, p) along d to the σ at which K is `total`, to some roundings of its terms, each of
    /// size `unit`. Returns whether there is one.
    #[cold]
    pub(super) fn leave_rest<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        total: V::Scalar,
        unit: f64,
    ) -> Result<bool, StepFailure>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let (zero, one) = (V::Scalar::zero(), V::Scalar::one());
        let free = state.dof() - system.motors();
        let end = self.place(system, state, direction, one, total)?.excess;
        // H grows like σ² from rest: the excess is nearly linear in σ².
        let (mut last, mut next) = ((one, end), zero);
        for _ in 0..MOST_POINTS {
            let sigma = next.sqrt();
            along(&mut self.q, &state.q, &direction.q, sigma, free);
            along(&mut self.p, &state.p, &direction.p, sigma, free);
            let excess = self.excess(system, total);
            // At σ = 0 the system stays at rest: nothing was supplied.
            let most = if next == zero { MET_ROUNDINGS } else { STALLED_K_ROUNDINGS };
            if excess.to_f64().abs() <= most * unit {
                return Ok(true);
            }
            let slope = (excess - last.1) / (next - last.0);
            last = (next, excess);
            next -= excess / slope;
            if !(0.0..=LONGEST * LONGEST).contains(&next.to_f64()) {
                break;
            }
        }
        Ok(false)
    }
}
