//! Quantities measured along a run.
//!
//! Energies cannot be compared in logarithm where H may be negative, as in a double well. The size
//! of the motion is nonnegative for every system:
//!
//! ```text
//! A = T/T_max + |x - c|²/Q²        T = ½ p·∂H/∂p        c = mean of x of the exact solution
//! ```
//!
//! Here x is the place of the state ([`Image`]). T_max and Q = |x|_max are the largest T and |x| of
//! the exact solution, and c is its mean of x over the second half of the run. The mean of A over
//! the second half measures decay, growth and the size of an oscillation, wherever it takes place.
//! The mean of x shows where it takes place: around which attractor, in which well. The means of q,
//! p and w and of their squares over each half ([`Halves`]) give the amplitude of each. For a
//! harmonic oscillation A is constant, so that its mean does not depend on the phase. All means are
//! taken over the same times of the run and of the exact solution, with weights sin² that vanish at
//! the ends of a half, so that the phase at which a run ends does not matter.
//!
//! Quantities that depend on the phase are compared at stations. These are up to [`MOST_STATIONS`]
//! of the observations, at which x, p and w are compared componentwise with the exact solution
//! ([`Track`]).
//!
//! A run is observed at no more than [`MOST_OBSERVATIONS`] equally spaced times. A mean over 1024
//! points no closer than the steps has only a discretization error, which run and solution share.
//! Motion that repeats itself between two observations, such as a relaxation much shorter than a
//! thousandth of the run, is seen only by chance.

use super::halves::Halves;
use super::image::Image;
use super::thresholds::{GROWTH, KEPT_ON_MAPS};
use super::track::Track;
use crate::study::side::{Side, lane_of, put_lane};
use afterbay_core::{Mask, Passive, Scalar, StateRef, System};

/// The most observations of a run.
pub(crate) const MOST_OBSERVATIONS: u64 = 2048;
/// The most observations that are compared with the exact solution componentwise.
pub(crate) const MOST_STATIONS: u64 = 64;

/// An observation of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Observation {
    /// 0 in the first half of the run, 1 in the second.
    pub(super) half: usize,
    /// Its weight among the observations of its half.
    pub(super) weight: f64,
    /// The index of its station, if it is one.
    pub(super) station: Option<usize>,
}

/// The steps of a run after which it is observed.
#[derive(Clone, Debug)]
pub(super) struct Observations {
    /// Steps of the run.
    pub(super) count: u64,
    /// The first observation.
    pub(super) first: u64,
    /// Steps between two observations.
    pub(super) every: u64,
    /// The observations. The last one is at the end.
    observations: Vec<Observation>,
}

impl Observations {
    pub(super) fn new(count: u64) -> Self {
        let half = count / 2;
        let every = (count - half).div_ceil(MOST_OBSERVATIONS / 2).max(1);
        let total = count.saturating_sub(1) / every + 1;
        let late = count.saturating_sub(half + 1) / every + 1;
        let stride = total.div_ceil(MOST_STATIONS);
        let (early, before) = (total - late, (total - 1) % stride);
        let weights = [early, late].map(|n| {
            let angle = std::f64::consts::PI / n as f64;
            let weights: Vec<f64> =
                (0..n).map(|i| ((i as f64 + 0.5) * angle).sin().powi(2)).collect();
            let sum: f64 = weights.iter().sum();
            weights.into_iter().map(move |weight| weight / sum)
        });
        let halves = weights.into_iter().enumerate();
        let weights = halves.flat_map(|(half, weights)| weights.map(move |weight| (half, weight)));
        let station = |i: u64| (i % stride == before).then(|| (i / stride) as usize);
        let observation = |(i, (half, weight))| Observation { half, weight, station: station(i) };
        let observations = (0..).zip(weights).map(observation).collect();
        Self { count, first: count - (total - 1) * every, every, observations }
    }

    /// The observations after a step.
    pub(super) fn ahead(&self, of: u64) -> Ahead<'_> {
        let index = of.checked_sub(self.first).map_or(0, |since| since / self.every + 1);
        Ahead { observations: self, index: index as usize, step: self.first + index * self.every }
    }

    /// The steps with their observations.
    pub(super) fn all(&self) -> impl Iterator<Item = (u64, Observation)> {
        (0..)
            .zip(&self.observations)
            .map(|(i, &observation)| (self.first + i * self.every, observation))
    }
}

/// The observations that are still ahead of a run. The next one is known, so that a step without
/// one costs a comparison and no division.
pub(super) struct Ahead<'a> {
    observations: &'a Observations,
    /// The next observation, and the step after which it is made.
    index: usize,
    step: u64,
}

impl Ahead<'_> {
    /// The observation after a step, if there is one. Steps ascend from call to call, and none that
    /// is observed is left out.
    #[inline]
    pub(super) fn take(&mut self, step: u64) -> Option<Observation> {
        if step != self.step {
            return None;
        }
        let observation = self.observations.observations.get(self.index).copied();
        self.index += 1;
        self.step += self.observations.every;
        observation
    }
}

