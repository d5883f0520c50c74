//! The linear equations of the simplified Newton iteration, in `f64`.
//!
//! With J the derivative of (∂H/∂p, -∂H/∂q - D) at the middle of the step and
//! `X_ij = ∫ P_i(τ) ∫_0^τ P_j`, the correction δγ for the residual `missing` solves
//! `(1 - h X ⊗ J) δγ = missing` with 2 s N unknowns. Diagonalising X (`spectrum.rs`) decouples the
//! equations. For each eigenvalue μ, with m = h μ, the 2 N components (a, b) of γ_q and -γ_p along
//! its eigenvector satisfy
//!
//! ```text
//! a - m Hpq a + m Hpp b = missing_a
//! b - m S a + m (Hqp + Dp) b = missing_b        S = Hqq + Dq
//! ```
//!
//! If H has no mixed derivatives and Hpp is diagonal, `a = missing_a - m Hpp b` is eliminated, and
//! N unknowns remain:
//!
//! ```text
//! (1 + m Dp + m² S Hpp) b = missing_b + m S missing_a
//! ```
//!
//! The matrix is tridiagonal if only neighbours in a row are coupled, sparse if it has few entries,
//! and dense otherwise.

use super::rule::Modes;
use super::spectrum::{self, Eigenvalue};
use crate::linear::{LinearSolver, Matrix, Number, SMALL};
use afterbay_core::{Block, Curvature, Scalar, StepFailure};
use faer::c64;

/// The memory limit for the matrices of all eigenvalues, in bytes. A choice.
const MOST_BYTES: f64 = 4e9;
/// A matrix is treated as sparse if fewer than one in this many entries is nonzero. A choice.
const ENTRIES_A_NONZERO: usize = 8;

/// A derivative provided by the system, and its positions in the matrix; only Hqp has a second one.
#[derive(Clone, Copy, Debug)]
struct Entry {
    block: Block,
    i: usize,
    j: usize,
    slots: [usize; 2],
}

/// The matrices, one for each eigenvalue, and their right-hand sides.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    stages: usize,
    n: usize,
    spectrum: &'static [Eigenvalue],
    entries: Vec<Entry>,
    values: Vec<f64>,
    /// Hpp, present if a is eliminated
    inertia: Option<Vec<f64>>,
    diagonal: Vec<usize>,
    matrices: Vec<Matrix<c64>>,
    /// h
    h: f64,
    a: Vec<c64>,
    unknowns: Vec<c64>,
    /// The right-hand side by parts, degrees of freedom and coefficients; then the solution
    pub(super) missing: Vec<f64>,
    solution: Vec<f64>,
    /// h times the largest entry of J.
    pub(super) gain: f64,
}

