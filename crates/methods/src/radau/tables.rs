//! The coefficients of the Radau IIA methods, computed in 31 digits.
//!
//! E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5. The nodes c_i are the
//! zeros of `P_s - P_{s-1}`, where P_k is the Legendre polynomial on [0, 1], orthonormal and of
//! degree k. With W_ik = P_k(c_i), `b_i = 1/Σ_k W_ik²` and the W-transformation
//!
//! ```text
//! A = W X Wᵀ diag(b)        X = tridiag(ξ_k, x_k, -ξ_{k+1})        ξ_k = 1/(2 √(4k² - 1))
//! x_0 = 1/2        x_{s-1} = 1/(4s - 2)        the other x_k are 0
//! ```
//!
//! X has one real eigenvalue μ and (s-1)/2 complex pairs. Except for its diagonal it is skew, so
//! its left eigenvectors are the right ones with the sign of every second entry reversed.

use crate::legendre::narrow;
use afterbay_core::{Quad, Scalar, Vector};
use faer::{Mat, c64};
use std::array::from_fn;
use std::f64::consts::PI;

/// The largest number of complex pairs.
const PAIRS: usize = 3;
/// Corrections by Newton's method, from 1e-3 to 32 digits.
const CORRECTIONS: usize = 6;
/// Intervals in which the zeros of a polynomial of degree 7 at most are searched.
const INTERVALS: u32 = 2000;

/// An eigenvalue of A from the upper half-plane, with its right and left eigenvectors. With `x_k`
/// the product of the left eigenvector with x, a vector x is `Re Σ x_k right_k`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<const S: usize> {
    pub(super) eigenvalue: c64,
    pub(super) right: [c64; S],
    pub(super) left: [c64; S],
}

/// The tables of the method with S stages, with ℓ_i the Lagrange polynomial of c_i.
#[derive(Clone, Debug)]
pub(crate) struct Tables<T, const S: usize> {
    pub(super) nodes: [T; S],
    /// A, by columns; its last row is b.
    pub(super) columns: [[T; S]; S],
    pub(super) weights: [T; S],
    /// ℓ_i(0)
    pub(super) start: [T; S],
    /// b_i P_k(c_i), k = S-1, S-2, S-3: maps values at the nodes to their last three Legendre
    /// coefficients.
    modes: [[f64; S]; 3],
    /// 1 / (c_i Π_k (c_i - c_k))
    barycentric: [T; S],
    /// The real eigenvalue of A, and its right and left eigenvectors.
    pub(super) eigenvalue: f64,
    pub(super) right: [f64; S],
    pub(super) left: [f64; S],
    pairs: [Pair<S>; PAIRS],
}

impl<const S: usize> Tables<Quad, S> {
    /// Computes the tables. S is odd and at most 7.
    pub(crate) fn new() -> Self {
        let nodes = nodes::<S>();
        let rows: [[Quad; S]; S] = nodes.map(legendre);
        let weights = rows.map(|row| row.iter().fold(Quad::ZERO, |sum, &p| sum + p * p).recip());
        let entry = |i: usize, j: usize| {
            let row = |k: usize| {
                let beyond =
                    if k + 1 < S { rows[j][k + 1] * offdiagonal(k + 1) } else { Quad::ZERO };
                let before = if k > 0 { rows[j][k - 1] * offdiagonal(k) } else { Quad::ZERO };
                before + rows[j][k] * diagonal(S, k) - beyond
            };
            (0..S).fold(Quad::ZERO, |sum, k| sum + rows[i][k] * row(k)) * weights[j]
        };
        let product = |i: usize, from: Quad| {
            let others = (0..S).filter(|&k| k != i);
            others.fold(Quad::ONE, |product, k| product * (from - nodes[k]))
        };
        let mut tables = Self {
            nodes,
            columns: from_fn(|j| from_fn(|i| entry(i, j))),
            weights,
            start: from_fn(|i| product(i, Quad::ZERO) / product(i, nodes[i])),
            modes: from_fn(|k| from_fn(|i| (weights[i] * rows[i][S - 1 - k]).to_f64())),
            barycentric: from_fn(|i| (nodes[i] * product(i, nodes[i])).recip()),
            eigenvalue: 0.0,
            right: [0.0; S],
            left: [0.0; S],
            pairs: [Pair { eigenvalue: c64::ZERO, right: [c64::ZERO; S], left: [c64::ZERO; S] };
                PAIRS],
        };
        tables.decompose(&rows.map(|row| row.map(Scalar::to_f64)));
        tables
    }

