//! The time loop with steps as long as a tolerance allows.

use super::method::Effort;
use super::observer::Observer;
use super::tolerance::Tolerance;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::numbers::{Mask, Scalar, Vector};
use crate::system::{State, System};

/// A method that knows its own error.
pub trait Adaptive<V: Vector, S: System<V::Scalar> + ?Sized> {
    /// Scratch space and the last step.
    type Workspace;

    /// A step that would grow by less stays as it is: more than 1 where much of what is computed for its length stays too.
    const LEAST_GROWTH: f64 = 1.0;

    /// The workspace for a run over the time `span`.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] where the method does not apply to this system, [`InputError::Tolerance`] where it cannot
    /// be that accurate.
    fn workspace(&self, system: &S, tolerance: &Tolerance, span: f64) -> Result<Self::Workspace, InputError>;

    /// Computes the step h from `state`.
    ///
    /// # Errors
    /// A [`StepFailure`]: a shorter step may go.
    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        workspace: &mut Self::Workspace,
    ) -> Result<Attempt, StepFailure>;

    /// Takes the step attempted last. The time in `state` is the caller's to set.
    fn accept(&self, state: &mut State<V>, workspace: &mut Self::Workspace);

    /// The state the time h after `before`, which the step accepted last began with and led beyond that.
    ///
    /// # Errors
    /// A [`StepFailure`].
    fn between(
        &self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        workspace: &mut Self::Workspace,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure>;
}

/// A step to be taken or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// Its error over what is allowed of a step of its length.
    pub error: f64,
    /// That grows like this power of h.
    pub order: u32,
    /// How much longer the next step may be for other reasons than its error.
    pub largest_growth: f64,
    /// What it cost.
    pub effort: Effort,
}

/// What a run did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Steps taken.
    pub accepted: u64,
    /// Steps that were not accurate enough.
    pub rejected: u64,
    /// Steps that could not be computed.
    pub failed: u64,
    /// The shortest and the longest step taken.
    pub least: f64,
    /// The longest.
    pub largest: f64,
    /// What all of them cost.
    pub effort: Effort,
}

/// The error a step aims at, over what is allowed.
const SAFETY: f64 = 0.2;
/// A step grows and shrinks by no more than this.
const GROWTH: f64 = 5.0;
/// The first step, over what it should be if solutions were no more than what they begin with.
const START: f64 = 0.3;
/// An error counts as no less, over what is allowed: of what the next step may be, and of what it says of a trend.
const TINY: f64 = 1e-30;
const CALM: f64 = 1e-3;
/// What is left of a step that could not be computed, and how often in a row that is tried.
const CUT: f64 = 0.5;
const CUTS: u32 = 60;

/// Carries `state` to the time `end`, showing every accepted step to `observer`.
///
/// # Errors
/// [`IntegrateError::Input`] if the state does not fit the system, the method does not apply or the tolerance or the end cannot
/// be reached: nothing was done. [`IntegrateError::Run`] if steps fail however short, or shrink to nothing: `state` is then that of
/// the last good step.
pub fn integrate_within<V, S, M, O>(
    method: &M,
    system: &S,
    tolerance: &Tolerance,
    end: V::Scalar,
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Statistics, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let mut run = Run::new(method, system, tolerance, end, state)?;
    let mut seen = observer.observe(0, state);
    while seen.is_continue() && state.t.lt(end).all() {
        run.step(state)?;
        seen = observer.observe(run.statistics.accepted, state);
    }
    Ok(run.statistics)
}

/// The same to the last of `times`, which ascend from the state's own, showing the states at these times to `observer`. They
/// are as accurate as those of the steps, and K is kept as well there.
///
/// # Errors
/// As [`integrate_within`]; [`InputError::End`] where times do not ascend.
pub fn sample_within<V, S, M, O>(
    method: &M,
    system: &S,
    tolerance: &Tolerance,
    times: &[V::Scalar],
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Statistics, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let Some(&end) = times.last() else { return Ok(Statistics::default()) };
    if let Some(pair) = times.windows(2).find(|pair| !pair[0].le(pair[1]).all()) {
        return Err(InputError::End { end: pair[1].to_f64() }.into());
    }
    if !state.t.le(times[0]).all() {
        return Err(InputError::End { end: times[0].to_f64() }.into());
    }
    let mut run = Run::new(method, system, tolerance, end, state)?;
    let (mut before, mut shown) = (state.clone(), state.clone());
    for (n, &time) in (0..).zip(times) {
        while state.t.lt(time).all() {
            before.copy(state);
            run.step(state)?;
        }
        let seen = if state.t == time {
            observer.observe(n, state)
        } else {
            let h = time - before.t;
            run.statistics.effort += match method.between(system, h, &before, &mut run.workspace, &mut shown)
            {
                Ok(effort) => effort,
                // What no single step leads to is reached by steps of its own.
                Err(_) => run.apart(&before, time, &mut shown)?,
            };
            shown.t = time;
            observer.observe(n, &shown)
        };
        if seen.is_break() {
            break;
        }
    }
    Ok(run.statistics)
}

/// A run on its way.
struct Run<'a, V: Vector, S: ?Sized, M: ?Sized, W> {
    method: &'a M,
    system: &'a S,
    workspace: W,
    tolerance: Tolerance,
    end: V::Scalar,
    h: f64,
    /// The step before, and the logarithm of its error over what it aimed at.
    before: f64,
    before_h: f64,
    statistics: Statistics,
}

