//! The distance of the states of a motion, in which coordinates of all sizes count alike.

use super::ranges::Ranges;
use super::section::nearest;
use serde::{Deserialize, Serialize};

/// The least unit of an entry, as a share of its extent in the whole run. What is left of a
/// transient is smaller.
const OF_RUN: f64 = 1e-3;
/// The largest difference that counts as zero, as a share of the largest extent of a coordinate, or
/// of a momentum. An entry that a symmetry keeps constant moves by roundings of the others.
const OF_OTHERS: f64 = 1e-10;
/// The largest difference that counts as zero, as a share of the largest magnitude of the entry:
/// some thousand roundings.
pub(super) const OF_MAGNITUDE: f64 = 1e-12;
/// The largest extent of a coordinate that does not move, in units.
const AT_REST: f64 = 1e-5;
/// The largest difference, in units, of states that count as one.
pub(super) const SAME: f64 = 1e-4;
/// A settled motion whose extent is at most this share of that of the whole motion counts as rest.
pub(super) const FADED: f64 = OF_RUN * SAME;

/// The distance of states (q, p): the largest difference of an entry, in units of its own. The unit
/// is the extent of the entry along the motion that has settled, and has a bound from below.
/// Differences of an angle are less its whole turns. Differences that are roundings beside the
/// motion count as 0, and so do those of a momentum whose coordinate does not move.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Metric {
    /// The periods of the coordinates that have one.
    periods: Vec<Option<f64>>,
    units: Vec<f64>,
    /// The largest difference of each entry that counts as zero.
    least: Vec<f64>,
    /// Whether no coordinate moves.
    at_rest: bool,
}

impl Metric {
    /// The distance for a run, from the ranges of its settled motion and of its whole motion.
    pub(super) fn of(periods: &[Option<f64>], settled: &Ranges, run: &Ranges) -> Self {
        let (size, dof) = (settled.len(), settled.len() / 2);
        let units: Vec<f64> = (0..size).map(|j| unit(periods, settled, run, j)).collect();
        let extents: Vec<f64> = (0..size).map(|j| extent(periods, settled, j)).collect();
        let rounding = |j: usize| rounding(&extents, j, settled.magnitude(j));
        let mut least: Vec<f64> = (0..size).map(rounding).collect();
        let moves = |j: usize| extents[j] > least[j].max(AT_REST * units[j]);
        let moving: Vec<bool> = (0..dof).map(moves).collect();
        // The roundings of a momentum whose coordinate rests have nothing to be compared with.
        let momenta = least[dof..].iter_mut().zip(&moving);
        momenta.filter(|(_, moves)| !**moves).for_each(|(least, _)| *least = f64::MAX);
        let at_rest = !moving.contains(&true);
        Self { periods: periods.to_vec(), units, least, at_rest }
    }

    /// The distance in given units.
    pub(super) fn with_units(periods: &[Option<f64>], units: Vec<f64>) -> Self {
        let least = vec![0.0; units.len()];
        Self { periods: periods.to_vec(), units, least, at_rest: false }
    }

    /// The distance whose units are the extents of a motion, at least a share of these units.
    pub(super) fn of_motion(&self, motion: &Ranges, share: f64) -> Self {
        let unit = |(j, unit): (usize, &f64)| extent(&self.periods, motion, j).max(share * unit);
        Self { units: self.units.iter().enumerate().map(unit).collect(), ..self.clone() }
    }

    /// The distance in the larger units of two.
    pub(super) fn with(&self, other: &Self) -> Self {
        let larger = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a.max(*b)).collect();
        Self {
            units: larger(&self.units, &other.units),
            least: larger(&self.least, &other.least),
            ..self.clone()
        }
    }

    /// The distance of two states.
    pub(super) fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.in_units(self.difference(a, b)).fold(0.0, f64::max)
    }

    /// The sum of the squared differences of the entries, in their units.
    pub(super) fn squared(&self, a: &[f64], b: &[f64]) -> f64 {
        self.in_units(self.difference(a, b)).map(|off| off * off).sum()
    }

    /// b - a, each angle less its whole turns.
    pub(super) fn difference<'a>(
        &'a self,
        a: &'a [f64],
        b: &'a [f64],
    ) -> impl Iterator<Item = f64> + 'a {
        difference(&self.periods, a, b)
    }

    /// The periods of the coordinates that have one.
    pub(super) fn periods(&self) -> &[Option<f64>] {
        &self.periods
    }

    /// Whether no coordinate of the motion that has settled moves.
    pub(super) fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    /// The unit of each entry, 0 where it does not move.
    pub(super) fn moving_units(&self) -> Vec<f64> {
        let moving = |(&unit, &least): (&f64, &f64)| if unit > least { unit } else { 0.0 };
        self.units.iter().zip(&self.least).map(moving).collect()
    }

    /// The unit of each entry.
    pub(super) fn units(&self) -> &[f64] {
        &self.units
    }

    /// The largest of differences of the entries, in their units.
    pub(super) fn largest(&self, off: &[f64]) -> f64 {
        self.in_units(off.iter().copied()).fold(0.0, f64::max)
    }

    /// The magnitudes of differences, in units; 0 for those that count as zero.
    fn in_units<'a>(
        &'a self,
        off: impl Iterator<Item = f64> + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        let in_units = |((off, &unit), &least): ((f64, &f64), &f64)| {
            if off.abs() <= least { 0.0 } else { off.abs() / unit.max(least) }
        };
        off.zip(&self.units).zip(&self.least).map(in_units)
    }
}

