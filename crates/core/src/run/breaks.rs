//! Fixed steps across breaks: instants at which V(q, t) or D(q, p, t) jumps or has a kink in t.

use super::method::{Effort, Method};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar, Vector};
use crate::quantity::Quantity;
use crate::system::{State, System};

/// The longest part of a step that passes a break, in roundings of the time. A break is passed in a
/// few tens of them.
const ROUNDINGS_AT_BREAK: f64 = 256.0;

/// Takes one step of a method, in parts that end at the breaks of the system
/// ([`System::has_breaks`]). There are no lanes where it has breaks.
///
/// # Errors
/// A [`StepFailure`] of a part; the state is then unchanged.
#[inline(always)]
pub fn step_in_parts<V, S, M>(
    method: &M,
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    workspace: &mut M::Workspace,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
{
    let zero = V::Scalar::zero();
    if !system.has_breaks() || h.le(zero).all() {
        return method.step(system, h, state, workspace);
    }
    let (mut effort, mut left, before) = (Effort::default(), h, state.clone());
    let clock = system.dof() - system.motors();
    while zero.lt(left).all() {
        let part = system.step_between_breaks(state.q.as_slice(), left);
        effort += if is_at_break(part, state.q.as_slice()[clock]) {
            pass_break(method, system, part, state, workspace)
        } else {
            method.step(system, part, state, workspace)
        }
        .inspect_err(|_| state.copy(&before))?;
        left -= part;
    }
    Ok(effort)
}

/// Whether a part of a step is so short that it passes a break.
fn is_at_break<T: Scalar>(part: T, time: T) -> bool {
    part.le(T::from_f64(ROUNDINGS_AT_BREAK * f64::EPSILON) * time.abs()).all()
}

/// Passes a break by a step of a few roundings of the time, or where the motion stands if the
/// method fails there. The energy pumped is that by which K would change: the method evaluates
/// ∂V/∂t on both sides of the break.
///
/// # Errors
/// [`StepFailure::NonFinite`] where H has no value behind the break.
#[cold]
fn pass_break<V, S, M>(
    method: &M,
    system: &S,
    part: V::Scalar,
    state: &mut State<V>,
    workspace: &mut M::Workspace,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
{
    let clock = system.dof() - system.motors();
    let (energy, held) = (state.energy(system), state.reservoir());
    let taken = method.step(system, part, state, workspace);
    if taken.is_err() {
        state.q.as_mut_slice()[clock..].iter_mut().for_each(|time| *time += part);
    }
    let end = state.energy(system);
    let pumped = end - energy + (state.reservoir() - held);
    if !pumped.is_finite().all() {
        return Err(StepFailure::non_finite(&[(Quantity::Energy, &[energy, end])]));
    }
    state.p.as_mut_slice()[clock] -= pumped;
    Ok(taken.unwrap_or_default())
}
