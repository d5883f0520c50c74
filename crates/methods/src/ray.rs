//! H and ∇H·z along the ray through a state z = (q, p): the change of H over an interval, compared
//! with the integral of its slope.

use crate::legendre::{gauss, narrow};
use afterbay_core::{Quad, Scalar, System};
use std::sync::LazyLock;

/// The number of nodes of the rule, even.
const NODES: usize = 6;
/// Nodes and weights of the Gauss-Legendre rule on [0, 1].
static RULE: LazyLock<Vec<[Quad; 2]>> = LazyLock::new(|| {
    let place = |x: Quad, weight: Quad| [(Quad::ONE + x).half(), weight];
    gauss(NODES).into_iter().flat_map(|[x, weight]| [place(-x, weight), place(x, weight)]).collect()
});

/// Memory for a point and ∇H there.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T> {
    at: [Vec<T>; 2],
    slope: [Vec<T>; 2],
}

impl<T: Scalar> Memory<T> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || [(); 2].map(|()| vec![T::zero(); n]);
        Self { at: zeros(), slope: zeros() }
    }
}

/// The points scale z (1 + share).
pub(crate) struct Ray<'a, T, S: ?Sized> {
    pub(crate) system: &'a S,
    pub(crate) z: [&'a [T]; 2],
    pub(crate) scale: f64,
    pub(crate) memory: &'a mut Memory<T>,
}

impl<T: Scalar, S: System<T> + ?Sized> Ray<'_, T, S> {
    /// Moves to the point at a share.
    fn go(&mut self, share: T) {
        let factor = T::from_f64(self.scale) * (T::one() + share);
        for (at, z) in self.memory.at.iter_mut().zip(self.z) {
            at.iter_mut().zip(z).for_each(|(at, &z)| *at = factor * z);
        }
    }

    /// H at a share.
    fn energy(&mut self, share: f64) -> T {
        self.go(T::from_f64(share));
        let [q, p] = &self.memory.at;
        self.system.energy(q, p)
    }

    /// The integral of ∇H·z, with z scaled, over the shares between two, and the largest sum of its
    /// terms.
    fn rise(&mut self, [from, to]: [f64; 2]) -> (T, f64) {
        let (mut integral, mut largest) = (T::zero(), 0.0_f64);
        let (scale, from, length) =
            (T::from_f64(self.scale), T::from_f64(from), T::from_f64(to - from));
        for &[node, weight] in RULE.iter() {
            self.go(narrow::<T>(node).mul_add(length, from));
            let Memory { at: [q, p], slope: [hq, hp] } = &mut *self.memory;
            self.system.gradient(q, p, hq, hp);
            let products = self.z[0].iter().zip(&*hq).chain(self.z[1].iter().zip(&*hp));
            let (mut sum, mut size) = (T::zero(), T::zero());
            for (&z, &slope) in products {
                let term = scale * z * slope;
                sum += term;
                size += term.abs();
            }
            integral += narrow::<T>(weight) * length * sum;
            largest = largest.max(size.to_f64());
        }
        (integral, largest)
    }
}

/// The change of H over an interval of shares less the integral of its slope.
pub(crate) struct Difference {
    pub(crate) size: f64,
    /// The change of H, and the integral.
    pub(crate) changes: [f64; 2],
    /// A bound of the terms of ∇H·z.
    pub(crate) slopes: f64,
    /// A bound of the terms of H and of ∇H·z.
    pub(crate) terms: f64,
    /// Whether the integral is good to a sixteenth of the difference, and both are finite.
    pub(crate) resolved: bool,
}

impl<T: Scalar, S: System<T> + ?Sized> Ray<'_, T, S> {
    /// The difference over an interval, by two rules.
    pub(crate) fn difference(&mut self, [from, to]: [f64; 2]) -> Difference {
        let middle = 0.5 * (from + to);
        let (rise, slopes) = self.rise([from, to]);
        let finer = self.rise([from, middle]).0 + self.rise([middle, to]).0;
        let (before, after) = (self.energy(from), self.energy(to));
        let change = after - before;
        let size = (change - finer).abs().to_f64();
        let terms = before.abs().to_f64() + after.abs().to_f64() + slopes;
        Difference {
            size,
            changes: [change.to_f64(), finer.to_f64()],
            slopes,
            terms,
            resolved: size.is_finite() && (rise - finer).abs().to_f64() <= size / 16.0,
        }
    }
}
