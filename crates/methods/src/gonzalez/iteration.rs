//! Newton's iteration for Δz: from a guess, from Δz = 0, or along the solution from h = 0.
//!
//! One Jacobian serves as long as each correction leaves less than a sixteenth of itself; after that it is made anew at z̄,
//! the change of λ included. From Δz = 0 the first correction is the linearly implicit midpoint rule, off by h³.
//! (A Jacobian at the explicit z0 + h/2 f(z0) saves few corrections of short steps, and on long ones may be so far
//! out that corrections are small because it is large.)
//!
//! **Which root.** There may be several, and the one wanted is that which continues from Δz = 0 at h = 0. The equation is
//! Δz = s h f(Δz) at s = 1, so it is lost on the way from s = 0 only where I - s h f' is singular. An iteration is believed if
//! 1. every correction above the noise is at most a sixteenth of the one before, the first two by the same Jacobian J. It
//!    is Kantorovich's condition for one root and a regular Jacobian around, the Lipschitz constant being the one seen in the
//!    two corrections. For one quadratic equation a quarter would do exactly; since what is seen is an estimate, in the
//!    direction of the corrections, a quarter was found to let other roots pass;
//! 2. J is itself joined to I. From Δz = 0 it is J(0), and I - s h f'(0) has to be regular for all s (a bound over its rows,
//!    which may be too strict but is never wrong). Along the solution it is the J of the last s. From a guess it is that of a
//!    step before, or at the guess, and the guess has to be right to a hundredth of z: steps so short follow the solution in time.
//!
//! Where Δz = 0 fails, the solution is followed in strides of s, each under the same condition. What is not guaranteed: a root
//! that branches off in a direction no correction has, and one lost and found again within the sixteenth.

use super::equation::Workspace;
use afterbay_core::{Curvature, Effort, Scalar, State, StepFailure, Vector};

/// Corrections before an iteration is given up.
const LIMIT: u32 = 40;
/// Corrections without a smaller one among them that end it: in the noise of the equation, and far from it.
const PATIENCE: [u32; 2] = [2, 8];
/// The most that a correction may be of the one before.
const TRUSTED: f64 = 0.0625;
/// The shortest stride in s where the solution is followed from s h = 0 to h.
const SHORTEST: f64 = 1e-4;
/// A correction that leaves more than this of the one before asks for a new Jacobian.
const SLOW: f64 = 0.0625;
/// So does one larger than this share of z, but for the first; a first one that large ends a guess.
const FAR: f64 = 0.01;
/// Unless it is a few roundings itself, and may be noise.
const FLOOR: f64 = 1e3;
/// The most that corrections may be, in roundings of what the equation is made of, where they no longer shrink.
const NOISE: f64 = 64.0;
/// The next correction that is not made, in roundings. Left out at every step, it is what K would drift by.
const UNSEEN: f64 = 0.015625;
/// The most noise in h λ that is let into the iteration.
const NOISY: f64 = 1e-3;

/// Where an iteration begins.
#[derive(Clone, Copy, PartialEq, Eq)]
enum From {
    /// At Δz = 0, with its Jacobian.
    Rest,
    /// At the solution for less of h, with its Jacobian.
    Along,
    /// At a guess, with the Jacobian there is.
    Guess,
    /// At a guess, with its Jacobian.
    GuessAnew,
}

/// An iteration that led nowhere.
struct Stalled {
    failure: StepFailure,
    iterations: u32,
}

