//! The attractor that a settled run reaches: a cycle its states repeat, or a set they fill.

use super::distribution::{Distribution, still_moves};
use super::known::{Known, MORE, NEAR, Nearby};
use crate::study::ranges::Ranges;
use std::collections::VecDeque;
use std::ops::ControlFlow;

/// The largest distance of states that count as repeated.
const REPEATED: f64 = 1e-6;
/// The longest cycle that is looked for, in returns.
const LONGEST_CYCLE: usize = 32;
/// The states in which a cycle is looked for.
pub(super) const SEEN: usize = LONGEST_CYCLE + 2 * (LONGEST_CYCLE + MORE);
/// The distance below which repeated states are one but for roundings.
const LARGEST_ROUNDING: f64 = 1e-10;
/// The largest distance that a run may still have to go to its cycle, as a share of [`NEAR`] or of
/// the extent of the cycle, whichever is less. A choice: other runs then count as near the same
/// cycle.
const TO_GO: f64 = 0.1;
/// The returns that show an attractor without a period.
pub(super) const FILLING: u64 = 4000;

/// The attractor of a settled run, or the data from which it is found.
pub(super) enum Shown {
    /// An attractor.
    Known(Known),
    /// A motion that does not rest, by a state on it and its extents. Its [`Path`] is the
    /// attractor.
    Motion { from: Vec<f64>, extents: Vec<f64> },
}

/// The findings of a run that has ended.
pub(super) struct Ended {
    /// The known attractor that it has reached.
    pub(super) reached: Option<usize>,
    /// The number of its returns.
    pub(super) returns: u64,
    /// Its motion, if it has settled.
    pub(super) shown: Option<Shown>,
}

/// Follows a run until it repeats, or fills the boxes of an attractor without a period.
///
/// Without a drive (`STEPS`) the phase of a motion is arbitrary. States at equal intervals of time
/// then depend on the interval: a cycle whose period is the interval looks like rest, and one of
/// nearly this period looks like slow motion. All steps are therefore examined. A run repeats only
/// where it rests; the attractor of any other motion is its path.
pub(super) struct Found<'a, const STEPS: bool> {
    nearby: Nearby<'a>,
    /// The last states.
    last: VecDeque<Vec<f64>>,
    /// The ranges between each of the last of them and the one before.
    paths: VecDeque<Ranges>,
    /// The returns in a row that repeat the state k returns before, for each k from 1.
    repeats: Vec<usize>,
    period: Option<usize>,
    /// Whether a step since the last return led away from its state.
    moved: bool,
    /// The states after the longest transient; with `STEPS` their number alone counts.
    filling: Vec<Vec<f64>>,
    /// The ranges of the motion there.
    filled: Ranges,
    /// Of the states of each half of that time, or of its steps.
    halves: [Vec<Distribution>; 2],
}

impl<'a, const STEPS: bool> Found<'a, STEPS> {
    pub(super) fn new(nearby: Nearby<'a>) -> Self {
        let (repeats, filling) = (vec![0; LONGEST_CYCLE], Vec::new());
        let filled = Ranges::nothing(nearby.dof);
        let halves = [Vec::new(), Vec::new()];
        let (last, paths, period, moved) = (VecDeque::new(), VecDeque::new(), None, false);
        Self { nearby, last, paths, repeats, period, moved, filling, filled, halves }
    }

    pub(super) fn periods(&self) -> &[Option<f64>] {
        self.nearby.periods()
    }

    pub(super) fn dof(&self) -> usize {
        self.nearby.dof
    }

    /// Adds the state after a step.
    pub(super) fn pass(&mut self, at: &[f64]) {
        let metric = self.nearby.metric;
        self.moved |= self.last.back().is_some_and(|last| metric.distance(last, at) > REPEATED);
        if self.nearby.returns >= self.nearby.longest {
            self.count(at);
        }
    }

