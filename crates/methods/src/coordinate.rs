//! One coordinate moved along its edge: the equation of modDG and of each coordinate of a sweep, for the mean momentum v.
//!
//! ```text
//! v = p0 - δ(p)/2 (mean of ∂V/∂q along the edge + D̄)        q1 = q0 + δ(q) v/m        p1 = 2 v - p0
//! Δw = δ(w)/m D̄ v        D̄ = D((q0 + q1)/2, v)
//! ```

use afterbay_core::solver::{Sample, Solver};
use afterbay_core::{Drag, Line, Scalar, StepFailure};

/// A coordinate before its step.
pub(crate) struct Coordinate<T> {
    pub(crate) dof: usize,
    pub(crate) q: T,
    pub(crate) p: T,
    /// δ(q)/m, δ(p) and δ(w)/m.
    pub(crate) steps: [T; 3],
    /// The largest |q_i|. Forces of that size may cancel here, and what is left has their rounding.
    pub(crate) reach: T,
    /// Is there a D?
    pub(crate) dissipative: bool,
}

/// The same coordinate after it.
pub(crate) struct Moved<T> {
    pub(crate) q: T,
    pub(crate) p: T,
    /// What the reservoir gains; 0 without dissipation.
    pub(crate) dw: T,
    pub(crate) evaluations: u64,
}

impl<T: Scalar> Coordinate<T> {
    /// Moves it. `force(to, middle, v)` gives the mean of ∂V/∂q along the edge from q to `to`, and D at (`middle`, v).
    #[inline(always)]
    pub(crate) fn advance(
        self,
        solver: &impl Solver,
        mut force: impl FnMut(T, T, T) -> (Line<T>, Drag<T>),
    ) -> Result<Moved<T>, StepFailure> {
        let Self { dof, q: q0, p: p0, steps: [rate, delta_p, drain], reach, dissipative } = self;
        let half_p = delta_p.half();
        // The step sizes shrink with `share`, from the step wanted (1) to none (0).
        let root = solver.solve(dof, p0, |share, v| {
            let (width, pull) = (share * rate, share * half_p);
            let (edge, drag) = force(width.mul_add(v, q0), width.half().mul_add(v, q0), v);
            if !dissipative {
                let by_q = pull * edge.slope;
                let (rough, blur) = ((by_q * q0).abs(), by_q.abs() * reach);
                return Sample { value: pull * edge.value, slope: width * by_q, rough, blur };
            }
            let by_q = pull * (edge.slope + drag.by_q.half());
            Sample {
                value: pull.mul_add(edge.value, pull * drag.value),
                slope: width.mul_add(by_q, pull * drag.by_p),
                rough: (by_q * q0).abs(),
                blur: by_q.abs() * reach,
            }
        })?;
        let v = root.x;
        let q = rate.mul_add(v, q0);
        let dw =
            if dissipative { drain * force(q, rate.half().mul_add(v, q0), v).1.value * v } else { T::zero() };
        let p = T::from_f64(2.0).mul_add(v, -p0);
        Ok(Moved { q, p, dw, evaluations: u64::from(root.evaluations) })
    }
}
