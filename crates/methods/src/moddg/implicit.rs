//! The solution of the scheme for any system, by iteration.

use super::steps::Steps;
use super::{ModDg, commit, one_degree_of_freedom};
use crate::balance::{Account, check, second_order_of_potential};
use crate::coordinate::{Coordinate, Edge, Rates};
use afterbay_core::solver::Solver;
use afterbay_core::{Effort, InputError, Method, Scalar, Separable, State, StepFailure, Vector};

impl<V, S, D, E> Method<V, S> for ModDg<D, E>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
    D: Steps<V::Scalar, S>,
    E: Solver,
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
    fn refuses_singularities(&self) -> bool {
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
        let [q, p, w] = [state.q.as_slice()[0], state.p.as_slice()[0], state.w.as_slice()[0]];
        let sizes = self.steps.sizes(system, h, q, p)?;
        let dissipative = !system.dissipation_form().zero;
        let mass = system.mass(0);
        let coordinate = Coordinate {
            dof: 0,
            q,
            p,
            rates: Rates { q: sizes.q / mass, p: sizes.p, w: sizes.w / mass },
            largest_coupled: Scalar::abs(q),
            dissipative,
            drive: (),
        };
        let moved =
            coordinate.advance(&self.solver, Edge { system, j: 0, q: &mut [q], p: &mut [p] })?;
        if !system.has_exact_divided_differences() {
            balanced(system, [q, moved.q], [p, moved.p], w)?;
        }
        commit(state, moved.q, moved.p, dissipative.then(|| w + moved.dw))?;
        Ok(Effort { evaluations: moved.evaluations, iterations: moved.evaluations })
    }
}

/// Checks that V(q1) - V(q0) equals the mean of ∂V/∂q times q1 - q0, up to rounding of the terms of
/// H.
fn balanced<T: Scalar, S: Separable<T> + ?Sized>(
    system: &S,
    [q0, q1]: [T; 2],
    [p0, p1]: [T; 2],
    w: T,
) -> Result<(), StepFailure> {
    let rise = system.divided_difference(&[q0], 0, q1).value * (q1 - q0);
    let account = |q: T, p: T| {
        let energy = system.energy(&[q], &[T::zero()]);
        Account { energy, size: energy.abs() + p * p / system.mass(0) + w.abs() }
    };
    let second_order = || second_order_of_potential(system, [&[q0], &[q1]], &[p0]);
    check(account(q0, p0), account(q1, p1), -rise, second_order)
}
