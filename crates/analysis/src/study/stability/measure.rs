//! What is looked at along a run.
//!
//! Energies can't be compared in logarithm where H may be negative, as in a double well. What no system has negative is the size
//!
//! ```text
//! A = T/T_max + |q - c|²/Q²        T = ½ p·∂H/∂p        c = mean of q of the exact solution
//! ```
//!
//! with the largest T and |q| of the exact solution, Q = |q|_max, and its mean over the second half of the run as the centre c. The mean of
//! A over the second half tells decay, growth and the size of an oscillation, wherever it takes place; the mean of q
//! tells where: around which attractor, in which well. Of a harmonic oscillation A is constant, so that its mean does not depend on
//! the phase. Both are means over the same times of the run and of the exact solution, with weights sin² that vanish at the ends of the second half:
//! at which phase a run is cut off makes no difference.
//!
//! At most [`MOST_LOOKS`] times are looked at, equally spaced: a mean over 1024 points that are no nearer to each other than the steps has an error of
//! their discreteness only, and run and solution share it. Motion that repeats itself between two looks, a relaxation much shorter
//! than a thousandth of the run, is seen by chance; near h = half a period the looks themselves stand still, and phase is judged too.

use super::side::{Side, lane_of, put_lane};
use afterbay_core::{Mask, Passive, System, View};

/// The most times a run is looked at.
pub const MOST_LOOKS: u64 = 1024;

/// The steps of a run after which it is looked at.
#[derive(Clone, Debug)]
pub(super) struct Looks {
    /// Steps of the run.
    pub(super) count: u64,
    /// The first look, in the second half.
    pub(super) first: u64,
    /// Steps from one look to the next.
    pub(super) every: u64,
    /// Their weights, of sum 1. The last look is at the end.
    weights: Vec<f64>,
}

impl Looks {
    pub(super) fn new(count: u64) -> Self {
        let half = count / 2;
        let every = (count - half).div_ceil(MOST_LOOKS).max(1);
        let spaces = count.saturating_sub(half + 1) / every;
        let angle = std::f64::consts::PI / (spaces + 1) as f64;
        let weights: Vec<f64> = (0..=spaces).map(|i| ((i as f64 + 0.5) * angle).sin().powi(2)).collect();
        let sum: f64 = weights.iter().sum();
        let weights = weights.into_iter().map(|weight| weight / sum).collect();
        Self { count, first: count - spaces * every, every, weights }
    }

    /// The weight of the look after a step, if there is one.
    pub(super) fn weight(&self, step: u64) -> Option<f64> {
        let since = step.checked_sub(self.first)?;
        let index = usize::try_from(since / self.every).ok()?;
        if since.is_multiple_of(self.every) { self.weights.get(index).copied() } else { None }
    }

    /// The steps and their weights.
    pub(super) fn all(&self) -> impl Iterator<Item = (u64, f64)> {
        (0..).zip(&self.weights).map(|(i, &weight)| (self.first + i * self.every, weight))
    }
}

/// What sizes are measured by.
#[derive(Clone, Debug)]
pub(super) struct Scales<T> {
    /// 1/T_max, 0 where nothing moves.
    pub(super) by_kinetic: T,
    /// 1/Q²
    pub(super) by_reach: T,
    /// c
    pub(super) centre: Vec<T>,
}

/// What has been seen of a run so far.
#[derive(Clone, Debug)]
pub(super) struct Seen<T> {
    /// The mean of A.
    pub(super) size: T,
    /// The means of q.
    pub(super) mean: Vec<T>,
    /// The largest A.
    pub(super) largest: T,
    /// w when it was seen last.
    filled: Vec<T>,
    /// 1 where an entry of w, and their sum, has fallen beyond rounding, else 0.
    fallen: [T; 2],
}

impl<T: Side> Seen<T> {
    pub(super) fn nothing(dof: usize) -> Self {
        let zeros = || vec![T::zero(); dof];
        Self { size: T::zero(), mean: zeros(), largest: T::zero(), filled: zeros(), fallen: [T::zero(); 2] }
    }

