//! The scheme's solution for any system.

use super::{ModDg, commit, one_degree_of_freedom, steps::Steps};
use crate::coordinate::{Along, Coordinate};
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
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        _workspace: &mut (),
    ) -> Result<Effort, StepFailure> {
        let [q, p, w] = [state.q.as_slice()[0], state.p.as_slice()[0], state.w.as_slice()[0]];
        let [delta_q, delta_p, delta_w] = self.steps.sizes(system, h, q, p)?;
        let dissipative = !system.damping().zero;
        let mass = system.mass(0);
        let coordinate = Coordinate {
            dof: 0,
            q,
            p,
            steps: [delta_q / mass, delta_p, delta_w / mass],
            reach: Scalar::abs(q),
            dissipative,
        };
        let (q, p) = (&mut [q], &mut [p]);
        let moved = coordinate.advance(&self.solver, Along { system, j: 0, q, p })?;
        commit(state, moved.q, moved.p, dissipative.then(|| w + moved.dw))?;
        Ok(Effort { evaluations: moved.evaluations, iterations: moved.evaluations })
    }
}
