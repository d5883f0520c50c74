//! Attractors as they are found and recognized.

use super::Basins;
use crate::study::attractor::Attractor;
use crate::study::section::far;
use serde::{Deserialize, Serialize};
use std::collections::{HashSet, VecDeque};
use std::ops::ControlFlow;

/// The largest distance of a state from a cycle that it has reached, relative to the grid.
const NEAR: f64 = 1e-3;
/// The largest distance of states that count as repeated, relative to the grid.
const REPEATED: f64 = 1e-6;
/// The longest cycle that is looked for, in returns.
const LONGEST_CYCLE: usize = 32;
/// Returns beyond one period that must repeat before a cycle is believed.
const MORE: usize = 5;
/// The states in which a cycle is looked for.
const SEEN: usize = LONGEST_CYCLE + 2 * (LONGEST_CYCLE + MORE);
/// The distance below which repeated states are one but for roundings, relative to the grid.
const ROUNDINGS: f64 = 1e-10;
/// The largest distance that a run may still have to go to its cycle, as a share of [`NEAR`] and of
/// the extent of the cycle. A choice: other runs are then told to be near the same cycle.
const TO_GO: f64 = 0.1;
/// The least change of the extent from one half of the points to the other that shows that a run
/// has not settled. A choice: chaos shows less, since its halves are of 2000 points.
const CHANGE: f64 = 0.05;
/// The least move of the mean between these halves that shows it, as a share of their range.
const MOVE: f64 = 0.5;
/// The side of the boxes of an attractor without a period, relative to the grid.
const BOX: f64 = 0.02;
/// Returns that fill these boxes.
const FILLING: u64 = 4000;
/// The returns of which a share must lie in the boxes.
const LAST: usize = 100;
const SHARE: f64 = 0.9;

/// An attractor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Known {
    /// Its points and its kind.
    pub attractor: Attractor,
    /// The points (q, p) of a cycle; empty without a period.
    cycle: Vec<Vec<f64>>,
    /// The boxes of an attractor without a period.
    boxes: HashSet<Vec<i64>>,
    /// The extent of the grid.
    scale: f64,
}

impl Known {
    /// The largest distance of attractors of two methods that count as one, relative to their size.
    /// A coarse choice: at large steps a method shifts an attractor by its phase, too.
    pub(super) const ALIKE: f64 = 0.5;

    /// The distance from another attractor, relative to the size of this one, or to the distance
    /// at which runs reach it if that is larger; infinite if they are of different kinds.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let size = self.attractor.size.max(NEAR * self.scale);
        if self.attractor.kind == other.attractor.kind {
            self.attractor.apart(&other.attractor) / size
        } else {
            f64::INFINITY
        }
    }

    /// The attractor in words.
    pub fn describe(&self) -> String {
        let kind = self.attractor.kind.describe();
        match self.cycle.first() {
            Some(point) => {
                let at: Vec<String> = point.iter().map(|x| format!("{x:.3}")).collect();
                format!("{kind}, ({})", at.join(", "))
            }
            None => kind,
        }
    }
}

/// Compares a run with the attractors that are known.
pub(super) struct Nearby<'a> {
    pub(super) periods: Vec<Option<f64>>,
    pub(super) dof: usize,
    known: &'a [Known],
    scale: f64,
    longest: u64,
    /// The returns in a row near each cycle.
    near: Vec<usize>,
    /// For each attractor without a period, whether each of the last returns lies in its boxes.
    inside: Vec<VecDeque<bool>>,
    /// The index of the attractor that the run has reached.
    pub(super) reached: Option<usize>,
    pub(super) returns: u64,
}