    /// Takes in a state. `slopes` is room for ∂H/∂q and ∂H/∂p.
    #[inline]
    pub(super) fn look(
        &mut self,
        state: View<'_, T>,
        weight: f64,
        scales: &Scales<T>,
        system: &dyn System<T>,
        [hq, hp]: &mut [Vec<T>; 2],
    ) {
        system.gradient(state.q, state.p, hq, hp);
        let twice = state.p.iter().zip(hp.iter()).fold(T::zero(), |sum, (&p, &hp)| p.mul_add(hp, sum));
        let weight = T::from_f64(weight);
        let mut away = T::zero();
        for ((&q, &c), mean) in state.q.iter().zip(&scales.centre).zip(&mut self.mean) {
            away = (q - c).mul_add(q - c, away);
            *mean = weight.mul_add(q, *mean);
        }
        let size = (twice.half().abs() * scales.by_kinetic) + away * scales.by_reach;
        self.size = weight.mul_add(size, self.size);
        self.largest = T::select(self.largest.lt(size), size, self.largest);
    }

    /// Takes in the reservoir: what has fallen by more than its rounding has fallen.
    #[inline]
    pub(super) fn watch(&mut self, w: &[T]) {
        let rounding = T::from_f64(4.0 * T::EPSILON);
        let (mut sum, mut doubt, mut fallen) = (T::zero(), T::zero(), T::one().lt(T::zero()));
        for (&now, before) in w.iter().zip(&mut self.filled) {
            let (change, noise) = (now - *before, rounding * (now.abs() + before.abs()));
            fallen = fallen.or(change.lt(-noise));
            (sum, doubt) = (sum + change, doubt + noise);
            *before = now;
        }
        let [each, all] = self.fallen;
        self.fallen = [T::select(fallen, T::one(), each), T::select(sum.lt(-doubt), T::one(), all)];
    }

    /// One lane of it.
    pub(super) fn lane(&self, k: usize) -> Seen<f64> {
        Seen {
            size: self.size.lane(k),
            mean: lane_of(&self.mean, k),
            largest: self.largest.lane(k),
            filled: lane_of(&self.filled, k),
            fallen: self.fallen.map(|fallen| fallen.lane(k)),
        }
    }

    /// Puts one into a lane.
    pub(super) fn put(&mut self, k: usize, one: &Seen<f64>) {
        self.size = self.size.with(k, one.size);
        put_lane(&mut self.mean, k, &one.mean);
        self.largest = self.largest.with(k, one.largest);
        put_lane(&mut self.filled, k, &one.filled);
        put_lane(&mut self.fallen, k, &one.fallen);
    }
}

impl Seen<f64> {
    /// Has the reservoir given back what it is owed to keep?
    pub(super) fn robbed(&self, owed: Passive) -> bool {
        match owed {
            Passive::No => false,
            Passive::Each => self.fallen[0] > 0.0,
            Passive::InSum => self.fallen[1] > 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_in_the_second_half_and_end_with_the_run() {
        for count in [1, 2, 3, 50, 2047, 2048, 2049, 10_000, 1_000_001] {
            let looks = Looks::new(count);
            let all: Vec<_> = looks.all().collect();
            assert!(all.len() as u64 <= MOST_LOOKS && (count < 1000 || all.len() > 500), "{count}");
            assert!(2 * looks.first >= count, "{count}");
            assert_eq!(all.last().map(|look| look.0), Some(count));
            assert!((all.iter().map(|look| look.1).sum::<f64>() - 1.0).abs() < 1e-12);
            for (step, weight) in all {
                assert_eq!(looks.weight(step), Some(weight));
            }
            assert_eq!(looks.weight(looks.first - 1), None);
            assert_eq!(looks.weight(count + looks.every), None);
        }
    }

    #[test]
    fn what_falls_is_seen_and_what_is_rounded_is_not() {
        let mut seen = Seen::<f64>::nothing(2);
        seen.watch(&[1.0, 3.0]);
        seen.watch(&[1.0, 3.0 - f64::EPSILON]);
        assert!(!seen.robbed(Passive::Each));
        seen.watch(&[0.5, 4.0]);
        assert!(seen.robbed(Passive::Each) && !seen.robbed(Passive::InSum) && !seen.robbed(Passive::No));
        seen.watch(&[0.4, 4.0]);
        assert!(seen.robbed(Passive::InSum));
    }
}
