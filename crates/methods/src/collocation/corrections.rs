//! The coefficients of a step by Newton's iteration: where sweeps do not contract, and where they
//! did not a step ago.
//!
//! First with the derivative at the middle of the step, from the polynomial of the last step
//! continued and from rest; where that does not converge, or crawls, with the whole derivative
//! (`krylov.rs`).

use super::equations::Equations;
use super::iteration::{Workspace, largest};
use super::krylov::Krylov;
use super::progress::{LIMIT, Progress};
use super::rule::Modes;
use afterbay_core::{Curvature, Quantity, Scalar, State, StepFailure, Vector};

/// Corrections without a smaller one among them after which the iteration is given up.
const PATIENCE: u32 = 7;
/// A correction that leaves more than this of the one before asks for a new Jacobian,
const SLOW: f64 = 0.0625;
/// and one that leaves more than this for the whole derivative, after so many corrections.
const CRAWL: (f64, u32) = (0.5, 12);

impl<V: Vector> Workspace<V> {
    /// Newton's iterations, one after the other: how many evaluations of the nodes they took.
    pub(super) fn correct<S>(
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
            outcome = self.corrections(system, h, state, level, &mut equations, &mut spent);
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

    /// The Jacobian at the middle of the step, factorised.
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

    /// The force that is no number, where what γ misses is none.
    #[cold]
    pub(super) fn not_finite(&self, equations: &Equations) -> StepFailure {
        let lost = |&(most, _): &(f64, usize)| !most.is_finite();
        let (value, dof) = equations.largest().into_iter().find(lost).unwrap_or((f64::NAN, 0));
        StepFailure::NonFinite { quantity: Quantity::Force, dof, value }
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
        let length = h.to_f64();
        let (mut stale, mut progress) = (true, Progress::new(V::Scalar::EPSILON));
        let mut last = (0, f64::NAN);
        for iterations in 1..=LIMIT {
            *spent += 1;
            if stale {
                self.factorise(system, h, state, equations)?;
            }
            self.miss(system, h, state, level, equations);
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
                return Err(StepFailure::NewtonStalled { dof, iterations, update: change });
            }
            progress.see(change);
            if progress.has_arrived(progress.ratio, change) {
                return Ok(());
            }
            let crawls = self.thorough && iterations >= CRAWL.1 && progress.ratio > CRAWL.0;
            if progress.is_lost(PATIENCE) || (crawls && progress.is_clear()) {
                let noise = !crawls && self.is_noise(system, h, state, progress.last);
                let failure = StepFailure::NewtonStalled { dof, iterations, update: change };
                return if noise { Ok(()) } else { Err(failure) };
            }
            stale = progress.ratio > SLOW && progress.is_clear();
        }
        let (dof, update) = last;
        if progress.is_rounding() {
            return Ok(());
        }
        Err(StepFailure::NewtonStalled { dof, iterations: LIMIT, update })
    }
}

/// The largest change of γ as one of z, relative to the size of z.
fn share<V: Vector>(change: f64, h: f64, start: &V, modes: &[Modes<V::Scalar>]) -> f64 {
    let most = modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
    let size = largest(start.as_slice()) + h.abs() * most;
    if change == 0.0 { 0.0 } else { h.abs() * change / size }
}
