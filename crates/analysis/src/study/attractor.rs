//! The attractor that points of a section show: a cycle of some period, or a set without one.

use super::metric::{Metric, SAME};
use super::ranges::Ranges;
use serde::{Deserialize, Serialize};

/// The largest distance of two attractors that count as one. A coarse choice: methods at finite
/// steps shift an attractor without changing its kind.
const ALIKE: f64 = 0.05;
/// The least number of returns after which a cycle must repeat.
const REPEATS: usize = 2;
/// The largest distance of points from those of the first turn of a cycle, in units and as a share
/// of the distance of its other points.
const OF_CYCLE: f64 = 0.01;
/// The word for a motion that has come to rest.
pub const REST: &str = "rest";
/// The words for a motion of which one point is kept, so that nothing is known of its period.
pub const OF_ONE_POINT: &str = "within 1 point";
/// The word for a motion that has no period because it still approaches a cycle.
pub const SETTLING: &str = "still settling";
/// The least number of points for each return of the cycle that a settling motion approaches.
pub const POINTS_A_RETURN: usize = 32;
/// The longest cycle, in returns, that a settling motion is seen to approach.
const LONGEST_APPROACHED: usize = 8;
/// The parts of a settling motion in which distances of points fall, and the mean distance in the
/// last as a share of that in the first. A choice: at most three of a thousand stretches of the
/// logistic map's chaos show either.
const FALLS: [(usize, f64); 2] = [(4, 0.2), (8, 0.6)];
/// The most points of each set that are compared.
const MOST_COMPARED: usize = 400;

/// The kind of an attractor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// It repeats after this many returns.
    Period(usize),
    /// It does not repeat within half of its points: chaos, a torus, or a long period.
    Aperiodic,
}

/// The points of an attractor, in order of time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Attractor {
    /// q and p of each point.
    points: Vec<Vec<f64>>,
    /// The distance of points.
    metric: Metric,
    /// The kind.
    pub kind: Kind,
    /// Properties of the motion that its points do not show.
    #[serde(default)]
    traits: Traits,
}

/// Properties of the motion of a run that the points of its section do not show.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Traits {
    /// Whether it has come to rest.
    pub(super) rests: bool,
    /// Whether no friction takes or gives energy. Then volumes of states are constant, and no
    /// motion approaches another.
    pub(super) conservative: bool,
}

