//! The test whether a run grows all along, so that it shows no attractor.

use super::outcome::Ending;
use super::ranges::Ranges;

/// The outcome of a run that grows all along, which shows no attractor.
pub const GROWING: &str = "growing";
/// A run grows if its last part is larger than the part before by at least this factor. In a run
/// that grows steadily it is larger by an eighth. In a run that has come near a cycle the two are
/// almost equal.
const STILL_GROWS: f64 = 1.02;
/// The parts of a run whose sizes show that it grows.
const PARTS: usize = 8;
/// The least returns of each of these parts.
const RETURNS_A_PART: u64 = 4;
/// The least factor from the size of the second of these parts to that of the last. A choice: the
/// states of a chaotic motion or of a slow beat are larger in the end by less, or do not rise from
/// each part to the next.
const GROWN: f64 = 3.0;

/// The ranges of a run in its parts. Points after a transient may be too few to tell growth.
#[derive(Clone, Debug)]
pub(super) struct SizeHistory {
    /// The returns of the run.
    last: u64,
    parts: Vec<Ranges>,
}

impl SizeHistory {
    /// The history of a run of `last` returns.
    pub(super) fn new(dof: usize, last: u64) -> Self {
        Self { last, parts: vec![Ranges::nothing(dof); PARTS] }
    }

    /// Adds the ranges between return n, counted from 1, and the return before.
    pub(super) fn see(&mut self, n: u64, path: &Ranges) {
        if (1..=self.last).contains(&n) {
            let part = ((n - 1) as f64 / self.last as f64 * PARTS as f64) as usize;
            self.parts[part].join(path);
        }
    }

    /// Whether the run grows: after the first part, the extent of an entry, or the largest
    /// magnitude of all entries but angles, rises from each part to the next. It rises by 2 % or
    /// more at the end, and to three times or more in all. The result for a short run is false.
    fn is_seen(&self, periods: &[Option<f64>]) -> bool {
        let entries = || 0..self.parts[0].len();
        let is_angle = |j: usize| periods.get(j).is_some_and(Option::is_some);
        let sizes = |part: usize| {
            let straight = entries().filter(|&j| !is_angle(j));
            straight.map(|j| self.parts[part].magnitude(j)).fold(0.0, f64::max)
        };
        let extents = |j: usize| std::array::from_fn(|part| self.parts[part].extent(j));
        let enough = self.last >= PARTS as u64 * RETURNS_A_PART;
        enough && (rises(std::array::from_fn(sizes)) || entries().any(|j| rises(extents(j))))
    }

    /// The outcome of the run: [`GROWING`] if it has reached its end and grows. `periods` are those
    /// of the coordinates.
    pub(super) fn ending(&self, ending: Ending, periods: &[Option<f64>]) -> Ending {
        let grows = ending.is_completed() && self.is_seen(periods);
        if grows { Ending { outcome: GROWING, ..ending } } else { ending }
    }
}

/// Whether sizes grow from part to part.
fn rises(sizes: [f64; PARTS]) -> bool {
    let [before, last] = [PARTS - 2, PARTS - 1].map(|part| sizes[part]);
    let rises = sizes[1..].windows(2).all(|pair| pair[1] > pair[0]);
    rises && last > STILL_GROWS * before && last > GROWN * sizes[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_told_from_motion_that_stays() {
        let see = |growth: &mut SizeHistory, n: u64, x: f64| {
            growth.see(n, &Ranges::of(&[vec![x, -x]]));
        };
        let grows = |count: u32, x: &dyn Fn(f64) -> f64| {
            let mut growth = SizeHistory::new(1, u64::from(count));
            (1..=count).for_each(|n| see(&mut growth, n.into(), x(n.into())));
            growth.is_seen(&[None])
        };
        let wave = |n: f64| (2.0 * n).cos();
        assert!(grows(208, &|n| 1e-9 * (0.01 * n).exp() * wave(n)) && grows(32, &|n| n));
        assert!(grows(1000, &|n| 1.0 + 0.02 * n));
        assert!(grows(208, &|n| 1e5 + 1e-3 * (0.01 * n).exp() * wave(n)));
        // A slow beat of a motion that stays.
        assert!(!grows(208, &|n| (2.0 - (n / 80.0).cos()) * wave(n)));
        // Motion that stays, decays, has come up to a cycle, or is too short.
        assert!(!grows(208, &wave) && !grows(208, &|n| (-0.01 * n).exp() * wave(n)));
        assert!(!grows(208, &|n| 1e5 + (2.0 - (n / 80.0).cos()) * wave(n)));
        assert!(!grows(208, &|n| 1.0 - (-0.05 * n).exp()) && !grows(31, &|n| n));
        // It has grown, and has come up to its cycle.
        assert!(!grows(440, &|n| 2.0 / (1.0 + 4e4 * (-0.0628 * n).exp()).sqrt()));
        // An angle that turns at one rate.
        let mut turns = SizeHistory::new(1, 208);
        (1..=208).for_each(|n| turns.see(n, &Ranges::of(&[vec![n as f64, 1.0]])));
        assert!(turns.is_seen(&[None]) && !turns.is_seen(&[Some(std::f64::consts::TAU)]));
        let growing = (1..1000).filter(|&seed| {
            let (mut x, mut growth) = (f64::from(seed) / 1000.0, SizeHistory::new(1, 208));
            (1..=208).for_each(|n| {
                x = 3.9 * x * (1.0 - x);
                see(&mut growth, n, x);
            });
            growth.is_seen(&[None])
        });
        assert_eq!(growing.count(), 0);
    }
}
