//! The control of the step size.
//!
//! The controller also uses how the error changes from step to step (K. Gustafsson, ACM TOMS 20
//! (1994) 496-517). All errors are shares of the error allowed for the step.

use super::method::Attempt;
use super::tolerance::Tolerance;
use crate::error::InputError;
use crate::numbers::{Scalar, Vector, larger_or_nan};
use crate::system::{State, System};

/// The error a step aims at, as a share of the error allowed; between 0 and 1. Values from 0.25 to
/// 0.4 are usual (E. Hairer, S. P. Nørsett, G. Wanner, *Solving ODEs I*, section II.4).
const TARGET_ERROR: f64 = 0.2;
/// The largest factor by which a step grows; above 1. Values from 1.5 to 5 are usual (ibid.).
const LARGEST_GROWTH: f64 = 5.0;
/// The largest factor by which a step shrinks; above 1. The value of [`LARGEST_GROWTH`].
const LARGEST_SHRINKAGE: f64 = 5.0;
/// The largest factor for the step after a rejected one; below 1, so that it is shorter.
const LARGEST_AFTER_REJECTION: f64 = 0.9;
/// The first step, as a share of the step at which a solution of the size and slope of the initial
/// state has the error allowed; between 0 and 1. A choice.
const FIRST_SHARE: f64 = 0.3;
/// The least size assumed for q and p when the first step is chosen, in their own units.
const LEAST_SIZE: f64 = 1e-6;
/// The least error that enters the next step, as a share of the error allowed. It only avoids ln 0.
const LEAST_ERROR: f64 = 1e-30;
/// The least error that is remembered for the trend, as a share of the error allowed: smaller ones
/// are dominated by rounding and carry no trend.
const LEAST_TREND: f64 = 1e-3;
/// The factor for a step that could not be computed or was rejected again; between 0 and 1.
pub(super) const CUT: f64 = 0.5;
/// The largest number of such cuts in a row: 2⁻⁶⁰ of a step is below its rounding.
pub(super) const MOST_CUTS: u32 = 60;
/// One step covers a remaining time of up to this number of steps, and two equal steps cover one of
/// less than 2 steps.
pub(super) const LAST_STRETCH: f64 = 1.01;

/// Options of the step size control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepControl {
    /// The length of the first step in the unit of time, from the least to the largest. Without it,
    /// it follows from the tolerance and the initial state.
    pub initial: Option<f64>,
    /// The least length of a step in the unit of time, at least 0. A run that needs a shorter one
    /// for its tolerance fails with [`StepFailure::Vanishes`]; the last two steps, and those that
    /// end at a break, may be shorter.
    ///
    /// [`StepFailure::Vanishes`]: crate::StepFailure::Vanishes
    pub least: f64,
    /// The largest length of a step in the unit of time; above the least. The last step may be 1 %
    /// longer.
    pub largest: f64,
    /// The error a step aims at, as a share of the error allowed; above 0 and below 1.
    pub target_error: f64,
    /// The largest factor by which a step grows; above 1.
    pub largest_growth: f64,
}

impl Default for StepControl {
    fn default() -> Self {
        Self {
            initial: None,
            least: 0.0,
            largest: f64::INFINITY,
            target_error: TARGET_ERROR,
            largest_growth: LARGEST_GROWTH,
        }
    }
}

impl StepControl {
    /// Checks the range of each option.
    ///
    /// # Errors
    /// [`InputError::Parameter`], with the option that is out of range.
    pub fn check(&self) -> Result<(), InputError> {
        let Self { initial, least, largest, target_error, largest_growth } = *self;
        let first = initial.unwrap_or(largest);
        let aims = target_error > 0.0 && target_error < 1.0;
        let starts = initial.is_none() || (first > 0.0 && first.is_finite());
        let parts = [
            (least >= 0.0 && least.is_finite(), "least step", least, "0 or more, and finite"),
            (largest > least, "largest step", largest, "above the least step"),
            (starts, "initial step", first, "above 0, and finite"),
            (
                (least..=largest).contains(&first),
                "initial step",
                first,
                "from the least to the largest step",
            ),
            (aims, "target error", target_error, "above 0 and below 1"),
            (largest_growth > 1.0, "largest growth", largest_growth, "above 1"),
        ];
        match parts.into_iter().find(|part| !part.0) {
            Some((_, name, value, range)) => Err(InputError::Parameter { name, value, range }),
            None => Ok(()),
        }
    }
}

/// The size of the next step, and the data of the step before.
#[derive(Clone, Copy)]
pub(super) struct Controller {
    options: StepControl,
    /// 1 over the error aimed at, and the logarithm of the least error remembered, over that error.
    inverse_target: f64,
    log_least: f64,
    /// The length of the next step.
    pub(super) h: f64,
    /// The logarithm of the error of the last accepted step over the error aimed at.
    log_error: f64,
    /// The length of that step.
    last_h: f64,
}

impl Controller {
    /// A controller that begins with the step h.
    pub(super) fn new(h: f64, options: StepControl) -> Self {
        let h = h.max(options.least).min(options.largest);
        let inverse_target = options.target_error.recip();
        let log_least = ln(LEAST_TREND * inverse_target);
        Self { options, inverse_target, log_least, h, log_error: f64::INFINITY, last_h: h }
    }

    /// The shortest step that the options allow.
    pub(super) fn least(&self) -> f64 {
        self.options.least
    }

    /// Chooses the next step after an attempt with the step h that was `accepted` or not. `cut`
    /// says that a longer step has failed before. The step does not grow by a factor below
    /// `least_growth`.
    #[inline(always)]
    pub(super) fn update(
        &mut self,
        attempt: Attempt,
        h: f64,
        accepted: bool,
        cut: bool,
        least_growth: f64,
    ) {
        let h = h * self.factor(attempt, h, accepted, cut, least_growth);
        // A step that was rejected has to be shorter.
        let h = if accepted { h.max(self.options.least) } else { h };
        self.h = h.min(self.options.largest);
    }

