//! Attractors as they are found and recognized.

use super::Basins;
use crate::study::attractor::{Attractor, Kind};
use crate::study::section::nearest;
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
}

impl Known {
    /// The largest distance of attractors of two methods that count as one, relative to their size.
    /// A coarse choice: at large steps a method shifts an attractor by its phase, too.
    pub(super) const ALIKE: f64 = 0.5;

    /// The distance from another attractor, relative to the size of this one; infinite if they are
    /// of different kinds.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        match (self.attractor.kind, other.attractor.kind) {
            (Kind::Period(a), Kind::Period(b)) if a == b => {
                self.attractor.distance(&other.attractor)
            }
            (Kind::Aperiodic, Kind::Aperiodic) => self.attractor.distance(&other.attractor),
            _ => f64::INFINITY,
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

    /// The largest difference of two points, round coordinates with a period.
    fn far(&self, a: &[f64], b: &[f64]) -> f64 {
        let periods = self.periods.iter().take(self.dof).copied().chain(std::iter::repeat(None));
        let off = |((a, b), period): ((&f64, &f64), Option<f64>)| {
            period.map_or(a - b, |period| nearest(a - b, period)).abs()
        };
        a.iter().zip(b).zip(periods).map(off).fold(0.0, f64::max)
    }
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
        if n <= self.nearby.longest {
            // The end of the transient is no reason to stop here.
            let _ = self.nearby.compare(n, &at);
            if self.nearby.reached.is_some() {
                return ControlFlow::Break(());
            }
        } else {
            self.filling.push(at.clone());
        }
        for (k, before) in self.last.iter().rev().enumerate() {
            let same = self.nearby.far(before, &at) <= REPEATED * self.nearby.scale;
            self.repeats[k] = if same { self.repeats[k] + 1 } else { 0 };
        }
        self.last.push_back(at);
        if self.last.len() > LONGEST_CYCLE {
            self.last.pop_front();
        }
        self.period = (1..=LONGEST_CYCLE).find(|&k| self.repeats[k - 1] > 2 * k + MORE);
        let done = self.period.is_some() || self.filling.len() as u64 >= FILLING;
        if done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The known attractor that the run has reached, its returns, and a new attractor.
    pub(super) fn ended(self) -> (Option<usize>, u64, Option<Known>) {
        let Self { nearby, last, period, filling, .. } = self;
        let dof = nearby.dof;
        let split = |point: &Vec<f64>| [point[..dof].to_vec(), point[dof..].to_vec()];
        let cycle: Vec<Vec<f64>> = match period {
            Some(period) => last.range(last.len() - period..).cloned().collect(),
            None => Vec::new(),
        };
        // Two turns of a cycle show its period.
        let points = if cycle.is_empty() { filling } else { [&cycle[..], &cycle[..]].concat() };
        let attractor = Attractor::of(&points.iter().map(split).collect::<Vec<_>>());
        let boxes = if cycle.is_empty() {
            points.iter().map(|point| boxed(point, nearby.scale)).collect()
        } else {
            HashSet::new()
        };
        let known = attractor.map(|attractor| Known { attractor, cycle, boxes });
        (nearby.reached, nearby.returns, known)
    }
}
