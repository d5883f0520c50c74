//! The kinks of a system that a step passes.
//!
//! A method has its order only where the solution is smooth. Collocation then errs by the square of
//! its defect, but across a kink by the defect itself. An estimate that is raised to the order of
//! the step misses this error, since the larger terms of the smooth parts hide it.

use super::budget::size_of_first_or_nan;
use afterbay_core::{Scalar, System, Vector, larger_or_nan};

/// The power of h that relates the errors of two steps across a kink, if the second derivative of
/// the slopes jumps there, as that of p|p|.
pub(crate) const KINK_ORDER: u32 = 3;

/// The roundings of t to which the time of a kink is known. A choice.
const TIME_ROUNDINGS: f64 = 64.0;
/// A function whose parabola through three points comes this near to zero, relative to the value
/// from which it descends, may pass it. A choice, between 0 and 1, for the error of the parabola.
const NEAR_ZERO: f64 = 0.25;
/// Values of a function below this share of its largest one in the run count as zero. A choice: a
/// motion that reaches so little beyond a kink stays there for a millionth of its own time scale.
const NOISE: f64 = 1e-12;

/// The error of the time of a kink.
pub(crate) fn time_rounding<T: Scalar>(t: T) -> f64 {
    TIME_ROUNDINGS * T::EPSILON * t.to_f64().abs()
}

/// The changes of q and p in the roundings of t to which the time of a kink is known, for slopes
/// `[q', p']` at the start and at the end of the step, of the first `free` degrees of freedom. No
/// step across a jump of the force is short enough for errors below them.
#[cold]
pub(crate) fn roundings_of_time<V: Vector>(
    t: V::Scalar,
    slopes: [[&V; 2]; 2],
    free: usize,
) -> [f64; 2] {
    let known = time_rounding(t);
    let [[v0, f0], [v1, f1]] = slopes.map(|ends| ends.map(|x| size_of_first_or_nan(x, free)));
    [larger_or_nan(v0, v1), larger_or_nan(f0, f1)].map(|slope| known * slope)
}

/// The functions at whose zeros a system has kinks, at the points of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kinks {
    /// The times of the points, which ascend, in units of the step.
    times: Vec<f64>,
    /// The values of all functions at the first point, at the second, and so on.
    values: Vec<f64>,
    /// The largest |value| of each function in the run.
    largest: Vec<f64>,
}

/// The kinks on the way of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// It passes none.
    Smooth,
    /// Its points are on both sides of a kink.
    Passed,
    /// It passes a kink and returns, or may do so between two points. The error estimate may miss
    /// what happens beyond the kink.
    Returned,
}

