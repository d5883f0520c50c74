//! The tables of Gauss collocation with K nodes on [0, 1], which represents a polynomial of degree
//! K - 1 by its values at the nodes.

use crate::legendre::{MODES, gauss, integrals, narrow, values};
use afterbay_core::{Quad, Scalar};
use std::array::from_fn;

/// A matrix that maps values at the nodes to values at the nodes, column by column.
pub(super) type Columns<T, const K: usize> = [[T; K]; K];

/// The tables for K nodes τ_i, with ℓ_j the Lagrange polynomial of τ_j. They are aligned for the
/// reason given at [`super::stages::Stages`].
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Gauss<T, const K: usize> {
    /// τ_i
    pub(super) nodes: [T; K],
    /// b_i
    pub(super) weights: [T; K],
    /// `∫_0^{τ_i} ℓ_j`, and the square of this matrix.
    pub(super) once: Columns<T, K>,
    pub(super) twice: Columns<T, K>,
    /// `∫_0^1 (1 - τ) ℓ_j`
    pub(super) moments: [T; K],
    /// ℓ_j(1); ℓ_j(0) are the same numbers in reversed order.
    pub(super) end: [T; K],
    /// b_j P_l(τ_j), by l: maps values at the nodes to Legendre coefficients.
    pub(super) modes: [[T; K]; K],
}

impl<const K: usize> Gauss<Quad, K> {
    /// Computes the tables in 31 digits.
    pub(super) fn new() -> Self {
        let mut at: Vec<[Quad; 2]> = gauss(K);
        at.extend(gauss(K).into_iter().map(|[x, weight]| [-x, weight]));
        at.sort_by(|a, b| a[0].to_f64().total_cmp(&b[0].to_f64()));
        let half = Quad::ONE.half();
        let table: [([Quad; MODES], [Quad; MODES]); K] = from_fn(|i| {
            let mut integrals = integrals(at[i][0]);
            integrals[0] += half;
            (values(at[i][0]), integrals)
        });
        let project = |j: usize, l: usize| at[j][1] * table[j].0[l];
        let sum = |j: usize, f: &[Quad; MODES]| {
            (0..K).fold(Quad::ZERO, |sum, l| sum + project(j, l) * f[l])
        };
        let once: Columns<Quad, K> = from_fn(|j| from_fn(|i| sum(j, &table[i].1)));
        let twice: Columns<Quad, K> = from_fn(|j| {
            from_fn(|i| (0..K).fold(Quad::ZERO, |sum, l| sum + once[l][i] * once[j][l]))
        });
        let ends = values(Quad::ONE);
        let late = |j: usize| at[j][1] * (Quad::ONE - at[j][0]).half();
        Self {
            nodes: from_fn(|i| (Quad::ONE + at[i][0]).half()),
            weights: from_fn(|i| at[i][1]),
            once,
            twice,
            moments: from_fn(late),
            end: from_fn(|j| sum(j, &ends)),
            modes: from_fn(|l| from_fn(|j| project(j, l))),
        }
    }

    /// Rounds the tables to the scalar type.
    pub(super) fn narrow<T: Scalar>(&self) -> Gauss<T, K> {
        let square = |table: &[[Quad; K]; K]| table.map(|row| row.map(narrow));
        Gauss {
            nodes: self.nodes.map(narrow),
            weights: self.weights.map(narrow),
            once: square(&self.once),
            twice: square(&self.twice),
            moments: self.moments.map(narrow),
            end: self.end.map(narrow),
            modes: square(&self.modes),
        }
    }
}

impl<T: Scalar, const K: usize> Gauss<T, K> {
    /// The coefficient of P_K in an oscillation over the phase 2θ, √(2K+1) j_K(θ), for small θ.
    pub(super) fn response(&self, theta: f64) -> f64 {
        let odd = (1..=K).fold(1.0, |product, n| product * (2 * n + 1) as f64);
        (((2 * K + 1) as f64).sqrt() * theta.powi(K as i32) / odd).min(1.0)
    }

    /// κ from the decrease of the coefficients of a slope with these values at the nodes and this
    /// coefficient of P_K, if those of Φ decrease alike: ρ^(K/2), at most 1.
    ///
    /// ρ is the ratio of the last two coefficients to the two before, as roots of their sums of
    /// squares, or, if larger, of the last one to the larger of the two before it.
    #[inline(always)]
    pub(super) fn decay(&self, at: [T; K], last: f64) -> f64 {
        let [third, second, before]: [f64; 3] = from_fn(|i| {
            let mode = &self.modes[K - 3 + i];
            let sum = mode.iter().zip(at).fold(T::zero(), |sum, (&b, x)| b.mul_add(x, sum));
            (sum * sum).to_f64()
        });
        let last = last * last;
        let ratio = ((last + before) / (second + third)).max(last / before.max(second)).min(1.0);
        if K == 4 { ratio } else { ratio * ratio }
    }

