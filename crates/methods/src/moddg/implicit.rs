//! The scheme's solution for any system.

use super::{ModDg, commit, one_degree_of_freedom, steps::Steps};
use afterbay_core::solver::Solver;
use afterbay_core::{Effort, InputError, Line, Method, Scalar, Separable, State, StepFailure, Vector};

impl<V, S, D, E> Method<V, S> for ModDg<D, E>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
    D: Steps<V::Scalar, S>,
    E: Solver,
{
    type Workspace = ();

    fn workspace(&self, system: &S) -> Result<(), InputError> {
        one_degree_of_freedom(system.dof())
    }

    #[inline(always)]
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        _workspace: &mut (),
    ) -> Result<Effort, StepFailure> {
        let [q0, p0, w0] = [state.q.as_slice()[0], state.p.as_slice()[0], state.w.as_slice()[0]];
        let [delta_q, delta_p, delta_w] = self.steps.sizes(system, h, q0, p0)?;
        let dissipative = !system.damping().zero;
        let rate = delta_q / system.mass(0);
        let half_rate = rate.half();
        let half_p = delta_p.half();
        let dissipation = |share: V::Scalar, v| system.drag(&[(share * half_rate).mul_add(v, q0)], &[v], 0);

        // Both step sizes shrink with `share`, from the step wanted (1) to none (0).
        let root = self.solver.solve(0, p0, q0.abs() / rate.abs(), |share, v| {
            let width = share * rate;
            let edge = system.edge(&[q0], 0, width.mul_add(v, q0));
            let pull = share * half_p;
            if !dissipative {
                return Line { value: pull * edge.value, slope: pull * width * edge.slope };
            }
            let drag = dissipation(share, v);
            let drag_slope = width.half().mul_add(drag.by_q, drag.by_p);
            Line {
                value: pull.mul_add(edge.value, pull * drag.value),
                slope: (pull * width).mul_add(edge.slope, pull * drag_slope),
            }
        })?;

        let v = root.x;
        let q1 = rate.mul_add(v, q0);
        let p1 = V::Scalar::from_f64(2.0).mul_add(v, -p0);
        let drained = |v| delta_w / system.mass(0) * dissipation(V::Scalar::one(), v).value;
        let w1 = dissipative.then(|| drained(v).mul_add(v, w0));
        commit(state, q1, p1, w1)?;
        Ok(Effort { evaluations: u64::from(root.evaluations), iterations: u64::from(root.evaluations) })
    }
}