impl<'a> Nearby<'a> {
    pub(super) fn new(basins: &Basins, known: &'a [Known], longest: u64) -> Self {
        let model = &basins.problem.model;
        let extent = |values: &[f64]| {
            values.last().copied().unwrap_or(0.0) - values.first().copied().unwrap_or(0.0)
        };
        let scale = basins.axes.iter().map(|axis| extent(&axis.values)).fold(0.0, f64::max);
        Self {
            periods: model.periods(),
            dof: model.degrees(),
            known,
            scale: if scale > 0.0 { scale } else { 1.0 },
            longest,
            near: vec![0; known.len()],
            inside: vec![VecDeque::new(); known.len()],
            reached: None,
            returns: 0,
        }
    }

    /// Compares the state of return n.
    pub(super) fn compare(&mut self, n: u64, at: &[f64]) -> ControlFlow<()> {
        self.returns = n;
        for (k, known) in self.known.iter().enumerate() {
            let is_near = |point: &Vec<f64>| self.far(point, at) <= NEAR * self.scale;
            if known.cycle.iter().any(is_near) {
                self.near[k] += 1;
            } else {
                self.near[k] = 0;
            }
            let mut settled = !known.cycle.is_empty() && self.near[k] > known.cycle.len() + MORE;
            if known.cycle.is_empty() {
                let inside = &mut self.inside[k];
                inside.push_back(known.boxes.contains(&boxed(at, self.scale)));
                if inside.len() > LAST {
                    inside.pop_front();
                    let count = inside.iter().filter(|inside| **inside).count();
                    settled = count as f64 >= SHARE * LAST as f64;
                }
            }
            if settled {
                self.reached = Some(k);
                return ControlFlow::Break(());
            }
        }
        if n >= self.longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The largest difference of two points.
    fn far(&self, a: &[f64], b: &[f64]) -> f64 {
        far(&self.periods, a, b)
    }
}

/// The known attractor that the points of a new one show, if they show one.
pub(super) fn same(basins: &Basins, known: &[Known], new: &Known) -> Option<usize> {
    let points = match &new.cycle[..] {
        [] => new.attractor.points(),
        cycle => cycle,
    };
    // As often as the longest cycle must be seen.
    let mut nearby = Nearby::new(basins, known, u64::MAX);
    let again = points.iter().cycle().take(points.len().max(2 * SEEN));
    let _ = (1..).zip(again).try_for_each(|(n, point)| nearby.compare(n, point));
    nearby.reached
}

/// The box that a point lies in.
fn boxed(point: &[f64], scale: f64) -> Vec<i64> {
    point.iter().map(|x| (x / (BOX * scale)).floor() as i64).collect()
}

/// Follows a run until it repeats, or fills the boxes of an attractor without a period.
pub(super) struct Found<'a> {
    nearby: Nearby<'a>,
    /// The last states.
    last: VecDeque<Vec<f64>>,
    /// The returns in a row that repeat the state k returns before, for each k from 1.
    repeats: Vec<usize>,
    period: Option<usize>,
    /// The states after the longest transient.
    filling: Vec<Vec<f64>>,
}

impl<'a> Found<'a> {
    pub(super) fn new(nearby: Nearby<'a>) -> Self {
        let repeats = vec![0; LONGEST_CYCLE];
        Self { nearby, last: VecDeque::new(), repeats, period: None, filling: Vec::new() }
    }

    pub(super) fn periods(&self) -> &[Option<f64>] {
        &self.nearby.periods
    }

    pub(super) fn dof(&self) -> usize {
        self.nearby.dof
    }

