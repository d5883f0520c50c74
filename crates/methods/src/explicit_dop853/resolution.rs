//! Whether a part of a step resolves the motion, in each lane.
//!
//! ```text
//! e = h |Σ_i (b_i - b̂_i) v_i|        s² = h² |Δv| |Δf|/(|Δq| |Δp|)        r = h |Δf|/|Δp|
//! ```
//!
//! e is the error of q by the embedded method of order 5, with v the velocities at the stages. It
//! shows what the motion does, but not that a mode of the equations which it does not excite is
//! fast, as under large friction: neighbouring motions excite it. The last stage and the result of
//! the step are states at the same time, whose difference (Δq, Δp) has a part along that mode. With
//! the difference (Δv, Δf) of their slopes, s is hω for an oscillator of the frequency ω, whatever
//! its phase, and r is hλ under friction -λp. Sizes are the largest over the degrees of freedom,
//! without motors and clocks, whose velocity is 1. Source of such a test of stiffness: E. Hairer
//! and G. Wanner, Solving Ordinary Differential Equations II, section IV.2.

use crate::kernels::reductions::{larger, smaller};
use crate::runge_kutta::{Dop853, Embedded, Q, Stages, Tableau};
use afterbay_core::{Mask, Scalar, State, System, Vector};

/// The last stage, at the end of the step, and the place of the slopes at its result.
const LAST: usize = Dop853::ROWS.len() - 1;
const RESULT: usize = Dop853::ROWS.len();
/// The number of slopes: those at the stages and at the result.
pub(super) const SLOPES: usize = RESULT + 1;
/// The largest error, as a share of the way of q. Order 8 then errs by some 1e-12 of it. A
/// choice.
const RESOLVED: f64 = 1e-8;
/// The factor by which e may be larger where the distance from a kink limits the part. There the
/// tangent of a force like √x errs by more, whatever the parts are. A choice.
const NEAR_KINKS: f64 = 10.0;
/// The largest s² and r²: 1/4². A mode of the rate λ errs by up to 3e-6 (hλ)^9 in a part.
const SHORT: f64 = 0.0625;
/// Errors of this number of roundings of q are roundings. A choice.
const ROUNDINGS: f64 = 64.0;
/// A part becomes eight times shorter if e exceeds its bound by the first factor, 8⁶, or s² and r²
/// exceed theirs by the second.
const COARSE: [f64; 2] = [(1 << 18) as f64, 64.0];
/// The next part may be twice as long if e is below its bound by the first factor, 2⁶, and s² or r²
/// is below its bound by the second.
const FINE: [f64; 2] = [64.0, 4.0];

/// The measures of a part, with their bounds.
pub(super) struct Resolution<T: Scalar> {
    /// e and its bound.
    error: T,
    bound: T,
    /// min(s², r²), bounded by [`SHORT`]; not a number, or 0, where differences are roundings.
    stiffness: T,
}

impl<T: Scalar> Resolution<T> {
    /// The resolution of a part that ends at (q, p).
    pub(super) fn of<V: Vector<Scalar = T>, S: System<T> + ?Sized>(
        system: &S,
        length: T,
        state: &State<V>,
        [q, p]: [&V; 2],
        stages: &mut Stages<V>,
    ) -> Self {
        let own = ..system.dof() - system.motors();
        let largest = |x: &V| x.as_slice()[own].iter().fold(T::zero(), larger);
        let apart = |a: &V, b: &V| {
            let pairs = a.as_slice()[own].iter().zip(&b.as_slice()[own]);
            pairs.fold(T::zero(), |most, (&a, &b)| larger(most, &(a - b)))
        };
        let [stage_q, stage_p] = stages.point();
        let [coordinates, momenta] = [apart(q, stage_q), apart(p, stage_p)];
        stages.evaluate_at(system, RESULT, [q, p]);
        let [[v, force], [result_v, result_force]] = [LAST, RESULT].map(|i| stages.slopes(i));
        let forces = length * apart(result_force, force);
        let of_friction = forces / momenta;
        let of_oscillation = length * apart(result_v, v) * forces / (coordinates * momenta);
        let way = length * larger(largest(stages.slopes(0)[Q]), &largest(v));
        let roundings = largest(&state.q) * T::from_f64(ROUNDINGS * T::EPSILON);
        let resolved = way * T::from_f64(RESOLVED);
        let moves = roundings.lt(resolved);
        let stiffness = smaller(of_oscillation, of_friction * of_friction);
        Self {
            error: length * stages.largest_in_lanes::<Q>(Dop853::DIFFERENCES[0], own),
            bound: T::select(moves, resolved, roundings),
            stiffness: T::select(moves, stiffness, T::zero()),
        }
    }

    /// Whether a bound is exceeded by more than these factors.
    fn exceeds(&self, [error, stiffness]: [f64; 2]) -> T::Mask {
        let error = (self.bound * T::from_f64(error)).lt(self.error);
        error.or(T::from_f64(SHORT * stiffness).lt(self.stiffness))
    }

    /// Whether the part has to be shorter. `by_kink` says whether the distance from a kink limits
    /// it.
    pub(super) fn is_insufficient(&self, by_kink: T::Mask) -> T::Mask {
        let near_kink = by_kink.not().or(self.exceeds([NEAR_KINKS, 1.0]));
        near_kink.and(self.exceeds([1.0; 2]))
    }

    /// Whether the part has to be much shorter.
    pub(super) fn is_coarse(&self) -> T::Mask {
        self.exceeds(COARSE)
    }

    /// Whether a part of twice the length resolves the motion, too.
    pub(super) fn is_fine(&self) -> T::Mask {
        self.exceeds(FINE.map(f64::recip)).not()
    }
}