    /// Adds a state to the half that it belongs to.
    fn count(&mut self, at: &[f64]) {
        let half = usize::from(self.filling.len() as u64 >= FILLING / 2);
        self.halves[half].resize_with(at.len(), Distribution::default);
        self.halves[half].iter_mut().zip(at).for_each(|(entry, &x)| entry.add(x));
    }

    /// Adds the state of return n.
    pub(super) fn add(&mut self, n: u64, at: Vec<f64>, path: &Ranges) -> ControlFlow<()> {
        // The end of the transient is no reason to stop here.
        let _ = self.nearby.compare(n, &at);
        if self.nearby.reached.is_some() {
            return ControlFlow::Break(());
        }
        if n > self.nearby.longest {
            if !STEPS {
                self.count(&at);
            }
            self.filling.push(at.clone());
            self.filled.join(path);
        }
        let rests = !std::mem::take(&mut self.moved);
        for (repeats, before) in self.repeats.iter_mut().zip(self.last.iter().rev()) {
            let same = rests && self.nearby.metric.distance(before, &at) <= REPEATED;
            *repeats = if same { *repeats + 1 } else { 0 };
        }
        self.last.push_back(at);
        self.paths.push_back(path.clone());
        if self.last.len() > SEEN {
            self.last.pop_front();
        }
        if self.paths.len() > LONGEST_CYCLE {
            self.paths.pop_front();
        }
        let period = (1..=LONGEST_CYCLE).find(|&k| self.repeats[k - 1] > 2 * (k + MORE));
        self.period = period.filter(|&k| self.has_settled(k));
        let done = self.period.is_some() || self.filling.len() as u64 >= FILLING;
        if done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Whether states that repeat after k returns are near the cycle that they tend to. They may
    /// also be those of a slow spiral, whose turns differ by less than what counts as repeated.
    fn has_settled(&self, k: usize) -> bool {
        let (window, end, metric) = (k + MORE, self.last.len() - 1, self.nearby.metric);
        let off = |i: usize| metric.distance(&self.last[end - i], &self.last[end - i - k]);
        let [now, before] =
            [0, window].map(|from| (from..from + window).map(off).fold(0.0, f64::max));
        if now <= LARGEST_ROUNDING {
            return true;
        }
        // These distances fall like a geometric series or faster. The bound is that of its sum.
        let to_go = now / (1.0 - now / before) * window as f64 / k as f64;
        let of_cycle = (1..k).map(|i| metric.distance(&self.last[end], &self.last[end - i]));
        let extent = of_cycle.reduce(f64::max).unwrap_or(f64::INFINITY);
        now < before && to_go <= TO_GO * extent.min(NEAR)
    }

    /// Ends the run and returns its findings.
    pub(super) fn ended(self) -> Ended {
        let Self { nearby, last, paths, period, filling, filled, halves, .. } = self;
        let metric = nearby.metric;
        let ranges = |returns: usize| {
            let mut all = Ranges::nothing(nearby.dof);
            paths.range(paths.len().saturating_sub(returns)..).for_each(|path| all.join(path));
            all
        };
        let shown = match (period, last.back()) {
            (Some(period), _) => {
                let cycle = last.range(last.len() - period..).cloned().collect();
                // With `STEPS` a run repeats only where it rests.
                Known::of_cycle(metric, cycle, &ranges(period), STEPS).map(Shown::Known)
            }
            _ if still_moves(&halves, metric.units(), REPEATED) => None,
            (None, Some(from)) if STEPS && !filling.is_empty() => {
                let [first, second] = &halves;
                let both = first.iter().zip(second);
                let extents = both.map(|(a, b)| a.range().max(b.range())).collect();
                Some(Shown::Motion { from: from.clone(), extents })
            }
            _ => Known::of_points(metric, filling, &filled).map(Shown::Known),
        };
        Ended { reached: nearby.reached, returns: nearby.returns, shown }
    }
}
