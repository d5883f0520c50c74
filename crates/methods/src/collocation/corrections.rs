//! Newton's iteration for the coefficients of a step, used where sweeps do not contract, and where
//! they did not in the step before.
//!
//! The simplified iteration uses the Jacobian at the middle of the step. It starts from the
//! continued polynomial of the last step, then from a constant. If it does not converge, or
//! converges slowly, the exact derivative is used (`krylov.rs`).

use super::equations::Equations;
use super::iteration::{Workspace, largest};
use super::krylov::Krylov;
use super::progress::{MOST_ITERATIONS, Progress};
use super::rule::Modes;
use afterbay_core::{Curvature, Quantity, Scalar, State, StepFailure, Vector};

/// The number of corrections without a new smallest one after which the iteration stops.
const STALLED_CORRECTIONS: u32 = 7;
/// The Jacobian is renewed if the ratio of successive corrections exceeds this;
const SLOWEST_RATIO: f64 = 0.0625;
/// the exact derivative is used if the ratio exceeds the first number after this many corrections.
const CRAWL: (f64, u32) = (0.5, 12);

impl<V: Vector> Workspace<V> {
    /// Runs Newton's iterations in turn. Returns the number of evaluations of all nodes.
    pub(super) fn newton<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        continued: bool,
    ) -> Result<u32, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let mut equations = match self.equations.take() {
            Some(equations) => equations,
            None => Box::new(Equations::new(system, self.stages)?),
        };
        let mut krylov = self.krylov.take();
        if let Some(krylov) = krylov.as_mut().filter(|_| self.hard) {
            krylov.keep([&self.q_modes, &self.p_modes]);
        }
        let mut spent = 0;
        let mut outcome =
            Err(StepFailure::NewtonStalled { dof: 0, iterations: 0, update: f64::NAN });
        let guesses: &[bool] = if continued { &[true, false] } else { &[false] };
        for &guess in if self.hard { &[] } else { guesses } {
            if !guess {
                self.rest(state.dof());
            }
            outcome = self.iterate(system, h, state, level, &mut equations, &mut spent);
            if outcome.is_ok() {
                break;
            }
        }
        if outcome.is_err() && self.thorough {
            let unknowns = equations.missing.len();
            let krylov =
                krylov.get_or_insert_with(|| Box::new(Krylov::new(&self.q_modes, unknowns)));
            if self.hard {
                krylov.recall([&mut self.q_modes, &mut self.p_modes]);
                outcome =
                    self.search(system, h, state, level, (&mut equations, krylov), &mut spent);
            }
            if outcome.is_err() {
                self.rest(state.dof());
                outcome =
                    self.search(system, h, state, level, (&mut equations, krylov), &mut spent);
            }
            if outcome.is_err() {
                outcome =
                    self.follow(system, h, state, level, (&mut equations, krylov), &mut spent);
            }
            self.hard = outcome.is_ok();
        }
        self.krylov = krylov;
        // Sweeps contract again where h J is small.
        self.stiff = outcome.is_ok() && equations.gain > 0.5;
        self.equations = Some(equations);
        outcome.map(|()| spent)
    }

    /// Evaluates and factorises the Jacobian at the middle of the step.
    pub(super) fn factorise<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        equations: &mut Equations,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let half = h.half();
        for j in 0..state.dof() {
            self.q.as_mut_slice()[j] = half.mul_add(self.q_modes[j][0][0], state.q.as_slice()[j]);
            self.p.as_mut_slice()[j] =
                (-half).mul_add(self.p_modes[j][0][0], state.p.as_slice()[j]);
        }
        let factorised =
            equations.factorise(system, h.to_f64(), self.q.as_slice(), self.p.as_slice());
        factorised.map_err(|dof| StepFailure::Singular { dof, slope: 0.0 })
    }

    /// The force that is not finite, if the residual is not.
    #[cold]
    pub(super) fn not_finite(&self, equations: &Equations) -> StepFailure {
        let not_finite = |&(most, _): &(f64, usize)| !most.is_finite();
        let (value, dof) =
            equations.largest().into_iter().find(not_finite).unwrap_or((f64::NAN, 0));
        StepFailure::NonFinite { quantity: Quantity::Force, dof, value }
    }

    /// Corrects the current coefficients until they converge to rounding.
    fn iterate<S>(
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
        let length = h.to_f64();
        let (mut stale, mut progress) = (true, Progress::new(V::Scalar::EPSILON));
        let mut last = (0, f64::NAN);
        for iterations in 1..=MOST_ITERATIONS {
            *spent += 1;
            if stale {
                self.factorise(system, h, state, equations)?;
            }
            self.residual(system, h, state, level, equations);
            equations.solve();
            equations.add(1.0, [&mut self.q_modes, &mut self.p_modes]);
            let [(dq, q), (dp, p)] = equations.largest();
            let Self { q_modes, p_modes, .. } = &*self;
            let changes =
                [share(dq, length, &state.q, q_modes), share(dp, length, &state.p, p_modes)];
            let change = changes[0].max(changes[1]) + 0.0 * (changes[0] + changes[1]);
            let dof = if changes[0] >= changes[1] { q } else { p };
            last = (dof, change);
            if !change.is_finite() {
                let update = change;
                return Err(StepFailure::NewtonStalled { dof, iterations: *spent, update });
            }
            progress.see(change);
            if progress.has_arrived(progress.ratio, change) {
                return Ok(());
            }
            let crawls = self.thorough && iterations >= CRAWL.1 && progress.ratio > CRAWL.0;
            if progress.diverges(STALLED_CORRECTIONS) || (crawls && progress.is_clear()) {
                let noise = !crawls && self.is_noise(system, h, state, progress.last);
                let failure =
                    StepFailure::NewtonStalled { dof, iterations: *spent, update: change };
                return if noise { Ok(()) } else { Err(failure) };
            }
            stale = progress.ratio > SLOWEST_RATIO && progress.is_clear();
        }
        let (dof, update) = last;
        if progress.is_rounding() {
            return Ok(());
        }
        Err(StepFailure::NewtonStalled { dof, iterations: *spent, update })
    }
}

/// The change of z due to the largest change of γ, relative to the size of z.
fn share<V: Vector>(change: f64, h: f64, start: &V, modes: &[Modes<V::Scalar>]) -> f64 {
    let most = modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
    let size = largest(start.as_slice()) + h.abs() * most;
    if change == 0.0 { 0.0 } else { h.abs() * change / size }
}
