//! The distance of the states of a motion, in which coordinates of all sizes count alike.

use super::ranges::Ranges;
use super::section::nearest;
use serde::{Deserialize, Serialize};

/// The least unit of an entry, as a share of its extent in the whole run. What is left of a
/// transient is smaller.
const OF_RUN: f64 = 1e-3;
/// The least unit, as a share of the largest extent of a coordinate, or of a momentum. An entry
/// that stays where it is, as by a symmetry, moves by roundings of the others.
const OF_OTHERS: f64 = 1e-8;
/// The least unit, as a share of the largest magnitude of the entry, of which roundings are 1e-16.
const OF_MAGNITUDE: f64 = 1e-9;
/// The largest difference, in units, of states that count as one.
pub(super) const SAME: f64 = 1e-4;

/// The distance of states (q, p): the largest difference of an entry, in units of its own. The unit
/// is the extent of the entry along the motion that has settled, and has a bound from below.
/// Differences of an angle are less its whole turns.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Metric {
    /// The periods of the coordinates that have one.
    periods: Vec<Option<f64>>,
    units: Vec<f64>,
    /// Whether no coordinate moves.
    at_rest: bool,
}

impl Metric {
    /// That of a run, by the ranges of its motion that has settled, and by those of all of it.
    pub(super) fn of(periods: &[Option<f64>], settled: &Ranges, run: &Ranges) -> Self {
        let (mut units, dof) = (units(periods, settled, run), settled.len() / 2);
        // Where no coordinate moves the momenta are those of a rest, and their roundings have
        // nothing that they could be compared with.
        let at_rest = (0..dof).all(|j| extent(periods, settled, j) <= SAME * units[j]);
        if at_rest {
            units[dof..].fill(f64::MAX);
        }
        Self { periods: periods.to_vec(), units, at_rest }
    }

    /// That of given units.
    pub(super) fn with_units(periods: &[Option<f64>], units: Vec<f64>) -> Self {
        Self { periods: periods.to_vec(), units, at_rest: false }
    }

    /// The distance whose units are the extents of a motion, at least a share of these units.
    pub(super) fn within(&self, motion: &Ranges, share: f64) -> Self {
        let unit = |(j, unit): (usize, &f64)| extent(&self.periods, motion, j).max(share * unit);
        Self { units: self.units.iter().enumerate().map(unit).collect(), ..self.clone() }
    }

    /// The distance of two states.
    pub(super) fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.difference(a, b).zip(&self.units).map(in_units).fold(0.0, f64::max)
    }

    /// b - a, each angle less its whole turns.
    pub(super) fn difference<'a>(
        &'a self,
        a: &'a [f64],
        b: &'a [f64],
    ) -> impl Iterator<Item = f64> + 'a {
        let periods = self.periods.iter().copied().chain(std::iter::repeat(None));
        let off = |((a, b), period): ((&f64, &f64), Option<f64>)| match period {
            Some(period) => nearest(b - a, period),
            None => b - a,
        };
        a.iter().zip(b).zip(periods).map(off)
    }

    /// The periods of the coordinates that have one.
    pub(super) fn periods(&self) -> &[Option<f64>] {
        &self.periods
    }

    /// Whether no coordinate of the motion that has settled moves.
    pub(super) fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    /// The unit of each entry.
    pub(super) fn units(&self) -> &[f64] {
        &self.units
    }

    /// The largest of differences of the entries, in their units.
    pub(super) fn largest(&self, off: &[f64]) -> f64 {
        off.iter().copied().zip(&self.units).map(in_units).fold(0.0, f64::max)
    }
}

/// The unit of each entry of (q, p): its extent in the motion that has settled, with a bound from
/// below. 0 for one that does not move at all.
pub(super) fn units(periods: &[Option<f64>], settled: &Ranges, run: &Ranges) -> Vec<f64> {
    let (size, dof) = (settled.len(), settled.len() / 2);
    let of_others = |j: usize| {
        let kind = if j < dof { 0..dof } else { dof..size };
        kind.map(|i| extent(periods, settled, i)).fold(0.0, f64::max)
    };
    let unit = |j: usize| {
        extent(periods, settled, j)
            .max(OF_RUN * extent(periods, run, j))
            .max(OF_OTHERS * of_others(j))
            .max(OF_MAGNITUDE * settled.magnitude(j))
    };
    (0..size).map(unit).collect()
}

/// The extent of entry j, of an angle at most a turn.
fn extent(periods: &[Option<f64>], ranges: &Ranges, j: usize) -> f64 {
    let turn = periods.get(j).copied().flatten().unwrap_or(f64::INFINITY);
    ranges.extent(j).min(turn)
}

/// A difference in units. An entry that never moves has the unit 0.
fn in_units((off, &unit): (f64, &f64)) -> f64 {
    if off == 0.0 { 0.0 } else { off.abs() / unit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::StateRef;
    use std::f64::consts::TAU;

    fn ranges(states: &[[[f64; 2]; 2]]) -> Ranges {
        let mut ranges = Ranges::nothing(2);
        let see = |[q, p]: &[[f64; 2]; 2]| ranges.see(StateRef { q, p, w: &[0.0; 2], t: 0.0 });
        states.iter().for_each(see);
        ranges
    }

    #[test]
    fn an_entry_is_measured_by_its_own_motion() {
        let motion = ranges(&[[[1e5, 2e-6], [3.0, 0.0]], [[1e5 + 1.0, 0.0], [1e3, 0.0]]]);
        let metric = Metric::of(&[None; 2], &motion, &motion);
        // The momentum that does not move has the bound by the other.
        assert_eq!(metric.units(), [1.0, 2e-6, 997.0, 997e-8]);
        let far = metric.distance(&[1e5, 0.0, 3.0, 0.0], &[1e5 + 0.25, 1e-6, 3.0, 0.0]);
        assert!((far - 0.5).abs() < 1e-9 && !metric.is_at_rest());
    }

    #[test]
    fn an_angle_moves_by_a_turn_at_most() {
        let turned = ranges(&[[[0.0; 2]; 2], [[9e4, 9e4], [1.0; 2]]]);
        let metric = Metric::of(&[Some(TAU), None], &turned, &turned);
        assert_eq!(metric.units(), [TAU, 9e4, 1.0, 1.0]);
        let (a, b) = ([3.0, 0.0, 0.0, 0.0], [-3.0, 0.0, 0.0, 0.0]);
        assert!((metric.distance(&a, &b) - (TAU - 6.0) / TAU).abs() < 1e-15);
    }

    #[test]
    fn what_is_left_of_a_transient_is_a_rest() {
        let all = ranges(&[[[5.0, -3.0], [2.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]]);
        let at = |off: f64| ranges(&[[[1.0, 0.0], [off, -off]], [[1.0 + off, off], [0.0; 2]]]);
        let metric = Metric::of(&[None; 2], &at(1e-8), &all);
        assert!(metric.is_at_rest());
        assert!(metric.distance(&[1.0, 0.0, 9e-9, 0.0], &[1.0, 1e-8, -3e-9, 1e-8]) < SAME);
        assert!(!Metric::of(&[None; 2], &at(1e-5), &all).is_at_rest());
        // A start at rest.
        let rest = ranges(&[[[2.0, 0.0], [0.0; 2]]]);
        let metric = Metric::of(&[None; 2], &rest, &rest);
        assert!(metric.is_at_rest());
        assert!(metric.distance(&[2.0, 0.0, 0.0, 0.0], &[2.0, 0.0, 1e-17, 0.0]) < SAME);
    }
}
