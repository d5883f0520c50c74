//! The Gauss nodes of a step and the values of the polynomials there, as tables.
//!
//! The nodes form pairs (1 ∓ x)/2, at which P_j agrees up to the sign (-1)^j. Even and odd j are
//! therefore summed separately, once for both nodes. This halves the work, and rounding is then
//! symmetric under time reversal.

use crate::legendre::{MODES, gauss, integrals, narrow, values};
use afterbay_core::{Quad, Scalar};
use std::array::from_fn;
use std::ops::{Deref, DerefMut};
use std::sync::LazyLock;

/// The number of pairs of nodes computed side by side: the lanes of a vector register.
pub(super) const PAIRS: usize = 4;
/// The number of nodes of a panel: first the earlier nodes of the pairs, then the later ones.
pub(super) const NODES: usize = 2 * PAIRS;
/// The number of quadrature rules, each with twice the nodes of the one before.
const RULES: usize = 4;
/// The largest number of nodes of a step.
pub(crate) const MOST_NODES: usize = NODES << (RULES - 1);

/// The coefficients γ_j of one variable, j = 2m + parity, as [parity][m].
///
/// It begins at a cache line, as do [`Panel`] and the arrays at the nodes. Without this, memory
/// placed them differently in each run of a program, and a step with one degree of freedom took up
/// to 1.6 times as long.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Modes<T>([[T; MODES / 2]; 2]);

impl<T: Scalar> Modes<T> {
    /// γ = 0
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self([[T::zero(); MODES / 2]; 2])
    }
}

impl<T> Modes<T> {
    /// The coefficients by parity and m.
    fn of(coefficient: impl Fn(usize, usize) -> T) -> Self {
        Self(from_fn(|parity| from_fn(|m| coefficient(parity, m))))
    }
}

impl<T> Deref for Modes<T> {
    type Target = [[T; MODES / 2]; 2];

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T> DerefMut for Modes<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// One number for each pair of a panel.
type Pairs<T> = [T; PAIRS];

/// The values of the polynomials at a panel of nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel<T> {
    /// b_i
    weights: Pairs<T>,
    /// P_j and its integral at the later nodes, as [parity][m].
    values: [[Pairs<T>; MODES / 2]; 2],
    integrals: [[Pairs<T>; MODES / 2]; 2],
    /// b_i P_j, and 0 for j beyond the stages, as [pair][parity].
    projections: [Modes<T>; PAIRS],
}

/// Σ c_j γ_j over the j of one parity, at the pairs. Two partial sums shorten the chain of
/// dependent operations.
#[inline(always)]
fn sum<T: Scalar>(columns: &[Pairs<T>; MODES / 2], modes: &[T; MODES / 2]) -> Pairs<T> {
    let mut total = [T::zero(); PAIRS];
    for i in 0..PAIRS {
        let first = columns[1][i].mul_add(modes[1], columns[0][i] * modes[0]);
        let second = columns[3][i].mul_add(modes[3], columns[2][i] * modes[2]);
        total[i] = first + second;
    }
    total
}

/// The panels of the rules with 8, 16, 32 and 64 nodes, for all coefficients, and the matrix that
/// extrapolates a polynomial.
struct Tables {
    rules: [Vec<Panel<Quad>>; RULES],
    extrapolation: [Modes<Quad>; MODES],
    integration: [[f64; MODES]; MODES],
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables {
    rules: from_fn(|level| panels(1 << level)),
    extrapolation: extrapolated(),
    integration: integrated(),
});

