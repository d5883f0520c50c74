//! The linear equations of a simplified Newton's iteration, in `f64`.
//!
//! With J the derivative of (∂H/∂p, -∂H/∂q - D) at the middle of the step and `X_ij = ∫ P_i(τ) ∫_0^τ P_j`, a tridiagonal matrix,
//! the correction δγ to what γ misses solves `(1 - h X ⊗ J) δγ = missing`: 2 s N unknowns.

use super::rule::{Modes, integration};
use crate::linear::{LinearSolver, Matrix, SMALL, Solver};
use afterbay_core::{Block, Coupling, Curvature, Scalar};

/// The most unknowns where everyone acts on everyone, and where neighbours do.
const DENSE: usize = 256;
const SPARSE: usize = 2048;

/// The matrix and its right-hand side.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    stages: usize,
    /// The places (i, j) with X_ij ≠ 0, and X_ij.
    integration: Vec<(usize, usize, f64)>,
    matrix: Matrix,
    unknowns: Vec<f64>,
    /// h times the largest entry of J.
    pub(super) gain: f64,
}

impl Equations {
    /// None where the system has too many degrees of freedom, or derivatives that belong to none.
    pub(super) fn new<T, S>(system: &S, stages: usize) -> Option<Self>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let size = 2 * stages * n;
        let dense = matches!(system.coupling(), Coupling::Dense);
        if size > if dense { DENSE } else { SPARSE } {
            return None;
        }
        let all = integration();
        let near = |i: usize| i.saturating_sub(1)..stages.min(i + 2);
        let integration: Vec<_> = (0..stages)
            .flat_map(|i| near(i).map(move |j| (i, j)))
            .filter(|&(i, j)| i != j || i == 0)
            .map(|(i, j)| (i, j, all[i][j]))
            .collect();
        let mut pattern: Vec<(usize, usize)> = (0..size).map(|i| (i, i)).collect();
        let origin = vec![T::zero(); n];
        let mut inside = true;
        system.curvature(&origin, &origin, |block, i, j, _| {
            inside &= i < n && j < n;
            for (row, column, _) in places(block, i, j) {
                let stage = |&(a, b, _): &(usize, usize, f64)| (row * stages + a, column * stages + b);
                pattern.extend(integration.iter().map(stage));
            }
        });
        let solver = match size {
            0..=SMALL => LinearSolver::Small,
            _ if dense => LinearSolver::Dense,
            _ => LinearSolver::Sparse,
        };
        let matrix = if inside { Matrix::new(solver, size, pattern).ok()? } else { return None };
        Some(Self { stages, integration, matrix, unknowns: vec![0.0; size], gain: 0.0 })
    }

    /// The derivatives at (q, p), factorised; the degree of freedom of a vanishing pivot is the failure.
    pub(super) fn factorise<T, S>(&mut self, system: &S, h: f64, q: &[T], p: &[T]) -> Result<(), usize>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let Self { stages, integration, matrix, gain, unknowns } = self;
        let mut most = 0.0_f64;
        matrix.values().fill(0.0);
        for i in 0..unknowns.len() {
            if let Some(slot) = matrix.slot(i, i) {
                matrix.values()[slot] = 1.0;
            }
        }
        system.curvature(q, p, |block, i, j, value| {
            let value = h * value.to_f64();
            most = most.max(value.abs());
            for (row, column, sign) in places(block, i, j) {
                for &(a, b, x) in &*integration {
                    if let Some(slot) = matrix.slot(row * *stages + a, column * *stages + b) {
                        matrix.values()[slot] -= sign * value * x;
                    }
                }
            }
        });
        *gain = most;
        matrix.factorise().map_err(|row| row / (2 * *stages))
    }

    /// Adds to γ the correction for what it misses, `next - γ`. The largest correction of q and of p.
    pub(super) fn correct<T: Scalar>(
        &mut self,
        next: [&[Modes<T>]; 2],
        [q_modes, p_modes]: [&mut [Modes<T>]; 2],
    ) -> [f64; 2] {
        let Self { stages, matrix, unknowns, .. } = self;
        let stages = *stages;
        for (d, rows) in unknowns.chunks_exact_mut(2 * stages).enumerate() {
            let (q, p) = rows.split_at_mut(stages);
            for (rows, next, modes) in [(q, &next[0][d], &q_modes[d]), (p, &next[1][d], &p_modes[d])] {
                for (j, x) in rows.iter_mut().enumerate() {
                    *x = (next[j % 2][j / 2] - modes[j % 2][j / 2]).to_f64();
                }
            }
        }
        matrix.solve(unknowns);
        let mut largest = [0.0_f64; 2];
        for (d, rows) in unknowns.chunks_exact(2 * stages).enumerate() {
            let (q, p) = rows.split_at(stages);
            let sides = [(q, &mut q_modes[d]), (p, &mut p_modes[d])];
            for ((rows, modes), largest) in sides.into_iter().zip(&mut largest) {
                for (j, &x) in rows.iter().enumerate() {
                    modes[j % 2][j / 2] += T::from_f64(x);
                    // What is not a number is larger than all.
                    *largest = if x.abs() <= *largest { *largest } else { x.abs() + 0.0 * *largest };
                }
            }
        }
        largest
    }
}

/// Where in J a derivative goes, by rows q_0, p_0, q_1, .. of what changes, with its sign: that of -p' and
/// -p where it is of p.
fn places(block: Block, i: usize, j: usize) -> impl Iterator<Item = (usize, usize, f64)> {
    let (q, p) = (|i: usize| 2 * i, |i: usize| 2 * i + 1);
    let [first, second] = match block {
        Block::Hqq | Block::Dq => [Some((p(i), q(j), 1.0)), None],
        Block::Dp => [Some((p(i), p(j), -1.0)), None],
        Block::Hpp => [Some((q(i), p(j), -1.0)), None],
        // ∂²H/∂q_i∂p_j changes ∂H/∂p_j with q_i, and ∂H/∂q_i with p_j.
        Block::Hqp => [Some((q(j), q(i), 1.0)), Some((p(i), p(j), -1.0))],
    };
    first.into_iter().chain(second)
}
