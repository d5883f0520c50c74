//! The runs of a cell of a long-run study, side by side or alone, in legs.

use super::{SAMPLES, Setup};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::kept::LargestEnergy;
use crate::study::outcome::Ending;
use crate::study::trajectory::{KeptState, of_run};
use afterbay_core::{
    Grid, IntegrateError, Quad, STEPS_OF_BLOCK, Scalar, State, StateRef, System, f64x8,
};
use afterbay_methods::registry::{Part, Run};
use serde::{Deserialize, Serialize};

/// Sums over the deviations in a window.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Window {
    pub(super) count: u64,
    pub(super) sum: f64,
    pub(super) squares: f64,
}

impl Window {
    pub(super) fn see(&mut self, deviation: f64) {
        self.count += 1;
        self.sum += deviation;
        self.squares += deviation * deviation;
    }

    pub(super) fn and(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
        }
    }
}

/// The window under way, and the largest energy of all samples so far.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Samples {
    window: Window,
    largest: LargestEnergy,
}

impl Samples {
    fn see(&mut self, exact: &dyn System<Quad>, state: &State<Vec<Quad>>, initial: Quad) {
        self.largest.see(exact, state.state_ref());
        self.window.see(self.largest.share((state.total(exact) - initial).to_f64()));
    }
}

/// The number of runs side by side.
pub(super) const WIDTH: usize = f64x8::LANES;
/// The steps of a leg, times degrees of freedom. A choice: a leg takes some seconds at most. Each
/// begins with a fresh workspace, whether runs go side by side or alone.
const LEG: u64 = 1 << 21;

/// The runs of a cell so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Followed {
    /// The steps done.
    pub(super) done: u64,
    /// Whether the runs go on one by one: there is only one, the method has no lanes, or a run has
    /// failed.
    alone: bool,
    pub(super) runs: Vec<FollowedRun>,
}

/// One run so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FollowedRun {
    /// The windows that are completed.
    pub(super) windows: Vec<Window>,
    under_way: Samples,
    pub(super) ending: Ending,
    /// The state; none once the run has failed.
    state: Option<KeptState>,
}

impl FollowedRun {
    fn new(start: &Problem) -> Result<Self, IntegrateError> {
        let (mut under_way, first) = (Samples::default(), start.start::<f64>()?);
        under_way.largest.see(&*start.model.system::<f64>()?, first.state_ref());
        let (windows, state) = (Vec::new(), Some(KeptState::of(first)));
        Ok(Self { windows, under_way, ending: Ending::interrupted(), state })
    }
}

/// The end of a leg of runs side by side.
enum Beside {
    /// All runs have finished it.
    Finished,
    /// The study was stopped.
    Stopped,
    /// The runs have to go on one by one.
    Apart,
}

/// A leg: a part of one window.
#[derive(Clone, Copy)]
struct Span {
    begin: u64,
    end: u64,
    /// Whether the window ends with the leg, and the run with the window.
    completes: [bool; 2],
    /// The first step of the window.
    window: u64,
    /// Every `stride`-th state of the window is sampled.
    stride: u64,
    h: f64,
}

impl Followed {
    /// The runs before their first leg.
    pub(super) fn new(starts: &[Problem]) -> Result<Self, IntegrateError> {
        let runs = starts.iter().map(FollowedRun::new).collect::<Result<_, _>>()?;
        Ok(Self { done: 0, alone: false, runs })
    }

