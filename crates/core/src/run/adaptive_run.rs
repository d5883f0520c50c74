//! A run with step size control.

use super::controller::{CUT, Controller, LAST_STRETCH, MOST_CUTS, StepControl, first};
use super::integrate::check_between;
use super::method::{Adaptive, Attempt, Effort};
use super::observer::Observer;
use super::tolerance::Tolerance;
use super::undefined::or_undefined;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::numbers::{Mask, Scalar, Vector};
use crate::system::{State, System};

/// The longest step across a break, or to the end, that is accepted whatever its estimated error,
/// in unit roundoffs of the larger of |t| and the proposed step. Over so short a step the estimate
/// is rounding. A choice.
const LONGEST_UNCONTROLLED: f64 = 512.0;

/// The longest step across a break that is accepted whatever its estimated error, in unit roundoffs
/// of the length of the run. Near t = 0 the roundings of 1 + t, within which a break of ⌊1 + t⌋ is
/// not located, are far above those of t. A choice.
const LONGEST_AT_BREAK: f64 = 64.0;
/// The largest relative change of a step by which its end becomes a number of the scalar. A choice.
const MOST_ROUNDED: f64 = 0.125;
/// The longest step that counts as one of a standstill, in unit roundoffs of t: 4 to 8 spacings of
/// the numbers near t. A choice.
const LONGEST_AT_STANDSTILL: f64 = 8.0;
/// The largest number of such steps in a row. A choice.
const MOST_AT_STANDSTILL: u32 = 1000;

/// The steps of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Steps taken.
    pub accepted: u64,
    /// Steps whose error was too large.
    pub rejected: u64,
    /// Steps that could not be computed.
    pub failed: u64,
    /// The length of the shortest step taken, in the unit of time.
    pub least: f64,
    /// The length of the longest step taken, in the unit of time.
    pub largest: f64,
    /// The work of steps taken and rejected, and of states between steps. Steps that could not be
    /// computed are not counted.
    pub effort: Effort,
}

/// A run of a method that chooses its steps, which may be advanced to one time after another. The
/// tolerance is that of the whole run, whatever the number of these times.
pub struct AdaptiveRun<'a, V, S, M>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
{
    method: &'a M,
    system: &'a S,
    pub(super) workspace: M::Workspace,
    tolerance: Tolerance,
    end: V::Scalar,
    span: f64,
    controller: Controller,
    /// The usual first step times the square of a rounding: shorter ones lead nowhere. Near t = 0
    /// steps can become much shorter than a rounding of anything else.
    shortest: f64,
    /// The number of steps of a few roundings of t up to here, in a row.
    at_standstill: u32,
    pub(super) statistics: Statistics,
}

/// A step to attempt.
struct Proposal<T> {
    h: T,
    /// Whether it ends at a break of the system.
    at_break: bool,
    /// Whether it ends at a break or at the end of the part.
    last: bool,
}

impl<'a, V, S, M> AdaptiveRun<'a, V, S, M>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
{
    /// A run from `state` to the time `end`.
    ///
    /// # Errors
    /// [`InputError`] if [`System::check`] refuses the system, the state does not fit it, the
    /// method does not apply, or the tolerance, an option or the end is invalid.
    pub fn new(
        method: &'a M,
        system: &'a S,
        tolerance: &Tolerance,
        control: StepControl,
        end: V::Scalar,
        state: &State<V>,
    ) -> Result<Self, InputError> {
        system.check()?;
        state.check_with(system.dof(), || system.motors())?;
        tolerance.check::<V::Scalar>()?;
        control.check()?;
        let span = (end - state.t).to_f64();
        if !(span >= 0.0 && span.is_finite()) {
            return Err(backwards(state.t, end));
        }
        let workspace = method.workspace(system, tolerance, span)?;
        let natural = first(system, state, tolerance);
        let h = control.initial.unwrap_or(natural).min(span);
        // At rest the first step is not known.
        let natural = if natural < f64::MAX { natural.min(h) } else { 0.0 };
        let shortest = natural * V::Scalar::EPSILON * V::Scalar::EPSILON;
        Ok(Self {
            method,
            system,
            workspace,
            tolerance: *tolerance,
            end,
            span,
            controller: Controller::new(h, control),
            shortest: shortest.max(f64::MIN_POSITIVE),
            at_standstill: 0,
            statistics: Statistics::default(),
        })
    }