/// The panels of the Gauss rule with `NODES · count` nodes.
fn panels(count: usize) -> Vec<Panel<Quad>> {
    let pairs = gauss(NODES * count);
    let by_mode = |x: [Quad; MODES]| Modes::of(|parity, m| x[2 * m + parity]);
    let (pairs, _) = pairs.as_chunks::<PAIRS>();
    let panel = |pairs: &[[Quad; 2]; PAIRS]| {
        let values = pairs.map(|[x, _]| by_mode(values(x)));
        let integrals = pairs.map(|[x, _]| by_mode(integrals(x)));
        let turned = |table: &[Modes<Quad>; PAIRS]| {
            from_fn(|parity| from_fn(|m| from_fn(|pair| table[pair][parity][m])))
        };
        Panel {
            weights: pairs.map(|[_, weight]| weight),
            values: turned(&values),
            integrals: turned(&integrals),
            projections: from_fn(|i| Modes::of(|parity, m| pairs[i][1] * values[i][parity][m])),
        }
    };
    pairs.iter().map(panel).collect()
}

/// The panels of the smallest rule with at least `nodes` nodes, and of all larger rules, for
/// polynomials with `stages` coefficients.
pub(super) fn rules<T: Scalar>(stages: usize, nodes: usize) -> Vec<Vec<Panel<T>>> {
    let known = |parity: usize, m: usize, x: Quad| {
        if 2 * m + parity < stages { narrow(x) } else { T::zero() }
    };
    let columns = |table: &[[Pairs<Quad>; MODES / 2]; 2]| -> [[Pairs<T>; MODES / 2]; 2] {
        from_fn(|parity| from_fn(|m| table[parity][m].map(|x| known(parity, m, x))))
    };
    let panel = |panel: &Panel<Quad>| Panel {
        weights: panel.weights.map(narrow),
        values: columns(&panel.values),
        integrals: columns(&panel.integrals),
        projections: panel
            .projections
            .map(|modes| Modes::of(|parity, m| known(parity, m, modes[parity][m]))),
    };
    let enough = TABLES.rules.iter().filter(|panels| NODES * panels.len() >= nodes);
    enough.map(|panels| panels.iter().map(panel).collect()).collect()
}

/// The matrix s of `P_l(1 + τ) = Σ_j s_lj P_j(τ)`, which extrapolates a polynomial to the next
/// interval. Rows l are stored as [parity][m].
pub(super) fn extrapolation<T: Scalar>() -> [Modes<T>; MODES] {
    TABLES.extrapolation.map(|row| Modes::of(|parity, m| narrow(row[parity][m])))
}

/// The coefficients of the same polynomial on the next interval.
#[inline(never)]
pub(super) fn extrapolate<T: Scalar>(by: &[Modes<T>; MODES], modes: &Modes<T>) -> Modes<T> {
    let mut ahead = Modes::zero();
    for (l, row) in by.iter().enumerate() {
        let mode = modes[l % 2][l / 2];
        for parity in 0..2 {
            for m in 0..MODES / 2 {
                ahead[parity][m] = row[parity][m].mul_add(mode, ahead[parity][m]);
            }
        }
    }
    ahead
}

/// The matrix `∫ P_i(τ) ∫_0^τ P_j`, which integrates a polynomial given by its coefficients.
pub(super) fn integration() -> &'static [[f64; MODES]; MODES] {
    &TABLES.integration
}

impl<T: Scalar> Panel<T> {
    /// Σ γ_j P_j at the nodes.
    #[inline(always)]
    pub(super) fn value(&self, modes: &Modes<T>) -> [T; NODES] {
        let (even, odd) = (sum(&self.values[0], &modes[0]), sum(&self.values[1], &modes[1]));
        let mut at = [T::zero(); NODES];
        for i in 0..PAIRS {
            at[i] = even[i] - odd[i];
        }
        for i in 0..PAIRS {
            at[PAIRS + i] = even[i] + odd[i];
        }
        at
    }

    /// `start + h Σ γ_j ∫_0^τ P_j` at the nodes.
    #[inline(always)]
    pub(super) fn place(&self, start: T, h: T, modes: &Modes<T>) -> [T; NODES] {
        let middle = h.mul_add(modes[0][0].half(), start);
        let (odd, even) = (sum(&self.integrals[0], &modes[0]), sum(&self.integrals[1], &modes[1]));
        let mut at = [T::zero(); NODES];
        for i in 0..PAIRS {
            at[i] = h.mul_add(even[i] - odd[i], middle);
        }
        for i in 0..PAIRS {
            at[PAIRS + i] = h.mul_add(even[i] + odd[i], middle);
        }
        at
    }

