//! A step that begins at rest, from which only a drive moves the system.
//!
//! Where the force begins within the step, the energy that it supplies and the energy of the motion
//! may both be wrong by their own size, and no γ near 1 makes them agree. The motion then keeps its
//! direction and takes the energy that was supplied:
//!
//! ```text
//! H(z0 + σ d) + Σ w1_j = K        σ ≥ 0
//! ```
//!
//! The change is of the size of the error of the step. Time, w and the energy supplied are those of
//! γ = 1.

use super::direction::Direction;
use super::root::{Chord, MET_ROUNDINGS, STALLED_K_ROUNDINGS};
use crate::kernels::reductions::sum;
use afterbay_core::{Scalar, State, StepFailure, System, Vector};

/// The largest σ. A choice.
const LONGEST: f64 = 4.0;
/// The largest number of points evaluated. Two are enough where H is quadratic.
const MOST_POINTS: u32 = 12;

impl<V: Vector> Chord<V> {
    /// Moves (q, p) along d to the σ at which K is `total`, given the rounding `unit` of its terms.
    /// Returns whether there is one.
    #[cold]
    pub(super) fn leave_rest<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        [total, unit]: [V::Scalar; 2],
    ) -> Result<bool, StepFailure>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let (zero, one) = (V::Scalar::zero(), V::Scalar::one());
        let end = self.place(system, state, direction, one, total)?.excess;
        // H grows like σ² from rest: the excess is nearly linear in σ².
        let (mut last, mut next) = ((one, end), zero);
        for _ in 0..MOST_POINTS {
            let excess = self.scale(system, state, direction, next.sqrt(), total);
            // At σ = 0 the system stays at rest: nothing was supplied.
            let most = if next == zero { MET_ROUNDINGS } else { STALLED_K_ROUNDINGS };
            if excess.to_f64().abs() <= most * unit.to_f64() {
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

    /// Sets (q, p) to z0 + σ d but for the motors, and returns the error of K.
    fn scale<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        sigma: V::Scalar,
        total: V::Scalar,
    ) -> V::Scalar
    where
        S: System<V::Scalar> + ?Sized,
    {
        let free = state.dof() - system.motors();
        let parts = [(&mut self.q, &state.q, &direction.q), (&mut self.p, &state.p, &direction.p)];
        for (new, old, change) in parts {
            let (old, change) = (old.as_slice(), change.as_slice());
            for (j, new) in new.as_mut_slice()[..free].iter_mut().enumerate() {
                *new = sigma.mul_add(change[j], old[j]);
            }
        }
        let (q, p, w) = (self.q.as_slice(), self.p.as_slice(), self.w.as_slice());
        self.energy = system.energy(q, p);
        self.energy + sum([w], |[w]| w) - total
    }
}
