//! The accumulation of roundings in K over very many steps.
//!
//! A method that keeps K changes it by one rounding per step. If these are independent, |K - K0|
//! grows like √t; if they are biased, like t. A single random walk determines its exponent poorly.
//! Each method therefore runs from several starts, and rms and mean are taken over the samples of a
//! window and over the starts.

use super::Problem;
use super::cell::{Cell, Study, compute_all};
use super::outcome::{COMPLETED, Ending};
use crate::progress::{Piece, Progress};
use crate::statistics::{Fit, fit};
use afterbay_core::{
    Grid, IntegrateError, Lanewise, Quad, Scalar, State, StateRef, System, f64x4, f64x8,
};
use afterbay_methods::registry::{Row, Run};
use serde::{Deserialize, Serialize};
use std::ops::{ControlFlow, Range};

/// A row of `long_run.csv`: one window of time.
#[derive(Clone, Debug, Serialize)]
pub struct LongRunRow {
    /// Name of the method.
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Whether roundings are compensated.
    pub compensated: bool,
    /// Steps done at the end of the window.
    pub steps: u64,
    /// Time at the end of the window.
    pub t: f64,
    /// Root of the mean of ((K - K0)/K0)².
    pub rms: f64,
    /// Mean of (K - K0)/|K0|.
    pub mean: f64,
}

/// A method at a step size.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The method.
    pub row: &'static Row,
    /// The step.
    pub h: f64,
    /// Whether roundings are compensated
    /// ([`Model::bind_compensated`](crate::Model::bind_compensated)).
    pub compensated: bool,
}

/// The result of one setup.
#[derive(Clone, Debug)]
pub struct LongRun {
    /// The setup.
    pub setup: Setup,
    /// The windows that every start completed, four per decade.
    pub rows: Vec<LongRunRow>,
    /// The ending of the first run that did not complete; `completed` if all did.
    pub ending: Ending,
}

impl Setup {
    /// The label in charts and sentences.
    pub fn label(&self) -> String {
        let how = if self.compensated { ", compensated" } else { "" };
        format!("{}{how}, h = {}", self.row.name, self.h)
    }
}

impl LongRun {
    /// The exponent of growth: the slope of log rms against log t over the last two decades.
    pub fn growth(&self) -> Option<Fit> {
        let last = self.rows.last()?.steps;
        let late = self.rows.iter().filter(|row| row.steps > last / 100);
        fit(&late.map(|row| (row.t.log10(), row.rms.log10())).collect::<Vec<_>>())
    }
}

/// The number of steps of the first window.
const FIRST: u64 = 100;
/// The number of windows per decade.
const WINDOWS: i32 = 4;
/// The number of samples per window.
const SAMPLES: u64 = 100;

/// The numbers of steps at which windows end.
fn ends(steps: u64) -> Vec<u64> {
    let end =
        |k: i32| (FIRST as f64 * 10_f64.powf(f64::from(k) / f64::from(WINDOWS))).round() as u64;
    let mut ends: Vec<_> = (0..).map(end).take_while(|&end| end < steps).collect();
    ends.push(steps);
    ends
}

/// Sums over the deviations in a window.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Window {
    count: u64,
    sum: f64,
    squares: f64,
}

impl Window {
    fn see(&mut self, deviation: f64) {
        self.count += 1;
        self.sum += deviation;
        self.squares += deviation * deviation;
    }

    fn and(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
        }
    }
}

/// Runs each setup from each start for `steps` steps. All starts must belong to one system; the
/// ends of the problems are ignored. K is computed in 106 bits at the samples only, so that the
/// deviation is the error of the states and not of the evaluation. Up to eight starts run side by
/// side where the method allows it, with the results they have alone.
///
/// # Errors
/// Invalid input. The row of a run that fails contains its failure.
pub fn run(
    starts: &[Problem],
    setups: &[Setup],
    steps: u64,
    progress: &dyn Progress,
) -> Result<Vec<LongRun>, IntegrateError> {
    let study = LongRuns::new(starts.to_vec(), setups.to_vec(), steps)?;
    Ok(study.gather(&compute_all(&study, progress)?))
}

