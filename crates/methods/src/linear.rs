//! The linear equations of an implicit step, with one solver per file.
//!
//! The matrix is the Jacobian of a Newton iteration. Its entries are always `f64`, or complex
//! numbers of two `f64`, since an approximate Jacobian costs corrections but no accuracy. Memory is
//! allocated once; filling, factorising and solving do not allocate.

mod dense;
mod derivatives;
mod gmres;
mod number;
mod phase_space;
mod ring;
mod small;
mod sparse;
mod tridiagonal;

use afterbay_core::InputError;
use dense::Dense;
pub(crate) use derivatives::{Derivative, Derivatives, NO_SUCH_DOF, check_derivatives};
pub(crate) use gmres::Gmres;
pub(crate) use number::Number;
pub(crate) use phase_space::{PhaseSpace, Plane, Unsolvable};
use ring::Ring;
use small::Small;
use sparse::Sparse;
use std::fmt::Debug;
use std::ops::{Deref, DerefMut};
use tridiagonal::Tridiagonal;

/// The solver of the linear equations of an implicit step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearSolver {
    /// Gaussian elimination with partial pivoting, for few unknowns.
    Small,
    /// Thomas' algorithm without pivoting, for nearest-neighbour coupling, H without mixed
    /// derivatives and diagonal ∂²H/∂p².
    Chain,
    /// Thomas' algorithm with the last unknown eliminated, for neighbours in a ring, under the same
    /// conditions.
    Ring,
    /// faer's sparse LU with one symbolic analysis, for matrices with few entries per row.
    Sparse,
    /// faer's dense LU with partial pivoting, for all-to-all coupling.
    Dense,
}

impl LinearSolver {
    /// All solvers.
    pub const ALL: [Self; 5] = [Self::Small, Self::Chain, Self::Ring, Self::Sparse, Self::Dense];
}

/// The number of unknowns from which faer's dense LU is faster than `Small`.
pub(crate) const SMALL: usize = 32;

/// A square matrix whose entries are filled in and then factorised in place.
pub(crate) trait Solver<T>: Debug + Send + Sync {
    /// The index of an entry in [`Solver::values`]; `None` outside the pattern.
    fn slot(&self, row: usize, column: usize) -> Option<usize>;

    /// The entries. Factorising may overwrite all of them.
    fn values(&mut self) -> &mut [T];

    /// Factorises the matrix. For a pivot that is zero or not finite, either its row is returned as
    /// the error, or the solutions are not finite.
    fn factorise(&mut self) -> Result<(), usize>;

    /// Subtracts from x the product of a with the matrix of the same pattern whose entries are
    /// `values`.
    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]);

    /// Replaces the right-hand side x by the solution.
    fn solve(&mut self, x: &mut [T]);

    /// A copy of the matrix and its factors.
    fn copied(&self) -> Box<dyn Solver<T>>;
}

/// A matrix with the solver chosen for it.
///
/// Its type is erased, so that faer is compiled once per number ([`Number::matrix`]) and not again
/// in every crate that steps a method.
#[derive(Debug)]
pub(crate) struct Matrix<T = f64>(Box<dyn Solver<T>>);

impl<T: Number> Matrix<T> {
    /// Creates a matrix with entries at `pattern` and on the diagonal.
    pub(crate) fn new(
        solver: LinearSolver,
        size: usize,
        pattern: Vec<(usize, usize)>,
    ) -> Result<Self, InputError> {
        Ok(Self(T::matrix(solver, size, pattern)?))
    }

    /// Replaces (a, b) by the solution. The unknowns x, in the order a_0, b_0, a_1, .., are
    /// overwritten.
    pub(crate) fn solve_pairs(&mut self, [a, b]: [&mut [T]; 2], x: &mut [T]) {
        for ((x, a), b) in x.as_chunks_mut::<2>().0.iter_mut().zip(&*a).zip(&*b) {
            *x = [*a, *b];
        }
        self.solve(x);
        for ((x, a), b) in x.as_chunks::<2>().0.iter().zip(a).zip(b) {
            [*a, *b] = *x;
        }
    }
}

impl<T> Clone for Matrix<T> {
    fn clone(&self) -> Self {
        Self(self.0.copied())
    }
}

impl<T> Deref for Matrix<T> {
    type Target = dyn Solver<T>;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl<T> DerefMut for Matrix<T> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}

fn matrix<T: Number>(
    solver: LinearSolver,
    size: usize,
    pattern: Vec<(usize, usize)>,
) -> Result<Box<dyn Solver<T>>, InputError> {
    Ok(match solver {
        LinearSolver::Small => Box::new(Small::new(size)),
        LinearSolver::Chain => Box::new(Tridiagonal::new(size)),
        LinearSolver::Ring => Box::new(Ring::new(size)),
        LinearSolver::Sparse => Box::new(Sparse::new(size, pattern)?),
        LinearSolver::Dense => Box::new(Dense::new(size)),
    })
}

