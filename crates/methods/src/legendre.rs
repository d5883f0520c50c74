//! Legendre polynomials on [0, 1] and Gauss nodes in 31 digits; tables are computed once and
//! rounded afterwards.
//!
//! P_j(τ) = √(2j+1) L_j(2τ - 1) with `∫ P_i P_j = δ_ij`, and with τ = (1 + x)/2
//!
//! ```text
//! (n+1) L_{n+1} = (2n+1) x L_n - n L_{n-1}
//! ∫_0^τ P_j = [L_{j+1}(x) - L_{j-1}(x)] / (2√(2j+1))        j ≥ 1
//! ```

use afterbay_core::{Quad, Scalar};

/// The number of coefficients of the polynomials of a step, the largest possible one.
pub(crate) const MODES: usize = 8;

fn whole(n: usize) -> Quad {
    Quad::from_f64(n as f64)
}

/// L_0 .. L_{M-1} at x.
fn legendre<const M: usize>(x: Quad) -> [Quad; M] {
    let mut l = [Quad::ONE; M];
    for n in 1..M {
        let before = if n > 1 { l[n - 2] } else { Quad::ZERO };
        l[n] = (whole(2 * n - 1) * x * l[n - 1] - whole(n - 1) * before) / whole(n);
    }
    l
}

/// Rounds x to T.
pub(crate) fn narrow<T: Scalar>(x: Quad) -> T {
    T::from_f64(x.0) + T::from_f64(x.1)
}

/// Converts a scalar that holds one number without rounding.
pub(crate) fn widen<T: Scalar>(x: T) -> Quad {
    let high = x.to_f64();
    Quad::from_f64(high) + Quad::from_f64((x - T::from_f64(high)).to_f64())
}

/// √(2j+1)
fn norm(j: usize) -> Quad {
    Scalar::sqrt(whole(2 * j + 1))
}

/// P_j at τ = (1 + x)/2.
pub(crate) fn values(x: Quad) -> [Quad; MODES] {
    let l = legendre::<MODES>(x);
    std::array::from_fn(|j| norm(j) * l[j])
}

/// `∫_{1/2}^τ P_0` and, for j ≥ 1, `∫_0^τ P_j` at τ = (1 + x)/2. They are odd in x where P_j is
/// even, and even where it is odd.
pub(crate) fn integrals(x: Quad) -> [Quad; MODES] {
    let l = legendre::<{ MODES + 1 }>(x);
    std::array::from_fn(|j| match j {
        0 => x.half(),
        _ => (l[j + 1] - l[j - 1]).half() / norm(j),
    })
}

/// The nodes (1 + x)/2 with x > 0 of the Gauss rule with `count` nodes on [0, 1], `count` even, and
/// their weights.
pub(crate) fn gauss(count: usize) -> Vec<[Quad; 2]> {
    (0..count / 2).map(|i| node(count, i)).collect()
}

fn node(count: usize, i: usize) -> [Quad; 2] {
    let guess = std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5);
    let mut x = Quad::from_f64(guess.cos());
    let mut slope = Quad::ONE;
    // Each Newton correction doubles the number of digits, from at least 2 of the initial guess.
    // The derivative is that of the last but one iterate.
    for _ in 0..7 {
        let (mut l, mut before) = (x, Quad::ONE);
        for n in 1..count {
            let next = (whole(2 * n + 1) * x * l - whole(n) * before) / whole(n + 1);
            (before, l) = (l, next);
        }
        slope = whole(count) * (before - x * l) / (Quad::ONE - x * x);
        x -= l / slope;
    }
    [x, (Quad::ONE - x * x).recip() / (slope * slope)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫_0^1 f by the Gauss rule.
    fn integral(count: usize, f: impl Fn(Quad) -> Quad) -> Quad {
        gauss(count).into_iter().fold(Quad::ZERO, |sum, [x, weight]| sum + weight * (f(x) + f(-x)))
    }

    fn close(a: Quad, b: Quad) -> bool {
        (a - b).abs().to_f64() < 2e-30
    }

    #[test]
    fn gauss_integrates_powers() {
        for count in [2, 8, 16, 32, 64] {
            for power in 0..2 * count {
                let found = integral(count, |x| {
                    let tau = (Quad::ONE + x).half();
                    (0..power).fold(Quad::ONE, |y, _| y * tau)
                });
                assert!(close(found, whole(power + 1).recip()), "{count} {power}: {found:?}");
            }
        }
    }

    #[test]
    fn polynomials_are_orthonormal() {
        for i in 0..MODES {
            for j in 0..MODES {
                let found = integral(MODES, |x| values(x)[i] * values(x)[j]);
                assert!(close(found, whole(usize::from(i == j))), "{i} {j}: {found:?}");
            }
        }
    }

    /// Applies the rule to [0, τ] instead of [0, 1].
    #[test]
    fn integrals_are_those_of_the_polynomials() {
        for x in [-1.0, -0.9, -0.3, 0.0, 0.25, 0.7, 1.0].map(Quad::from_f64) {
            let tau = (Quad::ONE + x).half();
            for j in 0..MODES {
                let inner = |y: Quad| values(tau * (Quad::ONE + y) - Quad::ONE)[j];
                let from = if j == 0 { Quad::ONE.half() } else { Quad::ZERO };
                let found = tau * integral(MODES, inner) - from;
                assert!(close(found, integrals(x)[j]), "{j} {x:?}: {found:?}");
            }
        }
    }
}