impl Kinks {
    /// Begins a step at (q, p). Returns whether the system has kinks.
    pub(crate) fn begin<T: Scalar, S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        q: &[T],
        p: &[T],
    ) -> bool {
        self.values.clear();
        system.kinks(q, p, &mut |x| self.values.push(x.to_f64()));
        if self.values.is_empty() {
            return false;
        }
        self.times.clear();
        self.largest.resize(self.values.len(), 0.0);
        self.end_point(0.0);
        true
    }

    /// Adds the point (q, p) at a time in units of the step.
    pub(crate) fn add<T: Scalar, S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        time: T,
        [q, p]: [&[T]; 2],
    ) {
        system.kinks(q, p, &mut |x| self.values.push(x.to_f64()));
        self.end_point(time.to_f64());
    }

    fn end_point(&mut self, time: f64) {
        self.times.push(time);
        // A system that passes another number of values is cut or filled to the first one.
        let count = self.largest.len();
        self.values.resize(self.times.len() * count, f64::NAN);
        let last = self.values.len() - count;
        for (largest, x) in self.largest.iter_mut().zip(&self.values[last..]) {
            *largest = largest.max(x.abs());
        }
    }

    /// Compares the values at the points of a step h from t. A step of roundings of t passes a
    /// kink: its stages may be beyond one that the points do not reach, and no shorter step shows
    /// more.
    pub(crate) fn passage<T: Scalar>(&self, h: T, t: T) -> Passage {
        if h.to_f64().abs() <= time_rounding(t) {
            return Passage::Passed;
        }
        let functions = || self.largest.iter().map(|largest| NOISE * largest).enumerate();
        let returns =
            |(k, noise)| self.changes_of_side(k, noise) > 1 || self.turns_near_zero(k, noise);
        if functions().any(returns) {
            Passage::Returned
        } else if functions()
            .any(|(k, noise)| self.changes_of_side(k, 0.0) > 0 || self.leaves_zero(k, noise))
        {
            Passage::Passed
        } else {
            Passage::Smooth
        }
    }

    /// Whether a step begins at a kink or shortly after it: a straight line through the first two
    /// values of a function reaches zero within one step before the start.
    pub(crate) fn begins_near(&self) -> bool {
        self.largest.iter().enumerate().any(|(k, largest)| {
            let mut points = self.points(k);
            let (Some((t0, x0)), Some((t1, x1))) = (points.next(), points.next()) else {
                return false;
            };
            let slope = (x1 - x0) / (t1 - t0);
            x1.abs() > NOISE * largest && x0 * slope >= 0.0 && x0.abs() <= slope.abs()
        })
    }

    /// The points with the values of function k.
    fn points(&self, k: usize) -> impl Iterator<Item = (f64, f64)> {
        let values = self.values.iter().skip(k).step_by(self.largest.len());
        self.times.iter().copied().zip(values.copied())
    }

    /// The number of sign changes of function k. Values up to `noise` are left out.
    fn changes_of_side(&self, k: usize, noise: f64) -> u32 {
        let (mut changes, mut before) = (0, 0.0);
        for (_, x) in self.points(k).filter(|(_, x)| x.abs() > noise) {
            changes += u32::from(x * before < 0.0);
            before = x.signum();
        }
        changes
    }

    /// Whether function k is zero at two successive points but not at all points, as x - ⌊x⌋ where
    /// x is a whole number to rounding for a while. A kink lies between.
    fn leaves_zero(&self, k: usize, noise: f64) -> bool {
        let zero = || self.points(k).map(|(_, x)| x.abs() <= noise);
        zero().zip(zero().skip(1)).any(|(a, b)| a && b) && !zero().all(|zero| zero)
    }

    /// Whether function k may pass zero and return between three successive points.
    fn turns_near_zero(&self, k: usize, noise: f64) -> bool {
        let ends = self.points(k).skip(2);
        let triples = self.points(k).zip(self.points(k).skip(1)).zip(ends);
        triples.into_iter().any(|((a, b), c)| turns_near_zero([a, b, c], noise))
    }
}

