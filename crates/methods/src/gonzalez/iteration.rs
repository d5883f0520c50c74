//! Newton's iteration for Δz, from Δz = 0, or where that fails along the solution from h = 0.
//!
//! The Jacobian of z0 serves the whole step, as long as each correction leaves less than a
//! sixteenth of itself; after that it is made anew at z̄, the change of λ included. The first
//! correction is the linearly implicit midpoint rule, off by h³. (A Jacobian at the explicit z0 +
//! h/2 f(z0) saves few corrections of short steps, and on long ones may be so far out that
//! corrections are small because it is large.)

use super::equation::Workspace;
use afterbay_core::{Curvature, Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};

/// Corrections before an iteration is given up.
const LIMIT: u32 = 40;
/// Corrections without a smaller one among them that end it: in the noise of the equation, and far
/// from it.
const PATIENCE: [u32; 2] = [2, 8];
/// The shortest stride in s where the solution is followed from s h = 0 to h.
const SHORTEST: f64 = 1e-3;
/// A correction that leaves more than this of the one before asks for a new Jacobian.
const SLOW: f64 = 0.0625;
/// So does one larger than this share of z, but for the first.
const FAR: f64 = 0.01;
/// Unless it is a few roundings itself, and may be noise.
const FLOOR: f64 = 1e3;
/// The most that corrections may be, in roundings of what the equation is made of, where they no
/// longer shrink.
const NOISE: f64 = 64.0;
/// The next correction that is not made, in roundings. Left out at every step, it is what K would
/// drift by.
const UNSEEN: f64 = 1.0 / 1024.0;
/// The most noise in h λ that is let into the iteration,
const NOISY: f64 = 1e-3;
/// but for a λ without which K would move by more roundings of H than this.
const FELT: f64 = 16.0;

/// An iteration that led nowhere.
struct Stalled {
    failure: StepFailure,
    iterations: u32,
}

fn effort(spent: u32) -> Effort {
    Effort { evaluations: u64::from(spent), iterations: u64::from(spent) }
}

impl<V: Vector> Workspace<V> {
    /// Finds Δz, z̄, z1 and w1.
    pub(super) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.rest();
        self.place(state);
        let stalled = match self.iterate(system, h, state) {
            Ok(spent) if self.balances(system, h, state) => return Ok(effort(spent)),
            Ok(spent) => self.unbalanced(spent),
            Err(stalled) => stalled,
        };
        let spent = self.follow(system, h, state, stalled)?;
        if self.balances(system, h, state) {
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

    /// The direct iteration from the Δz, z̄ and z1 there are, which are then those found. Gives the
    /// number of corrections.
    fn iterate<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Result<u32, Stalled>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let epsilon = V::Scalar::EPSILON;
        let start = state.energy(system);
        let (mut stale, mut renewed, mut resolved) = (true, false, None);
        let (mut before, mut least, mut waited, mut quiet) = (f64::NAN, f64::INFINITY, 0, 0);
        for iterations in 1..=LIMIT {
            let stalled = |failure| Err(Stalled { failure, iterations });
            self.evaluate(system);
            let mut correction = self.correction(system, start);
            if correction.inverse > 0.0 {
                // Decided once, so that the equation stays the same while it is solved.
                let noise = h.to_f64().abs() * epsilon * correction.rough;
                if !*resolved.get_or_insert(noise < NOISY || correction.roundings() > FELT) {
                    correction.drop();
                }
            }
            if stale && let Err(dof) = self.renew(system, h, &correction) {
                return stalled(StepFailure::Singular { dof, slope: 0.0 });
            }
            // Not later, where an iterate may be far out.
            if iterations == 1 {
                self.gain = self.jacobian.gain();
            }
            let fresh = stale;
            self.residual(system, h, &correction);
            self.correct();
            let update = self.take(h, state, &correction);
            if !update.size.is_finite() {
                return stalled(self.not_finite());
            }

            // Each correction leaves the share `ratio` of itself, unless it is the noise of the
            // equation.
            let ratio = update.size / before;
            let lost =
                update.size <= epsilon || (ratio < 0.5 && ratio * update.size <= UNSEEN * epsilon);
            waited = if update.size < least { 0 } else { waited + 1 };
            least = least.min(update.size);
            let small = update.reach <= NOISE * epsilon;
            let done = lost || (small && waited >= PATIENCE[0]);
            // On a way that needed new Jacobians, only the correction by one made there is
            // believed.
            if done && (!renewed || (fresh && small)) {
                return Ok(iterations);
            }
            // Next to a point of rest the noise of λ goes on and on beside p, and is nothing beside
            // the forces. A Jacobian made there has to say so first.
            quiet = if small && (fresh || quiet > 0) { quiet + 1 } else { 0 };
            if quiet > PATIENCE[1] {
                return Ok(iterations);
            }
            if waited >= PATIENCE[1] || iterations == LIMIT {
                let (dof, update) = self.largest();
                return stalled(StepFailure::NewtonStalled { dof, iterations, update });
            }
            // A Jacobian made far out makes the next correction small by being large.
            let far = iterations > 1 && update.size > FAR;
            stale = (ratio > SLOW && update.size > FLOOR * epsilon) || far || done;
            renewed |= stale;
            before = update.size;
        }
        Err(self.unbalanced(LIMIT))
    }

    /// Follows the solution from s = 0 to s = 1, the step being s h.
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
        self.rest();
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
                    if stride < SHORTEST {
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
