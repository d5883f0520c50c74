//! The exact solution, in the quantities by which runs are compared with it.

use super::halves::Halves;
use super::measure::{Scales, Statistics};
use super::thresholds::{SHARE, TOLERANCE};

/// A rest under forces that are roundings is known if a displacement of this share of q grows by at
/// most this factor. Short steps keep q at rest even where it is unstable, since they add less
/// than a rounding to it.
pub(super) const DISPLACED: f64 = 1.0 / (1 << 20) as f64;
const GROWN: f64 = 256.0;

/// A has decayed if its mean is below this, so that |x - c| is below √ε of the largest |x|. A
/// choice.
const DECAYED: f64 = f64::EPSILON;
/// Roundings decide A if a displaced start changes ln A by more than this. Without them it changes
/// ln A by about the displacement. A choice.
const APART: f64 = 1e-3;
/// The longest decay time of a motion that decays to roundings, as a share of the run. A choice.
const DECAY_SHARE: f64 = 0.125;
/// Two methods leave a motion with different amplitudes once roundings decide them. This is the
/// largest ratio of the two. A choice.
const ROUNDINGS_APART: f64 = 1024.0;

/// The accuracy of the reference of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Halving the step changes the compared quantities by at most a hundredth of what is allowed.
    Resolved,
    /// The compared quantities still change by more at the shortest step.
    Unsettled,
    /// The solution ceases to be finite.
    Leaves,
}

/// The exact solution, as runs are compared with it.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) standing: Standing,
    /// Whether it is resolved at each station.
    pub(super) followed: bool,
    /// Whether a step is too long to resolve the motion.
    pub(super) leaps: bool,
    /// Whether no coordinate moves, although forces that are roundings act.
    pub(super) rests: bool,
    pub(super) scales: Scales<f64>,
    /// The mean of A over the second half.
    pub(super) size: f64,
    /// A below which roundings decide: they keep a state of rest from being quieter than this.
    pub(super) floor: f64,
    pub(super) halves: Halves<f64>,
}

/// The references of a map, for each value and step.
#[derive(Clone, Debug)]
pub struct References(pub(super) Vec<Option<Vec<Reference>>>);

impl Reference {
    /// Whether it is known everywhere.
    pub(super) fn is_resolved(&self) -> bool {
        self.standing == Standing::Resolved && self.followed
    }

    /// Whether little is left of the motion in the second half.
    pub(super) fn has_decayed(&self) -> bool {
        self.size < DECAYED
    }

    /// Finds the size below which roundings decide, from another solution, whose start is
    /// displaced: it decays to another size there, or rests at another place.
    pub(super) fn find_floor(&mut self, displaced: &Self) {
        let [a, b] = [&*self, displaced].map(|x| x.size.max(1e-300));
        let pairs = self.scales.centre.iter().zip(&displaced.scales.centre);
        let between = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() * self.scales.by_reach;
        let is_apart = (a / b).ln().abs() > APART || between > APART * a;
        if is_apart && self.has_decayed() && displaced.has_decayed() {
            let size = ROUNDINGS_APART.powi(2) * a.max(b).max(between);
            self.floor = self.floor.max(size.min(DECAYED));
        }
    }

    /// Allows the roundings of the place of rest in `count` steps. They add up over a decay time of
    /// the motion, which is at most [`DECAY_SHARE`] of the run where they are seen.
    pub(super) fn allow_roundings(&mut self, count: u64) {
        let Scales { by_reach, centre, .. } = &self.scales;
        let square: f64 = centre.iter().map(|x| x * x).sum();
        self.floor = (DECAY_SHARE * count as f64 * f64::EPSILON).powi(2) * square * by_reach;
    }

    /// Whether another solution, whose start is displaced, stays near the place where this one
    /// rests.
    pub(super) fn stays_with(&self, displaced: &Self) -> bool {
        let reach: f64 = self.scales.centre.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = |(a, b): (&f64, &f64)| (a - b).abs() <= GROWN * DISPLACED * reach;
        self.scales.track.places().zip(displaced.scales.track.places()).all(off)
    }

    /// Whether a run has the size and the place of this solution.
    pub(super) fn is_as_large(&self, statistics: &Statistics<f64>) -> bool {
        let means = statistics.halves.last_mean().iter().zip(&self.scales.track.origin);
        let mean: Vec<f64> = means.map(|(off, origin)| off + origin).collect();
        self.agrees(statistics.size, &mean, [TOLERANCE, SHARE])
    }

    /// Whether size and mean agree within the given tolerance and share.
    pub(super) fn agrees(&self, size: f64, mean: &[f64], [tolerance, share]: [f64; 2]) -> bool {
        let Scales { by_reach, centre, .. } = &self.scales;
        let square =
            |parts: &mut dyn Iterator<Item = f64>| parts.map(|x| x * x).sum::<f64>() * by_reach;
        let [found, exact] = [size, self.size].map(|size| size.max(self.floor).max(1e-300).ln());
        let off = square(&mut mean.iter().zip(centre).map(|(mean, centre)| mean - centre));
        (found - exact).abs() <= tolerance * (1.0 + exact.abs()) && off.sqrt() <= share
    }
}
