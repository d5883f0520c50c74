//! Newton's iteration for Δz from Δz = 0, and by continuation from h = 0 if it fails.
//!
//! The Jacobian at z0 is kept for the whole step as long as each correction is less than a
//! sixteenth of the one before. Otherwise it is evaluated again at z̄, including the derivative of
//! λ. The first correction is the linearly implicit midpoint rule, whose error is O(h³). (A
//! Jacobian at the explicit z0 + h/2 f(z0) saves few corrections on short steps. On long steps that
//! point may be so far out that corrections are small only because the Jacobian is large.)

use super::equation::{Lambda, Workspace};
use crate::grain::{Scratch, grain};
use afterbay_core::{Curvature, Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};

/// The largest number of corrections of an iteration.
const MOST_CORRECTIONS: u32 = 40;
/// The number of corrections without a new smallest one that ends the iteration: at noise level,
/// and above it.
const STALLED_CORRECTIONS: [u32; 2] = [2, 8];
/// The smallest continuation step in s, where the solution is followed from s h = 0 to h.
const SHORTEST_STEP: f64 = 1e-3;
/// The Jacobian is renewed if the ratio of successive corrections exceeds this,
const SLOWEST_RATIO: f64 = 0.0625;
/// or if a correction other than the first exceeds this share of z,
const LARGEST_CORRECTION: f64 = 0.01;
/// unless the correction is below this number of roundings and may be noise.
const CLEAR_ROUNDINGS: f64 = 1e3;
/// The largest correction, in roundings of the terms of the equation, that is accepted where
/// corrections no longer shrink.
const NOISE_ROUNDINGS: f64 = 64.0;
/// The size of the next correction, in roundings, below which it is omitted. Omitted at every step,
/// it makes K drift by this amount.
const OMITTED_ROUNDINGS: f64 = 1.0 / 1024.0;
/// The largest noise of h λ that is admitted to the iteration,
pub(crate) const LARGEST_LAMBDA_NOISE: f64 = 1e-3;
/// unless K would change without λ by more than this number of roundings of H.
pub(crate) const NEGLIGIBLE_ROUNDINGS: f64 = 16.0;

/// An iteration that did not converge.
struct Stalled {
    failure: StepFailure,
    iterations: u32,
}

fn effort(spent: u32) -> Effort {
    Effort { evaluations: u64::from(spent), iterations: u64::from(spent) }
}