/// Whether the parabola through three points (t, x) on one side of zero turns between them, so near
/// to zero that the function may pass it. One that stays at zero from one point to the next does
/// not turn.
fn turns_near_zero([(t0, x0), (t1, x1), (t2, x2)]: [(f64, f64); 3], noise: f64) -> bool {
    let largest = x0.abs().max(x2.abs());
    let stays = x1.abs() <= noise && x0.abs().min(x2.abs()) <= noise;
    let slope = (x1 - x0) / (t1 - t0);
    let bend = ((x2 - x1) / (t2 - t1) - slope) / (t2 - t0);
    let turn = 0.5 * (t0 + t1 - slope / bend);
    let least = x0 + (turn - t0) * (slope + bend * (turn - t1));
    let side = x1.signum();
    largest > noise
        && !stays
        && side * bend > 0.0
        && t0 < turn
        && turn < t2
        && side * least < NEAR_ZERO * largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{DissipationForm, Passive};

    /// A system whose one kink is at q1 = 0.
    struct Wall;

    impl System<f64> for Wall {
        fn dof(&self) -> usize {
            1
        }
        fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
            q[0].abs() + 0.5 * p[0] * p[0]
        }
        fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
            (hq[0], hp[0]) = (q[0].signum(), p[0]);
        }
        fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
            d[0] = 0.0;
        }
        fn dissipation_form(&self) -> DissipationForm {
            DissipationForm { zero: true, passive: Passive::Each, ..DissipationForm::GENERAL }
        }
        fn kinks(&self, q: &[f64], _p: &[f64], put: &mut dyn FnMut(f64)) {
            put(q[0]);
        }
    }

    /// The passage of q(t) at five equally spaced times, from t = 0.
    fn passage(kinks: &mut Kinks, q: impl Fn(f64) -> f64) -> Passage {
        assert!(kinks.begin(&Wall, &[q(0.0)], &[0.0]));
        for t in [0.25, 0.5, 0.75, 1.0] {
            kinks.add(&Wall, t, [&[q(t)], &[0.0]]);
        }
        kinks.passage(1.0, 0.0)
    }

    #[test]
    fn a_motion_that_passes_a_kink_and_returns_is_found() {
        let mut kinks = Kinks::default();
        let mut of = |q: fn(f64) -> f64| passage(&mut kinks, q);
        assert_eq!(of(|t| t - 0.4), Passage::Passed);
        assert_eq!(of(|t| t + 0.4), Passage::Smooth);
        for turn in [0.1, 0.4, 0.6, 0.9] {
            for side in [1.0, -1.0] {
                let of = |depth: f64| {
                    passage(&mut Kinks::default(), |t| side * ((t - turn) * (t - turn) - depth))
                };
                assert_eq!(of(1e-4), Passage::Returned, "{turn}");
                assert_eq!(of(-1e-4), Passage::Returned, "{turn}: near, it may pass");
                assert_eq!(of(-0.1), Passage::Smooth, "{turn}");
                assert_eq!(of(0.02), Passage::Returned, "{turn}");
            }
        }
        assert_eq!(of(|t| 0.5 - t * t / 2.5), Passage::Smooth, "it turns away from zero");
    }

    #[test]
    fn a_step_that_begins_shortly_after_a_kink_is_found() {
        let begins_near = |q: fn(f64) -> f64| {
            let mut kinks = Kinks::default();
            passage(&mut kinks, q);
            kinks.begins_near()
        };
        assert!(begins_near(|t| t));
        assert!(begins_near(|t| -0.9 - t));
        assert!(begins_near(|t| 0.7 + t * (1.0 - t)), "it turns");
        assert!(!begins_near(|t| 1.1 + t));
        assert!(!begins_near(|t| 0.5 - 0.4 * t), "it comes nearer");
        assert!(!begins_near(|_| 0.0));
        assert!(!begins_near(|_| 1.0));
    }

    #[test]
    fn a_function_that_is_zero_for_a_while_and_jumps_is_passed() {
        for at in [0.1, 0.4, 0.9] {
            for (before, after) in [(0.0, 1.0), (1.0, 0.0), (-1.0, -1e-16), (0.0, 1.0 - 1e-16)] {
                let jump = |t: f64| if t < at { before } else { after };
                let found = passage(&mut Kinks::default(), jump);
                // With zero at one point only, the function may come from there.
                let zeros = [0.0, 0.25, 0.5, 0.75, 1.0].iter().filter(|t| jump(**t).abs() < 1e-15);
                let expected = if zeros.count() > 1 { Passage::Passed } else { Passage::Smooth };
                assert_eq!(found, expected, "{at}: {before} {after}");
            }
        }
        assert_eq!(passage(&mut Kinks::default(), |_| 0.0), Passage::Smooth);
    }

    #[test]
    fn so_short_a_step_passes() {
        let mut kinks = Kinks::default();
        let near = |t: f64| (t - 0.5) * (t - 0.5) - 1e-3;
        assert_eq!(passage(&mut kinks, near), Passage::Returned);
        assert_eq!(kinks.passage(1e-15, 1.0), Passage::Passed);
        assert_eq!(kinks.passage(1e-13, 1.0), Passage::Returned);
    }

    #[test]
    fn noise_near_zero_is_no_passage() {
        let mut kinks = Kinks::default();
        assert_eq!(passage(&mut kinks, |t| 1.0 + t), Passage::Smooth);
        let touch = |t: f64| 1e-13 * ((t - 0.6) * (t - 0.6) + 1e-3);
        assert_eq!(passage(&mut kinks, touch), Passage::Smooth);
        assert_eq!(passage(&mut Kinks::default(), touch), Passage::Returned);
    }
}
