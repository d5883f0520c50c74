//! The attractor that points of a section show: a cycle of some period, or a set without one.

use serde::{Deserialize, Serialize};

/// The largest distance of points that count as one, relative to [`Attractor::size`].
const SAME: f64 = 1e-4;
/// The largest distance of two attractors that count as one, relative to their size. A coarse
/// choice: methods at finite steps shift an attractor without changing its kind.
const ALIKE: f64 = 0.05;
/// The least number of returns after which a cycle must repeat.
const REPEATS: usize = 2;
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
    /// The kind.
    pub kind: Kind,
    /// The largest |q_j| or |p_j| of the points.
    pub size: f64,
}

impl Attractor {
    /// The attractor that points (q, p) show; none if there are fewer than two.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a [Vec<f64>; 2]>) -> Option<Self> {
        let points: Vec<Vec<f64>> = points.into_iter().map(|point| point.concat()).collect();
        let first = points.first().filter(|_| points.len() > 1)?;
        let size = (0..first.len())
            .map(|j| points.iter().map(|point| point[j].abs()).fold(0.0, f64::max))
            .fold(0.0, f64::max);
        let same = |a: &[f64], b: &[f64]| far(a, b) <= SAME * size;
        let repeats = |&k: &usize| (k..points.len()).all(|i| same(&points[i], &points[i - k]));
        let kind = (1..=points.len() / REPEATS).find(repeats).map_or(Kind::Aperiodic, Kind::Period);
        Some(Self { points, kind, size })
    }

    /// q and p of its points.
    pub(crate) fn points(&self) -> &[Vec<f64>] {
        &self.points
    }

    /// The largest distance of a point of one attractor from the nearest point of the other,
    /// relative to the size of this one.
    pub fn distance(&self, other: &Self) -> f64 {
        self.apart(other) / self.size.max(f64::MIN_POSITIVE)
    }

    /// The largest distance of a point of one attractor from the nearest point of the other.
    pub(crate) fn apart(&self, other: &Self) -> f64 {
        let [a, b] = [self, other].map(Self::compared);
        beyond(&a, &b).max(beyond(&b, &a))
    }

    /// Whether both are of one kind and lie in one place.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
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

    /// The largest difference of the least and the largest values of the two.
    fn extent_distance(&self, other: &Self) -> f64 {
        let range = |of: &Self, j: usize| {
            let values = || of.points.iter().map(|point| point[j]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        let off = |j: usize| {
            let ([a, b], [c, d]) = (range(self, j), range(other, j));
            (a - c).abs().max((b - d).abs())
        };
        let dof = self.points.first().map_or(0, Vec::len);
        (0..dof).map(off).fold(0.0, f64::max) / self.size.max(f64::MIN_POSITIVE)
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

fn far(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The largest distance of one of `from` from the nearest of `to`.
fn beyond(from: &[&[f64]], to: &[&[f64]]) -> f64 {
    let nearest = |a: &&[f64]| to.iter().map(|b| far(a, b)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attractor(points: &[f64]) -> Attractor {
        let points: Vec<_> = points.iter().map(|&x| [vec![x], vec![-x]]).collect();
        Attractor::of(&points).expect("two points")
    }

    #[test]
    fn periods_are_the_least_that_repeat() {
        assert_eq!(attractor(&[1.0, 1.0, 1.0, 1.0]).kind, Kind::Period(1));
        assert_eq!(attractor(&[1.0, 2.0, 1.0, 2.0, 1.0]).kind, Kind::Period(2));
        assert_eq!(attractor(&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0]).kind, Kind::Period(3));
        assert_eq!(attractor(&[1.0, 2.0, 3.0, 1.0]).kind, Kind::Aperiodic);
        assert_eq!(attractor(&[1.0, 1.001, 1.0, 1.001]).kind, Kind::Period(2));
        assert_eq!(attractor(&[0.0, 0.0]).kind, Kind::Period(1));
        assert!(Attractor::of(&[[vec![1.0], vec![0.0]]]).is_none());
    }

    #[test]
    fn attractors_are_compared_as_sets() {
        let (a, b) = (attractor(&[1.0, 2.0, 1.0, 2.0]), attractor(&[2.01, 1.0, 2.01, 1.0]));
        assert!((a.distance(&b) - 0.005).abs() < 1e-12 && a.is_like(&b));
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
