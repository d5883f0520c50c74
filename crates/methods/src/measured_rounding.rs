//! The rounding error of H near a state: its measurement, the largest in a run, and the rounding of
//! the forces that follows from it.

use afterbay_core::{Scalar, StepFailure, System};

/// Nodes and weights of the Gauss-Legendre rule of five points on [0, 1], to 15 digits: an estimate
/// needs no more.
/// M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, table 25.4.
const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];
/// The error of H, in roundings of |H| and of the terms of ∇H·z, that needs no cancellation: below
/// all bounds of the change of K, which are 16 of these roundings or more, so that no step falls
/// between the two. A choice.
const EXPLAINED_ROUNDINGS: f64 = 4.0;
/// The ratio of the bound of the rounding error to the largest of those measured. A choice: there
/// are few of them.
const BOUND_OVER_MEASURED: f64 = 4.0;

/// The ratio of a difference to those over shorter intervals from which on it may be no rounding. A
/// choice: roundings of neighbouring intervals are alike, or proportional to the length.
const LARGEST_LEAP: f64 = 16.0;
/// The number of times that the interval of a difference is halved, down to 2^-34 to 2^-50 of z. A
/// choice.
const HALVINGS: u32 = 30;
/// The share of a difference that must be left in the larger half of its interval. It is half where
/// both integrals are right, since the differences of the halves add up, and they are right to a
/// sixteenth.
const LEAST_PART: f64 = 3.0 / 8.0;

/// The error of ∇H·z, as a share of its terms, from which on ∇H may not be the gradient of H. A
/// choice: mistakes are larger. Roundings of ∇H of this size differ from node to node, so that the
/// integral is not resolved.
const LARGEST_SLOPE_ERROR: f64 = 1e-8;
/// The number of times that z is doubled at most. A choice: from the least number whose square is
/// normal, 1e-154, to beyond 1.
const DOUBLINGS: i32 = 520;
/// The number of doublings that tell. A choice: features of H that end it near z are rare.
const FEWEST_DOUBLINGS: i32 = 5;

/// Memory for a point and ∇H there.
#[derive(Clone, Debug)]
struct Memory<T> {
    at: [Vec<T>; 2],
    slope: [Vec<T>; 2],
}

impl<T: Scalar> Memory<T> {
    fn new(n: usize) -> Self {
        let zeros = || [(); 2].map(|()| vec![T::zero(); n]);
        Self { at: zeros(), slope: zeros() }
    }
}

/// The points scale z (1 + share).
struct Ray<'a, T, S: ?Sized> {
    system: &'a S,
    z: [&'a [T]; 2],
    scale: f64,
    memory: &'a mut Memory<T>,
}

impl<T: Scalar, S: System<T> + ?Sized> Ray<'_, T, S> {
    /// Moves to the point at a share.
    fn go(&mut self, share: f64) {
        let factor = T::from_f64(self.scale * (1.0 + share));
        for (at, z) in self.memory.at.iter_mut().zip(self.z) {
            at.iter_mut().zip(z).for_each(|(at, &z)| *at = factor * z);
        }
    }

    /// H at a share.
    fn energy(&mut self, share: f64) -> T {
        self.go(share);
        let [q, p] = &self.memory.at;
        self.system.energy(q, p)
    }

    /// The integral of ∇H·z, with z scaled, over the shares between two, and the largest sum of its
    /// terms.
    fn rise(&mut self, [from, to]: [f64; 2]) -> [f64; 2] {
        let (mut integral, mut largest) = (0.0, 0.0_f64);
        let scale = T::from_f64(self.scale);
        for (node, weight) in GAUSS_LEGENDRE {
            self.go(from + node * (to - from));
            let Memory { at: [q, p], slope: [hq, hp] } = &mut *self.memory;
            self.system.gradient(q, p, hq, hp);
            let products = self.z[0].iter().zip(&*hq).chain(self.z[1].iter().zip(&*hp));
            let (mut sum, mut size) = (T::zero(), T::zero());
            for (&z, &slope) in products {
                let term = scale * z * slope;
                sum += term;
                size += term.abs();
            }
            integral += weight * (to - from) * sum.to_f64();
            largest = largest.max(size.to_f64());
        }
        [integral, largest]
    }
}

/// The change of H over an interval of shares less the integral of its slope.
struct Difference {
    size: f64,
    /// The change of H, and the integral.
    changes: [f64; 2],
    /// A bound of the terms of ∇H·z.
    slopes: f64,
    /// A bound of the terms of H and of ∇H·z.
    terms: f64,
    /// Whether the integral is good to a sixteenth of the difference, and both are finite.
    resolved: bool,
}

