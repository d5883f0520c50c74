//! The accumulation of roundings in K over very many steps.
//!
//! A method that keeps K changes it by one rounding per step. If these are independent, |K - K0|
//! grows like √t; if they are biased, like t. A single random walk determines its exponent poorly.
//! Each method therefore runs from several starts, and rms and mean are taken over the samples of a
//! window and over the starts.

mod followed;

pub use followed::{Followed, Window};

use super::Problem;
use super::cell::{Cell, Leg, Study, all_legs, compute_all};
use super::outcome::{COMPLETED, Ending};
use crate::progress::Progress;
use crate::rows::Shelf;
use crate::statistics::{Fit, fit};
use afterbay_core::IntegrateError;
use afterbay_methods::registry::Row;
use followed::{WIDTH, lanes};
use serde::Serialize;
use std::ops::Range;

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
    /// Root of the mean of ((K - K0)/E)², where E is the largest energy of the samples so far: the
    /// largest |H| + Σ |w_j| and T = ½ Σ |p_j ∂H/∂p_j|.
    pub rms: f64,
    /// Mean of (K - K0)/E.
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

    /// Whether the deviation has stopped growing: the rms of the last three windows differ by less
    /// than a tenth. A power of t as [`growth`](Self::growth) does not describe it then.
    pub fn is_level(&self) -> bool {
        let late: Vec<_> = self.rows.iter().rev().take(3).map(|row| row.rms).collect();
        let least = late.iter().copied().fold(f64::INFINITY, f64::min);
        let most = late.iter().copied().fold(0.0, f64::max);
        late.len() == 3 && most - least < LEVEL_SPREAD * most
    }
}

/// The largest difference of the rms of windows in which the deviation is level, relative to the
/// largest. From the end of the first to that of the third √t grows by 1.33 to 1.8. A choice.
const LEVEL_SPREAD: f64 = 0.1;

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
    pub fn gather(&self, parts: &[Followed]) -> Vec<LongRun> {
        let of_setup = |(i, &setup): (usize, &Setup)| {
            let of = self.tasks.iter().zip(parts).filter(|(task, _)| task.0 == i);
            let all: Vec<_> = of
                .flat_map(|(_, followed)| &followed.runs)
                .map(|run| (run.windows.clone(), run.ending.clone()))
                .collect();
            gathered(setup, &self.ends, &all)
        };
        self.setups.iter().enumerate().map(of_setup).collect()
    }

    /// The steps of a run.
    fn last(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
    }
}

impl Study for LongRuns {
    type Shared = ();
    type Part = Followed;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let steps = self.last() as f64;
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
    ) -> Result<Followed, IntegrateError> {
        all_legs(self, &(), index, progress)
    }

    fn fraction_done(&self, followed: &Followed) -> f64 {
        followed.done as f64 / self.last().max(1) as f64
    }

    fn advance(
        &self,
        (): &(),
        index: usize,
        so_far: Option<Followed>,
        progress: &dyn Progress,
        _shelf: Option<&Shelf>,
    ) -> Result<Leg<Followed>, IntegrateError> {
        let (setup, starts) = &self.tasks[index];
        let (setup, starts) = (&self.setups[*setup], &self.starts[starts.clone()]);
        let mut followed = so_far.map_or_else(|| Followed::new(starts), Ok)?;
        followed.advance(starts, setup, &self.ends, progress)?;
        if followed.done < self.last() {
            return Ok(Leg::Further(followed));
        }
        starts.iter().for_each(|_| progress.advance());
        Ok(Leg::Last(followed))
    }
}

/// The cost of compensated roundings, relative to a plain run; above 1. An estimate, for the plan.
const COMPENSATED: f64 = 3.0;

/// One row per window, over all starts in order.
fn gathered(setup: Setup, ends: &[u64], of: &[(Vec<Window>, Ending)]) -> LongRun {
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

    /// A long run of given deviations, sampled like those of a run.
    fn long_run(deviations: &[Vec<f64>]) -> LongRun {
        let ends = ends(deviations[0].len() as u64 - 1);
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
        gathered(setup, &ends, &deviations.iter().map(seen).collect::<Vec<_>>())
    }

    #[test]
    fn a_drift_grows_like_t() {
        let drift = (0..=STEPS).map(|step| -1e-18 * step as f64).collect();
        let found = long_run(&[drift]);
        let fit = found.growth().unwrap();
        assert!((fit.slope - 1.0).abs() < 0.01 && !found.is_level(), "{fit:?}");
    }

    /// As in a motion that comes to rest.
    #[test]
    fn a_deviation_that_stops_growing_is_level() {
        for steps in [1000, 10_000, 20_000, STEPS] {
            let share = |step: u64| 1e-9 * (1.0 - (-10.0 * step as f64 / steps as f64).exp());
            assert!(long_run(&[(0..=steps).map(share).collect()]).is_level(), "{steps}");
        }
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
        let found = long_run(&walks);
        let fit = found.growth().unwrap();
        assert!((fit.slope - 0.5).abs() < 0.05 && !found.is_level(), "{fit:?}");
    }

    #[test]
    fn windows_are_four_a_decade() {
        assert_eq!(ends(1000), [100, 178, 316, 562, 1000]);
        assert_eq!(ends(50), [50]);
    }
}
