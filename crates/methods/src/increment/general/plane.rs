//! The step of one degree of freedom in its phase plane: two equations for x = Δq_j and y = Δp_j.
//!
//! ```text
//! x - h b̄ = 0        y + h (ā + D̄) = 0        D̄ = D_j(q0 + x/2, p0 + y/2) with the velocity x/h
//! q first:  ā from q0 to q0 + x at p0,      b̄ from p0 to p0 + y at q0 + x
//! p first:  b̄ from p0 to p0 + y at q0,      ā from q0 to q0 + x at p0 + y
//! ```

use afterbay_core::solver::newton_2x2::{Equations, solve};
use afterbay_core::{Mask, PhasePlane, Scalar, StepFailure};

/// The variable that moves first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Coordinate,
    Momentum,
}

/// A degree of freedom before its step.
pub(super) struct Plane<T> {
    pub(super) dof: usize,
    /// (q_j, p_j)
    pub(super) from: [T; 2],
    pub(super) h: T,
    pub(super) first: First,
    /// Whether the system is dissipative.
    pub(super) dissipative: bool,
    /// The largest |q_i| and |p_i|.
    pub(super) magnitudes: [T; 2],
}

/// The degree of freedom after its step.
pub(super) struct Moved<T> {
    pub(super) to: [T; 2],
    /// The increment of the reservoir; 0 without dissipation.
    pub(super) dw: T,
    pub(super) evaluations: u64,
}

impl<T: Scalar> Plane<T> {
    /// Takes the step with the other degrees of freedom held at `q` and `p`.
    pub(super) fn advance<S>(self, system: &S, q: &[T], p: &[T]) -> Result<Moved<T>, StepFailure>
    where
        S: PhasePlane<T> + ?Sized,
    {
        let Self { dof: j, from: [q0, p0], h, first, dissipative, magnitudes } = self;
        let resistance = |h: T, [x, y]: [T; 2]| {
            system.plane_dissipation(q, p, j, [q0 + x.half(), p0 + y.half()], x / h)
        };
        let root = solve(j, [q0, p0], magnitudes, |share, [x, y]| {
            let (h, q1, p1) = (share * h, q0 + x, p0 + y);
            let ((a, a_p), (b, b_q)) = match first {
                First::Coordinate => {
                    let a = system.along_q(q, p, j, [q0, q1], p0);
                    let b = system.along_p(q, p, j, q1, [p0, p1]);
                    ((a, T::zero()), (b, b.by_other))
                }
                First::Momentum => {
                    let b = system.along_p(q, p, j, q0, [p0, p1]);
                    let a = system.along_q(q, p, j, [q0, q1], p1);
                    ((a, a.by_other), (b, T::zero()))
                }
            };
            let mut residual = [(-h).mul_add(b.value, x), h.mul_add(a.value, y)];
            let mut excess = [[-(h * b_q), -(h * b.by_end)], [h * a.by_end, h * a_p]];
            if dissipative {
                let d = resistance(h, [x, y]);
                residual[1] = h.mul_add(d.value, residual[1]);
                excess[1][0] += h.mul_add(d.by_q.half(), d.by_v);
                excess[1][1] += h * d.by_p.half();
            }
            Equations { residual, excess }
        });
        let root = root.map_err(|failure| self.named(failure, system, q, p))?;
        let [x, y] = root.x;
        // The velocity is exactly Δq/h, so that rounding cannot make Δw negative where friction is
        // positive.
        let dw = if dissipative { resistance(h, [x, y]).value * x } else { T::zero() };
        Ok(Moved { to: [q0 + x, p0 + y], dw, evaluations: u64::from(root.evaluations) })
    }

    /// Replaces a failure by its cause, if the cause is a mean of ∂H/∂q that quadrature does not
    /// resolve.
    #[cold]
    fn named<S>(&self, failure: StepFailure, system: &S, q: &[T], p: &[T]) -> StepFailure
    where
        S: PhasePlane<T> + ?Sized,
    {
        let Self { dof, from: [q0, p0], h, .. } = *self;
        let finite = |x: T| x.is_finite().all();
        let slopes = |at: T| system.slopes(q, p, dof, [at, p0]);
        let to = h.mul_add(slopes(q0).hp, q0);
        let mean = system.along_q(q, p, dof, [q0, to], p0).value;
        if finite(to) && finite(slopes(q0).hq) && finite(slopes(to).hq) && !finite(mean) {
            return StepFailure::EdgeUnresolved { dof, from: q0.to_f64(), to: to.to_f64() };
        }
        failure
    }
}