/// b - a of states (q, p), each angle less its whole turns.
pub(super) fn difference<'a>(
    periods: &'a [Option<f64>],
    a: &'a [f64],
    b: &'a [f64],
) -> impl Iterator<Item = f64> + 'a {
    let periods = periods.iter().copied().chain(std::iter::repeat(None));
    let off = |((a, b), period): ((&f64, &f64), Option<f64>)| match period {
        Some(period) => nearest(b - a, period),
        None => b - a,
    };
    a.iter().zip(b).zip(periods).map(off)
}

/// The unit of entry j of (q, p): its extent in the motion that has settled, or what may be left of
/// a transient. 0 for one that does not move at all.
fn unit(periods: &[Option<f64>], settled: &Ranges, run: &Ranges, j: usize) -> f64 {
    extent(periods, settled, j).max(OF_RUN * extent(periods, run, j))
}

/// The largest difference of entry j that is a rounding, by the extents of all entries of (q, p)
/// and by the largest magnitude of its own.
pub(super) fn rounding(extents: &[f64], j: usize, magnitude: f64) -> f64 {
    let (q, p) = extents.split_at(extents.len() / 2);
    let kind = if j < q.len() { q } else { p };
    let others = kind.iter().copied().fold(0.0, f64::max);
    (OF_OTHERS * others).max(OF_MAGNITUDE * magnitude)
}

/// The extent of entry j, of an angle at most a turn.
fn extent(periods: &[Option<f64>], ranges: &Ranges, j: usize) -> f64 {
    let turn = periods.get(j).copied().flatten().unwrap_or(f64::INFINITY);
    ranges.extent(j).min(turn)
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
        assert_eq!(metric.units(), [1.0, 2e-6, 997.0, 0.0]);
        let far = metric.distance(&[1e5, 0.0, 3.0, 0.0], &[1e5 + 0.25, 1e-6, 3.0, 0.0]);
        assert!((far - 0.5).abs() < 1e-9 && !metric.is_at_rest());
        // A momentum that does not move has the roundings of the other, and not their size.
        let off = |p: f64| metric.distance(&[1e5, 0.0, 3.0, 0.0], &[1e5, 0.0, 3.0, p]);
        assert!(off(5e-8) == 0.0 && off(1e-6) > 1.0);
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
    fn roundings_of_a_momentum_whose_coordinate_rests_are_no_motion() {
        let motion = ranges(&[[[0.0, 1e3], [0.0, 3e-9]], [[1e-3, 1e3 + 2e-13], [1e-3, -2e-9]]]);
        let metric = Metric::of(&[None; 2], &motion, &motion);
        assert!(!metric.is_at_rest());
        assert_eq!(metric.distance(&[0.0, 1e3, 0.0, 3e-9], &[0.0, 1e3 + 2e-13, 0.0, -2e-9]), 0.0);
        assert!(metric.distance(&[0.0, 1e3, 0.0, 0.0], &[0.0, -1e3, 0.0, 0.0]) > 1.0);
    }

    #[test]
    fn what_is_left_of_a_transient_is_a_rest() {
        let all = ranges(&[[[5.0, -3.0], [2.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]]);
        let at = |off: f64| ranges(&[[[1.0, 0.0], [off, -off]], [[1.0 + off, off], [0.0; 2]]]);
        let metric = Metric::of(&[None; 2], &at(2e-9), &all);
        assert!(metric.is_at_rest());
        assert!(metric.distance(&[1.0, 0.0, 2e-9, 0.0], &[1.0, 2e-9, -1e-9, 2e-9]) < SAME);
        assert!(!Metric::of(&[None; 2], &at(1e-5), &all).is_at_rest());
        // A start at rest.
        let rest = ranges(&[[[2.0, 0.0], [0.0; 2]]]);
        let metric = Metric::of(&[None; 2], &rest, &rest);
        assert!(metric.is_at_rest());
        let far = |q: f64, p: f64| metric.distance(&[2.0, 0.0, 0.0, 0.0], &[q, 0.0, p, 0.0]);
        assert!(far(2.0, 1e-3) == 0.0 && far(1.9, 0.0) > 1.0);
    }
}