impl Attractor {
    /// The attractor that points show, each q and p in one vector; none if there are fewer than
    /// two.
    pub(super) fn of(points: Vec<Vec<f64>>, metric: Metric) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let kind = period(&points, &metric).map_or(Kind::Aperiodic, Kind::Period);
        Some(Self { points, metric, kind, traits: Traits::default() })
    }

    /// The attractor of a run that shows these traits.
    pub(super) fn with(self, traits: Traits) -> Self {
        Self { traits, ..self }
    }

    /// The kind in words, [`REST`], or [`SETTLING`].
    pub fn describe(&self) -> String {
        match self.of_few_points() {
            _ if self.rests() => REST.into(),
            Some(points) => format!("{} {points}", self.kind.describe()),
            None if self.is_settling() => SETTLING.into(),
            None => self.kind.describe(),
        }
    }

    /// Whether the motion has come to rest.
    pub fn rests(&self) -> bool {
        self.traits.rests
    }

    /// The words for a motion without a period that has too few points to tell whether it settles.
    pub fn of_few_points(&self) -> Option<String> {
        let count = self.points.len();
        let few = self.kind == Kind::Aperiodic && count < POINTS_A_RETURN;
        few.then(|| format!("within {count} points"))
    }

    /// Whether the motion has no period because it still approaches a cycle. For some number of
    /// returns k, the mean distance of points k returns apart then falls from each quarter of the
    /// points to the next, and to a fifth at most in all, or from each eighth to the next, and to
    /// three fifths. The mean is that of squares, which is the same for all phases of a spiral. Or
    /// each of these distances is less than the one k returns before, which shows an approach that
    /// is as slow as that by a power of the time.
    pub fn is_settling(&self) -> bool {
        let Self { points, metric, kind: Kind::Aperiodic, traits } = self else { return false };
        if traits.conservative {
            return false;
        }
        let approaches = |k: usize| {
            let squares =
                points.windows(k + 1).map(|passed| metric.squared(&passed[k], &passed[0]));
            let squares: Vec<_> = squares.collect();
            let steadily = squares.windows(k + 1).all(|passed| passed[k] < passed[0]);
            let mean = |part: &[f64]| (part.iter().sum::<f64>() / part.len() as f64).sqrt();
            let in_parts = FALLS.into_iter().any(|(parts, left)| {
                let parts: Vec<_> =
                    squares.chunks(squares.len().div_ceil(parts)).map(mean).collect();
                let falls = parts.windows(2).all(|pair| pair[1] < pair[0]);
                falls && parts[parts.len() - 1] <= left * parts[0]
            });
            steadily || in_parts
        };
        let longest = LONGEST_APPROACHED.min(points.len() / POINTS_A_RETURN);
        (1..=longest).any(approaches)
    }

    /// q and p of its points.
    pub fn points(&self) -> &[Vec<f64>] {
        &self.points
    }

    /// The largest distance of a point of one attractor from the nearest point of the other, in the
    /// larger units of the two.
    pub fn distance(&self, other: &Self) -> f64 {
        let ([a, b], metric) = ([self, other].map(Self::compared), self.metric.with(&other.metric));
        beyond(&metric, &a, &b).max(beyond(&metric, &b, &a))
    }

    /// The largest difference of the units of the two, relative to the larger unit.
    pub(super) fn size_difference(&self, other: &Self) -> f64 {
        let [own, others] = [self, other].map(|of| of.metric.units());
        own.iter().zip(others).map(|(a, b)| (a - b).abs() / a.max(*b)).fold(0.0, f64::max)
    }

    /// Whether both are of one kind and lie in one place.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self.kind, other.kind) {
            (Kind::Period(a), Kind::Period(b)) => a == b && self.distance(other) <= ALIKE,
            // Two stretches of one chaotic attractor share no point: their extents are compared.
            (Kind::Aperiodic, Kind::Aperiodic) => self.extent_distance(other) <= 4.0 * ALIKE,
            _ => false,
        }
    }

    fn compared(&self) -> Vec<&[f64]> {
        let count = match self.kind {
            Kind::Period(period) => period,
            Kind::Aperiodic => self.points.len(),
        };
        let stride = count.div_ceil(MOST_COMPARED).max(1);
        self.points[self.points.len() - count..].iter().step_by(stride).map(Vec::as_slice).collect()
    }

    /// The largest difference of the least and the largest values of the two, in units.
    fn extent_distance(&self, other: &Self) -> f64 {
        let [own, others] = [self, other].map(|of| Ranges::of(&of.points));
        let off = |j: usize| {
            let ([a, b], [c, d]) = (own.bounds(j), others.bounds(j));
            (a - c).abs().max((b - d).abs())
        };
        self.metric.with(&other.metric).largest(&(0..own.len()).map(off).collect::<Vec<_>>())
    }
}

impl Kind {
    /// The kind in words.
    pub fn describe(self) -> String {
        match self {
            Self::Period(period) => format!("period {period}"),
            Self::Aperiodic => "no period".into(),
        }
    }
}

/// The number of returns after which points are the same. They may be those of a transient.
pub(super) fn first_return(points: &[Vec<f64>], metric: &Metric) -> Option<usize> {
    let same = |i: usize, k: usize| metric.distance(&points[i], &points[k]) <= SAME;
    let repeats = |&k: &usize| (k..points.len()).all(|i| same(i, i - k));
    (1..=points.len() / REPEATS).find(repeats)
}

/// The number of returns after which points repeat. Those of a transient may be the same after some
/// returns as well, but move on from turn to turn.
fn period(points: &[Vec<f64>], metric: &Metric) -> Option<usize> {
    let (count, period) = (points.len(), first_return(points, metric)?);
    let distance = |i: usize, k: usize| metric.distance(&points[i], &points[k]);
    let moved = (period..count).map(|i| distance(i, i % period)).fold(0.0, f64::max) / OF_CYCLE;
    let apart = |k: usize| (k..count).any(|i| distance(i, i - k) >= moved);
    (moved <= 1.0 && (1..period).all(apart)).then_some(period)
}