/// Subtracts from x the product of a with a dense matrix stored by columns.
fn subtract_columns<T: Number>(values: &[T], a: &[T], x: &mut [T]) {
    for (column, &a) in values.chunks_exact(x.len().max(1)).zip(a) {
        for (x, &value) in x.iter_mut().zip(column) {
            *x = (-value).fused(a, *x);
        }
    }
}

/// Whether the pivot is finite and nonzero.
fn usable<T: Number>(pivot: T) -> bool {
    let size = pivot.size();
    size != 0.0 && size.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The solvers and their matrices: a tridiagonal one, and for all but `Chain` one of a ring.
    fn matrices(n: usize) -> impl Iterator<Item = (LinearSolver, Vec<(usize, usize, f64)>)> {
        let ring = move || {
            let mut entries = entries(n);
            if n > 2 {
                entries.extend([(0, n - 1, 0.6), (n - 1, 0, -0.3)]);
            }
            entries
        };
        LinearSolver::ALL.into_iter().flat_map(move |solver| {
            let closed = (solver != LinearSolver::Chain).then(|| (solver, ring()));
            [(solver, entries(n))].into_iter().chain(closed)
        })
    }

    /// A tridiagonal matrix that is not symmetric and has one small pivot.
    fn entries(n: usize) -> Vec<(usize, usize, f64)> {
        let value = |i: usize, j: usize| match (i, j) {
            (i, j) if i == j => 2.0 + (i as f64).sin() - if i == 2 { 1.9 } else { 0.0 },
            (i, j) if i < j => -0.7 - 0.1 * (i as f64).cos(),
            _ => 0.4 + 0.2 * (i as f64).sin(),
        };
        let near = (0..n).flat_map(|i| (i.saturating_sub(1)..n.min(i + 2)).map(move |j| (i, j)));
        near.map(|(i, j)| (i, j, value(i, j))).collect()
    }

    #[test]
    fn every_solver_solves() {
        for n in [1, 2, 3, 10, 70] {
            let exact: Vec<f64> = (0..n).map(|i| (i as f64 - 1.5).cos()).collect();
            for (solver, entries) in matrices(n) {
                let pattern = entries.iter().map(|&(i, j, _)| (i, j)).collect();
                let mut matrix = Matrix::<f64>::new(solver, n, pattern).unwrap();
                // The second factorisation overwrites the first.
                for scale in [1.0, -3.0] {
                    let mut x = vec![0.0; n];
                    matrix.values().fill(0.0);
                    for &(i, j, value) in &entries {
                        let slot = matrix.slot(i, j).unwrap();
                        matrix.values()[slot] += scale * value;
                        x[i] += scale * value * exact[j];
                    }
                    matrix.factorise().unwrap();
                    matrix.solve(&mut x);
                    for (x, exact) in x.iter().zip(&exact) {
                        assert!((x - exact).abs() < 1e-13, "{solver:?} {n}: {x} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_solver_multiplies() {
        for n in [1, 2, 3, 10, 70] {
            let a: Vec<f64> = (0..n).map(|i| (i as f64 - 1.5).cos()).collect();
            for (solver, entries) in matrices(n) {
                let pattern = entries.iter().map(|&(i, j, _)| (i, j)).collect();
                let mut matrix = Matrix::new(solver, n, pattern).unwrap();
                let mut values = vec![0.0; matrix.values().len()];
                let (mut x, mut exact) = (vec![1.0; n], vec![1.0; n]);
                for &(i, j, value) in &entries {
                    values[matrix.slot(i, j).unwrap()] = value;
                    exact[i] -= value * a[j];
                }
                matrix.subtract(&values, &a, &mut x);
                for (x, exact) in x.iter().zip(&exact) {
                    assert!((x - exact).abs() < 1e-15, "{solver:?} {n}: {x} {exact}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_said_to_be_singular() {
        for solver in LinearSolver::ALL {
            let pattern = (0..40).map(|i| (i, i)).collect();
            let mut matrix = Matrix::<f64>::new(solver, 40, pattern).unwrap();
            matrix.values().fill(0.0);
            for i in 0..40 {
                let slot = matrix.slot(i, i).unwrap();
                matrix.values()[slot] = if i == 7 { 0.0 } else { 1.0 };
            }
            let mut x = vec![1.0; 40];
            let factorised = matrix.factorise().map(|()| matrix.solve(&mut x));
            assert!(factorised.is_err() || x.iter().any(|x| !x.is_finite()), "{solver:?}");
        }
    }
}
