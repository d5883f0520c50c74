//! The rounding error of the forces near a state: its measurement, and the largest in a run.

use crate::second_derivatives::SecondDerivatives;
use afterbay_core::{Curvature, Scalar};

/// The longest interval, as a share of z. Over such intervals the second difference of a smooth
/// force is far below its rounding. It has no short binary fraction, because terms of few digits
/// have no rounding. A choice.
const LONGEST_SHARE: f64 = 6.180_339_887_498_949e-10;
/// The number of intervals, each half as long as the one before. A choice.
const INTERVALS: i32 = 8;
/// The ratio of the multiples of z at which the forces are measured, and their largest number: they
/// reach from a motion of 1e-16 to one of 1e-3. A choice.
const FARTHER: f64 = 16.0;
const MOST_MULTIPLES: usize = 12;
/// A difference that exceeds this times [`FARTHER`] times the one at the last multiple does not
/// grow with the force. A choice.
const LEAP: f64 = 4.0;
/// The ratio of the second derivatives at a multiple of z and at z beyond which a force is not
/// taken for linear. A choice.
const LARGEST_RATIO: f64 = 2.0;

/// The rounding of ∂H/∂q in a run, times 1/ε: the largest that was measured so far.
#[derive(Clone, Debug)]
pub(crate) struct ForceRounding<T> {
    largest: f64,
    /// The multiple of z, and the place at which the forces are evaluated.
    base: [Vec<T>; 2],
    place: [Vec<T>; 2],
    /// ∂H/∂q at the start, in the middle and at the end of an interval, and ∂H/∂p.
    slopes: [Vec<T>; 3],
    velocities: Vec<T>,
    /// The largest second difference of each ∂H/∂q_j, times 1/ε, and those at the last multiple.
    differences: [Vec<f64>; 2],
}

impl<T: Scalar> ForceRounding<T> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![T::zero(); n];
        Self {
            largest: 0.0,
            base: [zeros(), zeros()],
            place: [zeros(), zeros()],
            slopes: [zeros(), zeros(), zeros()],
            velocities: zeros(),
            differences: [vec![0.0; n], vec![0.0; n]],
        }
    }

    /// The largest so far.
    pub(crate) fn largest(&self) -> f64 {
        self.largest
    }

    /// Measures the rounding of ∂H/∂q at z = (q, p): the largest second difference over short
    /// intervals along z, in which up to four roundings add up.
    ///
    /// Near rest at 0 the terms of a force such as exp(q) - 1 do not change over an interval. Such
    /// a force is measured at the least multiple of z at which they do, as long as it is linear.
    #[cold]
    pub(crate) fn measure<S: Curvature<T> + ?Sized>(&mut self, system: &S, z: [&[T]; 2]) {
        for (base, z) in self.base.iter_mut().zip(z) {
            base.copy_from_slice(z);
        }
        let here = self.second_derivative(system);
        self.differentiate(system);
        self.largest = self.differences[0].iter().fold(self.largest, |most, x| most.max(*x));
        for _ in 0..MOST_MULTIPLES {
            self.base.iter_mut().flatten().for_each(|x| *x *= T::from_f64(FARTHER));
            let there = self.second_derivative(system);
            if !(there <= LARGEST_RATIO * here && here <= LARGEST_RATIO * there) {
                break;
            }
            self.differences.swap(0, 1);
            self.differentiate(system);
            let [next, last] = &self.differences;
            let leaps = next.iter().zip(last).filter(|(x, last)| **x > LEAP * FARTHER * **last);
            self.largest = leaps.fold(self.largest, |most, (x, _)| most.max(*x));
        }
    }

    fn second_derivative<S: Curvature<T> + ?Sized>(&self, system: &S) -> f64 {
        SecondDerivatives::at(system, &self.base[0], &self.base[1]).of_potential()
    }

    /// Computes the largest second difference of each ∂H/∂q_j at the multiple of z.
    fn differentiate<S: Curvature<T> + ?Sized>(&mut self, system: &S) {
        let Self { base, place, slopes, velocities, differences: [most, _], .. } = self;
        most.fill(0.0);
        for power in 0..INTERVALS {
            let share = LONGEST_SHARE * 2.0_f64.powi(-power);
            for (slopes, k) in slopes.iter_mut().zip([0.0, 1.0, 2.0]) {
                let factor = T::from_f64(share).mul_add(T::from_f64(k), T::one());
                for (place, base) in place.iter_mut().zip(&*base) {
                    place.iter_mut().zip(base).for_each(|(place, &base)| *place = factor * base);
                }
                system.gradient(&place[0], &place[1], slopes, velocities);
            }
            let [before, middle, after] = slopes;
            for (j, most) in most.iter_mut().enumerate() {
                let difference = (before[j] - middle[j]) + (after[j] - middle[j]);
                let rounding = difference.to_f64().abs() / T::EPSILON;
                if rounding > *most && rounding.is_finite() {
                    *most = rounding;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Formulas, FromFormulas};

    /// V = (1 - exp(-q))², whose force has the rounding of 1.
    struct Morse;

    impl Formulas for Morse {
        fn dof(&self) -> usize {
            1
        }

        fn potential<T: Scalar>(&self, q: &[T]) -> T {
            let rest = T::one() - (-q[0]).exp();
            rest * rest
        }

        fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
            T::zero()
        }
    }

    #[test]
    fn the_rounding_of_a_force_is_measured_at_any_distance_from_rest() {
        for power in 0..17 {
            let q = 0.3 * 10.0_f64.powi(-power);
            let mut rounding = ForceRounding::new(1);
            rounding.measure(&FromFormulas(Morse), [&[q], &[0.0]]);
            let found = rounding.largest();
            assert!((0.5..=16.0).contains(&found), "{found} at q = {q:e}");
        }
    }
}
