//! The multipliers of a cycle: the eigenvalues of its monodromy matrix.

use super::CycleFailure;
use faer::Mat;

/// The size of a multiplier, relative to the matrix, below which the determinant gives it better:
/// half of its digits are lost.
const SMALL: f64 = 1e-8;
/// The size below which it is lost in roundings. A choice: those of a product of thousands of
/// matrices.
const LOST: f64 = 1e-12;

/// A complex number, as its real and imaginary parts.
pub type Complex = [f64; 2];

pub(super) fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// A determinant, by its sign and the logarithm of its size, which may be below all numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Determinant {
    sign: f64,
    logarithm: f64,
}

impl Default for Determinant {
    /// 1
    fn default() -> Self {
        Self { sign: 1.0, logarithm: 0.0 }
    }
}

impl Determinant {
    /// The determinant of a product with a matrix of determinant x.
    pub(super) fn times(self, x: f64) -> Self {
        Self { sign: self.sign * x.signum(), logarithm: self.logarithm + x.abs().ln() }
    }

    /// Its quotient by x.
    fn over(self, x: f64) -> f64 {
        self.sign * x.signum() * (self.logarithm - x.abs().ln()).exp()
    }
}

/// The eigenvalues of a matrix, the largest first, and the bound below which they are not known.
/// They are computed in units in which all entries are of about one size. A small one that is the
/// least follows from the determinant, if the others are known: the rounding errors of eigenvalues
/// are relative to the largest.
pub(super) fn multipliers(
    matrix: &Mat<f64>,
    determinant: Determinant,
    units: &[f64],
) -> Result<(Vec<Complex>, Option<f64>), CycleFailure> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let scaled = Mat::from_fn(rows, columns, |i, j| matrix[(i, j)] * (units[j] / units[i]));
    let values = scaled.eigenvalues().map_err(|_| CycleFailure::NoMultipliers)?;
    let mut values: Vec<Complex> = values.iter().map(|z| [z.re, z.im]).collect();
    if values.iter().flatten().any(|x| !x.is_finite()) {
        return Err(CycleFailure::NoMultipliers);
    }
    let size = |[re, im]: &Complex| re.hypot(*im);
    values.sort_by(|a, b| size(b).total_cmp(&size(a)).then(b[1].total_cmp(&a[1])));
    let norm = scaled.norm_l2();
    let below = |share: f64| values.iter().filter(|value| size(value) < share * norm).count();
    let (small, lost) = (below(SMALL), below(LOST));
    if let Some(([_, 0.0], others)) = values.split_last()
        && small > 0
        && lost <= 1
    {
        let others = others.iter().fold([1.0, 0.0], |all, value| product(all, *value))[0];
        let least = determinant.over(others);
        if least != 0.0 && least.is_finite() {
            let last = values.len() - 1;
            values[last] = [least, 0.0];
            return Ok((values, None));
        }
    }
    Ok((values, (lost > 0).then_some(LOST * norm)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multipliers_fall() {
        let turn = Mat::from_fn(2, 2, |i, j| [[0.0, -0.5], [0.5, 0.0]][i][j]);
        let determinant = Determinant::default().times(0.25);
        let (found, lost) = multipliers(&turn, determinant, &[1.0; 2]).unwrap();
        assert_eq!(lost, None);
        assert!((found[0][1] - 0.5).abs() < 1e-15 && (found[1][1] + 0.5).abs() < 1e-15);
    }

    #[test]
    fn multipliers_do_not_depend_on_units() {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j) as f64).sin();
        let exact =
            multipliers(&Mat::from_fn(4, 4, entry), Determinant::default(), &[1.0; 4]).unwrap().0;
        let units = [1e-7, 1.0, 1e7, 3e3];
        let other = Mat::from_fn(4, 4, |i, j| entry(i, j) * units[i] / units[j]);
        let found = multipliers(&other, Determinant::default(), &units).unwrap().0;
        for (a, b) in found.iter().zip(&exact) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-14, "{found:?} {exact:?}");
        }
    }

    /// In coordinates in which no entry shows a multiplier.
    #[test]
    fn a_multiplier_below_the_roundings_follows_from_the_determinant_or_is_not_known() {
        let turned = |values: [f64; 3]| {
            let entry = |i: usize, j: usize| {
                [[1.0, 2.0, 2.0], [2.0, 1.0, -2.0], [2.0, -2.0, 1.0]][i][j] / 3.0
            };
            let along =
                |i: usize, j: usize| (0..3).map(|k| entry(i, k) * values[k] * entry(j, k)).sum();
            let determinant = values.into_iter().fold(Determinant::default(), Determinant::times);
            multipliers(&Mat::from_fn(3, 3, along), determinant, &[1.0; 3]).unwrap()
        };
        let (found, lost) = turned([1.0, 0.3, -1e-40]);
        assert!((found[2][0] / -1e-40 - 1.0).abs() < 1e-12 && lost.is_none(), "{found:?}");
        let (found, lost) = turned([1.0, 1e-20, 1e-40]);
        let bound = lost.expect("two are lost");
        assert!(found[1][0].abs() < bound && bound < 1e-11 && found[0][0] > bound);
    }
}