    /// Adds `Σ b_i P_j(τ_i) f_i`.
    #[inline(always)]
    pub(super) fn project(&self, f: [T; NODES], to: &mut Modes<T>) {
        let (mut sums, mut differences) = ([T::zero(); PAIRS], [T::zero(); PAIRS]);
        for i in 0..PAIRS {
            sums[i] = f[PAIRS + i] + f[i];
            differences[i] = f[PAIRS + i] - f[i];
        }
        for (parity, f) in [sums, differences].into_iter().enumerate() {
            let row = |i: usize, m: usize| self.projections[i][parity][m];
            for (m, to) in to[parity].iter_mut().enumerate() {
                let first = row(1, m).mul_add(f[1], row(0, m) * f[0]);
                let second = row(3, m).mul_add(f[3], row(2, m) * f[2]);
                *to += first + second;
            }
        }
    }

    /// Σ b_i f_i
    #[inline(always)]
    pub(super) fn integrate(&self, f: [T; NODES]) -> T {
        let terms: Pairs<T> = from_fn(|i| self.weights[i] * (f[i] + f[i + PAIRS]));
        terms.into_iter().fold(T::zero(), |sum, term| sum + term)
    }
}

/// Σ γ_j P_j(τ), with factors rounded to `f64`: accurate enough for an initial guess and an error
/// estimate.
pub(super) fn value<T: Scalar>(modes: &Modes<T>, time: T) -> T {
    let x = time + time - T::one();
    let (mut before, mut at, mut sum) = (T::zero(), T::one(), T::zero());
    for j in 0..MODES {
        let n = j as f64;
        sum += T::from_f64((2.0 * n + 1.0).sqrt()) * (modes[j % 2][j / 2] * at);
        let next = T::from_f64((2.0 * n + 1.0) / (n + 1.0)) * (x * at)
            - T::from_f64(n / (n + 1.0)) * before;
        (before, at) = (at, next);
    }
    sum
}

fn extrapolated() -> [Modes<Quad>; MODES] {
    let moment = |l: usize, j: usize| {
        gauss(MODES).into_iter().fold(Quad::ZERO, |sum, [x, weight]| {
            let term = |x: Quad| values(x)[j] * values(x + Quad::from_f64(2.0))[l];
            sum + weight * (term(x) + term(-x))
        })
    };
    // A polynomial of degree l has no higher coefficients.
    let entry = |l, j| if j > l { Quad::ZERO } else { moment(l, j) };
    from_fn(|l| Modes::of(|parity, m| entry(l, 2 * m + parity)))
}

fn integrated() -> [[f64; MODES]; MODES] {
    let moment = |i: usize, j: usize| {
        let start = if i == 0 && j == 0 { Quad::ONE.half() } else { Quad::ZERO };
        let product = gauss(MODES).into_iter().fold(start, |sum, [x, weight]| {
            let term = |x: Quad| values(x)[i] * integrals(x)[j];
            sum + weight * (term(x) + term(-x))
        });
        product.to_f64()
    };
    from_fn(|i| from_fn(|j| moment(i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of some polynomial of the highest degree.
    const SOME: Modes<f64> = Modes([[1.0, -0.7, 0.3, 0.9], [0.5, 0.8, -0.6, 0.2]]);

    #[test]
    fn a_polynomial_is_extrapolated_exactly() {
        let extrapolated = extrapolate(&extrapolation(), &SOME);
        for time in [0.0, 0.3, 1.0] {
            let ahead = value(&SOME, time + 1.0);
            let error = value(&extrapolated, time) - ahead;
            assert!(error.abs() <= 1e-11 * ahead.abs(), "at {time}: {error:e} of {ahead:e}");
        }
    }
}
