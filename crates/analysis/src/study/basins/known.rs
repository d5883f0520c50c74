//! Known attractors, and the test by which a run reaches one of them.

use crate::digits::in_short;
use crate::study::attractor::{Attractor, REST, Traits};
use crate::study::metric::Metric;
use crate::study::ranges::Ranges;
use serde::{Deserialize, Serialize};
use std::collections::{HashSet, VecDeque};
use std::ops::ControlFlow;

/// The largest distance of a state from a cycle that it has reached. Distances here are those of
/// the metric of the survey.
pub(super) const NEAR: f64 = 1e-3;
/// The number of returns beyond one period that must repeat before a cycle is accepted.
pub(super) const MORE: usize = 5;
/// The least sides of the boxes of an attractor without a period, relative to its extents.
pub(super) const BOX: f64 = 0.02;
/// The number of last returns that are compared with the boxes, and the share of them that must lie
/// inside.
const LAST: usize = 100;
const SHARE: f64 = 0.9;
/// The share of other returns that the boxes hold. More than [`SHARE`], since it varies.
const FILLED: f64 = 0.95;

/// An attractor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Known {
    /// Its points and its kind.
    pub attractor: Attractor,
    /// The points (q, p) of a cycle; empty without a period.
    cycle: Vec<Vec<f64>>,
    /// The first of them, to about a thousandth of the units of the survey.
    #[serde(default)]
    place: Vec<f64>,
    /// The boxes of an attractor without a period.
    boxes: HashSet<Vec<i64>>,
    /// The sides of the boxes.
    sides: Vec<f64>,
}

impl Known {
    /// The largest distance of attractors of two methods that count as one, relative to their
    /// extents. A coarse choice: at large steps a method shifts an attractor by its phase, too.
    pub(super) const ALIKE: f64 = 0.5;
    /// The largest difference of their extents. Half of an extent is as far as a cycle reaches from
    /// its centre, so that cycles of one period and any amplitudes are within [`Known::ALIKE`].
    const OF_ONE_SIZE: f64 = 0.25;

    /// An attractor without a period, from boxes with the given sides.
    pub(super) fn of_boxes(
        attractor: Attractor,
        boxes: HashSet<Vec<i64>>,
        sides: Vec<f64>,
    ) -> Self {
        Self { attractor, cycle: Vec::new(), place: Vec::new(), boxes, sides }
    }

    /// A cycle, or a rest, from one turn of it and the ranges of the motion.
    pub(super) fn of_cycle(
        metric: &Metric,
        cycle: Vec<Vec<f64>>,
        ranges: &Ranges,
        rests: bool,
    ) -> Option<Self> {
        // Two turns of a cycle show its period.
        let points = [&cycle[..], &cycle[..]].concat();
        let attractor = Attractor::of(points, metric.of_motion(ranges, NEAR))?;
        let attractor = attractor.with(Traits { rests, conservative: false });
        let place = cycle.first()?.iter().zip(metric.units()).map(|(&x, &unit)| near(x, unit));
        let (place, boxes) = (place.collect(), HashSet::new());
        Some(Self { attractor, cycle, place, boxes, sides: Vec::new() })
    }

    /// An attractor without a period, from points that fill it and the ranges of the motion. The
    /// boxes of the first half hold the second half as well: those of an attractor of many
    /// dimensions are larger.
    pub(super) fn of_points(
        metric: &Metric,
        points: Vec<Vec<f64>>,
        ranges: &Ranges,
    ) -> Option<Self> {
        let metric = metric.of_motion(ranges, NEAR);
        let (first, second) = points.split_at(points.len() / 2);
        let sides = |share: f64| metric.units().iter().map(|unit| share * unit).collect::<Vec<_>>();
        let boxes = |of: &[Vec<f64>], sides: &[f64]| -> HashSet<Vec<i64>> {
            of.iter().map(|point| boxed(point, sides)).collect()
        };
        let holds = |share: &f64| {
            let sides = sides(*share);
            let filled = boxes(first, &sides);
            let inside = second.iter().filter(|point| filled.contains(&boxed(point, &sides)));
            inside.count() as f64 >= FILLED * second.len() as f64
        };
        let sizes = std::iter::successors(Some(BOX), |share| Some(2.0 * share));
        let sides = sides(sizes.take_while(|share| *share < 1.0).find(holds).unwrap_or(1.0));
        let boxes = boxes(&points, &sides);
        let attractor = Attractor::of(points, metric)?;
        Some(Self::of_boxes(attractor, boxes, sides))
    }

    /// The points of a cycle; empty without a period.
    pub(super) fn cycle(&self) -> &[Vec<f64>] {
        &self.cycle
    }

    /// Its points: those of the cycle, if it has one.
    pub(super) fn points(&self) -> &[Vec<f64>] {
        if self.cycle.is_empty() { self.attractor.points() } else { &self.cycle }
    }

    /// The distance from another attractor, relative to the larger extents of the two; infinite if
    /// they are of different kinds or sizes.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let (own, other) = (&self.attractor, &other.attractor);
        if own.kind == other.kind && own.size_difference(other) <= Self::OF_ONE_SIZE {
            own.distance(other)
        } else {
            f64::INFINITY
        }
    }

    /// The attractor in words.
    pub fn describe(&self) -> String {
        let attractor = &self.attractor;
        let kind = if attractor.rests() { REST.into() } else { attractor.kind.describe() };
        if self.place.is_empty() {
            return kind;
        }
        let at: Vec<String> = self.place.iter().map(|x| in_short(*x)).collect();
        format!("{kind}, ({})", at.join(", "))
    }
}

/// Compares a run with the attractors that are known.
#[derive(Clone)]
pub(super) struct Nearby<'a> {
    pub(super) metric: &'a Metric,
    pub(super) dof: usize,
    known: &'a [Known],
    pub(super) longest: u64,
    /// The returns in a row near each cycle.
    near: Vec<usize>,
    /// For each attractor without a period, whether each of the last returns lies in its boxes.
    inside: Vec<VecDeque<bool>>,
    /// The index of the attractor that the run has reached.
    pub(super) reached: Option<usize>,
    pub(super) returns: u64,
}

impl<'a> Nearby<'a> {
    /// Compares up to return number `longest`.
    pub(super) fn new(metric: &'a Metric, dof: usize, known: &'a [Known], longest: u64) -> Self {
        Self {
            metric,
            dof,
            known,
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
            let is_near = |point: &Vec<f64>| self.metric.distance(point, at) <= NEAR;
            if known.cycle.iter().any(is_near) {
                self.near[k] += 1;
            } else {
                self.near[k] = 0;
            }
            let mut settled = !known.cycle.is_empty() && self.near[k] > known.cycle.len() + MORE;
            if known.cycle.is_empty() {
                let inside = &mut self.inside[k];
                inside.push_back(known.boxes.contains(&boxed(at, &known.sides)));
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

    /// The periods of the coordinates that have one.
    pub(super) fn periods(&self) -> &[Option<f64>] {
        self.metric.periods()
    }
}

/// x, to about a thousandth of a unit: to a power of ten.
fn near(x: f64, unit: f64) -> f64 {
    let digit = 10_f64.powf(unit.log10().floor() - 3.0);
    // No -0.
    (x / digit).round() * digit + 0.0
}

/// The box in which a point lies. 0 is the centre of a box, so that an entry that stays at 0 up to
/// roundings stays in its box.
pub(super) fn boxed(point: &[f64], sides: &[f64]) -> Vec<i64> {
    point.iter().zip(sides).map(|(x, side)| (x / side).round() as i64).collect()
}
