//! DOP853 with a fixed step, without relaxation or projection.
//!
//! ```text
//! Z_i = z0 + h Σ_j a_ij f(Z_j)        z1 = z0 + h Σ_i b_i f(Z_i)
//! z = (q, p, w)        f = (∂H/∂p, -∂H/∂q - D, D ∂H/∂p)
//! ```
//!
//! Source: E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I,
//! section II.5. Order 8 in q, p and w, explicit, applies to any system, also to eight side by
//! side. K is not kept. The studies of driven systems take their references from it. Where the
//! forces of a drive jump in t or have a kink, a step consists of several shorter ones. It
//! **fails** and leaves the state unchanged where a number is not finite.

use crate::commit::commit;
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use crate::runge_kutta::{Dop853, P, Q, Stages, Tableau, W};
use afterbay_core::{
    Abilities, Effort, InputError, Mask, Method, Scalar, State, StepFailure, System, Vector,
};

/// DOP853 with a fixed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExplicitDop853;

/// The stages, and q, p and w at the end of the step.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<V: Vector> {
    stages: Stages<V>,
    end: [V; 3],
}

impl Binding for ExplicitDop853 {
    const LANES: Option<InLanes<Self>> = Some(Self::bind_stored);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, dyn Abilities<V::Scalar>, _>(*self, target.system.clone())
    }
}

impl<V, S> Method<V, S> for ExplicitDop853
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let end = [0; 3].map(|_| V::zeros(system.dof()));
        Ok(Workspace { stages: Stages::new(system, Dop853::ROWS.len()), end })
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let first = system.step_between_breaks(state.q.as_slice(), h);
        if first == h {
            return smooth_step(system, h, state, workspace);
        }
        let before = state.clone();
        let (mut effort, mut left, mut part) = (Effort::default(), h, first);
        loop {
            match smooth_step(system, part, state, workspace) {
                Ok(more) => effort += more,
                Err(failure) => {
                    *state = before;
                    return Err(failure);
                }
            }
            left -= part;
            if left.le(V::Scalar::zero()).all() {
                return Ok(effort);
            }
            part = system.step_between_breaks(state.q.as_slice(), left);
        }
    }
}

/// One step in which the field is smooth.
fn smooth_step<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    workspace: &mut Workspace<V>,
) -> Result<Effort, StepFailure> {
    let Workspace { stages, end: [q, p, w] } = workspace;
    stages.begin(system, state);
    stages.advance::<Dop853, S>(system, h, state);
    stages.add::<Q>(Dop853::WEIGHTS, h, &state.q, q);
    stages.add::<P>(Dop853::WEIGHTS, h, &state.p, p);
    stages.add::<W>(Dop853::WEIGHTS, h, &state.w, w);
    let dissipative = !system.dissipation_form().zero;
    commit(state, [q.as_slice(), p.as_slice(), w.as_slice()], dissipative)?;
    Ok(Effort { evaluations: Dop853::ROWS.len() as u64, iterations: 0 })
}
