//! The sizes by which the unknowns of a cycle are measured.

use crate::study::ranges::Ranges;
use crate::study::stability::balance;
use faer::Mat;
use nalgebra::DMatrix;

/// The least extent of a coordinate or a momentum that moves, relative to the largest of its kind.
const MOVES: f64 = 1e-9;
/// The least size, as a share of the magnitude. Corrections below 1e-16 of the magnitude are
/// roundings.
const OF_MAGNITUDE: f64 = 1e-5;

/// A degree of freedom decays beside the cycle if the ends of its path are farther apart than this
/// share of its extent, and than this many times the least such share of all. Choices.
const OPEN: f64 = 0.1;
const TIMES_LEAST: f64 = 100.0;

/// Half of the extent of each q_j and p_j on a path, and the magnitudes of the other unknowns.
/// Those of a degree of freedom that does not move balance the matrix ∂Φ/∂z. `residual` is the
/// difference between the ends of the path.
pub(super) fn scales_of(
    path: &[Vec<f64>],
    residual: &[f64],
    monodromy: &Mat<f64>,
    x: &[f64],
) -> Vec<f64> {
    let size = monodromy.nrows();
    let ranges = Ranges::of(path);
    let extents: Vec<f64> = (0..size).map(|j| 0.5 * ranges.extent(j)).collect();
    let largest = |kind: &[f64]| kind.iter().copied().fold(0.0, f64::max);
    let dof = size / 2;
    let (q, p) = (largest(&extents[..dof]), largest(&extents[dof..]));
    let open = |j: usize| {
        let share = |i: usize| if extents[i] > 0.0 { residual[i].abs() / extents[i] } else { 0.0 };
        share(j).max(share(j + dof))
    };
    let least = (0..dof).map(open).fold(f64::INFINITY, f64::min);
    let moves = |j: usize| {
        let j = j % dof;
        let decays = open(j) > OPEN.max(TIMES_LEAST * least);
        !decays && (extents[j] > MOVES * q || extents[j + dof] > MOVES * p)
    };
    let sizes = balanced(monodromy);
    let resting = (0..dof).filter(|&j| !moves(j)).map(|j| sizes[j]).fold(0.0, f64::max);
    let scale = |j: usize| {
        let found = if moves(j) { extents[j] } else { q * sizes[j] / resting };
        found.max(OF_MAGNITUDE * ranges.magnitude(j))
    };
    let usable = |scale: f64| if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
    (0..size).map(scale).map(usable).chain(x[size..].iter().map(|x| x.abs())).collect()
}

/// The sizes d_j that balance a matrix; 1 if it is not finite.
fn balanced(matrix: &Mat<f64>) -> Vec<f64> {
    let size = matrix.nrows();
    let found = balance(&mut DMatrix::from_fn(size, size, |i, j| matrix[(i, j)]));
    found.map_or_else(|| vec![1.0; size], |(_, sizes)| sizes)
}