/// A study of long runs: runs side by side of each setup.
pub struct LongRuns {
    starts: Vec<Problem>,
    setups: Vec<Setup>,
    ends: Vec<u64>,
    /// The setup and the starts of each cell.
    tasks: Vec<(usize, Range<usize>)>,
}

impl LongRuns {
    /// Each setup from each start for `steps` steps, see [`run`].
    ///
    /// # Errors
    /// A method that does not apply.
    pub fn new(
        starts: Vec<Problem>,
        setups: Vec<Setup>,
        steps: u64,
    ) -> Result<Self, IntegrateError> {
        let mut tasks = Vec::new();
        for (i, setup) in setups.iter().enumerate() {
            let able = starts.len() > 1 && lanes(&starts[0], setup)?.is_some();
            let width = if able { WIDTH } else { 1 };
            let firsts = (0..starts.len()).step_by(width);
            tasks.extend(firsts.map(|first| (i, first..starts.len().min(first + width))));
        }
        Ok(Self { starts, setups, ends: ends(steps), tasks })
    }

    /// The result of each setup, from the results of all cells.
    pub fn gather(&self, parts: &[Vec<Followed>]) -> Vec<LongRun> {
        let of_setup = |(i, &setup): (usize, &Setup)| {
            let of = self.tasks.iter().zip(parts).filter(|(task, _)| task.0 == i);
            let all: Vec<Followed> = of.flat_map(|(_, followed)| followed.clone()).collect();
            gathered(setup, &self.ends, &all)
        };
        self.setups.iter().enumerate().map(of_setup).collect()
    }
}

impl Study for LongRuns {
    type Shared = ();
    type Part = Vec<Followed>;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let steps = self.ends.last().copied().unwrap_or(0) as f64;
        let degrees = self.starts.first().map_or(0, |start| start.model.degrees()) as f64;
        let cell = |(i, starts): &(usize, Range<usize>)| {
            let Setup { row, h, compensated } = self.setups[*i];
            let how = if compensated { "/compensated" } else { "" };
            let key =
                format!("{}/h={h:?}{how}/starts={}-{}", row.name, starts.start + 1, starts.end);
            let price = if compensated { COMPENSATED } else { 1.0 };
            let cost = price * steps * degrees * starts.len() as f64;
            Cell { pieces: starts.len(), ..Cell::new(key, cost) }
        };
        self.tasks.iter().map(cell).collect()
    }

    fn share(&self, _progress: &dyn Progress) -> Result<(), IntegrateError> {
        Ok(())
    }

    fn compute(
        &self,
        (): &(),
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Followed>, IntegrateError> {
        let (setup, starts) = &self.tasks[index];
        follow(&self.starts[starts.clone()], &self.setups[*setup], &self.ends, progress)
    }
}

/// The cost of compensated roundings, relative to a plain run.
const COMPENSATED: f64 = 3.0;

/// The windows completed by a run, and how it ended.
pub type Followed = (Vec<Window>, Ending);

/// The number of runs side by side.
const WIDTH: usize = f64x8::LANES;

/// Runs several starts, side by side where there are at least two and none fails.
fn follow(
    starts: &[Problem],
    setup: &Setup,
    ends: &[u64],
    progress: &dyn Progress,
) -> Result<Vec<Followed>, IntegrateError> {
    let together = match starts.len() {
        1 => None,
        2..=4 if setup.compensated => {
            let method = starts[0].model.bind_compensated::<f64x4>(setup.row)?;
            beside(&method, starts, setup, ends, progress)?
        }
        _ => match lanes(&starts[0], setup)? {
            Some(method) => beside(&method, starts, setup, ends, progress)?,
            None => None,
        },
    };
    let followed = match together {
        Some(followed) => followed,
        None => starts
            .iter()
            .map(|problem| alone(problem, setup, ends, progress))
            .collect::<Result<Vec<_>, _>>()?,
    };
    starts.iter().for_each(|_| progress.advance());
    Ok(followed)
}

