//! The classical fourth-order Runge-Kutta method on (q, p, w), called eRK4 in the paper.
//!
//! ```text
//! Z2 = z0 + h/2 f(z0)        Z3 = z0 + h/2 f(Z2)        Z4 = z0 + h f(Z3)
//! z1 = z0 + h/6 (f(z0) + 2 f(Z2) + 2 f(Z3) + f(Z4))
//! f = (∂H/∂p, -∂H/∂q - D, D ∂H/∂p)
//! ```
//!
//! W. Kutta, Z. Math. Phys. 46 (1901) 435-453. The method has order 4, is explicit, and applies to
//! any system. The error of K is O(h⁴). Since the weights are positive, Δw ≥ 0 for every passive
//! system, whatever H is. The method is unstable for |hλ| larger than about 2.8.
//!
//! No equation is **solved**. A step **fails** and leaves the state unchanged where a number is not
//! finite ([`StepFailure::NonFinite`]).

use crate::commit::{not_finite_by_value, store};
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use afterbay_core::{
    Abilities, Effort, InputError, Mask, Method, Scalar, State, StepFailure, System, Vector,
};

/// The classical Runge-Kutta method of order 4 (eRK4 of the paper).
#[derive(Clone, Copy, Debug, Default)]
pub struct Rk4;

/// The point of the current stage, the derivatives and the forces of motors there, and the weighted
/// sums of the stage increments so far; the sum for p has the opposite sign.
#[derive(Clone, Debug)]
pub struct Workspace<V> {
    q: V,
    p: V,
    hq: V,
    hp: V,
    d: V,
    forces: V,
    dq: V,
    dp: V,
    dw: V,
}

/// A stage.
#[derive(Clone, Copy, Debug)]
struct Stage {
    /// Its time, in units of h.
    time: f64,
    /// The offset of the next stage from the start of the step, in units of h.
    ahead: f64,
    /// Its weight, in units of h/6.
    weight: f64,
}

const STAGES: [Stage; 4] = [
    Stage { time: 0.0, ahead: 0.5, weight: 1.0 },
    Stage { time: 0.5, ahead: 0.5, weight: 2.0 },
    Stage { time: 0.5, ahead: 1.0, weight: 2.0 },
    Stage { time: 1.0, ahead: 0.0, weight: 1.0 },
];

impl Binding for Rk4 {
    const LANES: Option<InLanes<Self>> = Some(Self::bind_stored);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, dyn Abilities<V::Scalar>, _>(*self, target.system.clone())
    }
}

impl<V, S> Method<V, S> for Rk4
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let zeros = || V::zeros(system.dof());
        Ok(Workspace {
            q: zeros(),
            p: zeros(),
            hq: zeros(),
            hp: zeros(),
            d: zeros(),
            forces: zeros(),
            dq: zeros(),
            dp: zeros(),
            dw: zeros(),
        })
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
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        // Hoisted out of the stages.
        if system.dissipation_form().zero {
            advance::<V, S, false>(system, h, state, workspace)
        } else {
            advance::<V, S, true>(system, h, state, workspace)
        }
    }
}

/// Takes one step. `DISSIPATIVE` is false for systems with D = 0.
#[inline(always)]
fn advance<V, S, const DISSIPATIVE: bool>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    workspace: &mut Workspace<V>,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    let n = state.dof();
    let zero = V::Scalar::zero();
    let Workspace { q, p, hq, hp, d, forces, dq, dp, dw } = workspace;
    let (q, p) = (q.as_mut_slice(), p.as_mut_slice());
    let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
    let forces = forces.as_mut_slice();
    let (dq, dp, dw) = (dq.as_mut_slice(), dp.as_mut_slice(), dw.as_mut_slice());
    let (q0, p0, w0) = (state.q.as_slice(), state.p.as_slice(), state.w.as_slice());

    for j in 0..n {
        (q[j], p[j]) = (q0[j].read(), p0[j].read());
        (dq[j], dp[j], dw[j]) = (zero, zero, zero);
    }
    let driven = system.motors() > 0;
    let mut known = None;
    for Stage { time, ahead, weight } in STAGES {
        let ahead = h * V::Scalar::from_f64(ahead);
        let weight = h * (V::Scalar::from_f64(weight) / V::Scalar::from_f64(6.0));
        system.gradient(q, p, hq, hp);
        if DISSIPATIVE {
            if driven {
                if known != Some(time) {
                    known = system.motor_forces(q, forces).then_some(time);
                }
                system.dissipation_under(forces, q, p, hp, d);
            } else {
                system.dissipation(q, p, hp, d);
            }
        }
        for j in 0..n {
            dq[j] = weight.mul_add(hp[j], dq[j]);
            dp[j] = weight.mul_add(hq[j], dp[j]);
            q[j] = ahead.mul_add(hp[j], q0[j]);
            p[j] = (-ahead).mul_add(hq[j], p0[j]);
            if DISSIPATIVE {
                dp[j] = weight.mul_add(d[j], dp[j]);
                p[j] = (-ahead).mul_add(d[j], p[j]);
                dw[j] = weight.mul_add(d[j] * hp[j], dw[j]);
            }
        }
    }
    let mut finite = zero.is_finite();
    for j in 0..n {
        (q[j], p[j], dw[j]) = (q0[j] + dq[j], p0[j] - dp[j], w0[j] + dw[j]);
        finite = finite.and(q[j].is_finite()).and(p[j].is_finite()).and(dw[j].is_finite());
    }
    if !finite.all() {
        return Err(not_finite_by_value([q, p, dw].map(|part| V::filled(part, |x| x))));
    }
    store(state, [q, p, dw], DISSIPATIVE);
    Ok(Effort { evaluations: 4, iterations: 0 })
}
