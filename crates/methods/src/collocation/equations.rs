//! The linear equations of the simplified Newton iteration, in `f64`.
//!
//! With J the derivative of (∂H/∂p, -∂H/∂q - D) at the middle of the step and
//! `X_ij = ∫ P_i(τ) ∫_0^τ P_j`, the correction δγ for the residual `missing` solves
//! `(1 - h X ⊗ J) δγ = missing` with 2 s N unknowns. Diagonalising X (`spectrum.rs`) decouples the
//! equations: for each eigenvalue μ, the components (a, b) of γ_q and -γ_p along its eigenvector
//! satisfy the equations of [`PhaseSpace`] with m = h μ.

use super::rule::{Modes, integration};
use super::spectrum::{self, Eigenvalue};
use crate::kernels::reductions::largest_entry;
use crate::linear::{Matrix, PhaseSpace, Unsolvable};
use afterbay_core::{Curvature, Scalar, StepFailure};
use faer::c64;

/// The matrices, one for each eigenvalue, and their right-hand sides.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    stages: usize,
    n: usize,
    spectrum: &'static [Eigenvalue],
    space: PhaseSpace,
    matrices: Vec<Matrix<c64>>,
    /// h
    h: f64,
    a: Vec<c64>,
    b: Vec<c64>,
    unknowns: Vec<c64>,
    /// The right-hand side by parts, degrees of freedom and coefficients; then the solution
    pub(super) missing: Vec<f64>,
    solution: Vec<f64>,
    /// h times the largest entry of J.
    pub(super) gain: f64,
}

/// The response of a degree of freedom to a defect of the slopes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// The errors of q and -p at the end of the step over its length, which are the means of the
    /// errors of their slopes.
    pub(crate) ends: [f64; 2],
    /// The remaining defects of q' and -p'.
    pub(crate) slopes: [f64; 2],
    /// The mean error of D due to those of q and p.
    pub(crate) friction: f64,
}