fn alone(
    problem: &Problem,
    setup: &Setup,
    ends: &[u64],
    progress: &dyn Progress,
) -> Result<Followed, IntegrateError> {
    let Setup { row, h, compensated } = *setup;
    let model = &problem.model;
    let exact = model.system::<Quad>()?;
    let method = if compensated { model.bind_compensated(row)? } else { model.bind(row)? };
    let state = problem.start::<f64>()?;
    let initial = total(&*exact, state.state_ref(), |x| x);
    let off = |state: StateRef<'_, f64>, _| deviation(total(&*exact, state, |x| x), initial);
    let mut seen = windows(&method, h, state, 1, ends, progress, off)?;
    let ending = seen.ending(progress);
    Ok((seen.windows.swap_remove(0), ending))
}

/// Binds the method in lanes; `None` where it has no such form.
fn lanes(problem: &Problem, setup: &Setup) -> Result<Option<Run<f64x8>>, IntegrateError> {
    let Setup { row, compensated, .. } = *setup;
    if compensated {
        return Ok(Some(problem.model.bind_compensated(row)?));
    }
    // All lanes have the same parameters.
    let lanes = problem.model.bind_lanes(row, "", [0.0; WIDTH])?;
    Ok(lanes.map(|lanes| lanes.run))
}

/// Runs starts in lanes. Returns `None` if a step fails, since the lane that failed is not known.
fn beside<T: Lanewise>(
    method: &Run<T>,
    starts: &[Problem],
    setup: &Setup,
    ends: &[u64],
    progress: &dyn Progress,
) -> Result<Option<Vec<Followed>>, IntegrateError> {
    let exact = starts[0].model.system::<Quad>()?;
    // Lanes without a start repeat the last one.
    let states = starts.iter().map(Problem::start::<f64>).collect::<Result<Vec<_>, _>>()?;
    let pack = |of: fn(&State<Vec<f64>>) -> &Vec<f64>| -> Vec<T> {
        let lane = |k: usize| of(&states[k.min(states.len() - 1)]);
        (0..states[0].dof()).map(|j| T::from_lanes(|k| lane(k)[j])).collect()
    };
    let state = State::new(pack(|state| &state.q), pack(|state| &state.p))?;
    let initial: Vec<Quad> =
        states.iter().map(|state| total(&*exact, state.state_ref(), |x| x)).collect();
    let off = |state: StateRef<'_, T>, k: usize| {
        deviation(total(&*exact, state, |x: T| x.lane(k)), initial[k])
    };
    let seen = windows(method, setup.h, state, states.len(), ends, progress, off)?;
    if seen.result.is_err() {
        return Ok(None);
    }
    let ending = seen.ending(progress);
    Ok(Some(seen.windows.into_iter().map(|windows| (windows, ending.clone())).collect()))
}

/// The completed windows of each run, and how the runs ended.
struct Seen {
    windows: Vec<Vec<Window>>,
    result: Result<(), IntegrateError>,
}

impl Seen {
    fn ending(&self, progress: &dyn Progress) -> Ending {
        Ending::of(&self.result, 1, u64::from(!progress.stopped()))
    }
}

