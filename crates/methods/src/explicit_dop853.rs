//! DOP853 with a fixed step, without relaxation or projection.
//!
//! ```text
//! Z_i = z0 + h Σ_j a_ij f(Z_j)        z1 = z0 + h Σ_i b_i f(Z_i)
//! z = (q, p, w)        f = (∂H/∂p, -∂H/∂q - D, D ∂H/∂p)
//! ```
//!
//! Source: E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I,
//! section II.5. Order 8 in q, p and w, explicit, applies to any system, also to eight side by
//! side. K is not kept. The studies of attractors take their references from it. Where forces jump
//! or have a kink, in t or at values of q and p (`explicit_dop853/kinks.rs`), a step consists of
//! several shorter ones. It **fails** and leaves the state unchanged where a number is not finite,
//! and where the kinks in a step have no end.

mod kinks;

use crate::commit::commit;
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use crate::runge_kutta::{Dop853, P, Q, Stages, Tableau, W};
use afterbay_core::{
    Abilities, Effort, InputError, Mask, Method, Scalar, State, StepFailure, System, Vector, f64x8,
};
use kinks::{Kinks, Part, across};

/// The most parts of a step that end before or at a kink, or soon after it. A passage takes about
/// 60.
const MOST_PARTS: u32 = 2048;

/// DOP853 with a fixed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExplicitDop853;

/// The stages, q, p and w at the end of the step, and the kinks near it.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<V: Vector> {
    stages: Stages<V>,
    end: [V; 3],
    kinks: Kinks<V>,
}

impl Binding for ExplicitDop853 {
    const LANES: Option<InLanes<Self>> = Some(bind_lanes);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, dyn Abilities<V::Scalar>, _>(*self, target.system.clone())
    }
}

/// Binds to eight systems without kinks, which divide steps of each system at other places.
fn bind_lanes(method: &ExplicitDop853, target: &Target<'_, f64x8>) -> Bound<f64x8> {
    let origin = vec![f64x8::zero(); target.system.dof()];
    if Kinks::<Vec<_>>::exist(&**target.system, &origin, &origin) {
        return Err(target.refused("kinks divide the steps of each system at other places"));
    }
    method.bind_stored(target)
}

impl<V, S> Method<V, S> for ExplicitDop853
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let end = [0; 3].map(|_| V::zeros(system.dof()));
        let (stages, kinks) = (Stages::new(system, Dop853::ROWS.len()), Kinks::new(system.dof()));
        Ok(Workspace { stages, end, kinks })
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
        let mut part = system.step_between_breaks(state.q.as_slice(), h);
        let has_kinks = Kinks::<V>::exist(system, state.q.as_slice(), state.p.as_slice());
        if part == h && !has_kinks {
            return smooth_step(system, h, state, workspace);
        }
        let before = state.clone();
        let (mut effort, mut left, mut shortened) = (Effort::default(), h, 0);
        loop {
            let done = if shortened == MOST_PARTS {
                Err(StepFailure::KinksAccumulate { parts: MOST_PARTS })
            } else if has_kinks {
                step_near_kinks(system, [h, part], state, workspace)
            } else {
                smooth_step(system, part, state, workspace).map(|effort| (part, effort))
            };
            let (done, more) = match done {
                Ok(done) => done,
                Err(failure) => {
                    *state = before;
                    return Err(failure);
                }
            };
            effort += more;
            left -= done;
            if left.le(V::Scalar::zero()).all() {
                return Ok(effort);
            }
            shortened += u32::from(done != part);
            part = system.step_between_breaks(state.q.as_slice(), left);
        }
    }
}

/// One step of at most `most`, a part of a step h, that ends at the next kink at most. Returns its
/// length.
fn step_near_kinks<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    [h, most]: [V::Scalar; 2],
    state: &mut State<V>,
    workspace: &mut Workspace<V>,
) -> Result<(V::Scalar, Effort), StepFailure> {
    let Workspace { stages, end, kinks } = workspace;
    stages.begin(system, state);
    let Part { mut length, mut crosses } = kinks.part(system, [h, most], state, stages);
    let mut evaluations = 1;
    loop {
        let mut passed = false;
        stages.advance_seen::<Dop853, S>(system, length, state, |q, p| {
            passed |= kinks.passed(system, q, p);
        });
        sum(stages, length, state, end);
        evaluations += Dop853::ROWS.len() as u64 - 1;
        let [q, p, _] = end.each_ref().map(V::as_slice);
        let whole = length == most;
        if crosses && !whole && !kinks.left(system, q, p) {
            // Roundings of q or p hide so short a motion.
            length = shorter(length + length, most);
        } else if !crosses && (passed || kinks.passed(system, q, p)) {
            // The motion turned towards a kink.
            length = length.half();
            crosses = length.to_f64().abs() < across(h).to_f64().abs();
        } else {
            commit(state, end.each_ref().map(V::as_slice), stages.is_dissipative())?;
            return Ok((length, Effort { evaluations, iterations: 0 }));
        }
    }
}

fn shorter<T: Scalar>(a: T, b: T) -> T {
    if a.to_f64().abs() < b.to_f64().abs() { a } else { b }
}

/// One step in which the field is smooth.
fn smooth_step<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    workspace: &mut Workspace<V>,
) -> Result<Effort, StepFailure> {
    let Workspace { stages, end, .. } = workspace;
    stages.begin(system, state);
    stages.advance::<Dop853, S>(system, h, state);
    sum(stages, h, state, end);
    commit(state, end.each_ref().map(V::as_slice), stages.is_dissipative())?;
    Ok(Effort { evaluations: Dop853::ROWS.len() as u64, iterations: 0 })
}

/// Computes the end of a step from its stages.
fn sum<V: Vector>(stages: &Stages<V>, h: V::Scalar, state: &State<V>, [q, p, w]: &mut [V; 3]) {
    stages.add::<Q>(Dop853::WEIGHTS, h, &state.q, q);
    stages.add::<P>(Dop853::WEIGHTS, h, &state.p, p);
    stages.add::<W>(Dop853::WEIGHTS, h, &state.w, w);
}
