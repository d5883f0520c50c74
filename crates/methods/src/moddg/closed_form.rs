//! The closed-form solution of the scheme for linear systems.

use super::steps::{StepSizes, Steps};
use super::{ModDg, commit, one_degree_of_freedom};
use afterbay_core::{
    Effort, InputError, Linear, Mask, Method, Quantity, Scalar, State, StepFailure, Vector,
};
use std::hint::cold_path;

/// For V = k q²/2, D = b p the equation is linear in v:
///
/// ```text
/// v = (p0 - δ(p)/2 k q0) / σ        σ = 1 + δ(p)/2 (b + δ(q) k/2)
/// ```
///
/// The increments of q and p are evaluated as linear functions of (q0, p0). Their coefficients
/// depend on the step size alone, so a loop computes them once. They are O(h), so their rounding
/// errors change K by O(h) roundings only.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClosedForm;

impl<V, S, D> Method<V, S> for ModDg<D, ClosedForm>
where
    V: Vector,
    S: Linear<V::Scalar> + ?Sized,
    D: Steps<V::Scalar, S>,
{
    type Workspace = ();

    fn workspace(&self, system: &S) -> Result<(), InputError> {
        one_degree_of_freedom(system)
    }

    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        true
    }

    #[inline(always)]
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        _workspace: &mut (),
    ) -> Result<Effort, StepFailure> {
        let one = V::Scalar::one();
        let [q0, p0, w0] = [state.q.as_slice()[0], state.p.as_slice()[0], state.w.as_slice()[0]];
        let StepSizes { q: delta_q, p: delta_p, w: delta_w } =
            self.steps.sizes(system, h, q0, p0)?;
        let (k, b) = (system.stiffness(0, 0), system.dissipation_rate(0));

        let friction = (delta_q * k).half() + b;
        let sigma = delta_p.half().mul_add(friction, one);
        let inverse = sigma.recip();
        let p_factor = delta_p * inverse;
        let v = (-p_factor * k.half()).mul_add(q0, inverse * p0);
        let q_factor = delta_q * inverse;
        let mut q1 = q_factor.mul_add(p0, (-q_factor * (delta_p * k).half()).mul_add(q0, q0));
        let mut p1 = (-p_factor * k).mul_add(q0, (-p_factor * friction).mul_add(p0, p0));
        if !one.half().le(sigma).and(sigma.is_finite()).all() {
            cold_path();
            if !sigma.is_finite().all() {
                return Err(StepFailure::NonFinite {
                    quantity: Quantity::Force,
                    dof: 0,
                    value: sigma.to_f64(),
                });
            }
            // Near a singular step the coefficients lose digits. Computing all increments from one
            // v then still conserves K.
            let regular = one.half().le(sigma);
            q1 = V::Scalar::select(regular, q1, delta_q.mul_add(v, q0));
            p1 = V::Scalar::select(regular, p1, (one + one).mul_add(v, -p0));
        }
        let w1 = (!system.dissipation_form().zero).then(|| (delta_w * b * v).mul_add(v, w0));
        let singular = |failure| match sigma == V::Scalar::zero() {
            true => StepFailure::Singular { dof: 0, slope: Some(0.0) },
            false => failure,
        };
        commit(state, q1, p1, w1).map_err(singular)?;
        Ok(Effort { evaluations: 1, iterations: 0 })
    }
}
