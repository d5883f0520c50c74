//! The share of a step in the error allowed for the run.
//!
//! The steps of a stiff run differ by factors of 1e6 and more, so that a share by length would ask
//! of its many short steps far more accuracy than the run needs. The share of a step is one over
//! the number of steps. That number is estimated from the n steps taken and from the number m of
//! steps that fit into the rest of the run if each is as long as the longest one so far:
//!
//! ```text
//! n + 8 + m^(n / (n + 8))
//! ```
//!
//! This formula is a heuristic of this library. The exponent reduces the weight of m while few
//! steps are known, since the first steps say little about the later ones.

use crate::adaptive::{ROUNDINGS, SHARES, Sizes, scales};
use afterbay_core::{Scalar, State, Tolerance, Vector};

/// The number of steps that is guessed before any is taken. As many steps must be taken before they
/// count for more than the guess. A choice.
const GUESSED_STEPS: f64 = 8.0;

/// The tolerance of a run, and the history of its steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    tolerance: Tolerance,
    span: f64,
    /// The degrees of freedom without the motors, whose coordinates are the time.
    free: usize,
    /// The time at the start.
    from: Option<f64>,
    steps: f64,
    longest: f64,
}

/// The errors allowed for a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowed {
    /// The errors of q, p and energies allowed at the end of the run.
    pub(super) scales: [f64; 3],
    /// The number of degrees of freedom without motors.
    pub(super) free: usize,
    /// The share of `scales` allowed for this step.
    pub(super) share: f64,
    /// The relative tolerances of q, p and w.
    pub(super) relative: [f64; 3],
    /// A rounding of q and p, in units of the scales.
    pub(super) rounding: f64,
}

impl Allowed {
    /// 1 over the errors of q_d and p_d that are allowed at the end of the run. The coordinate of a
    /// motor is a time, which has no error, and its momentum an energy.
    #[inline(always)]
    pub(super) fn shares(&self) -> impl Fn(usize) -> [f64; 2] + use<> {
        let ([q, p, w], free) = (self.scales.map(f64::recip), self.free);
        move |d| if d < free { [q, p] } else { [0.0, w] }
    }

    /// Allows at least these errors of q and p for the step.
    pub(super) fn allow_at_least(&mut self, errors: [f64; 2]) {
        for (scale, error) in self.scales.iter_mut().zip(errors) {
            *scale = scale.max(error / self.share);
        }
    }
}

impl Share {
    pub(super) fn new(tolerance: &Tolerance, span: f64, free: usize) -> Self {
        Self { tolerance: *tolerance, span, free, from: None, steps: 0.0, longest: 0.0 }
    }

    /// Counts an accepted step.
    #[inline(always)]
    pub(super) fn spend(&mut self, length: f64) {
        self.steps += 1.0;
        self.longest = self.longest.max(length);
    }

    /// The errors allowed for the step from `state`, at which H is `energy`.
    #[inline(always)]
    pub(super) fn allowed<V: Vector>(&mut self, state: &State<V>, energy: V::Scalar) -> Allowed {
        let t = state.t.to_f64();
        let from = *self.from.get_or_insert(t);
        let left = (self.span - (t - from)).max(0.0);
        let room = if self.longest > 0.0 { (left / self.longest).max(1.0) } else { 1.0 };
        let guessed = self.steps + GUESSED_STEPS;
        let steps = guessed + power(room, self.steps / guessed);
        let share = SHARES / steps;
        let Tolerance { relative, w_relative, .. } = self.tolerance;
        let sizes = Sizes::of(state, energy, self.free);
        let scales = scales(&self.tolerance, sizes, ROUNDINGS * V::Scalar::EPSILON / share);
        let roundings = (sizes.q / scales[0]).max(sizes.p / scales[1]);
        Allowed {
            scales,
            free: self.free,
            share,
            relative: [relative, relative, w_relative],
            rounding: V::Scalar::EPSILON * roundings,
        }
    }
}

/// x^y for x ≥ 0, to single precision, which suffices for a step size.
#[inline(always)]
pub(super) fn power(x: f64, y: f64) -> f64 {
    let (single, power) = (x as f32, (x as f32).powf(y as f32));
    if single.is_normal() && power.is_normal() { f64::from(power) } else { x.powf(y) }
}