    #[inline(always)]
    fn factor(
        &mut self,
        attempt: Attempt,
        h: f64,
        accepted: bool,
        cut: bool,
        least_growth: f64,
    ) -> f64 {
        // The next step waits for the result, so that there are no divisions where they can be
        // avoided.
        let order = f64::from(attempt.order);
        let inverse_order = order.recip();
        let error = ln(attempt.error.max(LEAST_ERROR) * self.inverse_target);
        if !accepted {
            // The error of a step that is rejected twice does not follow the power of h.
            let factor = if cut {
                CUT
            } else {
                exp(-error * inverse_order).clamp(1.0 / LARGEST_SHRINKAGE, LARGEST_AFTER_REJECTION)
            };
            return factor.min(attempt.largest_growth);
        }
        let most = if cut { 1.0 } else { self.options.largest_growth };
        // The step for the present error, shortened if the error goes on to grow as it did.
        let longer = if h == self.last_h { 0.0 } else { ln(h / self.last_h) };
        let trend = self.log_error - error + order * longer;
        let factor =
            exp((trend.min(0.0) - error) * inverse_order).clamp(1.0 / LARGEST_SHRINKAGE, most);
        let factor = factor.min(attempt.largest_growth);
        (self.last_h, self.log_error) = (h, error.max(self.log_least));
        if (1.0..least_growth).contains(&factor) { 1.0 } else { factor }
    }
}

/// ln of a positive normal number, to 2e-4, from the exponent and a polynomial of the mantissa. A
/// step size needs no more digits, and the next step waits for the result.
#[inline]
fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let exponent = (bits >> 52) as i64 - 1023;
    let m = f64::from_bits((bits & 0x000F_FFFF_FFFF_FFFF) | 1.0_f64.to_bits()) - 1.0;
    std::f64::consts::LN_2.mul_add(exponent as f64, m * polynomial(LOG, m))
}

/// exp, to 2e-4 of itself, of numbers within ±690; constant beyond.
#[inline]
fn exp(x: f64) -> f64 {
    let power = (x * std::f64::consts::LOG2_E).clamp(-1000.0, 1000.0);
    let whole = power.floor();
    let scale = f64::from_bits(((whole as i64 + 1023) as u64) << 52);
    scale * polynomial(POWER, power - whole)
}

/// ln(1 + x)/x and 2^x for x in [0, 1], by least squares.
const LOG: [f64; 4] = [0.997_187_89, -0.469_775_83, 0.223_110_01, -0.057_434_66];
const POWER: [f64; 4] = [0.999_896_69, 0.696_390_55, 0.224_516_34, 0.079_085_7];

fn polynomial(terms: [f64; 4], x: f64) -> f64 {
    let [a, b, c, d] = terms;
    d.mul_add(x, c).mul_add(x * x, b.mul_add(x, a))
}

/// The first step: a share of the time in which q or p would change by its size, such that a method
/// of order 8 has about the error allowed.
pub(super) fn first<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    state: &State<V>,
    tolerance: &Tolerance,
) -> f64 {
    let (n, free) = (state.dof(), state.dof() - system.motors());
    let (mut hq, mut hp, mut d) = (V::zeros(n), V::zeros(n), V::zeros(n));
    system.gradient(state.q.as_slice(), state.p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
    system.dissipation(state.q.as_slice(), state.p.as_slice(), hp.as_slice(), d.as_mut_slice());
    let largest = |x: &[V::Scalar]| x.iter().map(|x| x.to_f64().abs()).fold(0.0, larger_or_nan);
    // The coordinates of motors are the time.
    let (q, p) = (&state.q.as_slice()[..free], state.p.as_slice());
    let size = largest(q).max(largest(p)).max(LEAST_SIZE);
    let rate = [&hq, &hp, &d].map(|x| largest(x.as_slice())).into_iter().fold(0.0, larger_or_nan);
    let h = FIRST_SHARE * tolerance.relative.powf(0.125) * size / rate;
    if h.is_finite() { h } else { f64::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ln_and_exp_are_close_enough_for_a_step_size() {
        for i in -690..690 {
            let x = f64::from(i) + 0.37;
            let y = x.exp();
            assert!((ln(y) - x).abs() < 2e-4, "ln {y}: {}", ln(y));
            assert!((exp(x) / y - 1.0).abs() < 2e-4, "exp {x}: {}", exp(x));
        }
        for i in 0..1000 {
            let x = 1.0 + f64::from(i) / 1000.0;
            assert!((ln(x) - x.ln()).abs() < 1e-4 && (exp(x.ln()) / x - 1.0).abs() < 2e-4, "{x}");
        }
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let good = StepControl::default();
        assert!(good.check().is_ok());
        for (bad, named) in [
            (StepControl { initial: Some(0.0), ..good }, "initial step"),
            (StepControl { initial: Some(0.1), least: 0.2, ..good }, "initial step"),
            (StepControl { initial: Some(3.0), largest: 2.0, ..good }, "initial step"),
            (StepControl { least: -1.0, ..good }, "least step"),
            (StepControl { least: 2.0, largest: 1.0, ..good }, "largest step"),
            (StepControl { target_error: 1.0, ..good }, "target error"),
            (StepControl { target_error: f64::NAN, ..good }, "target error"),
            (StepControl { largest_growth: 1.0, ..good }, "largest growth"),
        ] {
            let refused = bad.check();
            assert!(
                matches!(refused, Err(InputError::Parameter { name, .. }) if name == named),
                "{named}: {refused:?}"
            );
        }
    }
}