impl<V: Vector> Workspace<V> {
    /// Finds Δz, z̄ and z1.
    pub(super) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        if self.guess(h, state) {
            self.place(state);
            let from = if self.history.worn { From::GuessAnew } else { From::Guess };
            if let Ok(iterations) = self.iterate(system, h, state, from) {
                self.history.record(h, Some(iterations));
                return Ok(effort(iterations));
            }
            self.history.forget();
        }
        let found = self.begin(system, h, state).or_else(|stalled| self.follow(system, h, state, stalled));
        let iterations = found.inspect_err(|_| self.history.forget())?;
        self.history.record(h, None);
        Ok(effort(iterations))
    }

    /// The iteration from Δz = 0.
    fn begin<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Result<u32, Stalled>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.rest();
        self.place(state);
        self.iterate(system, h, state, From::Rest)
    }

    /// The iteration from the Δz, z̄ and z1 there are, which are then those found. Gives the number of corrections.
    fn iterate<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>, from: From) -> Result<u32, Stalled>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let epsilon = V::Scalar::EPSILON;
        let start = state.energy(system);
        let (mut stale, mut renewed, mut resolved, mut units) =
            (matches!(from, From::Rest | From::GuessAnew), false, None, None);
        let (mut before, mut moved, mut least, mut waited) = (f64::NAN, f64::NAN, f64::INFINITY, 0);
        // What a correction leaves of itself, and the most that was seen of it above the noise.
        let (mut rate, mut seen) = (self.history.rate(), f64::NAN);
        for iterations in 1..=LIMIT {
            let stalled = |failure| Err(Stalled { failure, iterations });
            self.evaluate(system);
            let mut correction = self.correction(system, start);
            let noise = h.to_f64().abs() * epsilon * correction.rough;
            if correction.inverse > 0.0 {
                // Decided once, so that the equation stays the same while it is solved.
                if !*resolved.get_or_insert(noise < NOISY) {
                    correction.drop();
                }
            }
            if stale && let Err(dof) = self.renew(system, h, &correction) {
                return stalled(StepFailure::Singular { dof, slope: 0.0 });
            }
            // Not later, where an iterate may be far out.
            if stale && iterations == 1 {
                self.gain = self.jacobian.gain();
            }
            let fresh = stale;
            if fresh {
                (rate, seen) = (f64::NAN, f64::NAN);
            }
            self.residual(system, h, &correction);
            self.correct();
            let update = self.take(h, state, &correction);
            if !update.size.is_finite() {
                return stalled(self.not_finite());
            }

            // Each correction leaves the share `ratio` of itself, unless it is the noise of the equation: there what it left
            // before still tells, also in the step before.
            let ratio = update.size / before;
            let small = update.reach <= NOISE * epsilon;
            if small {
                rate = rate.min(ratio);
            } else {
                (rate, seen) = (ratio, seen.max(ratio));
            }
            let noisy = update.size <= FLOOR * epsilon;
            let lost = update.size <= epsilon || (rate < 0.5 && rate * update.size <= UNSEEN * epsilon);
            waited = if update.size < least { 0 } else { waited + 1 };
            least = least.min(update.size);
            let done = lost || (small && waited >= PATIENCE[0]);
            // In the same units all along: what is lost in noise may be so because it is far out.
            let moves = update.within(*units.get_or_insert(update.z));
            let doubtful = match iterations {
                1 => match from {
                    From::Rest => !self.jacobian.is_regular_from_rest(),
                    From::Along => false,
                    From::Guess | From::GuessAnew => moves > FAR,
                },
                _ => moves > TRUSTED * moved && moves > NOISE.mul_add(noise.min(NOISY), FLOOR * epsilon),
            };
            // On a way that needed new Jacobians, only the correction by one made there is believed.
            if done && !doubtful && (!renewed || (fresh && small)) {
                self.history.rated(rate, seen);
                return Ok(iterations);
            }
            if doubtful || waited >= PATIENCE[1] || iterations == LIMIT {
                let (dof, update) = self.largest();
                return stalled(StepFailure::NewtonStalled { dof, iterations, update });
            }
            // A Jacobian made far out makes the next correction small by being large.
            let far = iterations > 1 && update.size > FAR;
            stale = (ratio > SLOW && !noisy) || far || done;
            renewed |= stale;
            (before, moved) = (update.size, moves);
        }
        let failure = StepFailure::NewtonStalled { dof: 0, iterations: LIMIT, update: before };
        Err(Stalled { failure, iterations: LIMIT })
    }

    /// Follows the solution from s = 0 to s = 1, the step being s h. Where it ends, the failure is that of the whole step.
    #[cold]
    fn follow<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        Stalled { failure, iterations: mut spent }: Stalled,
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
        let (mut s, mut stride) = (0.0_f64, 0.25_f64);
        while s < 1.0 {
            let next = (s + stride).min(1.0);
            let h = |s| h * V::Scalar::from_f64(s);
            self.remember();
            let found = if s == 0.0 {
                self.begin(system, h(next), state)
            } else {
                self.iterate(system, h(next), state, From::Along)
            };
            match found {
                Ok(iterations) => {
                    spent += iterations;
                    (s, stride) = (next, 2.0 * stride);
                }
                Err(stalled) => {
                    spent += stalled.iterations;
                    self.recall();
                    self.place(state);
                    stride *= 0.25;
                    if stride < SHORTEST {
                        return Err(match failure {
                            StepFailure::NewtonStalled { dof, update, .. } => {
                                StepFailure::NewtonStalled { dof, iterations: spent, update }
                            }
                            failure => failure,
                        });
                    }
                }
            }
            if s > 0.0 {
                // The Jacobian of the solution at s, which has to serve the next.
                self.evaluate(system);
                let correction = self.correction(system, state.energy(system));
                if self.renew(system, h(s), &correction).is_err() {
                    return Err(failure);
                }
                self.gain = self.jacobian.gain() / s;
            }
        }
        Ok(spent)
    }
}

/// A correction is an evaluation.
fn effort(iterations: u32) -> Effort {
    Effort { evaluations: u64::from(iterations), iterations: u64::from(iterations) }
}
