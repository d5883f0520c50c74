//! The reach of a Taylor polynomial, estimated from all of its coefficients.

use crate::numbers::{Scalar, Series, larger_or_nan};

/// The largest absolute value of each coefficient among several series.
pub(super) fn sizes<T: Scalar, const M: usize>(part: &[Series<T, M>]) -> [f64; M] {
    std::array::from_fn(|k| {
        let entries = part.iter().map(|x| x.c[k].abs().to_f64());
        entries.fold(0.0, larger_or_nan)
    })
}

/// An estimate of the time τ up to which the terms left out, from `a_M τ^M` on, are below the share
/// `epsilon` of the largest term; 0 if a coefficient is not finite.
///
/// The terms after a leading one, `a_i`, are assumed to be bounded by a geometric series with the
/// ratio `max_k (a_k/a_i)^{1/(k-i)}` over the last coefficients. The leading term of the first half
/// that gives the longest time is used. The last coefficients are those of the last quarter; if
/// they all vanish, those of the last half; then all, since a series may have every fourth, eighth
/// or twentieth power only. The estimate is infinite if all coefficients beyond the second vanish:
/// only the [defect](super::Defect) shows how far such a polynomial is a solution.
pub(super) fn reach<const M: usize>(sizes: &[f64; M], epsilon: f64) -> f64 {
    if !sizes.iter().all(|size| size.is_finite()) {
        return 0.0;
    }
    // The first k of a part of the coefficients, and the first whose coefficient is not 0.
    let last = |from: usize| Some((from, (from..M).find(|&k| sizes[k] > 0.0)?));
    let Some((from, first)) = [M - M / 4, M - M / 2, 2].into_iter().find_map(last) else {
        return f64::INFINITY;
    };
    let led_by = |i: usize| {
        let root = |k: usize| (sizes[i] / sizes[k]).powf(1.0 / (k - i) as f64);
        let radius = (from.max(i + 1)..M)
            .filter(|&k| sizes[k] > 0.0)
            .map(root)
            .fold(f64::INFINITY, f64::min);
        epsilon.powf(1.0 / (M - i) as f64) * radius
    };
    let leads = (0..(M / 2).min(from)).filter(|&i| sizes[i] > 0.0);
    let reach = leads.map(led_by).fold(0.0, f64::max);
    // If there are only later terms, the first of them leads.
    if reach > 0.0 {
        reach
    } else {
        epsilon.powf(1.0 / M as f64) * sizes[first].powf(-1.0 / first as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPSILON: f64 = 1e-32;

    fn estimate(size: impl Fn(usize) -> f64) -> f64 {
        reach::<24>(&std::array::from_fn(size), EPSILON)
    }

    /// A coefficient that is no number is not hidden by those of other degrees of freedom.
    #[test]
    fn coefficients_that_are_none_have_no_reach() {
        let good = Series::<f64, 24>::new(std::array::from_fn(|k| 0.5_f64.powi(k as i32)));
        for bad in [f64::NAN, f64::INFINITY] {
            let mut other = good;
            other.c[7] = bad;
            for part in [[other, good], [good, other]] {
                assert_eq!(reach(&sizes(&part), EPSILON), 0.0);
            }
        }
    }

    /// 1/(1 - (τ/3)^period) without the terms left out: they are τ^24/3^24 and beyond.
    #[test]
    fn gaps_do_not_look_like_an_end() {
        for period in 1..=23 {
            for shift in 0..=1 {
                let lacunary =
                    |k: usize| if k % period == shift { 3.0_f64.powi(-(k as i32)) } else { 0.0 };
                if period == 1 && shift == 1 || period + shift > 23 {
                    continue;
                }
                let found = estimate(lacunary);
                let ideal = 3.0 * EPSILON.powf(1.0 / 24.0);
                assert!(
                    found > 0.5 * ideal && found < 1.3 * ideal,
                    "{period} {shift}: {found} {ideal}"
                );
            }
        }
    }

    #[test]
    fn units_of_time_and_size_do_not_count() {
        let of = |unit: f64, size: f64| {
            estimate(|k| if k % 3 == 1 { size * unit.powi(k as i32) } else { 0.0 }) * unit
        };
        let one = of(1.0, 1.0);
        for (unit, size) in [(1e-5, 1.0), (1e5, 1e-20), (10.0, 1e30)] {
            assert!((of(unit, size) / one - 1.0).abs() < 1e-9, "{unit} {size}");
        }
    }

    #[test]
    fn only_constants_and_straight_lines_have_no_end() {
        assert_eq!(estimate(|k| if k < 2 { 1.0 } else { 0.0 }), f64::INFINITY);
        assert_eq!(estimate(|_| 0.0), f64::INFINITY);
        for k in 2..24 {
            assert!(estimate(|i| f64::from(i == 0 || i == k)) < 1.0, "{k}");
            assert!(estimate(|i| f64::from(i == k)) < 1.0, "{k} alone");
        }
        assert_eq!(estimate(|k| if k == 9 { f64::NAN } else { 1.0 }), 0.0);
    }

    /// Σ τ^k/k! with 24 terms: the first left out is τ^24/24!.
    #[test]
    fn an_entire_function_reaches_as_far_as_its_last_terms_allow() {
        let mut factorials = [1.0; 25];
        (1..25).for_each(|k| factorials[k] = factorials[k - 1] * k as f64);
        let found = estimate(|k| 1.0 / factorials[k]);
        let ideal = (EPSILON * factorials[24]).powf(1.0 / 24.0);
        assert!(found > 0.7 * ideal && found < ideal, "{found} {ideal}");
    }
}