impl<T: Scalar, S: System<T> + ?Sized> Ray<'_, T, S> {
    /// The difference over an interval, by two rules.
    fn difference(&mut self, [from, to]: [f64; 2]) -> Difference {
        let middle = 0.5 * (from + to);
        let [rise, slopes] = self.rise([from, to]);
        let finer = self.rise([from, middle])[0] + self.rise([middle, to])[0];
        let (before, after) = (self.energy(from), self.energy(to));
        let change = (after - before).to_f64();
        let size = (change - finer).abs();
        let terms = before.abs().to_f64() + after.abs().to_f64() + slopes;
        Difference {
            size,
            changes: [change, finer],
            slopes,
            terms,
            resolved: size.is_finite() && (rise - finer).abs() <= size / 16.0,
        }
    }

    /// Whether a difference over an interval remains as the interval is halved, as a rounding does.
    /// That of a thin wall that no node has met dissolves.
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

    /// Checks that ∇H·z is the slope of H. An error is a large part of it, proportional to the
    /// interval, and no rounding.
    fn check_slope(&mut self) -> Result<(), StepFailure> {
        let [long, middle, short] =
            [4, 8, 12].map(|power| self.difference([0.0, 2.0_f64.powi(-power)]));
        let large = long.size > LARGEST_SLOPE_ERROR * 2.0_f64.powi(-4) * long.slopes;
        let sizes = [long.size, 16.0 * middle.size, 256.0 * short.size];
        let proportional = sizes.iter().all(|size| (size / long.size - 1.0).abs() < 0.25);
        if !(long.resolved && large && proportional) || self.becomes_noise() {
            return Ok(());
        }
        let [rise, integral] = long.changes;
        Err(StepFailure::NotGradient { integral, rise })
    }

    /// Whether the difference becomes irregular as z is doubled again and again, while it is still a
    /// large part of the slope, as that of terms which cancel does: where 1 - cos q is 0 for a small
    /// q, its rounding is all of q²/2, and for a larger q it is that of 1. That of a wrong gradient
    /// stays proportional to the interval. True where H ends too soon to tell.
    fn becomes_noise(&mut self) -> bool {
        let begin = self.scale;
        let verdict = (0..DOUBLINGS).find_map(|doubling| {
            self.scale = begin * 2.0_f64.powi(doubling);
            let [long, short] = [4, 12].map(|power| self.difference([0.0, 2.0_f64.powi(-power)]));
            if !(long.size.is_finite() && short.size.is_finite()) {
                return Some(doubling < FEWEST_DOUBLINGS);
            }
            let irregular = 256.0 * short.size > LARGEST_LEAP * long.size;
            let large = short.size > LARGEST_SLOPE_ERROR * 2.0_f64.powi(-12) * short.slopes;
            irregular.then_some(large)
        });
        self.scale = begin;
        verdict.unwrap_or(false)
    }
}

/// The rounding error of H near z = (q, p), times 1/ε, that cancellation between its terms causes,
/// or `largest` if that is larger: the largest difference between the change of H when z grows by a
/// share of itself and the integral of its slope. It is 0 where |H| and the terms of ∇H·z explain
/// the difference.
///
/// Terms that cancel inside H, as in 1 - cos q, leave an error that |H| does not bound, and only a
/// measurement shows it. The shares are 2^-4 to 2^-20, so that H changes by more than one unit in
/// the last place of its terms unless z is nearly at rest. A difference far above those of smaller
/// shares counts only if it remains as the interval is halved. In scalars of more than 53 bits
/// nothing is measured.
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
    // The rule has 16 digits.
    if T::IS_EXTENDED {
        return Ok(largest);
    }
    let mut ray = Ray { system, z: [q, p], scale: 1.0, memory };
    ray.check_slope()?;
    let (mut most, mut usual) = (largest * T::EPSILON / BOUND_OVER_MEASURED, 0.0_f64);
    for power in (4..21).rev() {
        let interval = [0.0, 2.0_f64.powi(-power)];
        let Difference { size, terms, resolved, .. } = ray.difference(interval);
        // A wall is met from one share on, with a leap.
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

/// Checks that ∇H·(q, p) is the slope of H.
///
/// # Errors
/// [`StepFailure::NotGradient`]
#[cold]
pub(crate) fn check_gradient<T: Scalar, S: System<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> Result<(), StepFailure> {
    if T::IS_EXTENDED {
        return Ok(());
    }
    Ray { system, z: [q, p], scale: 1.0, memory: &mut Memory::new(q.len()) }.check_slope()
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

    /// The largest so far.
    pub(crate) fn largest(&self) -> f64 {
        self.largest
    }

    /// The rounding of the forces, times 1/ε, where H has the value `energy` and second derivatives
    /// up to `second`. It is an estimate by dimensions: a term H of the second derivative H'' has a
    /// slope of about √(H H'').
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