/// The scales by which sizes are measured.
#[derive(Clone, Debug)]
pub(super) struct Scales<T> {
    /// 1/T_max; 0 if nothing moves.
    pub(super) by_kinetic: T,
    /// 1/Q²
    pub(super) by_reach: T,
    /// c
    pub(super) centre: Vec<T>,
    /// The exact solution at the stations.
    pub(super) track: Track<T>,
}

impl<T: Side> Scales<T> {
    /// The scales of eight cells side by side; `None` if they compare different components.
    pub(super) fn beside<'a>(of: impl Fn(usize) -> &'a Scales<f64>) -> Option<Self> {
        let track = Track::beside(|k| &of(k).track)?;
        Some(Self {
            by_kinetic: T::gather(|k| of(k).by_kinetic),
            by_reach: T::gather(|k| of(k).by_reach),
            centre: (0..of(0).centre.len()).map(|j| T::gather(|k| of(k).centre[j])).collect(),
            track,
        })
    }
}

/// Workspace of an observation.
pub(super) struct Workspace<T> {
    hq: Vec<T>,
    hp: Vec<T>,
    z: Vec<T>,
}

impl<T: Side> Workspace<T> {
    pub(super) fn new(dof: usize, image: &Image<T>) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        Self { hq: zeros(dof), hp: zeros(dof), z: zeros(image.size()) }
    }
}

/// The statistics of a run, accumulated step by step.
#[derive(Clone, Debug)]
pub(super) struct Statistics<T> {
    /// The mean of A over the second half.
    pub(super) size: T,
    /// 1 if A has exceeded [`GROWTH`] by a rise of H, else 0.
    grows: T,
    pub(super) halves: Halves<T>,
    /// Over the stations: the largest deviation of a component of z from the exact solution, as a
    /// multiple of the allowed one, the largest |K - K_0|, and the largest |H| + Σ |w_j| + T.
    stations: [T; 3],
    /// w at the last observation.
    filled: Vec<T>,
    /// 1 if a step has violated the passivity of each entry of w, and of their sum, else 0.
    violated: [T; 2],
}

impl<T: Side> Statistics<T> {
    pub(super) fn nothing(dof: usize, image: &Image<T>) -> Self {
        Self {
            size: T::zero(),
            grows: T::zero(),
            halves: Halves::nothing(image.size()),
            stations: [T::zero(); 3],
            filled: vec![T::zero(); dof],
            violated: [T::zero(); 2],
        }
    }

    /// Observes a state.
    #[inline]
    pub(super) fn observe(
        &mut self,
        state: StateRef<'_, T>,
        observation: Observation,
        scales: &Scales<T>,
        system: &dyn System<T>,
        workspace: &mut Workspace<T>,
    ) {
        let Workspace { hq, hp, z } = workspace;
        let Scales { track, centre, .. } = scales;
        system.gradient(state.q, state.p, hq, hp);
        track.image.of(state, z);
        let away =
            z.iter().zip(centre).fold(T::zero(), |away, (&x, &c)| (x - c).mul_add(x - c, away));
        let kinetic = kinetic(state.p, hp);
        let size = (kinetic * scales.by_kinetic) + away * scales.by_reach;
        let weight = T::from_f64(observation.weight);
        if observation.half == 1 {
            self.size = weight.mul_add(size, self.size);
        }
        let is_large = size.le(T::from_f64(GROWTH)).not();
        if is_large.any() {
            let (energy, before) = (system.energy(state.q, state.p), track.total);
            let rounding = T::from_f64(KEPT_ON_MAPS) * (energy.abs() + before.abs());
            // A motion down a slope of V has a large T, although H does not rise.
            let has_risen = (energy - before - kinetic.half() - rounding).le(T::zero()).not();
            self.grows = T::select(is_large.and(has_risen), T::one(), self.grows);
        }
        self.halves.add(observation.half, weight, z, &track.origin);
        if let Some(off) = observation.station.and_then(|station| track.off(station, z)) {
            let energy = system.energy(state.q, state.p);
            let (sum, sizes) =
                state.w.iter().fold((energy, energy.abs() + kinetic), |(sum, sizes), &w| {
                    (sum + w, sizes + w.abs())
                });
            let found = [off, (sum - track.total).abs(), sizes];
            self.stations
                .iter_mut()
                .zip(found)
                .for_each(|(most, found)| *most = larger(*most, found));
        }
    }

    /// Observes the reservoir after a step, or after several if each is known to be passive.
    #[inline]
    pub(super) fn check_passivity(&mut self, w: &[T]) {
        for (violated, passivity) in self.violated.iter_mut().zip([Passive::Each, Passive::InSum]) {
            *violated = T::select(passivity.violated(&self.filled, w), T::one(), *violated);
        }
        self.filled.copy_from_slice(w);
    }

    /// Lane k.
    pub(super) fn lane(&self, k: usize) -> Statistics<f64> {
        Statistics {
            size: self.size.lane(k),
            grows: self.grows.lane(k),
            halves: self.halves.lane(k),
            stations: self.stations.map(|most| most.lane(k)),
            filled: lane_of(&self.filled, k),
            violated: self.violated.map(|violated| violated.lane(k)),
        }
    }