    /// The steps up to here.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Integrates to the time `to` and passes every accepted step to `observer`, with the number of
    /// steps of the run. `state` is the one at which the last call ended, or that of
    /// [`AdaptiveRun::new`]. A time before the state changes nothing.
    ///
    /// # Errors
    /// [`RunError`] if steps fail at every length, or shrink to roundings of t; `state` is then
    /// that of the last successful step.
    pub fn advance<O: Observer<V> + ?Sized>(
        &mut self,
        to: V::Scalar,
        state: &mut State<V>,
        observer: &mut O,
    ) -> Result<(), RunError> {
        while state.t.lt(to).all() {
            self.step(to, state)?;
            if observer.observe(self.statistics.accepted, state).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Integrates from `before` to a time within the tolerance of the run, by steps that do not
    /// belong to the run.
    #[cold]
    pub(super) fn apart(
        &self,
        before: &State<V>,
        time: V::Scalar,
        shown: &mut State<V>,
    ) -> Result<Effort, IntegrateError> {
        shown.copy(before);
        let (control, tolerance) = (StepControl::default(), &self.tolerance);
        let mut run = Self::new(self.method, self.system, tolerance, control, self.end, before)?;
        run.advance(time, shown, &mut ()).map_err(|error| self.failed(before, error.failure))?;
        Ok(run.statistics.effort)
    }

    #[cold]
    fn failed(&self, state: &State<V>, failure: StepFailure) -> RunError {
        let failure = or_undefined(self.system, state, self.statistics.accepted == 0, failure);
        RunError { step: self.statistics.accepted + 1, t: state.t.to_f64(), failure }
    }

    /// Takes one step within the tolerance, not beyond the time `to`.
    pub(super) fn step(&mut self, to: V::Scalar, state: &mut State<V>) -> Result<(), RunError> {
        let mut cuts = 0;
        loop {
            let proposal = self.propose(to, state)?;
            let Proposal { h, last, at_break } = proposal;
            let wanted = self.controller;
            // A run that ends at a break, to rounding, ends within the step across it.
            let longest = LONGEST_AT_BREAK * V::Scalar::EPSILON * self.span;
            let crosses = (at_break && h.to_f64() <= longest)
                || (at_break || last) && is_uncontrolled(h, state.t.to_f64().abs().max(wanted.h));
            let outcome = self.method.attempt(self.system, h, state, &mut self.workspace);
            match outcome.and_then(|attempt| self.refuse_across(attempt, state)) {
                Err(failure) => {
                    self.statistics.failed += 1;
                    cuts += 1;
                    // No shorter step avoids a wrong gradient.
                    let stays = matches!(failure, StepFailure::NotGradient { .. });
                    if stays || cuts > MOST_CUTS {
                        return Err(self.failed(state, failure));
                    }
                    self.controller.h = CUT * h.to_f64();
                }
                Ok(attempt) => {
                    self.statistics.effort += attempt.effort;
                    let taken = attempt.error <= 1.0 || (crosses && attempt.error.is_finite());
                    self.controller.update(attempt, h.to_f64(), taken, cuts > 0, M::LEAST_GROWTH);
                    if taken {
                        if at_break && last {
                            // The break made the step short, not its error.
                            self.controller = wanted;
                        }
                        self.take(&proposal, to, state);
                        return Ok(());
                    }
                    self.statistics.rejected += 1;
                    cuts = 1;
                }
            }
        }
    }

    /// The step to attempt from `state`.
    #[inline(always)]
    fn propose(&self, to: V::Scalar, state: &State<V>) -> Result<Proposal<V::Scalar>, RunError> {
        let (left, at_break) = self.smooth_part(to, state);
        // The last step is not much shorter than those before.
        let rest = left.to_f64();
        let last = rest <= self.controller.h * LAST_STRETCH;
        let h = match self.controller.h {
            _ if last => left,
            h if rest < 2.0 * h => left.half(),
            h => V::Scalar::from_f64(h),
        };
        let h = if last { h } else { between_times(state.t, h) };
        let short = self.controller.h < self.controller.least().max(self.shortest);
        let stands = self.at_standstill > MOST_AT_STANDSTILL;
        if state.t + h == state.t || stands || (short && !last) {
            return Err(self.failed(state, StepFailure::Vanishes { h: h.to_f64() }));
        }
        Ok(Proposal { h, at_break, last })
    }

    /// Moves `state` to the end of the step attempted last.
    #[inline(always)]
    fn take(&mut self, proposal: &Proposal<V::Scalar>, to: V::Scalar, state: &mut State<V>) {
        let &Proposal { h, at_break, last } = proposal;
        self.method.accept(state, &mut self.workspace);
        state.t = if last && !at_break { to } else { state.t + h };
        let h = h.to_f64();
        let stands = is_at_standstill(h, state.t);
        self.at_standstill = if stands { self.at_standstill + 1 } else { 0 };
        let Statistics { accepted, least, largest, .. } = &mut self.statistics;
        *least = if *accepted == 0 { h } else { least.min(h) };
        *largest = largest.max(h);
        *accepted += 1;
    }

    /// The time from here to `to` or to the next break, and whether it is a break.
    #[inline(always)]
    fn smooth_part(&self, to: V::Scalar, state: &State<V>) -> (V::Scalar, bool) {
        let left = to - state.t;
        // Only breaks within the next two steps matter.
        let near = V::Scalar::from_f64(2.0 * LAST_STRETCH * self.controller.h);
        let ahead = V::Scalar::select(left.lt(near), left, near);
        let smooth = self.system.step_between_breaks(state.q.as_slice(), ahead);
        if smooth.lt(ahead).any() { (smooth, true) } else { (left, false) }
    }

    /// Fails a step that is accurate enough and has a singularity of H between its ends.
    #[inline(always)]
    fn refuse_across(&self, attempt: Attempt, state: &State<V>) -> Result<Attempt, StepFailure> {
        if self.system.may_be_singular() && attempt.error <= 1.0 {
            check_between(self.system, state.q.as_slice(), self.method.end(&self.workspace))?;
        }
        Ok(attempt)
    }
}

pub(super) fn backwards<T: Scalar>(from: T, to: T) -> InputError {
    InputError::Backwards { from: from.to_f64(), to: to.to_f64() }
}

/// The step nearest to h that ends at a number of the scalar. A rounding of t + h would be an error
/// of the time at every step. A step of a few roundings of t stays as it is, so that it can shrink.
#[inline(always)]
fn between_times<T: Scalar>(t: T, h: T) -> T {
    let rounded = (t + h) - t;
    let change = (rounded - h).to_f64().abs();
    if change <= MOST_ROUNDED * h.to_f64().abs() { rounded } else { h }
}

/// Whether a step h is so short beside a time that its estimated error is rounding.
pub(super) fn is_uncontrolled<T: Scalar>(h: T, time: f64) -> bool {
    h.to_f64() <= LONGEST_UNCONTROLLED * T::EPSILON * time
}

/// Whether a step h to the time t is about as short as the spacing of the numbers near t.
fn is_at_standstill<T: Scalar>(h: f64, t: T) -> bool {
    h <= LONGEST_AT_STANDSTILL * T::EPSILON * t.to_f64().abs()
}
