//! The detection of stiffness, where sweeps limit the step size.
//!
//! If many steps are as long as the contraction of sweeps permits and much shorter than their error
//! would permit, Newton's method is tried. If the steps do not soon become much longer, the method
//! returns to sweeps, and the next trial waits twice as long.

/// The number of limited steps before the first trial, for one degree of freedom. The cost of a
/// trial, in sweeps, grows like the square of the number of degrees of freedom. A choice.
const STEPS_BEFORE_TRIAL: u64 = 8;
/// The factor by which steps must become longer, times the number of degrees of freedom, and the
/// number of steps in which they must. Choices: a step by Newton's method costs about as many
/// sweeps.
const LEAST_GAIN: f64 = 8.0;
const TRIAL_STEPS: u32 = 6;

/// The history of the steps so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffness {
    /// Whether Newton's method is in use.
    pub(super) uses_newton: bool,
    dof: u64,
    /// The number of steps limited by sweeps, and the number at which the next trial begins.
    limited_steps: u64,
    wait: u64,
    /// The number of steps by Newton's method, and the step size at their start.
    tried: u32,
    trial_h: f64,
}

impl Stiffness {
    pub(super) fn new(dof: usize) -> Self {
        let dof = dof as u64;
        Self {
            uses_newton: false,
            dof,
            limited_steps: 0,
            wait: STEPS_BEFORE_TRIAL * dof * dof,
            tried: 0,
            trial_h: 0.0,
        }
    }

    /// Records a step by sweeps: whether sweeps limited it, and whether it is far more accurate
    /// than required. A step that is not far more accurate halves the count instead of clearing it,
    /// since the error that sweeps leave may spoil one step among many.
    pub(super) fn record_swept(&mut self, h: f64, limited: bool, far: bool) {
        let before = self.limited_steps;
        self.limited_steps = if far { before + u64::from(limited) } else { before / 2 };
        if self.limited_steps >= self.wait {
            *self = Self { uses_newton: true, limited_steps: 0, tried: 0, trial_h: h, ..*self };
        }
    }

    /// Records a step that was refused because its sweeps did not contract.
    pub(super) fn record_refused(&mut self, h: f64) {
        self.record_swept(h, true, true);
    }

    /// Records a step by Newton's method.
    pub(super) fn record_newton(&mut self, h: f64) {
        self.tried += 1;
        if h > LEAST_GAIN * self.dof as f64 * self.trial_h {
            self.wait = STEPS_BEFORE_TRIAL * self.dof * self.dof;
        } else if self.tried > TRIAL_STEPS {
            *self = Self { uses_newton: false, wait: self.wait.saturating_mul(2), ..*self };
        }
    }
}