    /// Computes the eigenvalues and eigenvectors of A.
    fn decompose(&mut self, rows: &[[f64; S]; S]) {
        let (x, y) = (|k: usize| diagonal(S, k).to_f64(), |k: usize| offdiagonal(k).to_f64());
        let matrix = Mat::from_fn(S, S, |i, j| match (i, j) {
            _ if i == j => x(i),
            _ if i == j + 1 => y(i),
            _ if j == i + 1 => -y(j),
            _ => 0.0,
        });
        let mut pairs = self.pairs.iter_mut();
        for eigenvalue in matrix.eigenvalues().unwrap_or_default() {
            // Rounding moves the real eigenvalue by less than this from the real axis.
            let real = eigenvalue.im.abs() < 1e-9;
            if eigenvalue.im < 0.0 && !real {
                continue;
            }
            let mut vector = [c64::ZERO; S];
            vector[0] = c64::from(1.0);
            for k in 0..S - 1 {
                let before = if k > 0 { vector[k - 1] * y(k) } else { c64::ZERO };
                vector[k + 1] = (vector[k] * (c64::from(x(k)) - eigenvalue) + before) / y(k + 1);
            }
            let turned = |k: usize| if k.is_multiple_of(2) { vector[k] } else { -vector[k] };
            let norm = (0..S).fold(c64::ZERO, |sum, k| sum + turned(k) * vector[k]);
            let count = if real { 1.0 } else { 2.0 };
            let sum = |i: usize, of: &dyn Fn(usize) -> c64| {
                (0..S).fold(c64::ZERO, |sum, k| sum + of(k) * rows[i][k])
            };
            let right: [c64; S] = from_fn(|i| sum(i, &|k| vector[k]));
            let left: [c64; S] =
                from_fn(|i| sum(i, &turned) * (count * self.weights[i].to_f64()) / norm);
            if real {
                (self.eigenvalue, self.right, self.left) =
                    (eigenvalue.re, right.map(|x| x.re), left.map(|x| x.re));
            } else if let Some(pair) = pairs.next() {
                *pair = Pair { eigenvalue, right, left };
            }
        }
    }

    /// Rounds the tables to the scalar type.
    pub(super) fn narrow<T: Scalar>(&self) -> Tables<T, S> {
        Tables {
            nodes: self.nodes.map(narrow),
            columns: self.columns.map(|column| column.map(narrow)),
            weights: self.weights.map(narrow),
            start: self.start.map(narrow),
            modes: self.modes,
            barycentric: self.barycentric.map(narrow),
            eigenvalue: self.eigenvalue,
            right: self.right,
            left: self.left,
            pairs: self.pairs,
        }
    }
}

impl<T: Scalar, const S: usize> Tables<T, S> {
    /// The complex pairs of eigenvalues.
    #[inline(always)]
    pub(super) fn pairs(&self) -> &[Pair<S>] {
        &self.pairs[..S / 2]
    }

