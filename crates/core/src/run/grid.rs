//! Equally spaced times.

use crate::error::InputError;
use crate::numbers::{Mask, Scalar};

/// The times `t_n = t0 + n h`, n = 0..=steps. They are not accumulated, so that each has one
/// rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<T> {
    /// h
    pub h: T,
    /// The number of steps.
    pub steps: u64,
}

impl<T: Scalar> Grid<T> {
    /// The steps of size `h` that end at `end`, counted from 0: a run that begins at the time t
    /// ends at t + `end`.
    ///
    /// # Errors
    /// [`InputError::Step`] and [`InputError::End`] if a number is not positive and finite,
    /// [`InputError::TimeStalled`] if `end + h = end`, [`InputError::NotAMultiple`] if `end / h`
    /// differs from a whole number by more than rounding.
    pub fn new(h: f64, end: f64) -> Result<Self, InputError> {
        if !(end > 0.0 && end.is_finite()) {
            return Err(InputError::End { end });
        }
        check_step(h)?;
        if end + h == end {
            return Err(InputError::TimeStalled { t: end, h });
        }
        let count = (end / h).round();
        // The quotient of two rounded numbers is off by a few roundings of itself.
        if count < 1.0 || ((end / h) - count).abs() > 4.0 * f64::EPSILON * count {
            return Err(InputError::NotAMultiple { end, h, nearest: end / count.max(1.0) });
        }
        Ok(Self { h: T::from_f64(h), steps: count as u64 })
    }

    /// `steps` steps of size `h`.
    ///
    /// # Errors
    /// [`InputError::Step`] if the step is not positive and finite, [`InputError::End`] if the end
    /// overflows.
    pub fn of(h: f64, steps: u64) -> Result<Self, InputError> {
        check_step(h)?;
        let end = h * steps as f64;
        if !end.is_finite() {
            return Err(InputError::End { end });
        }
        Ok(Self { h: T::from_f64(h), steps })
    }

    /// The time after `n` steps from `start`: `start + n h`, with one rounding.
    #[inline(always)]
    pub(crate) fn time(&self, start: T, n: u64) -> T {
        T::from_f64(n as f64).mul_add(self.h, start)
    }

    /// Checks the step, and the last time of a run from `start`.
    ///
    /// # Errors
    /// [`InputError::Step`] if h is not finite, [`InputError::TimeStalled`] if the last time is not
    /// finite, or does not change by h.
    #[inline(always)]
    pub(crate) fn check_from(&self, start: T) -> Result<(), InputError> {
        if !self.h.is_finite().all() {
            return Err(InputError::Step { h: self.h.to_f64() });
        }
        let end = self.time(start, self.steps);
        if end + self.h == end || !end.is_finite().all() {
            return Err(InputError::TimeStalled { t: end.to_f64(), h: self.h.to_f64() });
        }
        Ok(())
    }
}

fn check_step(h: f64) -> Result<(), InputError> {
    if h > 0.0 && h.is_finite() { Ok(()) } else { Err(InputError::Step { h }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_are_counted() {
        for (h, end, steps) in
            [(0.1, 20.0, 200), (0.001, 20.0, 20_000), (1.0 / 3.0, 1.0, 3), (0.036, 0.036, 1)]
        {
            assert_eq!(Grid::<f64>::new(h, end).unwrap().steps, steps);
        }
    }

    #[test]
    fn steps_that_lead_nowhere_are_refused() {
        for h in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            assert!(matches!(Grid::<f64>::new(h, 1.0), Err(InputError::Step { .. })), "{h}");
        }
        for end in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Grid::<f64>::new(0.1, end), Err(InputError::End { .. })), "{end}");
        }
        assert!(matches!(Grid::<f64>::new(1e-20, 1.0), Err(InputError::TimeStalled { .. })));
        for h in [f64::NAN, f64::INFINITY] {
            let refused = Grid { h, steps: 1 }.check_from(0.0);
            assert!(matches!(refused, Err(InputError::Step { .. })), "{h}: {refused:?}");
        }
        let error = Grid::<f64>::new(0.3, 1.0).unwrap_err();
        assert_eq!(error, InputError::NotAMultiple { end: 1.0, h: 0.3, nearest: 1.0 / 3.0 });
        assert!(matches!(Grid::<f64>::new(3.0, 1.0), Err(InputError::NotAMultiple { .. })));
    }
}
