//! DOP853 with a fixed step, without relaxation or projection.
//!
//! ```text
//! Z_i = z0 + h Σ_j a_ij f(Z_j)        z1 = z0 + h Σ_i b_i f(Z_i)
//! z = (q, p, w)        f = (∂H/∂p, -∂H/∂q - D, D ∂H/∂p)
//! ```
//!
//! Source: E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I,
//! section II.5. Order 8 in q, p and w, explicit, applies to any system, also to eight side by
//! side. K is not kept. The studies of attractors take their references from it. A step consists of
//! several parts where forces jump or have a kink, in t or at values of q and p
//! (`explicit_dop853/kinks.rs`), and where it does not resolve the motion
//! (`explicit_dop853/division.rs`). It **fails** and leaves the state unchanged where a number is
//! not finite, and where too many parts do not reach the end of the step.

mod division;
mod kinks;
mod resolution;

use crate::commit::{not_finite, store};
use crate::kernels::reductions::finite_in_lanes;
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use crate::runge_kutta::{Dop853, P, Q, Stages, Tableau, W};
use afterbay_core::{
    Abilities, Effort, InputError, Mask, Method, Scalar, State, StepFailure, System, Vector,
};
use division::{Division, Trial, nowhere};
use kinks::{Kinks, Part};
use resolution::{Resolution, SLOPES};

/// The most parts of a step, those included that are taken again. The passage of a kink takes
/// about 60.
const MOST_PARTS: u32 = 2048;

/// DOP853 with a fixed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExplicitDop853;

/// The stages, (q, p, w) at the start of the step and at the end of a part, and the kinks near it.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<V: Vector> {
    stages: Stages<V>,
    start: [V; 3],
    end: [V; 3],
    kinks: Kinks<V>,
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
        let n = system.dof();
        let zeros = || [0; 3].map(|_| V::zeros(n));
        let (stages, kinks) = (Stages::new(system, SLOPES), Kinks::new(n));
        Ok(Workspace { stages, start: zeros(), end: zeros(), kinks })
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
        let mut division = Division::new(h);
        for parts in 1..=MOST_PARTS {
            let trial = try_part(system, &division, state, workspace);
            let accepted = division.judge(&trial);
            let Workspace { stages, start, end, .. } = workspace;
            if parts == 1 && !division.is_complete() {
                copy([&state.q, &state.p, &state.w], start);
            }
            if division.is_stuck() {
                let failure = not_finite(end.each_ref().map(V::as_slice));
                store(state, start.each_ref().map(V::as_slice), true);
                return Err(failure);
            }
            let dissipative = stages.is_dissipative();
            commit_where(accepted, state, end.each_ref().map(V::as_slice), dissipative);
            if division.is_complete() {
                let evaluations = u64::from(parts) * SLOPES as u64;
                return Ok(Effort { evaluations, iterations: 0 });
            }
        }
        store(state, workspace.start.each_ref().map(V::as_slice), true);
        Err(StepFailure::PartsAccumulate { parts: MOST_PARTS })
    }
}

/// Computes the end of the next part of a step.
fn try_part<V: Vector, S: System<V::Scalar> + ?Sized>(
    system: &S,
    division: &Division<V::Scalar>,
    state: &State<V>,
    workspace: &mut Workspace<V>,
) -> Trial<V::Scalar> {
    let Workspace { stages, end, kinks, .. } = workspace;
    stages.begin(system, state);
    let most = division.most(system.step_between_breaks(state.q.as_slice(), division.left()));
    let Part { length, crosses } = kinks.part(system, division, most, state, stages);
    let mut passed = nowhere::<V::Scalar>();
    stages.advance_seen::<Dop853, S>(system, length, state, |q, p| {
        passed = passed.or(kinks.passed(system, q, p));
    });
    let [q, p, w] = end;
    stages.add::<Q>(Dop853::WEIGHTS, length, &state.q, q);
    stages.add::<P>(Dop853::WEIGHTS, length, &state.p, p);
    stages.add::<W>(Dop853::WEIGHTS, length, &state.w, w);
    let resolution = Resolution::of(system, length, state, [&*q, &*p], stages);
    let [q, p, w] = end.each_ref().map(V::as_slice);
    Trial {
        length,
        most,
        crosses,
        passed: passed.or(kinks.passed(system, q, p)),
        leaves: kinks.leaves(system, q, p),
        finite: finite_in_lanes(q).and(finite_in_lanes(p)).and(finite_in_lanes(w)),
        resolution,
    }
}

fn copy<V: Vector>(from: [&V; 3], to: &mut [V; 3]) {
    for (to, from) in to.iter_mut().zip(from) {
        to.as_mut_slice().copy_from_slice(from.as_slice());
    }
}

/// Stores q, p and w in the lanes in which a part is accepted.
fn commit_where<V: Vector>(
    accepted: <V::Scalar as Scalar>::Mask,
    state: &mut State<V>,
    end: [&[V::Scalar]; 3],
    dissipative: bool,
) {
    if accepted.all() {
        return store(state, end, dissipative);
    }
    for (to, from) in [&mut state.q, &mut state.p, &mut state.w].into_iter().zip(end) {
        for (to, &from) in to.as_mut_slice().iter_mut().zip(from) {
            *to = V::Scalar::select(accepted, from, *to);
        }
    }
}