    /// ρ² for the entries d of vectors at the nodes, at most 1; 0 with three nodes, which have too
    /// few coefficients. `defect` is the value at the start less that of the polynomial through the
    /// nodes.
    ///
    /// ρ is the ratio of the last two Legendre coefficients to the two before, as roots of their
    /// sums of squares, or, if larger, of the last one to the larger of the two before it. The last
    /// one is that of `P_S`. It leaves the defect `P_S - P_(S-1)`, which is `2 √(2S+1)` times the
    /// coefficient at the start. Of an oscillation, ρ is proportional to (hω)² and hardly depends
    /// on the phase.
    #[inline(always)]
    pub(super) fn roughness<V>(&self, at: &[V; S], d: usize, defect: f64) -> f64
    where
        V: Vector<Scalar = T>,
    {
        if S == 3 {
            return 0.0;
        }
        let [before, third, fourth] = self.modes.map(|mode| {
            let terms = mode.iter().zip(at);
            let sum = terms.fold(0.0, |sum, (b, x)| b.mul_add(x.as_slice()[d].to_f64(), sum));
            sum * sum
        });
        let last = defect * defect / (8 * S + 4) as f64;
        // Without a force there is nothing to resolve.
        let ratio = |late: f64, early: f64| if late > 0.0 { late / early } else { 0.0 };
        let of_pairs = ratio(last + before, third + fourth);
        of_pairs.max(ratio(last, before.max(third))).min(1.0)
    }

    /// The matrix that maps increments of a step to those of the polynomial through them at the
    /// times `offset + ratio c_i`, in multiples of the step. By columns.
    pub(super) fn extrapolation(&self, offset: T, ratio: T) -> [[T; S]; S] {
        let mut columns = [[T::zero(); S]; S];
        for (i, &node) in self.nodes.iter().enumerate() {
            let at = ratio.mul_add(node, offset);
            // The products of (at - c_k) before and behind each node.
            let mut behind = [T::one(); S];
            for k in (1..S).rev() {
                behind[k - 1] = behind[k] * (at - self.nodes[k]);
            }
            let mut before = at;
            for j in 0..S {
                columns[j][i] = before * behind[j] * self.barycentric[j];
                before *= at - self.nodes[j];
            }
        }
        columns
    }
}

/// ξ_k
fn offdiagonal(k: usize) -> Quad {
    let k = Quad::from_f64(k as f64);
    (Quad::from_f64(2.0) * (Quad::from_f64(4.0) * k * k - Quad::ONE).sqrt()).recip()
}

/// x_k
fn diagonal(stages: usize, k: usize) -> Quad {
    match k {
        0 => Quad::ONE.half(),
        _ if k + 1 == stages => Quad::from_f64(4.0 * stages as f64 - 2.0).recip(),
        _ => Quad::ZERO,
    }
}

/// P_0(c) .. P_{S-1}(c)
fn legendre<const S: usize>(c: Quad) -> [Quad; S] {
    let x = c + c - Quad::ONE;
    from_fn(|k| {
        let [value, _] = polynomial_and_slope(k, x);
        value * Quad::from_f64((2 * k + 1) as f64).sqrt()
    })
}

/// The Legendre polynomial on [-1, 1] of degree n, and its derivative.
fn polynomial_and_slope(n: usize, x: Quad) -> [Quad; 2] {
    let (mut value, mut before) = (Quad::ONE, Quad::ZERO);
    let (mut slope, mut slope_before) = (Quad::ZERO, Quad::ZERO);
    for k in 0..n {
        let [a, b] = [(2 * k + 1) as f64, k as f64].map(Quad::from_f64);
        let next = (a * x * value - b * before) / Quad::from_f64((k + 1) as f64);
        (slope, slope_before) = (slope_before + a * value, slope);
        (value, before) = (next, value);
    }
    [value, slope]
}

