//! A branch near a homoclinic orbit: the period grows without bound, `T ≈ -ln |λ - λ_c|/μ` with the
//! exponent μ of the saddle, while the cycle and the parameter hardly change any more.

/// The cycles over which the period must grow while all else stays. A choice.
const CYCLES: usize = 20;
/// The largest change of the parameter over these cycles, as a share of its range. A choice.
const UNCHANGED: f64 = 1e-5;
/// The largest change of a size over these cycles, relative to it, and the least of the period.
/// Choices: along other stretches on which λ hardly changes, at a fold or where a cycle grows at
/// once, its size changes as well.
const SAME_SIZE: f64 = 1e-3;
const LONGER: f64 = 1e-3;

/// The cycles since the parameter and the sizes last changed.
#[derive(Default)]
pub(super) struct Approach {
    since: Option<Since>,
}

/// The cycle from which on all but the period stays the same.
struct Since {
    value: f64,
    period: f64,
    sizes: Vec<f64>,
    /// The last period, and the number of cycles.
    last: f64,
    count: usize,
}

impl Approach {
    /// Takes the next cycle: the parameter as a share of its range, the period, and the sizes of q
    /// and p. Returns whether the period has grown alone for long enough.
    pub(super) fn see(&mut self, value: f64, period: f64, sizes: &[f64]) -> bool {
        let stays = |since: &Since| {
            let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_SIZE * b.abs();
            (value - since.value).abs() <= UNCHANGED
                && period > since.last
                && sizes.iter().zip(&since.sizes).all(same)
        };
        match self.since.as_mut().filter(|since| stays(since)) {
            Some(since) => {
                (since.last, since.count) = (period, since.count + 1);
                since.count >= CYCLES && period >= (1.0 + LONGER) * since.period
            }
            None => {
                let sizes = sizes.to_vec();
                self.since = Some(Since { value, period, sizes, last: period, count: 0 });
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cycle at which a branch of these values, periods and sizes ends.
    fn ends(at: impl Fn(f64) -> [f64; 3]) -> Option<i32> {
        let mut approach = Approach::default();
        (0..2000).find(|&n| {
            let [value, period, size] = at(f64::from(n));
            approach.see(value, period, &[size])
        })
    }

    #[test]
    fn only_a_period_that_grows_alone_ends_a_branch() {
        // The distance falls by a twentieth from cycle to cycle.
        let near = |n: f64| 0.4 * 0.95_f64.powf(n);
        let found = ends(|n| [near(n), 5.0 - near(n).ln(), 2.0 - near(n)]);
        assert!(found.is_some_and(|n| near(f64::from(n)) < UNCHANGED), "{found:?}");
        // A fold at n = 1000, at which the period grows and the size does too.
        let fold = |n: f64| 1e-6 * (n - 1000.0).powi(2);
        assert_eq!(ends(|n| [fold(n), 5.0 + 1e-3 * n, 1.0 + 1e-3 * n]), None);
        // A cycle that grows at once.
        assert_eq!(ends(|n| [0.3, 5.0 + 0.01 * n, 1.0 + 0.01 * n]), None);
        // A branch along which only the parameter changes.
        assert_eq!(ends(|n| [1e-4 * n, 5.0, 1.0]), None);
    }
}
