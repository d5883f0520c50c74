//! How the roundings of very many steps add up in K.
//!
//! A method that keeps K moves it by one rounding a step. Where these are independent, |K - K0| grows like √t; where they
//! lean to one side, like t. One path of a random walk says little about its exponent, so the same is run from several
//! starts, and rms and mean go over the samples of a window and over the starts.

use super::Problem;
use super::outcome::{COMPLETED, Ending};
use crate::Subject;
use crate::progress::Progress;
use crate::statistics::{Fit, fit};
use afterbay_core::{Grid, IntegrateError, Quad, Scalar, State, View};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// A row of `long_run.csv`: one window of time.
#[derive(Clone, Debug, Serialize)]
pub struct LongRunRow {
    /// Name of the method.
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Are the roundings kept from adding up?
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
    /// Are the roundings kept from adding up ([`Model::bind_compensated`](crate::Model::bind_compensated))?
    pub compensated: bool,
}

/// How it went.
#[derive(Clone, Debug)]
pub struct LongRun {
    /// What was run.
    pub setup: Setup,
    /// The windows that every start reached the end of, four a decade.
    pub rows: Vec<LongRunRow>,
    /// How the runs ended: that of the first that did not reach its end.
    pub ending: Ending,
}

impl Setup {
    /// In words.
    pub fn label(&self) -> String {
        let how = if self.compensated { ", compensated" } else { "" };
        format!("{}{how}, h = {}", self.row.name, self.h)
    }
}

impl LongRun {
    /// The exponent of the growth: slope of log rms against log t over the last two decades.
    pub fn growth(&self) -> Option<Fit> {
        let last = self.rows.last()?.steps;
        let late = self.rows.iter().filter(|row| row.steps > last / 100);
        fit(&late.map(|row| (row.t.log10(), row.rms.log10())).collect::<Vec<_>>())
    }
}

/// Steps of the first window.
const FIRST: u64 = 100;
/// Windows a decade.
const WINDOWS: i32 = 4;
/// Samples a window.
const SAMPLES: u64 = 100;

/// The steps at which windows end.
fn ends(steps: u64) -> Vec<u64> {
    let end = |k: i32| (FIRST as f64 * 10_f64.powf(f64::from(k) / f64::from(WINDOWS))).round() as u64;
    let mut ends: Vec<_> = (0..).map(end).take_while(|&end| end < steps).collect();
    ends.push(steps);
    ends
}

/// What was seen of the deviations in a window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
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

/// Runs each setup from each start for so many steps; the ends of the problems are not looked at. K is
/// computed in 106 bits, and at the samples alone: what is seen is the error of the states, not of the look at them.
///
/// # Errors
/// Those of the input. A run that fails is in its row.
pub fn run(
    starts: &[Problem],
    setups: &[Setup],
    steps: u64,
    progress: &dyn Progress,
) -> Result<Vec<LongRun>, IntegrateError> {
    let tasks: Vec<_> =
        setups.iter().flat_map(|setup| starts.iter().map(move |start| (setup, start))).collect();
    let ends = ends(steps);
    let followed = tasks
        .par_iter()
        .with_max_len(1)
        .map(|&(setup, problem)| {
            let followed = follow(problem, setup, &ends, progress);
            progress.advance();
            followed
        })
        .collect::<Result<Vec<_>, _>>()?;
    let of_run = followed.chunks(starts.len().max(1));
    Ok(setups.iter().zip(of_run).map(|(&setup, of)| gathered(setup, &ends, of)).collect())
}

/// The windows a run came to the end of, and how it ended.
type Followed = (Vec<Window>, Ending);

fn follow(
    problem: &Problem,
    setup: &Setup,
    ends: &[u64],
    progress: &dyn Progress,
) -> Result<Followed, IntegrateError> {
    let Setup { row, h, compensated } = *setup;
    let exact = problem.model.subject::<Quad>()?;
    let method = if compensated { problem.model.bind_compensated(row)? } else { problem.model.bind(row)? };
    let mut state = problem.start::<f64>()?;
    let initial = total(&*exact, state.view());
    let (mut windows, mut done) = (Vec::with_capacity(ends.len()), 0);
    for &end in ends {
        let mut window = Window::default();
        let stride = (end - done).div_ceil(SAMPLES);
        let result = method.run(Grid::of(h, end - done)?, &mut state, stride, &mut |step, state| {
            // What a window begins with is the end of the one before.
            if step > 0 {
                window.see(((total(&*exact, state) - initial) / initial.abs()).to_f64());
            }
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let ending = Ending::of(&result, 1, u64::from(!progress.stopped()));
        if !ending.is_completed() {
            return Ok((windows, ending));
        }
        windows.push(window);
        done = end;
    }
    Ok((windows, Ending { outcome: COMPLETED, failure: None }))
}

/// K of a state, in 106 bits.
fn total(system: &dyn Subject<Quad>, state: View<'_, f64>) -> Quad {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
    State { q: lift(state.q), p: lift(state.p), w: lift(state.w), t: Quad::from_f64(state.t) }.total(system)
}

/// One row a window, over all starts, in their order.
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
    use afterbay_methods::registry::METHODS;

    const STEPS: u64 = 100_000;

    /// The growth seen of deviations that are put in by hand, sampled as those of a run are.
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
        let setup = Setup { row: &METHODS[0], h: 0.1, compensated: false };
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
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
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