    /// Replaces lane k.
    pub(super) fn put(&mut self, k: usize, one: &Statistics<f64>) {
        self.size = self.size.with(k, one.size);
        self.grows = self.grows.with(k, one.grows);
        self.halves.put(k, &one.halves);
        put_lane(&mut self.stations, k, &one.stations);
        put_lane(&mut self.filled, k, &one.filled);
        put_lane(&mut self.violated, k, &one.violated);
    }
}

/// T = ½ |p·∂H/∂p|
pub(super) fn kinetic<T: Scalar>(p: &[T], hp: &[T]) -> T {
    p.iter().zip(hp).fold(T::zero(), |sum, (&p, &hp)| p.mul_add(hp, sum)).half().abs()
}

/// The larger of two numbers.
pub(super) fn larger<T: Scalar>(a: T, b: T) -> T {
    T::select(a.lt(b), b, a)
}

impl Statistics<f64> {
    /// Whether a step has violated the passivity of the system.
    pub(super) fn violates_passivity(&self, passivity: Passive) -> bool {
        match passivity {
            Passive::No => false,
            Passive::Each => self.violated[0] > 0.0,
            Passive::InSum => self.violated[1] > 0.0,
        }
    }

    /// Whether the energy has grown far beyond that of the solution.
    pub(super) fn grows(&self) -> bool {
        self.grows > 0.0
    }

    /// Whether q, p and w were within the allowed deviation at every station.
    pub(super) fn follows(&self) -> bool {
        self.stations[0] <= 1.0
    }

    /// Whether K was constant at every station, up to rounding.
    pub(super) fn keeps_k(&self) -> bool {
        self.stations[1] <= KEPT_ON_MAPS * self.stations[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_cover_both_halves_and_end_with_the_run() {
        for count in [1, 2, 3, 50, 2047, 2048, 2049, 10_000, 1_000_001] {
            let observations = Observations::new(count);
            let all: Vec<_> = observations.all().collect();
            assert!(
                all.len() as u64 <= MOST_OBSERVATIONS && (count < 2000 || all.len() > 1000),
                "{count}"
            );
            assert!(observations.first <= observations.every, "{count}");
            assert_eq!(all.last().map(|observation| observation.0), Some(count));
            for half in [0, 1] {
                let of_half = || all.iter().filter(|observation| observation.1.half == half);
                assert!(
                    of_half().all(|observation| (2 * observation.0 > count) == (half == 1)),
                    "{count}"
                );
                let sum: f64 = of_half().map(|observation| observation.1.weight).sum();
                assert!((sum - 1.0).abs() < 1e-12 || (count == 1 && half == 0), "{count}");
            }
            let stations: Vec<_> =
                all.iter().filter_map(|observation| observation.1.station).collect();
            assert!(stations.iter().copied().eq(0..stations.len()), "{count}");
            assert!(
                stations.len() as u64 <= MOST_STATIONS && stations.len() as u64 >= count.min(32)
            );
            assert!(
                all.last().is_some_and(|observation| observation.1.station.is_some()),
                "{count}"
            );
            for from in [0, 1, observations.first, count / 2, count - 1, count] {
                let (mut ahead, mut rest) = (observations.ahead(from), all.clone());
                rest.retain(|observation| observation.0 > from);
                for (step, observation) in rest {
                    assert_eq!(ahead.take(step - 1), None, "{count}");
                    assert_eq!(ahead.take(step), Some(observation), "{count}");
                }
                assert_eq!(ahead.take(count + observations.every), None);
            }
        }
    }

    #[test]
    fn k_that_moves_by_more_than_rounding_is_lost() {
        let statistics = |stations| Statistics {
            stations,
            ..Statistics::<f64>::nothing(1, &Image::new(&[None]))
        };
        assert!(statistics([0.0, 1e-9, 1.0]).keeps_k() && !statistics([0.0, 1e-6, 1.0]).keeps_k());
        assert!(
            statistics([0.0, 1e-6, 200.0]).keeps_k() && !statistics([0.0, 1.5, 200.0]).keeps_k()
        );
    }

    #[test]
    fn what_falls_is_seen_and_what_is_rounded_is_not() {
        let mut statistics = Statistics::<f64>::nothing(2, &Image::new(&[None, None]));
        statistics.check_passivity(&[1.0, 3.0]);
        statistics.check_passivity(&[1.0, 3.0 - f64::EPSILON]);
        assert!(!statistics.violates_passivity(Passive::Each));
        statistics.check_passivity(&[0.5, 4.0]);
        assert!(
            statistics.violates_passivity(Passive::Each)
                && !statistics.violates_passivity(Passive::InSum)
                && !statistics.violates_passivity(Passive::No)
        );
        statistics.check_passivity(&[0.4, 4.0]);
        assert!(statistics.violates_passivity(Passive::InSum));
    }
}
