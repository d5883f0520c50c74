//! Coordinate increments for H that is not separable.
//!
//! The degrees of freedom are updated one after the other. Each moves q_j along an edge, then p_j:
//!
//! ```text
//! Δq_j = h b̄_j        Δp_j = -h (ā_j + D̄_j)        Δw_j = D̄_j Δq_j
//! ā_j = mean of ∂H/∂q_j from (q0_j, p0_j) to (q1_j, p0_j)
//! b̄_j = mean of ∂H/∂p_j from (q1_j, p0_j) to (q1_j, p1_j)
//! D̄_j = D_j at the midpoint, with the velocity Δq_j/h
//! ```
//!
//! The other degrees of freedom are held fixed. H changes by `ā Δq + b̄ Δp = -D̄ Δq`, so K is exact
//! for any step size, any N and any D, provided ā and b̄ are means to rounding ([`PhasePlane`]).
//! Each degree of freedom has two equations; no linear algebra is needed, and a sweep costs O(N)
//! where the coupling is local. One sweep has order 1, also with one degree of freedom. Its adjoint
//! traverses the degrees of freedom in reversed order and moves p_j first, at q0_j, then q_j at
//! p1_j. Half a step of each is symmetric and has order 2; [`Composition`]s have higher orders. For
//! separable H this is [`super::Increment`].
//!
//! It is passive in each degree of freedom where D = R ∂H/∂p with R diagonal, as long as no substep
//! runs backwards in time; beyond order 2 some do. D that couples the velocities is refused. A step
//! **fails** and leaves the state unchanged where the equations have no solution that continues
//! from h = 0.

mod plane;

use super::before::Before;
use super::{Composition, ordering};
use crate::balance::{Account, check_step};
use crate::hidden_coupling::states_coupling;
use crate::kernels::reductions::largest;
use afterbay_core::{
    Effort, InputError, Method, PhasePlane, Scalar, Slopes, State, StepFailure, Vector,
};
use plane::{First, Plane};

/// The coordinate-increment discrete gradient for any H, a composition of forward and backward
/// sweeps.
#[derive(Clone, Debug)]
pub struct GeneralIncrement {
    composition: Composition,
    order: Option<Vec<usize>>,
}

impl GeneralIncrement {
    /// Uses `composition` with the degrees of freedom in their natural order.
    pub fn new(composition: Composition) -> Self {
        Self { composition, order: None }
    }

    /// Updates the degrees of freedom in the given order. `order` must contain each of 0 to N - 1
    /// exactly once; [`Method::workspace`] refuses others.
    pub fn in_order(self, order: Vec<usize>) -> Self {
        Self { order: Some(order), ..self }
    }
}

/// The state before the step, and the order of the degrees of freedom.
#[derive(Clone, Debug)]
pub struct Workspace<V> {
    before: Before<V>,
    order: Vec<usize>,
}

impl<V, S> Method<V, S> for GeneralIncrement
where
    V: Vector,
    S: PhasePlane<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        const METHOD: &str = "general increment";
        if system.dissipation_form().coupled {
            let why = "D couples the velocities: take gonzalez";
            return Err(InputError::Unsupported { method: METHOD, why });
        }
        states_coupling(METHOD, system, false)?;
        let n = system.dof();
        let order = ordering(METHOD, self.order.as_ref(), n)?;
        Ok(Workspace { before: Before::new(n), order })
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { before, order } = workspace;
        let sweeps = |state: &mut State<V>| {
            let mut effort = Effort::default();
            for (i, fraction) in self.composition.fractions::<V::Scalar>().enumerate() {
                let h = fraction * h;
                // The state does not change, and the velocity Δq/h is undefined.
                if h == V::Scalar::zero() {
                    continue;
                }
                effort += match i % 2 {
                    0 => sweep(system, h, state, First::Coordinate, order.iter().copied())?,
                    _ => sweep(system, h, state, First::Momentum, order.iter().rev().copied())?,
                };
            }
            Ok(effort.shared_by(order.len()))
        };
        before.attempt_and(state, sweeps, |before, after| balanced(system, before, after))
    }
}

/// Checks K over a step. It is lost where a quadrature does not resolve a mean, and near overflow,
/// where Newton's method may stop at a state that does not solve the equations.
fn balanced<T: Scalar, S: PhasePlane<T> + ?Sized>(
    system: &S,
    before: [&[T]; 3],
    after: [&[T]; 3],
) -> Result<(), StepFailure> {
    let account = |q: &[T], p: &[T]| {
        let energy = system.energy(q, p);
        Account { energy, size: energy.abs() }
    };
    // The kinetic and the potential energy may cancel in H.
    let second_order = || {
        let at = |[q, p, _]: [&[T]; 3]| {
            (0..q.len()).fold(T::zero(), |sum, j| {
                let Slopes { hq, hp, .. } = system.slopes(q, p, j, [q[j], p[j]]);
                sum + ((hq * q[j]).abs() + (hp * p[j]).abs())
            })
        };
        Ok(at(before) + at(after))
    };
    check_step(before, after, account, second_order)
}

/// Updates every degree of freedom once, in the given order.
fn sweep<V, S>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    first: First,
    order: impl Iterator<Item = usize>,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: PhasePlane<V::Scalar> + ?Sized,
{
    let dissipative = !system.dissipation_form().zero;
    let (q, p, w) = (state.q.as_mut_slice(), state.p.as_mut_slice(), state.w.as_mut_slice());
    let magnitudes = [largest(q), largest(p)];
    let mut evaluations = 0;
    for j in order {
        let plane = Plane { dof: j, from: [q[j], p[j]], h, first, dissipative, magnitudes };
        let moved = plane.advance(system, q, p)?;
        [q[j], p[j]] = moved.to;
        w[j] += moved.dw;
        evaluations += moved.evaluations;
    }
    Ok(Effort { evaluations, iterations: evaluations })
}