/// The nodes, in ascending order.
fn nodes<const S: usize>() -> [Quad; S] {
    let both = |x: Quad| {
        let [high, low] = [polynomial_and_slope(S, x), polynomial_and_slope(S - 1, x)];
        [high[0] - low[0], high[1] - low[1]]
    };
    let at = |k: u32| Quad::from_f64(-(PI * f64::from(k) / f64::from(INTERVALS)).cos());
    let sign = |x: Quad| both(x)[0].to_f64() > 0.0;
    // The last node is the end of the interval.
    let brackets = (0..INTERVALS - 1).filter(|&k| sign(at(k)) != sign(at(k + 1)));
    let mut nodes = [Quad::ONE; S];
    for (node, k) in nodes[..S - 1].iter_mut().zip(brackets) {
        let mut x = (at(k) + at(k + 1)).half();
        for _ in 0..CORRECTIONS {
            let [value, slope] = both(x);
            x -= value / slope;
        }
        *node = (x + Quad::ONE).half();
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const S: usize>() {
        let tables = Tables::<Quad, S>::new();
        let node = |i: usize, k: i32| (0..k).fold(Quad::ONE, |power, _| power * tables.nodes[i]);
        let off = |found: Quad, exact: Quad| (found - exact).abs().to_f64();
        for k in 1..2 * S as i32 {
            let sum = (0..S).fold(Quad::ZERO, |sum, i| sum + tables.weights[i] * node(i, k - 1));
            assert!(off(sum, Quad::from_f64(f64::from(k)).recip()) < 1e-29, "B({k})");
        }
        for (k, i) in (1..=S as i32).flat_map(|k| (0..S).map(move |i| (k, i))) {
            let sum = (0..S).fold(Quad::ZERO, |sum, j| sum + tables.columns[j][i] * node(j, k - 1));
            assert!(off(sum, node(i, k) / Quad::from_f64(f64::from(k))) < 1e-29, "C({k}), {i}");
        }
        for (i, j) in (0..S).flat_map(|i| (0..S).map(move |j| (i, j))) {
            let (mut one, mut a) = (tables.right[i] * tables.left[j], 0.0);
            a += one * tables.eigenvalue;
            for pair in tables.pairs() {
                let product = pair.right[i] * pair.left[j];
                (one, a) = (one + product.re, a + (product * pair.eigenvalue).re);
            }
            // The eigenvectors are far from orthogonal, so that the sums lose up to six digits.
            // Corrections then contract by 1e-9 at best.
            assert!((one - f64::from(i == j)).abs() < 1e-9, "{i} {j}: {one}");
            assert!((a - tables.columns[j][i].to_f64()).abs() < 1e-9, "{i} {j}: {a}");
            assert!(i + 1 < S || off(tables.columns[j][i], tables.weights[j]) < 1e-30);
        }
        // A polynomial of degree S without constant term is extrapolated exactly.
        let (offset, ratio) = (Quad::from_f64(0.25), Quad::from_f64(1.5));
        let columns = tables.extrapolation(offset, ratio);
        for (k, i) in (1..=S as i32).flat_map(|k| (0..S).map(move |i| (k, i))) {
            let found = (0..S).fold(Quad::ZERO, |sum, j| sum + columns[j][i] * node(j, k));
            let at = offset + ratio * tables.nodes[i];
            let exact = (0..k).fold(Quad::ONE, |power, _| power * at);
            assert!(off(found, exact) < 1e-26, "{k} {i}");
        }
        for k in 0..S as i32 {
            let sum = (0..S).fold(Quad::ZERO, |sum, i| sum + tables.start[i] * node(i, k));
            assert!(off(sum, if k == 0 { Quad::ONE } else { Quad::ZERO }) < 1e-28, "start {k}");
        }
    }

    #[test]
    fn tables_satisfy_the_order_conditions() {
        check::<3>();
        check::<5>();
        check::<7>();
    }

    /// Hairer and Wanner II, table IV.5.6.
    #[test]
    fn three_stages_are_radau5() {
        let tables = Tables::<Quad, 3>::new();
        let root = 6.0_f64.sqrt();
        let nodes = [(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0];
        for (found, exact) in tables.nodes.iter().zip(nodes) {
            assert!((found.to_f64() - exact).abs() < 1e-15);
        }
        assert!((tables.columns[0][0].to_f64() - (88.0 - 7.0 * root) / 360.0).abs() < 1e-15);
        // 1/γ, ibid. (8.10)
        let gamma = 3.637_834_252_744_496;
        assert!((tables.eigenvalue * gamma - 1.0).abs() < 1e-14);
    }
}
