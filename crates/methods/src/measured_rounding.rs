//! The rounding error of H near a state: its measurement, the largest in a run, and the rounding of
//! the forces that follows from it.

use crate::gradient_check::{EXPLAINED_ROUNDINGS, check_slope};
use crate::ray::{Difference, Memory, Ray};
use afterbay_core::{Scalar, StepFailure, System};

/// The ratio of the bound of the rounding error to the largest error measured. A choice: few errors
/// are measured, and others may be larger.
const BOUND_OVER_MEASURED: f64 = 4.0;

/// The longest interval, as a share of z. The others are shorter by powers of two. A choice: a
/// number without a short binary fraction, because terms of few digits have no rounding, as those of
/// q²/2 - 2q + 2 at q = 2 + 2^-k.
const LONGEST_SHARE: f64 = 0.061_803_398_874_989_49;
/// The number of intervals on each side of z.
const INTERVALS: i32 = 17;
/// A difference that exceeds those over shorter intervals by this factor may not be rounding. A
/// choice: roundings of neighbouring intervals are alike, or proportional to the length.
const LARGEST_LEAP: f64 = 16.0;
/// The number of times that the interval of a difference is halved, down to 2^-34 to 2^-50 of z. A
/// choice.
const HALVINGS: u32 = 30;
/// One half of an interval must contain at least this share of its difference. With exact integrals
/// the differences of the halves add up, so that the share is at least 1/2. The integrals are exact
/// to a sixteenth.
const LEAST_PART: f64 = 3.0 / 8.0;

impl<T: Scalar, S: System<T> + ?Sized> Ray<'_, T, S> {
    /// Whether a difference over an interval remains as the interval is halved, as a rounding does.
    /// A difference caused by a narrow feature of H between the nodes vanishes.
    fn is_rounding(&mut self, [mut from, mut to]: [f64; 2], mut size: f64) -> bool {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            let [left, right] = [[from, middle], [middle, to]].map(|part| self.difference(part));
            let larger = if left.size < right.size {
                from = middle;
                right
            } else {
                to = middle;
                left
            };
            if !larger.resolved || larger.size < LEAST_PART * size {
                return false;
            }
            size = larger.size;
        }
        true
    }
}

/// The rounding error of H near z = (q, p), times 1/ε, that cancellation between its terms causes,
/// or `largest` if that is larger: the largest difference between the change of H when z grows or
/// shrinks by a share of itself and the integral of its slope. It is 0 where |H| and the terms of
/// ∇H·z explain the difference.
///
/// Terms that cancel inside H, as in 1 - cos q, leave an error that |H| does not bound, and only a
/// measurement shows it. The shares are [`LONGEST_SHARE`] to 2^-16 times that, so that H changes by
/// more than one unit in the last place of its terms unless z is nearly at rest. Both signs count,
/// because the terms may be exact on one side of a power of two alone: q²/2 - 2q + 2, computed as
/// q(q/2 - 2) + 2 with one rounding, is exact where 2 ≤ q < 4. A difference far above those of
/// smaller shares counts only if it remains as the interval is halved.
///
/// # Errors
/// [`StepFailure::NotGradient`]
#[cold]
fn measure<T: Scalar, S: System<T> + ?Sized>(
    system: &S,
    [q, p]: [&[T]; 2],
    memory: &mut Memory<T>,
    largest: f64,
) -> Result<f64, StepFailure> {
    let mut ray = Ray { system, z: [q, p], scale: 1.0, memory };
    check_slope(&mut ray)?;
    let (mut most, mut usual) = (largest * T::EPSILON / BOUND_OVER_MEASURED, 0.0_f64);
    let shares = (0..INTERVALS).rev().map(|power| LONGEST_SHARE * 2.0_f64.powi(-power));
    for interval in shares.flat_map(|share| [[0.0, share], [-share, 0.0]]) {
        let Difference { size, terms, resolved, .. } = ray.difference(interval);
        // A narrow feature of H makes the difference jump once the interval contains it.
        let leaps = size > LARGEST_LEAP * usual && size > most;
        if !resolved || (leaps && !ray.is_rounding(interval, size)) {
            continue;
        }
        usual = usual.max(size);
        if size > EXPLAINED_ROUNDINGS * T::EPSILON * terms {
            most = most.max(size);
        }
    }
    Ok(BOUND_OVER_MEASURED * most / T::EPSILON)
}