    /// P_0 .. P_{K-1}, by l, at the nodes of an interval whose length is `ratio` and whose start is
    /// `offset`, in units of this interval.
    #[inline(always)]
    pub(super) fn basis(&self, offset: T, ratio: T) -> [[T; K]; K] {
        let two = T::one() + T::one();
        let x: [T; K] = from_fn(|i| (ratio * two).mul_add(self.nodes[i], offset * two - T::one()));
        let mut l = [[T::one(); K]; K];
        l[1] = x;
        for n in 1..K - 1 {
            let (a, b) = ((2 * n + 1) as f64 / (n + 1) as f64, n as f64 / (n + 1) as f64);
            let (a, b) = (T::from_f64(a), T::from_f64(b));
            for i in 0..K {
                l[n + 1][i] = (a * x[i]).mul_add(l[n][i], -(b * l[n - 1][i]));
            }
        }
        l
    }

    /// The values at the nodes of another interval, with this basis, of the polynomial with values
    /// f at the nodes, truncated to `count` coefficients.
    #[inline(always)]
    pub(super) fn extended(&self, basis: &[[T; K]; K], count: usize, f: [T; K]) -> [T; K] {
        let mut ahead = [T::zero(); K];
        for (l, (basis, modes)) in basis.iter().zip(&self.modes).enumerate().take(count) {
            let norm = T::from_f64(((2 * l + 1) as f64).sqrt());
            let coefficient = norm * weighted(modes, f);
            for i in 0..K {
                ahead[i] = coefficient.mul_add(basis[i], ahead[i]);
            }
        }
        ahead
    }

    /// The matrix that maps values at the nodes to those on another interval, of the same
    /// polynomial truncated to `count` coefficients.
    #[inline(never)]
    pub(super) fn extrapolation(&self, offset: T, ratio: T, count: usize) -> Columns<T, K> {
        let basis = self.basis(offset, ratio);
        let mut columns = [[T::zero(); K]; K];
        for (l, (basis, modes)) in basis.iter().zip(&self.modes).enumerate().take(count) {
            let norm = T::from_f64(((2 * l + 1) as f64).sqrt());
            for (column, &mode) in columns.iter_mut().zip(modes) {
                let factor = norm * mode;
                for i in 0..K {
                    column[i] = factor.mul_add(basis[i], column[i]);
                }
            }
        }
        columns
    }
}

/// Σ b_i x_i
#[inline(always)]
pub(super) fn weighted<T: Scalar, const K: usize>(weights: &[T; K], x: [T; K]) -> T {
    let mut terms: [T; K] = from_fn(|i| weights[i] * x[i]);
    let mut width = K / 2;
    while width > 0 {
        for i in 0..width {
            terms[i] += terms[i + width];
        }
        width /= 2;
    }
    terms[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers up to K - 1 are integrated and extrapolated exactly.
    #[test]
    fn polynomials_are_exact() {
        fn check<const K: usize>() {
            let gauss = Gauss::<Quad, K>::new().narrow::<f64>();
            let ahead = gauss.extrapolation(1.0, 0.5, K);
            for n in 0..K {
                let power = gauss.nodes.map(|x| x.powi(n as i32));
                let apply = |columns: &Columns<f64, K>, i: usize| -> f64 {
                    (0..K).map(|j| columns[j][i] * power[j]).sum()
                };
                let extended = gauss.extended(&gauss.basis(1.0, 0.5), K, power);
                let m = n as f64;
                for (i, &x) in gauss.nodes.iter().enumerate() {
                    let once = x.powi(n as i32 + 1) / (m + 1.0);
                    assert!((apply(&gauss.once, i) - once).abs() < 1e-15, "{K} {n}");
                    let later = (1.0 + 0.5 * x).powi(n as i32);
                    assert!((apply(&ahead, i) - later).abs() < 1e-10, "{K} {n} {later}");
                    assert!((extended[i] - later).abs() < 1e-10, "{K} {n} {later}");
                    if n + 1 < K {
                        let twice = x.powi(n as i32 + 2) / ((m + 1.0) * (m + 2.0));
                        assert!((apply(&gauss.twice, i) - twice).abs() < 1e-15, "{K} {n}");
                    }
                }
                let sum = |row: &[f64; K]| (0..K).map(|j| row[j] * power[j]).sum::<f64>();
                assert!((sum(&gauss.weights) - 1.0 / (m + 1.0)).abs() < 1e-15);
                assert!((sum(&gauss.moments) - 1.0 / ((m + 1.0) * (m + 2.0))).abs() < 1e-15);
                assert!((sum(&gauss.end) - 1.0).abs() < 1e-13);
            }
        }
        check::<4>();
        check::<8>();
    }
}