    /// Computes the next leg, side by side where there are at least two runs and none fails.
    pub(super) fn advance(
        &mut self,
        starts: &[Problem],
        setup: &Setup,
        ends: &[u64],
        progress: &dyn Progress,
    ) -> Result<(), IntegrateError> {
        let Some(at) = ends.iter().position(|&end| self.done < end) else { return Ok(()) };
        let (window, end) = (if at == 0 { 0 } else { ends[at - 1] }, ends[at]);
        let dof = starts.first().map_or(1, |start| start.model.dof());
        let steps = (LEG / dof as u64 / STEPS_OF_BLOCK).max(1) * STEPS_OF_BLOCK;
        let to = end.min(self.done.saturating_add(steps));
        let completes = [to == end, to == end && at + 1 == ends.len()];
        let stride = (end - window).div_ceil(SAMPLES);
        let span = Span { begin: self.done, end: to, completes, window, stride, h: setup.h };
        let mut piece = Piece::several(progress, starts.len());
        let last = ends.last().copied().unwrap_or(0);
        let mut report = |step: u64| piece.report(step, last);
        // A leg counts once every run has finished it.
        let mut next = self.clone();
        let beside = match self.alone {
            true => Beside::Apart,
            false => next.together(starts, setup, span, &mut report, progress)?,
        };
        let mut finished = matches!(beside, Beside::Finished);
        if matches!(beside, Beside::Apart) {
            next.alone = true;
            finished = true;
            for (run, start) in next.runs.iter_mut().zip(starts) {
                finished = finished && run.advance(start, setup, span, &mut report, progress)?;
            }
        }
        if finished {
            next.done = to;
            *self = next;
        }
        Ok(())
    }

    /// Computes a leg of all runs in lanes. They go on apart if there is a single run, if the
    /// method has no lanes, or where a step fails, since the lane that failed is not known.
    fn together(
        &mut self,
        starts: &[Problem],
        setup: &Setup,
        span: Span,
        report: &mut dyn FnMut(u64),
        progress: &dyn Progress,
    ) -> Result<Beside, IntegrateError> {
        if starts.len() > 1
            && let Some(method) = lanes(&starts[0], setup)?
        {
            return self.beside(&method, starts, span, report, progress);
        }
        Ok(Beside::Apart)
    }

    fn beside(
        &mut self,
        method: &Run<f64x8>,
        starts: &[Problem],
        span: Span,
        report: &mut dyn FnMut(u64),
        progress: &dyn Progress,
    ) -> Result<Beside, IntegrateError> {
        let states: Option<Vec<_>> = self.runs.iter().map(|run| run.state.as_ref()).collect();
        let Some(states) = states else { return Ok(Beside::Apart) };
        let exact = starts[0].model.system::<Quad>()?;
        // Lanes without a run repeat the last one.
        let lane = |k: usize| states[k.min(states.len() - 1)];
        let pack = |part: fn(&KeptState) -> &[f64]| -> Vec<f64x8> {
            let entries = 0..part(states[0]).len();
            entries.map(|j| f64x8::from_lanes(|k| part(lane(k))[j])).collect()
        };
        let (q, p, w) = (pack(|state| &state.q), pack(|state| &state.p), pack(|state| &state.w));
        let mut remainder = pack(|state| &state.remainder);
        let mut state = State { q, p, w, t: f64x8::splat(span.begin as f64 * span.h) };
        let initial = initial(starts, &*exact)?;
        let mut samples: Vec<Samples> = self.runs.iter().map(|run| run.under_way).collect();
        let mut see = |state: StateRef<'_, f64x8>| {
            for (k, (samples, &initial)) in samples.iter_mut().zip(&initial).enumerate() {
                samples.see(&*exact, &lifted(state, |x: f64x8| x.lane(k)), initial);
            }
        };
        let result = leg(method, span, &mut state, &mut remainder, report, progress, &mut see);
        if progress.stopped() {
            return Ok(Beside::Stopped);
        }
        if result.is_err() {
            return Ok(Beside::Apart);
        }
        for (k, (run, samples)) in self.runs.iter_mut().zip(samples).enumerate() {
            let lane = |part: &[f64x8]| part.iter().map(|x| x.lane(k)).collect();
            let (q, p, w) = (lane(&state.q), lane(&state.p), lane(&state.w));
            let state = KeptState { q, p, w, remainder: lane(&remainder) };
            run.complete(span, samples, Some(state), Ending::of(&result, 1, 1));
        }
        Ok(Beside::Finished)
    }
}