impl Equations {
    /// Allocates the equations of a system.
    ///
    /// # Errors
    /// [`StepFailure::TooLarge`] if the matrices exceed the memory limit; [`StepFailure::Singular`]
    /// if a derivative names a degree of freedom that does not exist, which the methods refuse
    /// before they allocate ([`check_derivatives`](crate::linear::check_derivatives)).
    pub(super) fn new<T, S>(system: &S, stages: usize) -> Result<Self, StepFailure>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let (n, spectrum) = (system.dof(), spectrum::of(stages));
        let space = PhaseSpace::new(system, spectrum.len()).map_err(|reason| match reason {
            Unsolvable::NoSuchDof(dof) => StepFailure::Singular { dof, slope: None },
            Unsolvable::TooLarge { unknowns, bytes } => StepFailure::TooLarge { unknowns, bytes },
        })?;
        let unknowns = space.size();
        let bytes = 16.0 * (spectrum.len() * unknowns) as f64 * unknowns as f64;
        let first = space.matrix().map_err(|_| StepFailure::TooLarge { unknowns, bytes })?;
        Ok(Self {
            stages,
            n,
            spectrum,
            space,
            matrices: vec![first; spectrum.len()],
            h: 0.0,
            a: vec![c64::ZERO; n],
            b: vec![c64::ZERO; n],
            unknowns: vec![c64::ZERO; unknowns],
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
        self.space.evaluate(system, q, p);
        (self.gain, self.h) = (h.abs() * self.space.largest(), h);
        let pairs = self.matrices.iter_mut().zip(self.spectrum);
        pairs.into_iter().try_for_each(|(matrix, Eigenvalue { value, .. })| {
            self.space.factorise(*value * h, matrix)
        })
    }

    /// Solves the equations in place of `missing`.
    pub(super) fn solve(&mut self) {
        let Self { stages, n, spectrum, space, matrices, h, .. } = self;
        let Self { missing, solution, a, b, unknowns, .. } = self;
        let (stages, n) = (*stages, *n);
        solution.fill(0.0);
        for (matrix, Eigenvalue { value, right, left }) in matrices.iter_mut().zip(*spectrum) {
            let part = |rows: &[f64]| {
                rows.iter().zip(left).fold(c64::ZERO, |sum, (&x, &left)| sum + left * x)
            };
            let (q, p) = missing.split_at(stages * n);
            let rows = q.chunks_exact(stages).zip(p.chunks_exact(stages));
            for ((a, b), (q, p)) in a.iter_mut().zip(&mut *b).zip(rows) {
                (*a, *b) = (part(q), -part(p));
            }
            space.solve(*value * *h, matrix, [a, b], unknowns);
            let (q, p) = solution.split_at_mut(stages * n);
            let rows = q.chunks_exact_mut(stages).zip(p.chunks_exact_mut(stages));
            for ((a, b), (q, p)) in a.iter().zip(&*b).zip(rows) {
                for ((q, p), right) in q.iter_mut().zip(p).zip(right) {
                    *q += right.re * a.re - right.im * a.im;
                    *p -= right.re * b.re - right.im * b.im;
                }
            }
        }
        std::mem::swap(missing, solution);
    }

    /// Solves the equations with a defect of q' and -p' that is a multiple of P_{s-1}, for each
    /// degree of freedom, and passes the responses to `see`. The part of the defect that these
    /// roundings of q and p may cause is left out.
    pub(super) fn respond(
        &mut self,
        roundings: impl Fn(usize) -> [f64; 2],
        defect: impl Fn(usize) -> [f64; 2],
        mut see: impl FnMut(usize, Response),
    ) {
        let (n, stages, last) = (self.n, self.stages, self.stages - 1);
        let Self { space, missing, solution, .. } = self;
        let (of_z, of_slopes) = solution[..4 * n].split_at_mut(2 * n);
        let [(of_q, of_p), (of_v, of_f)] = [of_z, of_slopes].map(|of| of.split_at_mut(n));
        (0..n).for_each(|d| [of_q[d], of_p[d]] = roundings(d));
        space.changes([of_q, of_p], [of_v, of_f]);
        missing.fill(0.0);
        let (q, p) = missing.split_at_mut(stages * n);
        let rows = q.chunks_exact_mut(stages).zip(p.chunks_exact_mut(stages));
        for (d, (q, p)) in rows.enumerate() {
            let [by_q, by_p] = defect(d);
            (q[last], p[last]) = (beyond(by_q, of_v[d]), beyond(by_p, of_f[d]));
        }
        self.solve();
        // `solution` is free now: it takes the mean errors of q and p, and of D.
        let Self { space, missing, solution, h, .. } = self;
        let mean = |row: &[f64]| *h * (integration()[0][0] * row[0] + integration()[0][1] * row[1]);
        let (q, p) = missing.split_at(stages * n);
        let (of_q, rest) = solution.split_at_mut(n);
        let (of_p, rest) = rest.split_at_mut(n);
        of_q.iter_mut().zip(q.chunks_exact(stages)).for_each(|(to, row)| *to = mean(row));
        of_p.iter_mut().zip(p.chunks_exact(stages)).for_each(|(to, row)| *to = -mean(row));
        space.friction(of_q, of_p, &mut rest[..n]);
        let rows = q.chunks_exact(stages).zip(p.chunks_exact(stages));
        for (d, ((q, p), &friction)) in rows.zip(&*rest).enumerate() {
            see(d, Response { ends: [q[0], p[0]], slopes: [q[last], p[last]], friction });
        }
    }

    /// Solves the equations with the errors at the end that [`Self::respond`] has shown as the
    /// defect of q' and -p', and shows the last coefficient but one of the solutions, divided by
    /// 2 (2s+1) |X_{s-1,s-2}|.
    pub(super) fn respond_again(&mut self, mut see: impl FnMut(usize, [f64; 2])) {
        let (size, stages, last) = (self.stages * self.n, self.stages, self.stages - 1);
        let scale = (2.0 * (2 * stages + 1) as f64 * integration()[last][last - 1]).recip();
        for row in self.missing.chunks_exact_mut(stages) {
            let end = row[0];
            row.fill(0.0);
            row[last] = end;
        }
        self.solve();
        let (q, p) = self.missing.split_at(size);
        let rows = q.chunks_exact(stages).zip(p.chunks_exact(stages));
        for (d, (q, p)) in rows.enumerate() {
            see(d, [scale * q[last - 1], scale * p[last - 1]]);
        }
    }

    /// Computes the residual of γ, `next - γ`.
    pub(super) fn set_residual<T: Scalar>(
        &mut self,
        next: [&[Modes<T>]; 2],
        modes: [&[Modes<T>]; 2],
    ) {
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
            let (most, at) = largest_entry(part.iter().map(|x| x.abs()));
            (most, at / self.stages)
        })
    }
}

/// The part of x beyond ± `bound`.
fn beyond(x: f64, bound: f64) -> f64 {
    if x.abs() > bound { x - bound.copysign(x) } else { 0.0 * x }
}
