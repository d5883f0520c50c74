//! The path of a motion without a period, as the boxes that it passes.

use super::known::{BOX, FILLING, Known, Nearby, REPEATED, boxed};
use crate::study::attractor::{Attractor, Kind};
use crate::study::section::nearest;
use std::collections::HashSet;
use std::ops::ControlFlow;

/// The least pieces of a path in a box that it passes from side to side.
const PIECES: f64 = 4.0;
/// The most pieces of a step.
const MOST_PIECES: f64 = 256.0;
/// The most boxes that a path fills.
const MOST_BOXES: usize = 20_000;

/// Fills boxes with the path of a motion that has settled.
pub(super) struct Path<'a> {
    nearby: Nearby<'a>,
    side: f64,
    last: Option<Vec<f64>>,
    boxes: HashSet<Vec<i64>>,
    /// The first point in each box.
    points: Vec<Vec<f64>>,
}

impl<'a> Path<'a> {
    pub(super) fn new(nearby: Nearby<'a>, extent: f64) -> Self {
        let side = BOX * extent.max(REPEATED * nearby.scale());
        Self { nearby, side, last: None, boxes: HashSet::new(), points: Vec::new() }
    }

    pub(super) fn periods(&self) -> &[Option<f64>] {
        &self.nearby.periods
    }

    pub(super) fn dof(&self) -> usize {
        self.nearby.dof
    }

    /// Adds the chord to the state after a step.
    pub(super) fn pass(&mut self, at: Vec<f64>) {
        let from = self.last.get_or_insert_with(|| at.clone());
        let far = self.nearby.far(from, &at);
        let pieces = (PIECES * far / self.side).ceil().clamp(1.0, MOST_PIECES);
        for i in 1..=pieces as u32 {
            let share = f64::from(i) / pieces;
            let periods = self.nearby.periods.iter().copied().chain(std::iter::repeat(None));
            let between = |((a, b), period): ((&f64, &f64), Option<f64>)| match period {
                Some(period) => nearest(a + share * nearest(b - a, period), period),
                None => a + share * (b - a),
            };
            let point: Vec<f64> = from.iter().zip(&at).zip(periods).map(between).collect();
            if self.boxes.len() < MOST_BOXES && self.boxes.insert(boxed(&point, self.side)) {
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
        let Self { nearby, side, boxes, points, .. } = self;
        let mut attractor = Attractor::of(points, &nearby.periods, nearby.scale())?;
        // The points are in the order in which they were first met, which is no order in time.
        attractor.kind = Kind::Aperiodic;
        Some(Known::of_boxes(attractor, boxes, side, nearby.scale()))
    }
}