impl FollowedRun {
    /// Computes a leg. Returns whether it was finished.
    fn advance(
        &mut self,
        start: &Problem,
        setup: &Setup,
        span: Span,
        report: &mut dyn FnMut(u64),
        progress: &dyn Progress,
    ) -> Result<bool, IntegrateError> {
        let Some(KeptState { q, p, w, mut remainder }) = self.state.clone() else {
            return Ok(true);
        };
        let (Setup { row, compensated, .. }, model) = (*setup, &start.model);
        let exact = model.system::<Quad>()?;
        let method = if compensated { model.bind_compensated(row)? } else { model.bind(row)? };
        let mut state = State { q, p, w, t: span.begin as f64 * span.h };
        let initial = initial(std::slice::from_ref(start), &*exact)?[0];
        let mut samples = self.under_way;
        let mut see = |state: StateRef<'_, f64>| {
            samples.see(&*exact, &lifted(state, |x| x), initial);
        };
        let result = leg(&method, span, &mut state, &mut remainder, report, progress, &mut see);
        if progress.stopped() {
            return Ok(false);
        }
        let State { q, p, w, .. } = state;
        let state = result.is_ok().then_some(KeptState { q, p, w, remainder });
        self.complete(span, samples, state, Ending::of(&result, 1, 1));
        Ok(true)
    }

    /// Records the result of a leg.
    fn complete(&mut self, span: Span, samples: Samples, state: Option<KeptState>, ending: Ending) {
        let [window_ends, run_ends] = span.completes;
        self.under_way = samples;
        if state.is_some() && window_ends {
            self.windows.push(std::mem::take(&mut self.under_way.window));
        }
        if state.is_none() || run_ends {
            self.ending = ending;
        }
        self.state = state;
    }
}

/// Binds the method in lanes; `None` where it has no such form.
pub(super) fn lanes(
    problem: &Problem,
    setup: &Setup,
) -> Result<Option<Run<f64x8>>, IntegrateError> {
    let Setup { row, compensated, .. } = *setup;
    if compensated {
        return Ok(Some(problem.model.bind_compensated(row)?));
    }
    // All lanes have the same parameters.
    let lanes = problem.model.bind_lanes(row, "", [0.0; WIDTH])?;
    Ok(lanes.map(|lanes| lanes.run))
}

/// K at the starts.
fn initial(starts: &[Problem], exact: &dyn System<Quad>) -> Result<Vec<Quad>, IntegrateError> {
    let of = |start: &Problem| Ok(start.start::<Quad>()?.total(exact));
    starts.iter().map(of).collect()
}

/// Carries a state over a leg, and passes the samples of the window to `see`.
fn leg<T: Scalar>(
    method: &Run<T>,
    Span { begin, end, window, stride, h, .. }: Span,
    state: &mut State<Vec<T>>,
    remainder: &mut [T],
    report: &mut dyn FnMut(u64),
    progress: &dyn Progress,
    see: &mut dyn FnMut(StateRef<'_, T>),
) -> Result<(), IntegrateError> {
    let of_window = begin - window;
    let first = of_window.next_multiple_of(stride) - of_window;
    let part = Part { grid: Grid::<T>::of(h, end - begin)?, first, stride, remainder };
    let result = method.run_part(part, state, &mut |step, state| {
        report(begin + step);
        // The state at the start of a leg was sampled at the end of the one before.
        if step > 0 {
            see(state);
        }
        progress.flow()
    });
    result.map(drop).map_err(|error| of_run(begin, error))
}

/// The state of one of the runs, in 106 bits.
fn lifted<T: Scalar>(state: StateRef<'_, T>, of: impl Fn(T) -> f64) -> State<Vec<Quad>> {
    let lift = |part: &[T]| part.iter().map(|&x| Quad::from_f64(of(x))).collect::<Vec<_>>();
    let t = Quad::from_f64(of(state.t));
    State { q: lift(state.q), p: lift(state.p), w: lift(state.w), t }
}

#[cfg(test)]
mod tests;
