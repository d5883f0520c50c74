//! The error estimate of a step that Newton's method solved.
//!
//! The error at the end is `h κ(h J) c`, with the defects c of all slopes, the Jacobian J and
//!
//! ```text
//! κ(z) = ∫ e^{z (1-τ)} P_K(τ) dτ
//! ```
//!
//! which is √(2K+1) (z/2)^K/(2K+1)!! for small z and √(2K+1)/z for large z. Stiff components of c
//! are divided by their eigenvalues, and slow ones are not, however stiff the others are. The
//! equations of the step with the defect c P_{K-1} need no new matrix and have the solution
//! g(h J) c, where |g| is 2(2K+1)/|z| times |κ| for small z and about twice |κ| for large z < 0.
//! This is the error if J is constant. Since J varies, and the more the larger the relative defect
//! of the slopes is, this share of the remaining defect is an error too.
//!
//! Errors of slow components add up over the run, and each step is allowed its share of the
//! tolerance. Those of stiff components do not: the step keeps a stiff error of the start, which
//! the solution forgets, so that every step shows it again. So g c is compared with the whole
//! tolerance, and f g c with the share. The equations with the defect g c have the last coefficient
//! but one that is proportional to f(h J) g c, where f is z/(2(2K+1)) for small z, so that f g is
//! about κ, and proportional to 1/z for large z.

use super::engine::Engine;
use super::gauss::weighted;
use super::limits::Limits;
use crate::collocation::Response;
use crate::kernels::reductions::{largest_if_finite, see_size};
use afterbay_core::{Scalar, State, StepFailure, Vector, larger_or_nan};
use std::array::from_fn;

/// A defect that this many roundings of q and p may cause counts as noise, which no shorter step
/// reduces. A choice: the noise of Van der Pol's oscillator (μ = 1e6) is up to a third as large.
const DEFECT_ROUNDINGS: f64 = 2.0;

impl<V: Vector, const K: usize> Engine<V, K> {
    /// The error estimate of the step relative to the allowed one. Across a kink the error is of
    /// the size of the remaining defect.
    pub(super) fn error_after_newton(
        &mut self,
        state: &State<V>,
        limits: &Limits,
    ) -> Result<f64, StepFailure> {
        let Limits { scales, share, smooth, least_error, .. } = *limits;
        let [force, velocity, losses] = self.defects();
        let kernel = if smooth { force.share().max(velocity.share()) } else { 1.0 };
        let Self { gauss, trial, start, end, last, h, spare, inverse_mass, free, .. } = self;
        let (length, epsilon) = (h.to_f64().abs(), V::Scalar::EPSILON);
        let norm = ((2 * K + 1) as f64).sqrt().recip();
        // The errors over h: of q, p and w; those of q and p that add up; those of q and p due to
        // changes of J.
        let (mut ends, mut sums, mut varied) = ([[0.0; 2]; 3], [[0.0; 2]; 2], [[0.0; 2]; 2]);
        let points = [(&*start, [&state.q, &state.p], true), (&*last, [&end.q, &end.p], false)];
        for (there, point, is_start) in points {
            let defect = |slopes: &[V; K], slope: &V, d: usize| {
                let at = from_fn(|i| slopes[if is_start { K - 1 - i } else { i }].as_slice()[d]);
                norm * (slope.as_slice()[d] - weighted(&gauss.end, at)).to_f64()
            };
            let roundings = |d: usize| {
                point.map(|x| DEFECT_ROUNDINGS * epsilon * x.as_slice()[d].to_f64().abs())
            };
            let defects = |d| [defect(&trial.v, &there.v, d), defect(&trial.f, &there.f, d)];
            let respond = |d: usize, Response { ends: [q, p], slopes, friction }: Response| {
                let at = |x: &V| x.as_slice()[d].to_f64();
                let power = q * (at(&there.f) - at(&there.hq)) + friction * at(&there.v);
                if d < *free {
                    see(&mut ends, [q, p, power]);
                    see(&mut varied, slopes);
                } else {
                    // The momentum of a motor is an energy.
                    see(&mut ends, [0.0, 0.0, p]);
                }
            };
            if let Some(spare) = spare {
                let add_up = |d: usize, errors| {
                    if d < *free {
                        see(&mut sums, errors);
                    }
                };
                spare.respond(roundings, defects, respond, add_up);
            }
        }
        let [q_end, p_end, power] = ends.map(|[most, poison]| length * (most + poison));
        let [q_sum, p_sum] = sums.map(|[most, poison]| length * (most + poison));
        let [q, p] = varied.map(|[most, poison]| length * kernel * (most + poison));
        // The error of p is also an error of the velocities. Its effect on q grows over the step.
        let q = larger_or_nan(q, 0.5 * length * *inverse_mass * p);
        let w = larger_or_nan(power, length * losses.largest * kernel.max(losses.share()));
        let [q_end, q_sum, q] = [q_end * share, q_sum, q].map(|q| q / scales[0]);
        let [p_end, p_sum, p] = [p_end * share, p_sum, p].map(|p| p / scales[1]);
        let value = largest_if_finite([q_end, q_sum, q, p_end, p_sum, p, w / scales[2]]);
        self.relative_error(value / share, least_error)
    }
}

/// Takes sizes into account.
fn see<const N: usize>(most: &mut [[f64; 2]; N], x: [f64; N]) {
    most.iter_mut().zip(x).for_each(|(most, x)| *most = see_size(*most, x.abs()));
}