impl<V: Vector> Workspace<V> {
    /// Computes Δz, z̄ and z1. `settle` computes w1 and returns whether it accepts the solution.
    pub(crate) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        settle: impl Fn(&mut Self) -> bool,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.initial_guess();
        self.place(state);
        self.grain = 0.0;
        if self.has_lambda {
            self.start = state.energy(system);
        }
        let mut stalled = match self.iterate(system, h, state) {
            Ok(spent) if settle(self) => return Ok(effort(spent)),
            Ok(spent) => self.unbalanced(spent),
            Err(stalled) => stalled,
        };
        // Terms that cancel inside H leave λ a rounding that |H| does not show.
        if self.has_lambda {
            let [hq, hp] = &mut self.ends;
            let scratch = Scratch {
                q: self.q.as_mut_slice(),
                p: self.p.as_mut_slice(),
                hq: hq.as_mut_slice(),
                hp: hp.as_mut_slice(),
            };
            self.grain = grain(system, [state.q.as_slice(), state.p.as_slice()], scratch);
        }
        if self.grain > 0.0 {
            self.initial_guess();
            self.place(state);
            stalled = match self.iterate(system, h, state) {
                Ok(spent) if settle(self) => return Ok(effort(stalled.iterations + spent)),
                Ok(spent) => self.unbalanced(stalled.iterations + spent),
                Err(failed) => {
                    Stalled { iterations: stalled.iterations + failed.iterations, ..failed }
                }
            };
        }
        let spent = self.follow(system, h, state, stalled)?;
        if settle(self) {
            return Ok(effort(spent));
        }
        if self.energy.is_finite().all() {
            return Err(self.unbalanced(spent).failure);
        }
        Err(StepFailure::non_finite(&[(Quantity::Energy, &[self.energy])]))
    }

    #[cold]
    fn unbalanced(&self, iterations: u32) -> Stalled {
        let (dof, update) = self.largest();
        Stalled { failure: StepFailure::NewtonStalled { dof, iterations, update }, iterations }
    }

    /// Iterates from the current Δz, z̄ and z1, and stores the solution there. Returns the number
    /// of corrections.
    fn iterate<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Result<u32, Stalled>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let epsilon = V::Scalar::EPSILON;
        let (mut stale, mut renewed, mut resolved) = (true, false, None);
        let (mut before, mut least, mut waited, mut quiet) = (f64::NAN, f64::INFINITY, 0, 0);
        for iterations in 1..=MOST_CORRECTIONS {
            let stalled = |failure| Err(Stalled { failure, iterations });
            self.evaluate(system);
            let mut lambda = self.lambda(system);
            if lambda.inverse > 0.0 {
                // Decided once per step, so that the equation does not change while it is solved.
                let noise = h.to_f64().abs() * epsilon * lambda.rough;
                if !*resolved.get_or_insert(
                    noise < LARGEST_LAMBDA_NOISE || lambda.roundings() > NEGLIGIBLE_ROUNDINGS,
                ) {
                    lambda = Lambda::zero();
                }
            }
            if stale && let Err(dof) = self.factorise(system, h, &lambda) {
                return stalled(StepFailure::Singular { dof, slope: 0.0 });
            }
            // Only at the first iterate; later ones may be far out.
            if iterations == 1 {
                self.gain = self.jacobian.gain();
            }
            let fresh = stale;
            self.residual(system, h, &lambda);
            self.solve();
            let update = self.update(h, state, &lambda);
            if !update.size.is_finite() {
                return stalled(self.not_finite());
            }

            // Successive corrections have the ratio `ratio`, unless they are noise.
            let ratio = update.size / before;
            let next_is_rounding = update.size <= epsilon
                || (ratio < 0.5 && ratio * update.size <= OMITTED_ROUNDINGS * epsilon);
            waited = if update.size < least { 0 } else { waited + 1 };
            least = least.min(update.size);
            let small = update.reach <= NOISE_ROUNDINGS * epsilon;
            let done = next_is_rounding || (small && waited >= STALLED_CORRECTIONS[0]);
            // If the Jacobian had to be renewed, convergence must be confirmed by a correction with
            // a Jacobian evaluated at the current iterate.
            if done && (!renewed || (fresh && small)) {
                return Ok(iterations);
            }
            // Near an equilibrium the noise of λ stays large relative to p, but is negligible
            // relative to the forces. A correction with a Jacobian evaluated here must confirm this
            // first.
            quiet = if small && (fresh || quiet > 0) { quiet + 1 } else { 0 };
            if quiet > STALLED_CORRECTIONS[1] {
                return Ok(iterations);
            }
            if waited >= STALLED_CORRECTIONS[1] || iterations == MOST_CORRECTIONS {
                let (dof, update) = self.largest();
                return stalled(StepFailure::NewtonStalled { dof, iterations, update });
            }
            // A Jacobian evaluated far out is large and makes the next correction small.
            let far = iterations > 1 && update.size > LARGEST_CORRECTION;
            stale =
                (ratio > SLOWEST_RATIO && update.size > CLEAR_ROUNDINGS * epsilon) || far || done;
            renewed |= stale;
            before = update.size;
        }
        Err(self.unbalanced(MOST_CORRECTIONS))
    }

    /// Continues the solution from s = 0 to s = 1 for the step size s h.
    #[cold]
    fn follow<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        mut stalled: Stalled,
    ) -> Result<u32, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.initial_guess();
        self.place(state);
        self.evaluate(system);
        self.v.as_mut_slice().copy_from_slice(self.hp.as_slice());
        if self.dissipative {
            self.dissipate(system);
        }
        self.check_force()?;
        let mut spent = stalled.iterations;
        let (mut s, mut stride) = (0.0_f64, 0.25_f64);
        while s < 1.0 {
            let next = (s + stride).min(1.0);
            self.remember();
            match self.iterate(system, h * V::Scalar::from_f64(next), state) {
                Ok(iterations) => {
                    spent += iterations;
                    s = next;
                    stride *= 2.0;
                }
                Err(failed) => {
                    stalled = failed;
                    spent += stalled.iterations;
                    self.recall();
                    self.place(state);
                    stride *= 0.25;
                    if stride < SHORTEST_STEP {
                        return Err(match stalled.failure {
                            StepFailure::NewtonStalled { dof, update, .. } => {
                                StepFailure::NewtonStalled { dof, iterations: spent, update }
                            }
                            failure => failure,
                        });
                    }
                }
            }
        }
        Ok(spent)
    }
}
