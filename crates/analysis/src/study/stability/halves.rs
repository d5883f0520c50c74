//! Means over the first and the second half of a run, which do not depend on its phase.

use crate::study::side::{Side, lane_of, put_lane};

/// The weighted means of z - z_0 and of its square over each half of a run, componentwise. The
/// weights of a half sum to 1.
#[derive(Clone, Debug)]
pub(super) struct Halves<T> {
    /// The means of each half, followed by the means of its squares.
    sums: Vec<T>,
}

impl<T: Side> Halves<T> {
    pub(super) fn nothing(size: usize) -> Self {
        Self { sums: vec![T::zero(); 4 * size] }
    }

    /// Adds an observation of z in one of the halves.
    #[inline]
    pub(super) fn add(&mut self, half: usize, weight: T, z: &[T], origin: &[T]) {
        let size = z.len();
        let (means, squares) = self.sums[2 * half * size..2 * (half + 1) * size].split_at_mut(size);
        for (((&z, &origin), mean), square) in z.iter().zip(origin).zip(means).zip(squares) {
            let off = z - origin;
            *mean = weight.mul_add(off, *mean);
            *square = (weight * off).mul_add(off, *square);
        }
    }

    pub(super) fn lane(&self, k: usize) -> Halves<f64> {
        Halves { sums: lane_of(&self.sums, k) }
    }

    pub(super) fn put(&mut self, k: usize, one: &Halves<f64>) {
        put_lane(&mut self.sums, k, &one.sums);
    }
}

impl Halves<f64> {
    /// The mean of z - z_0 over the second half.
    pub(super) fn last_mean(&self) -> &[f64] {
        let size = self.sums.len() / 4;
        &self.sums[2 * size..3 * size]
    }

    /// Whether each mean, and each root mean square about it, agrees with that of another run
    /// within the tolerance of its component.
    pub(super) fn agree(&self, other: &Self, allowed: &[f64]) -> bool {
        let size = allowed.len();
        (0..2).all(|half| {
            (0..size).all(|i| {
                let (mean, square) = (2 * half * size + i, (2 * half + 1) * size + i);
                let spread = |sums: &[f64]| (sums[square] - sums[mean].powi(2)).max(0.0).sqrt();
                let of_mean = (self.sums[mean] - other.sums[mean]).abs();
                let of_spread = (spread(&self.sums) - spread(&other.sums)).abs();
                of_mean <= allowed[i] && of_spread <= allowed[i]
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sin of a phase, with an amplitude, over both halves.
    fn waves(amplitude: f64, phase: f64) -> Halves<f64> {
        let mut halves = Halves::nothing(1);
        for half in 0..2 {
            for i in 0..100 {
                let z = amplitude * (0.5 * f64::from(i) + phase).sin();
                let weight =
                    ((f64::from(i) + 0.5) * std::f64::consts::PI / 100.0).sin().powi(2) / 50.0;
                halves.add(half, weight, &[z], &[0.0]);
            }
        }
        halves
    }

    #[test]
    fn phase_is_not_seen_and_amplitude_is() {
        let wave = waves(1.0, 0.0);
        assert!([0.3, 1.0, 2.5].iter().all(|&phase| wave.agree(&waves(1.0, phase), &[0.01])));
        assert!(!wave.agree(&waves(1.1, 0.0), &[0.01]) && !wave.agree(&waves(0.9, 1.0), &[0.01]));
    }
}