    /// Adds the state of return n.
    pub(super) fn add(&mut self, n: u64, at: Vec<f64>) -> ControlFlow<()> {
        // The end of the transient is no reason to stop here.
        let _ = self.nearby.compare(n, &at);
        if self.nearby.reached.is_some() {
            return ControlFlow::Break(());
        }
        if n > self.nearby.longest {
            self.filling.push(at.clone());
        }
        for (repeats, before) in self.repeats.iter_mut().zip(self.last.iter().rev()) {
            let same = self.nearby.far(before, &at) <= REPEATED * self.nearby.scale;
            *repeats = if same { *repeats + 1 } else { 0 };
        }
        self.last.push_back(at);
        if self.last.len() > SEEN {
            self.last.pop_front();
        }
        let period = (1..=LONGEST_CYCLE).find(|&k| self.repeats[k - 1] > 2 * (k + MORE));
        self.period = period.filter(|&k| self.has_settled(k));
        let done = self.period.is_some() || self.filling.len() as u64 >= FILLING;
        if done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Whether states that repeat after k returns are near the cycle that they tend to. They may
    /// also be those of a slow spiral, whose turns differ by less than what counts as repeated.
    fn has_settled(&self, k: usize) -> bool {
        let (window, end, scale) = (k + MORE, self.last.len() - 1, self.nearby.scale);
        let off = |i: usize| self.nearby.far(&self.last[end - i], &self.last[end - i - k]);
        let [now, before] =
            [0, window].map(|from| (from..from + window).map(off).fold(0.0, f64::max));
        if now <= ROUNDINGS * scale {
            return true;
        }
        // These distances fall like a geometric series or faster. The bound is that of its sum.
        let to_go = now / (1.0 - now / before) * window as f64 / k as f64;
        let of_cycle = (1..k).map(|i| self.nearby.far(&self.last[end], &self.last[end - i]));
        let extent = of_cycle.reduce(f64::max).unwrap_or(f64::INFINITY);
        now < before && to_go <= TO_GO * extent.min(NEAR * scale)
    }

    /// The known attractor that the run has reached, its returns, and a new attractor, if the run
    /// has settled.
    pub(super) fn ended(self) -> (Option<usize>, u64, Option<Known>) {
        let Self { nearby, last, period, filling, .. } = self;
        let scale = nearby.scale;
        let cycle: Vec<Vec<f64>> = match period {
            Some(period) => last.range(last.len() - period..).cloned().collect(),
            None => Vec::new(),
        };
        if cycle.is_empty() && still_moves(&filling, REPEATED * scale) {
            return (nearby.reached, nearby.returns, None);
        }
        // Two turns of a cycle show its period.
        let points = if cycle.is_empty() { filling } else { [&cycle[..], &cycle[..]].concat() };
        let boxes = if cycle.is_empty() {
            points.iter().map(|point| boxed(point, scale)).collect()
        } else {
            HashSet::new()
        };
        let attractor = Attractor::of(points, &nearby.periods, scale);
        let known = attractor.map(|attractor| Known { attractor, cycle, boxes, scale });
        (nearby.reached, nearby.returns, known)
    }
}

/// Whether a run changes from the first half of its points to the second: an entry shrinks or
/// grows, in range and in standard deviation, or its mean moves.
fn still_moves(points: &[Vec<f64>], least: f64) -> bool {
    let halves = points.split_at(points.len() / 2);
    let mut entries = 0..points.first().map_or(0, Vec::len);
    entries.any(|j| {
        let [first, second] = [halves.0, halves.1].map(|half| Distribution::of(half, j));
        let range = first.range.max(second.range);
        let (by_range, by_deviation) =
            ((second.range / first.range).ln(), (second.deviation / first.deviation).ln());
        let both = by_range.min(by_deviation) > CHANGE || by_range.max(by_deviation) < -CHANGE;
        range > least && (both || (second.mean - first.mean).abs() > MOVE * range)
    })
}

/// The range, the mean and the standard deviation of one coordinate or momentum over points.
struct Distribution {
    range: f64,
    mean: f64,
    deviation: f64,
}

impl Distribution {
    fn of(points: &[Vec<f64>], j: usize) -> Self {
        let (values, count) = (|| points.iter().map(|point| point[j]), points.len() as f64);
        let mean = values().sum::<f64>() / count;
        let square = values().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
        let least = values().fold(f64::INFINITY, f64::min);
        let most = values().fold(f64::NEG_INFINITY, f64::max);
        Self { range: most - least, mean, deviation: square.sqrt() }
    }
}
