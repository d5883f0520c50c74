//! A lower bound of the time to the first kink.

use crate::numbers::{Scalar, Series};

/// A time up to which the series has no zero, infinite if it has none up to `limit`: the zero of
///
/// ```text
/// |x_0| + s x_1 τ - Σ_{k≥2} max(0, -s x_k) τ^k ≤ s x(τ)        s = sign x_0
/// ```
///
/// which is concave in τ ≥ 0. Newton's method approaches it from above. If the expansion is renewed
/// each time, these zeros converge quadratically to a simple zero of x. A series that is not 0 but
/// has a constant term of 0 has a zero at τ = 0.
pub(super) fn first_zero<T: Scalar, const M: usize>(x: &Series<T, M>, limit: f64) -> f64 {
    let start = x.c[0].to_f64();
    let term = |k: usize| x.c[k].to_f64() * start.signum() * limit.signum().powi(k as i32);
    // Its value and its slope.
    let bound = |tau: f64| {
        (2..M).rev().chain([1, 0]).fold([0.0, 0.0], |[value, slope], k| {
            let term = if k < 2 { term(k) } else { term(k).min(0.0) };
            [f64::mul_add(value, tau, term), f64::mul_add(slope, tau, value)]
        })
    };
    if start == 0.0 {
        return if x.c.iter().all(|c| *c == T::zero()) { f64::INFINITY } else { 0.0 };
    }
    let mut tau = limit.abs();
    let [mut value, mut slope] = bound(tau);
    if value >= 0.0 {
        return f64::INFINITY;
    }
    while value < 0.0 {
        // A difference much smaller than τ is rounding.
        let next = (tau - value / slope).max(f64::EPSILON * tau);
        if next >= tau {
            break;
        }
        tau = next;
        [value, slope] = bound(tau);
    }
    // A few roundings before the zero.
    tau * (1.0 - 64.0 * f64::EPSILON)
}