/// [`measure`] where a few allocations do not matter.
#[cold]
pub(crate) fn measured_rounding<T: Scalar, S: System<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> Result<f64, StepFailure> {
    measure(system, [q, p], &mut Memory::new(q.len()), 0.0)
}

/// The rounding of H in a run, times 1/ε: the largest that was measured so far. It is kept because
/// a measurement finds nothing where the terms of H happen to be exact, as at q = 0 in 1 - cos q.
#[derive(Clone, Debug)]
pub(crate) struct EnergyRounding<T> {
    largest: f64,
    memory: Memory<T>,
}

impl<T: Scalar> EnergyRounding<T> {
    pub(crate) fn new(n: usize) -> Self {
        Self { largest: 0.0, memory: Memory::new(n) }
    }

    /// Measures the rounding of H at (q, p), and returns the largest so far.
    ///
    /// # Errors
    /// [`StepFailure::NotGradient`]
    #[cold]
    pub(crate) fn measure<S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        q: &[T],
        p: &[T],
    ) -> Result<f64, StepFailure> {
        self.largest = measure(system, [q, p], &mut self.memory, self.largest)?;
        Ok(self.largest)
    }

    /// Whether `accepts` holds with the largest rounding so far or, since a measurement takes about
    /// 700 gradients, only then with one measured at z = (q, p).
    ///
    /// # Errors
    /// [`StepFailure::NotGradient`]
    #[cold]
    pub(crate) fn allows<S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        [q, p]: [&[T]; 2],
        accepts: impl Fn(&Self) -> bool,
    ) -> Result<bool, StepFailure> {
        if accepts(self) {
            return Ok(true);
        }
        self.measure(system, q, p)?;
        Ok(accepts(self))
    }

    /// The largest so far.
    pub(crate) fn largest(&self) -> f64 {
        self.largest
    }

    /// The rounding of the forces, times 1/ε, where H has the value `energy` and second derivatives
    /// by q up to `second`. It is an estimate by dimensions: a term H of the second derivative H''
    /// has a slope of about √(H H'').
    pub(crate) fn of_forces(&self, energy: f64, second: f64) -> f64 {
        // The product of the two may overflow where this does not.
        (energy.abs() + self.largest).sqrt() * second.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Formulas, FromFormulas};

    /// V = 1 - cos q, or a wall 10⁻⁶/(q - 1)².
    #[derive(Clone, Copy, PartialEq)]
    enum Potential {
        Pendulum,
        Wall,
    }

    impl Formulas for Potential {
        fn dof(&self) -> usize {
            1
        }
        fn potential<T: Scalar>(&self, q: &[T]) -> T {
            let distance = q[0] - T::one();
            match self {
                Self::Pendulum => T::one() - q[0].sin_cos().1,
                Self::Wall => T::from_f64(1e-6) / (distance * distance),
            }
        }
        fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
            T::zero()
        }
    }

    #[test]
    fn a_rounding_is_measured_and_a_wall_is_not() {
        for distance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
            for n in 0..50 {
                let near = distance * (1.0 + f64::from(n) / 50.0);
                let rounding = |potential: Potential, q: f64| {
                    measured_rounding(&FromFormulas(potential), &[q], &[0.0]).expect("a gradient")
                };
                let found = rounding(Potential::Pendulum, near);
                // V is exact to half a unit in the last place of 1, which is ε.
                assert!((0.1..=16.0).contains(&found), "{found} at q = {near}");
                let found = rounding(Potential::Wall, 1.0 - near);
                assert!(found <= 1e3, "{found} at {near} from the wall");
            }
        }
    }
}
