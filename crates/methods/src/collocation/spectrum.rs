//! The eigenvalues of integration on polynomials, by which the equations of a step fall apart.
//!
//! The tridiagonal `X_ij = ∫ P_i(τ) ∫_0^τ P_j` of s coefficients has distinct eigenvalues: pairs of
//! complex ones, and a real one where s is odd. (The W-transformation: E. Hairer, G. Wanner,
//! Solving Ordinary Differential Equations II, IV.5 and IV.8.) X is skew but for its first entry,
//! so that its transpose is X with the sign of every second row and column turned, and so are its
//! eigenvectors.

use super::legendre::MODES;
use super::rule::integration;
use faer::{Mat, c64};
use std::sync::LazyLock;

/// An eigenvalue μ of X; of a pair the one above the real axis, counted twice.
#[derive(Clone, Debug)]
pub(super) struct Eigenvalue {
    pub(super) value: c64,
    /// X v = μ v
    pub(super) right: [c64; MODES],
    /// uᵀ X = μ uᵀ with uᵀ v = 1, times the count
    pub(super) left: [c64; MODES],
}

static SPECTRA: LazyLock<Vec<Vec<Eigenvalue>>> = LazyLock::new(|| (0..=MODES).map(spectrum).collect());

/// The eigenvalues for so many coefficients, 8 at most: `X = Re Σ μ v uᵀ` and `1 = Re Σ v uᵀ`.
pub(super) fn of(stages: usize) -> &'static [Eigenvalue] {
    &SPECTRA[stages]
}

fn spectrum(stages: usize) -> Vec<Eigenvalue> {
    let x = integration();
    let matrix =
        Mat::from_fn(stages, stages, |i, j| if i.abs_diff(j) == 1 || i + j == 0 { x[i][j] } else { 0.0 });
    let all = matrix.eigenvalues().unwrap_or_default();
    // Roundings leave the real one no more than that above the axis.
    let upper = all.into_iter().filter(|value| value.im > -1e-9);
    upper.map(|value| eigenvalue(stages, value)).collect()
}

fn eigenvalue(stages: usize, value: c64) -> Eigenvalue {
    let x = integration();
    let zero = c64 { re: 0.0, im: 0.0 };
    let real = value.im.abs() < 1e-9;
    let value = if real { c64 { im: 0.0, ..value } } else { value };
    let mut right = [zero; MODES];
    right[0] = c64 { re: 1.0, im: 0.0 };
    for k in 0..stages.saturating_sub(1) {
        let below = if k == 0 { right[0] * x[0][0] } else { right[k - 1] * x[k][k - 1] };
        right[k + 1] = (value * right[k] - below) / x[k][k + 1];
    }
    let turned = |k: usize| if k.is_multiple_of(2) { right[k] } else { -right[k] };
    let norm = (0..stages).fold(zero, |sum, k| sum + turned(k) * right[k]);
    let count = if real { 1.0 } else { 2.0 };
    let left = std::array::from_fn(|k| if k < stages { turned(k) * count / norm } else { zero });
    Eigenvalue { value, right, left }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integration_is_its_eigenvalues() {
        for stages in 1..=MODES {
            let spectrum = of(stages);
            assert_eq!(spectrum.len(), stages.div_ceil(2));
            for i in 0..stages {
                for j in 0..stages {
                    let sum = |weight: &dyn Fn(&Eigenvalue) -> c64| -> f64 {
                        spectrum.iter().map(|e| (weight(e) * e.right[i] * e.left[j]).re).sum()
                    };
                    let exact = if i.abs_diff(j) == 1 || i + j == 0 { integration()[i][j] } else { 0.0 };
                    let (found, one) = (sum(&|e| e.value), sum(&|_| c64 { re: 1.0, im: 0.0 }));
                    assert!((found - exact).abs() < 1e-12, "{stages} {i} {j}: {found} {exact}");
                    assert!((one - f64::from(i == j)).abs() < 1e-11, "{stages} {i} {j}: {one}");
                }
            }
        }
    }
}
