//! The rounding error of H, measured.

use afterbay_core::{Scalar, System};

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
/// The error of H, in roundings of |H| and of the terms of ∇H·z, that needs no cancellation.
const EXPLAINED_ROUNDINGS: f64 = 256.0;
/// The ratio of the bound of the rounding error to the largest of those measured. A choice: there
/// are few of them.
const BOUND_OVER_MEASURED: f64 = 4.0;

/// Vectors that a measurement overwrites.
pub(crate) struct Scratch<'a, T> {
    pub(crate) q: &'a mut [T],
    pub(crate) p: &'a mut [T],
    pub(crate) hq: &'a mut [T],
    pub(crate) hp: &'a mut [T],
}

impl<T: Scalar> Scratch<'_, T> {
    /// z grown by a share of itself.
    fn grow(&mut self, [q, p]: [&[T]; 2], share: f64) {
        let factor = T::from_f64(1.0 + share);
        self.q.iter_mut().zip(q).for_each(|(to, &z)| *to = factor * z);
        self.p.iter_mut().zip(p).for_each(|(to, &z)| *to = factor * z);
    }

    /// The integral of ∇H·z over the shares between two, and the largest sum of its terms.
    fn rise<S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        z: [&[T]; 2],
        [from, to]: [f64; 2],
    ) -> [f64; 2] {
        let (mut integral, mut largest) = (0.0, 0.0_f64);
        for (node, weight) in GAUSS_LEGENDRE {
            self.grow(z, from + node * (to - from));
            system.gradient(self.q, self.p, self.hq, self.hp);
            let products = z[0].iter().zip(&*self.hq).chain(z[1].iter().zip(&*self.hp));
            let (mut sum, mut size) = (T::zero(), T::zero());
            for (&z, &slope) in products {
                sum += z * slope;
                size += (z * slope).abs();
            }
            integral += weight * (to - from) * sum.to_f64();
            largest = largest.max(size.to_f64());
        }
        [integral, largest]
    }
}

/// The rounding error of H near z = (q, p), times 1/ε, that cancellation between its terms causes:
/// the largest difference between the change of H when z grows by a share of itself and the
/// integral of its slope. It is 0 where |H| and the terms of ∇H·z explain the difference.
///
/// Terms that cancel inside H, as in 1 - cos q, leave an error that |H| does not bound, and only a
/// measurement shows it. The shares are 2^-4 to 2^-20, so that H changes by more than one unit in
/// the last place of its terms unless z is nearly at rest. A share counts only if twice as many
/// nodes give nearly the same integral, and both are finite. In scalars of more than 53 bits
/// nothing is measured.
#[cold]
pub(crate) fn grain<T: Scalar, S: System<T> + ?Sized>(
    system: &S,
    z: [&[T]; 2],
    mut scratch: Scratch<'_, T>,
) -> f64 {
    // The rule has 16 digits.
    if T::EPSILON < f64::EPSILON / 4.0 {
        return 0.0;
    }
    let here = system.energy(z[0], z[1]);
    let mut most = 0.0_f64;
    for power in 4..21 {
        let share = 2.0_f64.powi(-power);
        let [rise, size] = scratch.rise(system, z, [0.0, share]);
        let halves = [[0.0, 0.5 * share], [0.5 * share, share]];
        let finer: f64 = halves.iter().map(|part| scratch.rise(system, z, *part)[0]).sum();
        scratch.grow(z, share);
        let end = system.energy(scratch.q, scratch.p);
        let off = ((end - here).to_f64() - finer).abs();
        let terms = here.abs().to_f64() + end.abs().to_f64() + size;
        let explained = EXPLAINED_ROUNDINGS * T::EPSILON * terms;
        if off.is_finite() && off > explained && (rise - finer).abs() <= off / 16.0 {
            most = most.max(off);
        }
    }
    BOUND_OVER_MEASURED * most / T::EPSILON
}

/// [`grain`] where a few allocations do not matter.
#[cold]
pub(crate) fn grain_at<T: Scalar, S: System<T> + ?Sized>(system: &S, q: &[T], p: &[T]) -> f64 {
    let [mut a, mut b, mut c, mut d] = [(); 4].map(|()| vec![T::zero(); q.len()]);
    grain(system, [q, p], Scratch { q: &mut a, p: &mut b, hq: &mut c, hp: &mut d })
}
