//! The path of a motion without a period, as the boxes that it passes.

use super::Basins;
use super::found::FILLING;
use super::known::{BOX, Known, boxed};
use crate::study::attractor::{Attractor, Kind};
use crate::study::metric::Metric;
use crate::study::section::nearest;
use std::collections::HashSet;
use std::ops::ControlFlow;

/// The least pieces of a path in a box that it passes from side to side.
const PIECES: f64 = 4.0;
/// The most pieces of a step.
const MOST_PIECES: f64 = 256.0;
/// The most boxes that a path fills.
const MOST_BOXES: usize = 20_000;
/// The least extent of the motion in an entry that has boxes of its own, in units of the distance.
/// Smaller motions may be what is left of a transient.
const LEAST: f64 = 1e-4;

/// Fills boxes with the path of a motion that has settled.
pub(super) struct Path<'a> {
    metric: &'a Metric,
    dof: usize,
    /// The sides of the boxes.
    sides: Vec<f64>,
    last: Option<Vec<f64>>,
    boxes: HashSet<Vec<i64>>,
    /// The first point in each box.
    points: Vec<Vec<f64>>,
}

impl<'a> Path<'a> {
    /// The path of a motion with the given extents.
    pub(super) fn new(basins: &Basins, metric: &'a Metric, extents: Vec<f64>) -> Self {
        let side = |(extent, unit): (f64, &f64)| BOX * extent.max(LEAST * unit);
        let sides = extents.into_iter().zip(metric.units()).map(side).collect();
        let (dof, boxes) = (basins.problem.model.degrees(), HashSet::new());
        Self { metric, dof, sides, last: None, boxes, points: Vec::new() }
    }

    pub(super) fn periods(&self) -> &[Option<f64>] {
        self.metric.periods()
    }

    pub(super) fn dof(&self) -> usize {
        self.dof
    }

    /// Adds the chord to the state after a step.
    pub(super) fn pass(&mut self, at: Vec<f64>) {
        let from = self.last.take().unwrap_or_else(|| at.clone());
        let off: Vec<f64> = self.metric.difference(&from, &at).collect();
        let sides = off.iter().zip(&self.sides).map(|(off, side)| off.abs() / side);
        let pieces = (PIECES * sides.fold(0.0, f64::max)).ceil().clamp(1.0, MOST_PIECES);
        for i in 1..=pieces as u32 {
            let share = f64::from(i) / pieces;
            let periods = self.periods().iter().copied().chain(std::iter::repeat(None));
            let between = |((from, off), period): ((&f64, &f64), Option<f64>)| match period {
                Some(period) => nearest(from + share * off, period),
                None => from + share * off,
            };
            let point: Vec<f64> = from.iter().zip(&off).zip(periods).map(between).collect();
            if self.boxes.len() < MOST_BOXES && self.boxes.insert(boxed(&point, &self.sides)) {
                self.points.push(point);
            }
        }
        self.last = Some(at);
    }

    /// Whether return n is not the last one.
    pub(super) fn goes_on(n: u64) -> ControlFlow<()> {
        if n >= FILLING { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    pub(super) fn known(self) -> Option<Known> {
        let Self { metric, sides, boxes, points, .. } = self;
        let units = sides.iter().map(|side| side / BOX).collect();
        let mut attractor = Attractor::of(points, Metric::with_units(metric.periods(), units))?;
        // The points are in the order in which they were first met, which is no order in time.
        attractor.kind = Kind::Aperiodic;
        Some(Known::of_boxes(attractor, boxes, sides))
    }
}
