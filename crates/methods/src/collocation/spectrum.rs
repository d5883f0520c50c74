//! The eigenvalues of the integration matrix, which decouple the equations of a step.
//!
//! The tridiagonal matrix `X_ij = ∫ P_i(τ) ∫_0^τ P_j` of s coefficients has distinct eigenvalues:
//! complex pairs, and a real one if s is odd. (The W-transformation: E. Hairer, G. Wanner, Solving
//! Ordinary Differential Equations II, IV.5 and IV.8.) X is skew except for its first entry, so its
//! transpose is X with the signs of every second row and column reversed. The left eigenvectors
//! follow from the right ones in the same way.

use super::rule::integration;
use crate::legendre::MODES;
use faer::{Mat, c64};
use std::sync::LazyLock;

/// An eigenvalue μ of X. A complex pair is represented by the one in the upper half-plane, with
/// count 2.
#[derive(Clone, Debug)]
pub(super) struct Eigenvalue {
    pub(super) value: c64,
    /// X v = μ v
    pub(super) right: [c64; MODES],
    /// uᵀ X = μ uᵀ with uᵀ v = 1, multiplied by the count
    pub(super) left: [c64; MODES],
}

static SPECTRA: LazyLock<Vec<Vec<Eigenvalue>>> =
    LazyLock::new(|| (0..=MODES).map(spectrum).collect());

/// The eigenvalues for `stages` coefficients, 8 at most: `X = Re Σ μ v uᵀ` and `1 = Re Σ v uᵀ`.
pub(super) fn of(stages: usize) -> &'static [Eigenvalue] {
    &SPECTRA[stages]
}

fn spectrum(stages: usize) -> Vec<Eigenvalue> {
    let x = integration();
    let matrix =
        Mat::from_fn(
            stages,
            stages,
            |i, j| if i.abs_diff(j) == 1 || i + j == 0 { x[i][j] } else { 0.0 },
        );
    let all = matrix.eigenvalues().unwrap_or_default();
    // Rounding moves the real eigenvalue by less than this from the real axis.
    let upper = all.into_iter().filter(|value| value.im > -1e-9);
    upper.map(|value| eigenvalue(stages, value)).collect()
}

/// The number of Newton corrections of an eigenvalue, whose matrix is far from normal.
const EIGENVALUE_CORRECTIONS: u32 = 3;

/// The eigenvector with first entry 1, computed row by row, and the residual of the last row, which
/// vanishes at an eigenvalue, with its derivative with respect to the eigenvalue.
fn eigenvector(stages: usize, value: c64) -> ([c64; MODES], [c64; 2]) {
    let (x, zero) = (integration(), c64 { re: 0.0, im: 0.0 });
    let (mut right, mut slopes) = ([zero; MODES], [zero; MODES]);
    right[0] = c64 { re: 1.0, im: 0.0 };
    for k in 0..stages {
        let of = |v: &[c64; MODES]| if k == 0 { v[0] * x[0][0] } else { v[k - 1] * x[k][k - 1] };
        let rest = value * right[k] - of(&right);
        let slope = right[k] + value * slopes[k] - of(&slopes);
        if k + 1 == stages {
            return (right, [rest, slope]);
        }
        (right[k + 1], slopes[k + 1]) = (rest / x[k][k + 1], slope / x[k][k + 1]);
    }
    (right, [zero, right[0]])
}

fn eigenvalue(stages: usize, value: c64) -> Eigenvalue {
    let zero = c64 { re: 0.0, im: 0.0 };
    let real = value.im.abs() < 1e-9;
    let mut value = if real { c64 { im: 0.0, ..value } } else { value };
    for _ in 0..EIGENVALUE_CORRECTIONS {
        let (_, [rest, slope]) = eigenvector(stages, value);
        value -= rest / slope;
    }
    let (right, _) = eigenvector(stages, value);
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
            // The eigenvectors are far from orthogonal: with κ = |u||v|, the sums lose a factor κ
            // in accuracy, and the eigenvectors themselves lose as much.
            let largest = |v: &[c64]| v.iter().map(|x| x.re.hypot(x.im)).fold(0.0, f64::max);
            let size: f64 = spectrum.iter().map(|e| largest(&e.right) * largest(&e.left)).sum();
            let bound = 4.0 * f64::EPSILON * size * size;
            println!("{stages}: {size:.1e}");
            for i in 0..stages {
                for j in 0..stages {
                    let sum = |weight: &dyn Fn(&Eigenvalue) -> c64| -> f64 {
                        spectrum.iter().map(|e| (weight(e) * e.right[i] * e.left[j]).re).sum()
                    };
                    let exact =
                        if i.abs_diff(j) == 1 || i + j == 0 { integration()[i][j] } else { 0.0 };
                    let (found, one) = (sum(&|e| e.value), sum(&|_| c64 { re: 1.0, im: 0.0 }));
                    assert!((found - exact).abs() < bound, "{stages} {i} {j}: {found} {exact}");
                    assert!((one - f64::from(i == j)).abs() < bound, "{stages} {i} {j}: {one}");
                }
            }
        }
    }
}