impl Equations {
    /// Allocates the equations of a system.
    ///
    /// # Errors
    /// [`StepFailure::TooLarge`] if the matrices exceed the memory limit; [`StepFailure::Singular`]
    /// if a derivative names a degree of freedom that does not exist.
    pub(super) fn new<T, S>(system: &S, stages: usize) -> Result<Self, StepFailure>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let origin = vec![T::zero(); n];
        let mut entries = Vec::new();
        system.curvature(&origin, &origin, |block, i, j, _| {
            entries.push(Entry { block, i, j, slots: [0; 2] });
        });
        Self::with_entries(n, entries, stages)
    }

    fn with_entries(n: usize, mut entries: Vec<Entry>, stages: usize) -> Result<Self, StepFailure> {
        let most = entries.iter().map(|entry| entry.i.max(entry.j)).max().unwrap_or(0);
        if most >= n {
            return Err(StepFailure::Singular { dof: most, slope: f64::NAN });
        }
        let eliminate = entries.iter().all(|entry| match entry.block {
            Block::Hqp => false,
            Block::Hpp => entry.i == entry.j,
            Block::Hqq | Block::Dq | Block::Dp => true,
        });
        let chain = eliminate && entries.iter().all(|entry| entry.i.abs_diff(entry.j) <= 1);
        let size = if eliminate { n } else { 2 * n };
        let spectrum = spectrum::of(stages);
        let dense = !chain
            && (size <= SMALL || entries.len().saturating_mul(ENTRIES_A_NONZERO) >= size * size);
        let bytes = 16.0 * (spectrum.len() * size) as f64 * size as f64;
        if dense && bytes > MOST_BYTES {
            return Err(StepFailure::TooLarge { unknowns: size, bytes });
        }
        let solver = match dense {
            _ if chain => LinearSolver::Chain,
            true if size <= SMALL => LinearSolver::Small,
            true => LinearSolver::Dense,
            false => LinearSolver::Sparse,
        };
        let places =
            |entry: &Entry| if eliminate { [(entry.i, entry.j); 2] } else { places(entry) };
        let pattern: Vec<_> =
            entries.iter().flat_map(places).chain((0..size).map(|i| (i, i))).collect();
        let first = Matrix::new(solver, size, pattern)
            .map_err(|_| StepFailure::TooLarge { unknowns: size, bytes })?;
        let slot = |(row, column)| first.slot(row, column).unwrap_or(0);
        for entry in &mut entries {
            entry.slots = places(entry).map(slot);
        }
        let diagonal = (0..size).map(|i| slot((i, i))).collect();
        let zero = c64::ZERO;
        Ok(Self {
            stages,
            n,
            spectrum,
            values: vec![0.0; entries.len()],
            entries,
            inertia: eliminate.then(|| vec![0.0; n]),
            diagonal,
            matrices: vec![first; spectrum.len()],
            h: 0.0,
            a: vec![zero; n],
            unknowns: vec![zero; size],
            missing: vec![0.0; 2 * stages * n],
            solution: vec![0.0; 2 * stages * n],
            gain: 0.0,
        })
    }

    /// Evaluates the derivatives at (q, p) and factorises the matrices. The error is the degree of
    /// freedom of a vanishing pivot.
    pub(super) fn factorise<T, S>(
        &mut self,
        system: &S,
        h: f64,
        q: &[T],
        p: &[T],
    ) -> Result<(), usize>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let mut next = self.values.iter_mut();
        system.curvature(q, p, |_, _, _, value| {
            if let Some(place) = next.next() {
                *place = value.to_f64();
            }
        });
        self.factorise_values(h)
    }

    fn factorise_values(&mut self, h: f64) -> Result<(), usize> {
        let Self { entries, values, inertia, diagonal, matrices, spectrum, gain, .. } = self;
        let most = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        (*gain, self.h) = (h.abs() * most, h);
        let given = || entries.iter().zip(values.iter());
        if let Some(inertia) = inertia {
            inertia.fill(0.0);
            for (entry, value) in given().filter(|(entry, _)| entry.block == Block::Hpp) {
                inertia[entry.i] += value;
            }
        }
        for (matrix, eigenvalue) in matrices.iter_mut().zip(*spectrum) {
            let (m, to) = (eigenvalue.value * h, matrix.values());
            let square = m * m;
            to.fill(c64::ZERO);
            diagonal.iter().for_each(|&slot| to[slot] = c64::real(1.0));
            for (&Entry { block, j, slots: [first, second], .. }, &value) in given() {
                match (block, &*inertia) {
                    (Block::Hqq | Block::Dq, Some(inertia)) => {
                        to[first] += square * (value * inertia[j]);
                    }
                    (Block::Dp, _) => to[first] += m * value,
                    (Block::Hpp, Some(_)) => {}
                    (Block::Hpp, None) => to[first] += m * value,
                    (Block::Hqq | Block::Dq, None) => to[first] -= m * value,
                    (Block::Hqp, _) => {
                        to[first] -= m * value;
                        to[second] += m * value;
                    }
                }
            }
            let rows = if inertia.is_some() { 1 } else { 2 };
            matrix.factorise().map_err(|row| row / rows)?;
        }
        Ok(())
    }

    /// Solves the equations in place of `missing`.
    pub(super) fn solve(&mut self) {
        let Self { stages, n, spectrum, matrices, missing, solution, a, unknowns, .. } = self;
        let (stages, n) = (*stages, *n);
        solution.fill(0.0);
        for (matrix, Eigenvalue { value, right, left }) in matrices.iter_mut().zip(*spectrum) {
            let m = *value * self.h;
            let part = |rows: &[f64]| {
                rows.iter().zip(left).fold(c64::ZERO, |sum, (&x, &left)| sum + left * x)
            };
            let (q, p) = missing.split_at(stages * n);
            let rows = q.chunks_exact(stages).zip(p.chunks_exact(stages)).enumerate();
            if let Some(inertia) = &self.inertia {
                for (d, (q, p)) in rows {
                    (a[d], unknowns[d]) = (part(q), part(p));
                }
                for (&Entry { block, i, j, .. }, &value) in self.entries.iter().zip(&self.values) {
                    if matches!(block, Block::Hqq | Block::Dq) {
                        unknowns[i] += m * a[j] * value;
                    }
                }
                matrix.solve(unknowns);
                for ((a, b), &inertia) in a.iter_mut().zip(&*unknowns).zip(inertia) {
                    *a -= m * *b * inertia;
                }
            } else {
                for (d, (q, p)) in rows {
                    (unknowns[2 * d], unknowns[2 * d + 1]) = (part(q), part(p));
                }
                matrix.solve(unknowns);
            }
            let eliminated = self.inertia.is_some();
            let (q, p) = solution.split_at_mut(stages * n);
            for (d, (q, p)) in
                q.chunks_exact_mut(stages).zip(p.chunks_exact_mut(stages)).enumerate()
            {
                let [x, y] = if eliminated {
                    [a[d], unknowns[d]]
                } else {
                    [unknowns[2 * d], unknowns[2 * d + 1]]
                };
                for ((q, p), right) in q.iter_mut().zip(p).zip(right) {
                    *q += right.re * x.re - right.im * x.im;
                    *p += right.re * y.re - right.im * y.im;
                }
            }
        }
        std::mem::swap(missing, solution);
    }

    /// Computes the residual of γ, `next - γ`.
    pub(super) fn see<T: Scalar>(&mut self, next: [&[Modes<T>]; 2], modes: [&[Modes<T>]; 2]) {
        let Self { stages, n, missing, .. } = self;
        let (q, p) = missing.split_at_mut(*stages * *n);
        for ((rows, next), modes) in [q, p].into_iter().zip(next).zip(modes) {
            for ((rows, next), modes) in rows.chunks_exact_mut(*stages).zip(next).zip(modes) {
                for (j, x) in rows.iter_mut().enumerate() {
                    *x = (next[j % 2][j / 2] - modes[j % 2][j / 2]).to_f64();
                }
            }
        }
    }

    /// Adds `share` times `missing` to γ.
    pub(super) fn add<T: Scalar>(&self, share: f64, modes: [&mut [Modes<T>]; 2]) {
        let (q, p) = self.missing.split_at(self.stages * self.n);
        for (rows, modes) in [q, p].into_iter().zip(modes) {
            for (rows, modes) in rows.chunks_exact(self.stages).zip(modes) {
                for (j, &x) in rows.iter().enumerate() {
                    modes[j % 2][j / 2] += T::from_f64(share * x);
                }
            }
        }
    }

    /// The largest entries of the two parts of `missing` with their degrees of freedom. NaN counts
    /// as larger than every number.
    pub(super) fn largest(&self) -> [(f64, usize); 2] {
        let (q, p) = self.missing.split_at(self.stages * self.n);
        [q, p].map(|part| {
            let (mut most, mut at) = (0.0_f64, 0);
            for (k, x) in part.iter().enumerate() {
                let larger = x.abs() > most || x.is_nan();
                if larger && !most.is_nan() {
                    (most, at) = (x.abs(), k);
                }
            }
            (most, at / self.stages)
        })
    }
}

/// The positions of a derivative in the matrix, with rows and columns a_0, b_0, a_1, ..
fn places(&Entry { block, i, j, .. }: &Entry) -> [(usize, usize); 2] {
    match block {
        Block::Hqq | Block::Dq => [(2 * i + 1, 2 * j); 2],
        Block::Dp => [(2 * i + 1, 2 * j + 1); 2],
        Block::Hpp => [(2 * i, 2 * j + 1); 2],
        // ∂²H/∂q_i∂p_j is the derivative of ∂H/∂p_j with respect to q_i, and of ∂H/∂q_i with
        // respect to p_j.
        Block::Hqp => [(2 * j, 2 * i), (2 * i + 1, 2 * j + 1)],
    }
}
