//! The coefficients of a step by a simplified Newton's iteration: where sweeps do not contract, and where they did not a step ago.

use super::equations::Equations;
use super::iteration::{Workspace, largest, starts};
use super::nodes::{forces, place_q, velocities};
use super::progress::{LIMIT, Progress};
use super::rule::Modes;
use afterbay_core::{Curvature, Scalar, State, StepFailure, Vector};

/// Corrections without a smaller one among them after which the iteration is given up.
const PATIENCE: u32 = 7;
/// A correction that leaves more than this of the one before asks for a new Jacobian.
const SLOW: f64 = 0.0625;

impl<V: Vector> Workspace<V> {
    /// Newton's iteration, where there is one: from the continued polynomial if that leads on, else from rest.
    pub(super) fn correct<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        failure: Option<StepFailure>,
    ) -> Result<u32, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let Some(mut equations) = self.equations.take() else {
            let nothing = StepFailure::NotContracting { dof: 0, iterations: 0, ratio: f64::NAN };
            return Err(failure.unwrap_or(nothing));
        };
        let mut spent = 0;
        let mut outcome = Err(StepFailure::NewtonStalled { dof: 0, iterations: 0, update: f64::NAN });
        for guess in [failure.is_none(), false] {
            if !guess {
                self.rest(state.dof());
            }
            outcome = self.corrections(system, h, state, level, &mut equations, &mut spent);
            if outcome.is_ok() {
                break;
            }
        }
        // Sweeps contract again where h J is small.
        self.stiff = outcome.is_ok() && equations.gain > 0.5;
        self.equations = Some(equations);
        outcome.map(|()| spent)
    }

    /// Corrections to rounding, from the coefficients there are.
    fn corrections<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        equations: &mut Equations,
        spent: &mut u32,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let (n, length) = (state.dof(), h.to_f64());
        let (mut stale, mut progress) = (true, Progress::new(V::Scalar::EPSILON));
        for iterations in 1..=LIMIT {
            *spent += 1;
            if stale {
                let half = h.half();
                for j in 0..n {
                    self.q.as_mut_slice()[j] = half.mul_add(self.q_modes[j][0][0], state.q.as_slice()[j]);
                    self.p.as_mut_slice()[j] = (-half).mul_add(self.p_modes[j][0][0], state.p.as_slice()[j]);
                }
                let factorised = equations.factorise(system, length, self.q.as_slice(), self.p.as_slice());
                factorised.map_err(|dof| StepFailure::Singular { dof, slope: 0.0 })?;
            }
            let Self { rules, nodes, slopes, q_modes, p_modes, next, next_q, .. } = self;
            let (panels, [q, p]) = (&rules[level], starts(h, state));
            place_q(panels, nodes, q, q_modes);
            velocities(system, panels, nodes, slopes, p, p_modes, next_q);
            forces(system, panels, nodes, slopes, q, [q_modes, next_q], next);
            let [dq, dp] = equations.correct([next_q, next], [q_modes, p_modes]);
            let changes = [share(dq, length, &state.q, q_modes), share(dp, length, &state.p, p_modes)];
            let change = changes[0].max(changes[1]) + 0.0 * (changes[0] + changes[1]);
            let stalled = StepFailure::NewtonStalled { dof: 0, iterations, update: change };
            if !change.is_finite() {
                return Err(stalled);
            }
            progress.see(change);
            if progress.has_arrived(progress.ratio, change) {
                return Ok(());
            }
            if progress.is_lost(PATIENCE) {
                return if self.is_noise(system, h, state, progress.last) { Ok(()) } else { Err(stalled) };
            }
            stale = progress.ratio > SLOW && progress.is_clear();
        }
        Err(StepFailure::NewtonStalled { dof: 0, iterations: LIMIT, update: progress.last })
    }
}

/// The largest change of γ as one of z, relative to the size of z.
fn share<V: Vector>(change: f64, h: f64, start: &V, modes: &[Modes<V::Scalar>]) -> f64 {
    let most = modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
    let size = largest(start.as_slice()) + h.abs() * most;
    if change == 0.0 { 0.0 } else { h.abs() * change / size }
}
