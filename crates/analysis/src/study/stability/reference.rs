//! The exact solution, in the quantities by which runs are compared with it.

use super::halves::Halves;
use super::measure::{Scales, Statistics};
use super::thresholds::{SHARE, TOLERANCE};

/// A rest under forces that are roundings is known if a displacement of this share of q grows by at
/// most this factor. Short steps keep q at rest even where it is unstable, since they add less
/// than a rounding to it.
pub(super) const DISPLACED: f64 = 1.0 / (1 << 20) as f64;
const GROWN: f64 = 256.0;

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
    pub(super) halves: Halves<f64>,
}

/// The references of a map, for each value and step.
#[derive(Clone, Debug)]
pub struct References(pub(super) Vec<Option<Vec<Reference>>>);

impl Reference {
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
        // Rounding keeps a state of rest from being quieter than this.
        let rounding = (1024.0 * f64::EPSILON).powi(2) * square(&mut centre.iter().copied());
        let [found, exact] = [size, self.size].map(|size| size.max(rounding).max(1e-300).ln());
        let off = square(&mut mean.iter().zip(centre).map(|(mean, centre)| mean - centre));
        (found - exact).abs() <= tolerance * (1.0 + exact.abs()) && off.sqrt() <= share
    }
}