/// The largest distance of one of `from` from the nearest of `to`.
fn beyond(metric: &Metric, from: &[&[f64]], to: &[&[f64]]) -> f64 {
    let nearest =
        |a: &&[f64]| to.iter().map(|b| metric.distance(a, b)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::StateRef;
    use std::f64::consts::{PI, TAU};

    /// Of a motion from 2 that passes 0 between its points.
    fn attractor(points: &[f64]) -> Attractor {
        let mut settled = Ranges::nothing(1);
        let mut see = |x: f64| {
            settled.see(StateRef { q: &[x], p: &[-x], w: &[0.0], t: 0.0 });
            settled.clone()
        };
        points.iter().for_each(|&x| drop(see(x)));
        let (settled, run) = (see(0.0), see(2.0));
        let points = points.iter().map(|&x| vec![x, -x]).collect();
        Attractor::of(points, Metric::of(&[None], &settled, &run)).expect("two points")
    }

    #[test]
    fn periods_are_the_least_that_repeat() {
        assert_eq!(attractor(&[1.0, 1.0, 1.0, 1.0]).kind, Kind::Period(1));
        assert_eq!(attractor(&[1.0, 2.0, 1.0, 2.0, 1.0]).kind, Kind::Period(2));
        assert_eq!(attractor(&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0]).kind, Kind::Period(3));
        assert_eq!(attractor(&[1.0, 2.0, 3.0, 1.0]).kind, Kind::Aperiodic);
        assert_eq!(attractor(&[1.0, 1.001, 1.0, 1.001]).kind, Kind::Period(2));
        assert_eq!(attractor(&[0.0, 0.0]).kind, Kind::Period(1));
        let metric = Metric::with_units(&[None], vec![1.0; 2]);
        assert!(Attractor::of(vec![vec![1.0, 0.0]], metric).is_none());
    }

    #[test]
    fn a_motion_that_has_decayed_is_at_rest() {
        let decayed = attractor(&[4e-10, -2e-10, 1e-10, -5e-11]);
        let more = attractor(&[4e-56, -2e-56, 1e-56, 0.0]);
        assert_eq!([decayed.kind, more.kind], [Kind::Period(1); 2]);
        assert!(decayed.distance(&more) < SAME && more.distance(&decayed) < SAME);
        assert!(decayed.is_like(&more) && more.is_like(&decayed));
        let small = attractor(&[4e-4, -2e-4, 1e-4, -5e-5]);
        assert!(small.kind == Kind::Aperiodic && !small.is_like(&more));
    }

    #[test]
    fn what_is_left_of_a_transient_has_no_period_of_its_own() {
        // Spirals to a cycle of period 1, and an alternation.
        let spiral = |rate: f64, turn: f64| {
            let x =
                |n: i32| 1.0 + 0.002 * (-rate * f64::from(n)).exp() * (turn * f64::from(n)).cos();
            attractor(&(0..100).map(x).collect::<Vec<_>>())
        };
        for rate in [0.04, 0.02, 0.01] {
            for turn in [TAU / 7.01, PI, 0.4 * TAU] {
                let found = spiral(rate, turn);
                assert_eq!(found.kind, Kind::Aperiodic, "{rate} {turn}");
                assert!(found.is_settling(), "{rate} {turn}");
            }
        }
        // Nor has a motion that creeps on.
        let creeps = attractor(&(0..2000).map(|n| 1.0 + 4e-5 * f64::from(n)).collect::<Vec<_>>());
        assert_eq!(creeps.kind, Kind::Aperiodic);
        // A cycle of period 2 whose points are as near.
        let of_two = |n: usize| if n.is_multiple_of(2) { 1.0 } else { 1.002 };
        let of_two = attractor(&(0..100).map(of_two).collect::<Vec<_>>());
        assert_eq!(of_two.kind, Kind::Period(2));
    }

    #[test]
    fn what_approaches_a_cycle_is_still_settling() {
        let points = |count: usize, x: &dyn Fn(f64) -> f64| {
            attractor(&(0..count).map(|n| x(n as f64)).collect::<Vec<_>>())
        };
        let decay = |n: f64| (-0.1 * n).exp();
        let wave = |n: f64| (2.0 * n).cos();
        let of_two = |n: f64| if n % 2.0 == 0.0 { 1.0 } else { -0.5 };
        for count in [32, 40, 100] {
            assert!(points(count, &decay).is_settling(), "{count}");
        }
        assert!(points(100, &|n| 1.0 + decay(n) * wave(n)).is_settling());
        assert!(points(100, &|n| of_two(n) + 0.1 * decay(n)).is_settling());
        // An approach like a power of the time, and slow ones to cycles of periods 1 and 2.
        let slow = |n: f64| 0.1 / (400.0 + n).sqrt();
        for count in [32, 64, 400] {
            assert!(points(count, &|n| 10.0 * slow(n)).is_settling(), "{count}");
            assert!(points(count.max(64), &|n| of_two(n) + 50.0 * slow(n)).is_settling());
        }
        // Without friction there is none.
        let conservative = Traits { rests: false, conservative: true };
        assert_eq!(points(100, &decay).with(conservative).describe(), "no period");
        // A motion that grows, a torus, one with few points, and one that has settled.
        assert!(!points(100, &|n| 1e-3 / decay(n)).is_settling());
        assert!(!points(100, &wave).is_settling());
        assert!(!points(31, &decay).is_settling());
        assert_eq!(points(31, &decay).describe(), "no period within 31 points");
        assert_eq!(points(32, &wave).describe(), "no period");
        assert!(!points(1000, &|_| 1.0).is_settling());
        assert_eq!(points(100, &decay).describe(), SETTLING);
    }

    #[test]
    fn chaos_is_not_still_settling() {
        for (count, most) in [(32, 3), (60, 3), (200, 1)] {
            let settling = (1..1000).filter(|&seed| {
                let mut x = f64::from(seed) / 1000.0;
                let next = |_| {
                    x = 3.9 * x * (1.0 - x);
                    x
                };
                attractor(&(0..count).map(next).collect::<Vec<_>>()).is_settling()
            });
            let settling = settling.count();
            assert!(settling <= most, "{settling} of {count} points");
        }
    }

    #[test]
    fn an_angle_at_half_a_turn_is_one_place() {
        let turn = std::f64::consts::TAU;
        let of = |angles: [f64; 4]| {
            let points = angles.map(|q| vec![q, 0.1]).to_vec();
            Attractor::of(points, Metric::with_units(&[Some(turn)], vec![1.0; 2]))
                .expect("two points")
        };
        let near = turn / 2.0 - 1e-9;
        let (a, b) = (of([near, -near, near, near]), of([-near; 4]));
        assert_eq!([a.kind, b.kind], [Kind::Period(1); 2]);
        assert!(a.distance(&b) < 1e-8 && a.is_like(&b));
    }

    #[test]
    fn attractors_are_compared_as_sets() {
        let (a, b) = (attractor(&[1.0, 2.0, 1.0, 2.0]), attractor(&[2.01, 1.0, 2.01, 1.0]));
        assert!((a.distance(&b) - 0.01 / 2.01).abs() < 1e-12 && a.is_like(&b));
        assert!(!a.is_like(&attractor(&[1.0, 2.4, 1.0, 2.4])));
        assert!(!a.is_like(&attractor(&[1.5, 1.5])));
        let logistic = |mut x: f64| {
            let next = |_| {
                x = 3.9 * x * (1.0 - x);
                x
            };
            attractor(&(0..500).map(next).collect::<Vec<_>>())
        };
        let (c, d) = (logistic(0.3), logistic(0.31));
        assert_eq!([c.kind, d.kind], [Kind::Aperiodic; 2]);
        assert!(c.is_like(&d) && !c.is_like(&a));
    }
}
