//! The linear equations of an implicit step, one solver a file.
//!
//! The matrix is the Jacobian of Newton's iteration: always of `f64`, or of pairs of them where it
//! is complex, since an approximate one costs corrections, never digits. Everything is laid out
//! once; filling, factorising and solving allocate nothing.

mod dense;
mod gmres;
mod number;
mod small;
mod sparse;
mod tridiagonal;

use afterbay_core::InputError;
use dense::Dense;
pub(crate) use gmres::Gmres;
pub(crate) use number::Number;
use small::Small;
use sparse::Sparse;
use tridiagonal::Tridiagonal;

/// How the linear equations of an implicit step are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearSolver {
    /// Gauss with partial pivoting, written out: a few unknowns.
    Small,
    /// Thomas' algorithm, without pivoting: neighbours in a row, H without mixed derivatives and a
    /// diagonal ∂²H/∂p².
    Chain,
    /// Sparse LU of faer with one symbolic analysis: anything with few entries a row.
    Sparse,
    /// LU of faer with partial pivoting: everyone acts on everyone.
    Dense,
}

/// Unknowns from which faer's dense LU is faster than the one written out.
pub(crate) const SMALL: usize = 32;

/// A square matrix: entries to be filled in, then factorised in place.
pub(crate) trait Solver<T> {
    /// Where in [`Solver::values`] an entry is; `None` outside the pattern.
    fn slot(&self, row: usize, column: usize) -> Option<usize>;

    /// The entries. Factorising may overwrite them all.
    fn values(&mut self) -> &mut [T];

    /// Factorises. The row of a pivot that is zero or not finite is the failure, or else solutions
    /// are not finite.
    fn factorise(&mut self) -> Result<(), usize>;

    /// Subtracts from x the product of a with the matrix that has `values` where this one has its
    /// own.
    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]);

    /// Replaces the right-hand side by the solution.
    fn solve(&mut self, x: &mut [T]);
}

/// One of the solvers.
#[derive(Clone, Debug)]
pub(crate) enum Matrix<T = f64> {
    Small(Small<T>),
    Chain(Tridiagonal<T>),
    Sparse(Box<Sparse<T>>),
    Dense(Dense<T>),
}

impl<T: Number> Matrix<T> {
    /// A matrix with entries at `pattern` and on the diagonal.
    pub(crate) fn new(
        solver: LinearSolver,
        size: usize,
        pattern: Vec<(usize, usize)>,
    ) -> Result<Self, InputError> {
        Ok(match solver {
            LinearSolver::Small => Self::Small(Small::new(size)),
            LinearSolver::Chain => Self::Chain(Tridiagonal::new(size)),
            LinearSolver::Sparse => Self::Sparse(Box::new(Sparse::new(size, pattern)?)),
            LinearSolver::Dense => Self::Dense(Dense::new(size)),
        })
    }

    fn solver(&self) -> &dyn Solver<T> {
        match self {
            Self::Small(matrix) => matrix,
            Self::Chain(matrix) => matrix,
            Self::Sparse(matrix) => matrix.as_ref(),
            Self::Dense(matrix) => matrix,
        }
    }

    fn solver_mut(&mut self) -> &mut dyn Solver<T> {
        match self {
            Self::Small(matrix) => matrix,
            Self::Chain(matrix) => matrix,
            Self::Sparse(matrix) => matrix.as_mut(),
            Self::Dense(matrix) => matrix,
        }
    }
}

impl<T: Number> Solver<T> for Matrix<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        self.solver().slot(row, column)
    }

    fn values(&mut self) -> &mut [T] {
        self.solver_mut().values()
    }

    fn factorise(&mut self) -> Result<(), usize> {
        self.solver_mut().factorise()
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        self.solver().subtract(values, a, x);
    }

    fn solve(&mut self, x: &mut [T]) {
        self.solver_mut().solve(x);
    }
}

/// Subtracts from x the product of a with a dense matrix by columns.
fn subtract_columns<T: Number>(values: &[T], a: &[T], x: &mut [T]) {
    for (column, &a) in values.chunks_exact(x.len().max(1)).zip(a) {
        for (x, &value) in x.iter_mut().zip(column) {
            *x = (-value).fused(a, *x);
        }
    }
}

/// Is this a number one can divide by?
fn usable<T: Number>(pivot: T) -> bool {
    let size = pivot.size();
    size != 0.0 && size.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tridiagonal and not symmetric, with one small pivot.
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
            let entries = entries(n);
            let exact: Vec<f64> = (0..n).map(|i| (i as f64 - 1.5).cos()).collect();
            for solver in [
                LinearSolver::Small,
                LinearSolver::Chain,
                LinearSolver::Sparse,
                LinearSolver::Dense,
            ] {
                let pattern = entries.iter().map(|&(i, j, _)| (i, j)).collect();
                let mut matrix = Matrix::<f64>::new(solver, n, pattern).unwrap();
                // The second time over the first factors.
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
            let entries = entries(n);
            let a: Vec<f64> = (0..n).map(|i| (i as f64 - 1.5).cos()).collect();
            for solver in [
                LinearSolver::Small,
                LinearSolver::Chain,
                LinearSolver::Sparse,
                LinearSolver::Dense,
            ] {
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
        for solver in
            [LinearSolver::Small, LinearSolver::Chain, LinearSolver::Sparse, LinearSolver::Dense]
        {
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
