//! Is it sweeps that hold steps back?
//!
//! Where many steps are as long as sweeps allow and much shorter than their error would, Newton's
//! method is tried. If it does not soon lead to much longer ones, sweeps take over again, and the
//! next trial waits twice as long.

/// Steps held back before the first trial, for one degree of freedom: what a trial costs grows like
/// the square of their number, in sweeps.
const WAIT: u64 = 8;
/// How much longer steps should become, likewise, and in how many of them.
const LONGER: f64 = 8.0;
const TRIAL: u32 = 6;

/// What has been seen of the steps so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffness {
    /// Is Newton's method on?
    pub(super) on: bool,
    dof: u64,
    held: u64,
    wait: u64,
    /// Steps of Newton's method, and the step they began with.
    tried: u32,
    from: f64,
}

impl Stiffness {
    pub(super) fn new(dof: usize) -> Self {
        let dof = dof as u64;
        Self { on: false, dof, held: 0, wait: WAIT * dof * dof, tried: 0, from: 0.0 }
    }

    /// A step by sweeps, held back by them or not, far more accurate than it need be or not.
    pub(super) fn see_short(&mut self, h: f64, held: bool, far: bool) {
        self.held = if far { self.held + u64::from(held) } else { 0 };
        if self.held >= self.wait {
            *self = Self { on: true, held: 0, tried: 0, from: h, ..*self };
        }
    }

    /// A step by Newton's method.
    pub(super) fn see_long(&mut self, h: f64) {
        self.tried += 1;
        if h > LONGER * self.dof as f64 * self.from {
            self.wait = WAIT * self.dof * self.dof;
        } else if self.tried > TRIAL {
            *self = Self { on: false, wait: self.wait.saturating_mul(2), ..*self };
        }
    }
}
