//! The spectral radius of a step.

use afterbay_core::{InputError, IntegrateError, State};
use afterbay_methods::registry::Run;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{DMatrix, Schur};

/// The largest difference of an entry between the image of a sum and the sum of the images at which
/// a step counts as linear, as a share of the largest number of its row, or of 1 if that is larger.
const LINEAR: f64 = 1e-9;
/// The most sweeps of the eigenvalue iteration per row.
const SWEEPS: usize = 100;

/// The largest |eigenvalue| of the 2N x 2N matrix of one step on (q, p), from its action on 0 and
/// on unit vectors. `None` if the step fails on one of the unit vectors or is not affine. If it
/// fails on 0 alone, where terms may vanish, it is tested as a linear one.
///
/// # Errors
/// Invalid input.
pub(super) fn spectral_radius(
    method: &Run<f64>,
    dof: usize,
    h: f64,
) -> Result<Option<f64>, InputError> {
    let size = 2 * dof;
    let image = |z: &[f64]| -> Result<Option<Vec<f64>>, InputError> {
        let mut state = State::new(z[..dof].to_vec(), z[dof..].to_vec())?;
        match method.step(h, &mut state) {
            Ok(_) => Ok(Some([state.q, state.p].concat())),
            Err(IntegrateError::Input(error)) => Err(error),
            Err(IntegrateError::Run(_) | IntegrateError::Interrupted) => Ok(None),
        }
    };
    let origin = image(&vec![0.0; size])?.unwrap_or_else(|| vec![0.0; size]);
    // A sum in which all weights differ.
    let weights: Vec<f64> = (0..size).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
    let Some(mut off) = image(&weights)? else { return Ok(None) };
    off.iter_mut().zip(&origin).for_each(|(x, origin)| *x -= origin);
    let mut matrix = DMatrix::zeros(size, size);
    for i in 0..size {
        let mut unit = vec![0.0; size];
        unit[i] = 1.0;
        let Some(column) = image(&unit)? else { return Ok(None) };
        for (j, x) in column.into_iter().enumerate() {
            let x = x - origin[j];
            matrix[(j, i)] = x;
            off[j] -= weights[i] * x;
        }
    }
    let largest = |row: usize| matrix.row(row).iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    if (0..size).any(|i| off[i].abs() > LINEAR * largest(i) * size as f64) {
        return Ok(None);
    }
    Ok(largest_eigenvalue(matrix))
}

/// Balances a square matrix M: divides it by its largest |entry|, and returns this with the sizes
/// d_j for which the rows and columns of M_ij d_j/d_i have about equal norms. `None` if M is not
/// finite.
pub(crate) fn balance(matrix: &mut DMatrix<f64>) -> Option<(f64, Vec<f64>)> {
    let largest = matrix.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
    }
    if largest > 0.0 {
        // Squares of entries may not overflow.
        *matrix /= largest;
    }
    let sizes = balance_parlett_reinsch(matrix);
    Some((largest, sizes.iter().copied().collect()))
}

/// The largest |eigenvalue| of a square matrix; `None` if the iteration does not converge. The
/// matrix is balanced first, so that entries in small units count as others do.
pub(crate) fn largest_eigenvalue(mut matrix: DMatrix<f64>) -> Option<f64> {
    let (largest, _) = balance(&mut matrix)?;
    let sweeps = SWEEPS * matrix.nrows();
    let schur = Schur::try_new(matrix, f64::EPSILON, sweeps)?;
    let sizes = schur.complex_eigenvalues().map(|z| z.re.hypot(z.im));
    Some(largest * sizes.iter().copied().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_do_not_depend_on_units() {
        let units = [1e-7, 1.0, 1e7, 3e3];
        let entry = |i: usize, j: usize| ((3 * i + 5 * j) as f64).sin();
        let exact = largest_eigenvalue(DMatrix::from_fn(4, 4, entry)).unwrap();
        let other = DMatrix::from_fn(4, 4, |i, j| entry(i, j) * units[i] / units[j]);
        let found = largest_eigenvalue(other).unwrap();
        assert!((found - exact).abs() < 1e-14 * exact, "{found} {exact}");
        assert_eq!(largest_eigenvalue(DMatrix::from_element(2, 2, f64::NAN)), None);
        // Squares of these overflow.
        let large = largest_eigenvalue(DMatrix::from_element(2, 2, 1e200)).unwrap();
        assert!((large / 2e200 - 1.0).abs() < 1e-14, "{large:e}");
    }
}