impl<'a, V, S, M> Run<'a, V, S, M, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
{
    fn new(
        method: &'a M,
        system: &'a S,
        tolerance: &Tolerance,
        end: V::Scalar,
        state: &State<V>,
    ) -> Result<Self, InputError> {
        state.check(system.dof())?;
        tolerance.check::<V::Scalar>()?;
        let span = (end - state.t).to_f64();
        if !(span >= 0.0 && span.is_finite()) {
            return Err(InputError::End { end: end.to_f64() });
        }
        let workspace = method.workspace(system, tolerance, span)?;
        let h = first(system, state, tolerance).min(span);
        let statistics = Statistics { least: f64::INFINITY, ..Statistics::default() };
        let tolerance = *tolerance;
        Ok(Self {
            method,
            system,
            workspace,
            tolerance,
            end,
            h,
            before: f64::INFINITY,
            before_h: h,
            statistics,
        })
    }

    /// Carries `shown` from `before` to a time, with the tolerance of the run.
    #[cold]
    fn apart(
        &self,
        before: &State<V>,
        time: V::Scalar,
        shown: &mut State<V>,
    ) -> Result<Effort, IntegrateError> {
        shown.copy(before);
        let mut run =
            Run { end: time, ..Run::new(self.method, self.system, &self.tolerance, self.end, before)? };
        while shown.t.lt(time).all() {
            run.step(shown).map_err(|error| self.failed(before, error.failure))?;
        }
        Ok(run.statistics.effort)
    }

    fn failed(&self, state: &State<V>, failure: StepFailure) -> RunError {
        RunError { step: self.statistics.accepted + 1, t: state.t.to_f64(), failure }
    }

    /// One step that is accurate enough.
    fn step(&mut self, state: &mut State<V>) -> Result<(), RunError> {
        let left = self.end - state.t;
        let mut cuts = 0;
        loop {
            // No step is left that is much shorter than the others.
            let rest = left.to_f64();
            let last = rest <= self.h * 1.01;
            let h = match rest / self.h {
                _ if last => left,
                steps if steps < 2.0 => left.half(),
                _ => V::Scalar::from_f64(self.h),
            };
            if state.t + h == state.t {
                return Err(self.failed(state, StepFailure::Vanishes { h: h.to_f64() }));
            }
            match self.method.attempt(self.system, h, state, &mut self.workspace) {
                Err(failure) => {
                    self.statistics.failed += 1;
                    cuts += 1;
                    if cuts > CUTS {
                        return Err(self.failed(state, failure));
                    }
                    self.h = CUT * h.to_f64();
                }
                Ok(attempt) => {
                    self.statistics.effort += attempt.effort;
                    let taken = attempt.error <= 1.0;
                    let factor = self.factor(attempt, h.to_f64(), taken, cuts > 0);
                    self.h = h.to_f64() * factor;
                    if taken {
                        self.method.accept(state, &mut self.workspace);
                        state.t = if last { self.end } else { state.t + h };
                        let h = h.to_f64();
                        let Statistics { accepted, least, largest, .. } = &mut self.statistics;
                        (*accepted, *least, *largest) = (*accepted + 1, least.min(h), largest.max(h));
                        return Ok(());
                    }
                    self.statistics.rejected += 1;
                    cuts = 1;
                }
            }
        }
    }

    /// The next step over this one, by a controller that sees how the error changes (K. Gustafsson, ACM TOMS 20 (1994) 496-517).
    fn factor(&mut self, attempt: Attempt, h: f64, taken: bool, cut: bool) -> f64 {
        let order = f64::from(attempt.order);
        let error = ln(attempt.error.max(TINY) / SAFETY);
        if !taken {
            // What is rejected twice does not follow the power of h.
            let factor = if cut { CUT } else { exp(-error / order).clamp(1.0 / GROWTH, 0.9) };
            return factor.min(attempt.largest_growth);
        }
        let most = if cut { 1.0 } else { GROWTH };
        // What the error asks for, and what it asks for if it goes on to change as it did.
        let longer = if h == self.before_h { 0.0 } else { ln(h / self.before_h) };
        let trend = self.before - error + order * longer;
        let factor = exp((trend.min(0.0) - error) / order).clamp(1.0 / GROWTH, most);
        let factor = factor.min(attempt.largest_growth);
        (self.before_h, self.before) = (h, error.max(ln(CALM / SAFETY)));
        if (1.0..M::LEAST_GROWTH).contains(&factor) { 1.0 } else { factor }
    }
}

/// How long a step is need not be known to more than single precision, in which these take a third of the time.
fn ln(x: f64) -> f64 {
    f64::from((x as f32).ln())
}

fn exp(x: f64) -> f64 {
    f64::from((x as f32).exp())
}

/// A step to begin with: of the time in which q or p would change by its size a share that a method of order 8 makes such
/// errors of.
fn first<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    state: &State<V>,
    tolerance: &Tolerance,
) -> f64 {
    let n = state.dof();
    let (mut hq, mut hp, mut d) = (V::zeros(n), V::zeros(n), V::zeros(n));
    system.gradient(state.q.as_slice(), state.p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
    system.dissipation(state.q.as_slice(), state.p.as_slice(), hp.as_slice(), d.as_mut_slice());
    let largest = |x: &V| x.as_slice().iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
    let size = largest(&state.q).max(largest(&state.p)).max(1e-6);
    let rate = largest(&hq).max(largest(&hp)).max(largest(&d));
    let h = START * tolerance.relative.powf(0.125) * size / rate;
    if h.is_finite() { h } else { f64::MAX }
}