/// Carries `count` runs in one state through the windows. `off` computes the deviation of one of
/// them.
fn windows<T: Scalar>(
    method: &Run<T>,
    h: f64,
    mut state: State<Vec<T>>,
    count: usize,
    ends: &[u64],
    progress: &dyn Progress,
    off: impl Fn(StateRef<'_, T>, usize) -> f64,
) -> Result<Seen, IntegrateError> {
    let (mut all, mut done) = (vec![Vec::with_capacity(ends.len()); count], 0);
    let (mut piece, last) = (Piece::several(progress, count), ends.last().copied().unwrap_or(0));
    for &end in ends {
        let mut seen = vec![Window::default(); count];
        let stride = (end - done).div_ceil(SAMPLES);
        let grid = Grid::<T>::of(h, end - done)?;
        let result = method.run(grid, &mut state, stride, &mut |step, state| {
            piece.reach(done + step, last);
            // The state at the start of a window was sampled at the end of the one before.
            if step > 0 {
                seen.iter_mut().enumerate().for_each(|(k, window)| window.see(off(state, k)));
            }
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if result.is_err() || progress.stopped() {
            return Ok(Seen { windows: all, result: result.map(drop) });
        }
        all.iter_mut().zip(seen).for_each(|(all, seen)| all.push(seen));
        done = end;
    }
    Ok(Seen { windows: all, result: Ok(()) })
}

/// (K - K0)/|K0|
fn deviation(total: Quad, initial: Quad) -> f64 {
    ((total - initial) / initial.abs()).to_f64()
}

/// K of one of the runs in a state, in 106 bits.
fn total<T: Scalar>(
    system: &dyn System<Quad>,
    state: StateRef<'_, T>,
    of: impl Fn(T) -> f64,
) -> Quad {
    let lift = |part: &[T]| part.iter().map(|&x| Quad::from_f64(of(x))).collect::<Vec<_>>();
    let t = Quad::from_f64(of(state.t));
    State { q: lift(state.q), p: lift(state.p), w: lift(state.w), t }.total(system)
}

/// One row per window, over all starts in order.
fn gathered(setup: Setup, ends: &[u64], of: &[Followed]) -> LongRun {
    let Setup { row: &Row { name: method, .. }, h, compensated } = setup;
    let reached = of.iter().map(|(windows, _)| windows.len()).min().unwrap_or(0);
    let row = |(i, &steps): (usize, &u64)| {
        let windows = of.iter().filter_map(|(windows, _)| windows.get(i));
        let all = windows.fold(Window::default(), Window::and);
        let count = all.count as f64;
        let (rms, mean) = ((all.squares / count).sqrt(), all.sum / count);
        LongRunRow { method, h, compensated, steps, t: h * steps as f64, rms, mean }
    };
    let endings = of.iter().map(|(_, ending)| ending);
    let ending = endings.clone().find(|ending| !ending.is_completed()).or(endings.clone().next());
    LongRun {
        setup,
        rows: ends.iter().enumerate().take(reached).map(row).collect(),
        ending: ending.cloned().unwrap_or(Ending { outcome: COMPLETED, failure: None }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::FIXED;

    const STEPS: u64 = 100_000;

    /// The growth of given deviations, sampled like those of a run.
    fn growth(deviations: &[Vec<f64>]) -> Fit {
        let ends = ends(STEPS);
        let seen = |path: &Vec<f64>| {
            let begins = std::iter::once(0).chain(ends.iter().copied());
            let window = |(begin, &end): (u64, &u64)| {
                let mut window = Window::default();
                let stride = (end - begin).div_ceil(SAMPLES);
                (begin..=end)
                    .step_by(stride as usize)
                    .skip(1)
                    .for_each(|step| window.see(path[step as usize]));
                window
            };
            (begins.zip(&ends).map(window).collect(), Ending { outcome: COMPLETED, failure: None })
        };
        let setup = Setup { row: &FIXED[0], h: 0.1, compensated: false };
        gathered(setup, &ends, &deviations.iter().map(seen).collect::<Vec<_>>()).growth().unwrap()
    }

    #[test]
    fn a_drift_grows_like_t() {
        let drift = (0..=STEPS).map(|step| -1e-18 * step as f64).collect();
        let found = growth(&[drift]);
        assert!((found.slope - 1.0).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_random_walk_grows_like_the_root_of_t() {
        let mut seed = 1_u64;
        let mut coin = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            if seed >> 63 == 0 { 1e-16 } else { -1e-16 }
        };
        let mut walk = || {
            let steps = (0..STEPS).scan(0.0, |at, _| {
                *at += coin();
                Some(*at)
            });
            std::iter::once(0.0).chain(steps).collect::<Vec<_>>()
        };
        let walks: Vec<_> = (0..200).map(|_| walk()).collect();
        let found = growth(&walks);
        assert!((found.slope - 0.5).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn windows_are_four_a_decade() {
        assert_eq!(ends(1000), [100, 178, 316, 562, 1000]);
        assert_eq!(ends(50), [50]);
    }
}
