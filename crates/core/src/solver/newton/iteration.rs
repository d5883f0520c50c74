//! Newton's iteration for equations that two evaluations do not solve in every lane.

use super::bracket::Bracket;
use super::rounding::{MeasuredRounding, Point, measure_rounding};
use super::two_corrections::{Correction, FirstInverse, TwoCorrections, rounding_of_solution};
use super::{Equation, MOST_MISSING, Outcome, Sample};
use crate::numbers::{Mask, Scalar};
use crate::solver::convergence::UPDATE_ROUNDINGS;
use std::hint::cold_path;

/// The largest number of evaluations of the direct iteration. Bisection takes 64 to 128 of them for
/// all bits of a number.
const MOST_EVALUATIONS: u32 = 200;
/// Evaluations after which the iteration is confined to a bracket. A choice: Newton's method needs
/// fewer where it converges quadratically.
const EVALUATIONS_BEFORE_BRACKET: u32 = 16;
/// The largest |F'| at the start for a direct iteration; between 0 and 1. Beyond it the solution at
/// s = 1 may be on another branch, and is continued from s = 0.
const LARGEST_DIRECT_SLOPE: f64 = 0.125;

/// Corrects until every lane has converged or stalled.
#[cold]
#[inline(never)]
pub(super) fn iterate_to_rounding<T: Scalar, E: Equation<T>, const DIRECT: bool>(
    s: T,
    start: T,
    pair: TwoCorrections<T>,
    equation: &mut E,
) -> Outcome<T> {
    // In lanes with an improvable inverse, `pair` equals the result of this iteration to the bit.
    let (mut iteration, mut evaluations) = match pair.second.zip(pair.points()) {
        Some(((_, second), seen)) if DIRECT && pair.improvable.or(pair.done).all() => {
            (Iteration::after(&pair, seen, second), 2)
        }
        _ => (Iteration::new(&pair), 0),
    };
    let mut looked = if evaluations > 1 { iteration.judge(s, start, equation) } else { 0 };
    let second = pair.second.map(|(middle, f)| (T::select(pair.done, pair.end, middle), f));
    while !iteration.done.or(iteration.stalled).all() {
        if evaluations == MOST_EVALUATIONS {
            iteration.stalled = iteration.done.not();
            break;
        }
        evaluations += 1;
        let f = match (evaluations, second, pair.third) {
            (1, ..) => pair.first.1,
            (2, Some((middle, f)), _) if iteration.x == middle => f,
            (3, _, Some(f)) if iteration.x == pair.end => f,
            _ => equation.at(s, iteration.x),
        };
        iteration.correct::<DIRECT>(start, f, evaluations);
        if evaluations > 1 {
            looked += iteration.judge(s, start, equation);
        }
    }
    let Iteration { x, stalled, correction: Correction { update, .. }, .. } = iteration;
    Outcome { x, stalled, update, evaluations: evaluations + looked }
}

/// The state of an iteration, lane by lane.
struct Iteration<T: Scalar> {
    x: T,
    /// Lanes that have converged, and below, lanes that have failed. Both keep their x.
    done: T::Mask,
    stalled: T::Mask,
    inverse: T,
    /// Lanes in which the inverse has just been computed by a division.
    anew: T::Mask,
    /// The last two corrections.
    correction: Correction<T>,
    /// The relative error of the inverse: the square of its error before the improvement.
    inverse_error: T,
    /// The last two points.
    seen: [Point<T>; 2],
    /// The last sample of F.
    f: Sample<T>,
    /// The measured rounding error of F.
    rounding: T,
    /// The number of corrections that grew and are small enough for noise.
    grown: T,
    bracket: Bracket<T>,
    /// Lanes in which the last two moves were bisections, older first.
    halved: [T::Mask; 2],
}

impl<T: Scalar> Iteration<T> {
    /// The state before the first correction.
    #[inline(always)]
    fn new(pair: &TwoCorrections<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let none = one.lt(zero);
        Self {
            x: T::select(pair.done, pair.end, pair.first.0),
            done: pair.done,
            stalled: none,
            inverse: one,
            anew: none,
            correction: Correction::none(),
            inverse_error: zero,
            seen: [Point { x: zero, slope: one, residual: zero }; 2],
            f: pair.first.1,
            rounding: zero,
            grown: zero,
            bracket: Bracket::none(),
            halved: [none; 2],
        }
    }

    /// The state after both corrections of an ordinary step.
    #[inline(always)]
    fn after(pair: &TwoCorrections<T>, seen: [Point<T>; 2], second: Sample<T>) -> Self {
        let Correction { missing, .. } = pair.correction;
        Self {
            x: pair.end,
            inverse: pair.inverse,
            correction: pair.correction,
            inverse_error: missing * missing,
            seen,
            f: second,
            ..Self::new(pair)
        }
    }

    /// A correction with an inverse slope that is improved or computed anew.
    #[inline(always)]
    fn correct<const DIRECT: bool>(&mut self, start: T, f: Sample<T>, evaluations: u32) {
        let (zero, one) = (T::zero(), T::one());
        let mut open = self.done.or(self.stalled).not();
        // Newton's iteration for the inverse, y ← y (2 - (1 + F') y), squares what y misses and
        // needs no division. An inverse that misses much, as for any slope that is not positive, is
        // computed anew.
        let (before, inverse) = (self.inverse_error, self.inverse);
        let short = one - inverse;
        let missing = (-f.slope).mul_add(inverse, short);
        self.anew = open.and(T::from_f64(MOST_MISSING).le(missing.abs()));
        (self.inverse, self.inverse_error) = if evaluations == 1 {
            let FirstInverse { inverse, inverse_error } = FirstInverse::of(f.slope);
            (inverse, inverse_error)
        } else if DIRECT && evaluations == 2 {
            // Equal to `two_corrections` to the bit. The square of a small inverse would underflow.
            let inverse = (-f.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse));
            (inverse, missing * missing)
        } else {
            (inverse.mul_add(missing, inverse), missing * missing)
        };
        if self.anew.any() {
            cold_path();
            let derivative = one + f.slope;
            let mut stalled = zero.lt(derivative).not();
            // A steep F is continued from s = 0 in steps.
            if DIRECT && evaluations == 1 {
                stalled = stalled.or(T::from_f64(LARGEST_DIRECT_SLOPE).lt(f.slope.abs()));
            }
            self.stalled = self.stalled.or(self.anew.and(stalled));
            open = open.and(self.stalled.not());
            self.inverse_error = T::select(self.anew, zero, self.inverse_error);
            self.inverse = T::select(self.anew, derivative.recip(), self.inverse);
        }
        let residual = if DIRECT && evaluations == 1 { -f.value } else { start - self.x - f.value };
        let update = residual * self.inverse;
        self.correction =
            Correction { previous: self.correction.update, update, inverse_error: before, missing };
        self.seen = [self.seen[1], Point { x: self.x, slope: one + f.slope, residual }];
        let mut end = residual.mul_add(self.inverse, self.x);
        if evaluations > EVALUATIONS_BEFORE_BRACKET {
            cold_path();
            end = self.within(end);
        }
        self.x = T::select(open, end, self.x);
        self.f = f;
    }

    /// The end of a correction, or the middle of the bracket if the correction leaves it or is more
    /// than half of the previous one.
    #[inline(always)]
    fn within(&mut self, end: T) -> T {
        let Correction { previous, update, .. } = self.correction;
        let Point { x, residual, .. } = self.seen[1];
        self.bracket.take(x, residual);
        let (middle, able) = self.bracket.middle();
        let slow = previous.abs().half().lt(update.abs());
        let halve = able.and(slow.or(self.bracket.leaves(end)));
        self.halved = [self.halved[1], halve];
        self.correction.update = T::select(halve, middle - x, update);
        T::select(halve, middle, end)
    }

    /// Marks the lanes that have converged and those that have stalled. Returns the number of
    /// evaluations made.
    #[inline(always)]
    fn judge<E: Equation<T>>(&mut self, s: T, start: T, equation: &mut E) -> u32 {
        let open = self.done.or(self.stalled).not();
        let Correction { previous, update, .. } = self.correction;
        let (size, largest, steep) = (update.abs(), previous.abs(), self.inverse.abs());
        let scale = rounding_of_solution(start, self.f, self.inverse, self.x);
        // Converged if the next correction is below rounding. A bisection does not predict it.
        let corrected = self.halved[0].or(self.halved[1]).not();
        let converged = open.and(corrected).and(self.correction.next_is_rounding(scale));
        // Numbers near underflow are rounded by the smallest normal number.
        let floored_scale = scale + T::from_f64(f64::MIN_POSITIVE);
        self.done = self.done.or(converged);
        let unsure = open.and(self.anew.or(converged.not()));
        if !unsure.any() {
            return 0;
        }
        cold_path();
        let (zero, one) = (T::zero(), T::one());
        let rise_noise = (T::from_f64(T::EPSILON.sqrt() / T::EPSILON) * floored_scale)
            .mul_add(self.seen[0].slope.abs(), self.rounding + self.rounding);
        let bent = unsure.and(rises(self.seen, previous, rise_noise).not());
        self.done = self.done.and(bent.not());
        // Corrections that shrink, however slowly, are not noise. Noise grows now and then.
        let update_noise =
            (T::from_f64(T::EPSILON) * self.f.value_rounding).mul_add(steep, floored_scale);
        let measured_noise = (self.rounding + self.rounding) * steep;
        let undecided = self.done.or(self.stalled).or(bent).not();
        let most_noise = T::from_f64(UPDATE_ROUNDINGS).mul_add(update_noise, measured_noise);
        let small = undecided.and(size.le(most_noise));
        self.grown = T::select(small.and(largest.le(size)), self.grown + one, self.grown);
        let settled = size.le(zero).or(one.lt(self.grown));
        let enclosed = undecided.and(self.bracket.within(floored_scale));
        self.done = self.done.or(small.and(settled)).or(enclosed);
        if !bent.any() {
            return 0;
        }
        // A measurement decides between rounding and an x + F that does not rise.
        let MeasuredRounding { size: mismatch, rounding, evaluations } =
            measure_rounding(s, start, self.seen, bent, equation);
        let more = rounding.and(self.rounding.lt(mismatch));
        self.rounding = T::select(more, mismatch, self.rounding);
        self.stalled = self.stalled.or(bent.and(rounding.not()));
        evaluations
    }
}

/// Whether x + F rises all along an edge of that width, judged by its slopes a and b at the ends
/// and its rise. Its slope is approximated by the parabola a (1-t)² + 2 c t (1-t) + b t² with the
/// mean (a + c + b)/3, which has no zero if c > -√(ab). Half of that bound is required as a margin,
/// up to the noise of the rise.
#[inline(always)]
pub(super) fn rises<T: Scalar>([from, to]: [Point<T>; 2], width: T, noise: T) -> T::Mask {
    let (a, b, rise) = (from.slope, to.slope, from.residual - to.residual);
    let c = rise * T::from_f64(3.0) - (a + b) * width;
    let c = T::select(width.lt(T::zero()), -c, c);
    let product = a * b;
    let least = product.abs().sqrt().half().mul_add(width.abs(), noise);
    T::zero().lt(a).and(T::zero().lt(b)).and(T::zero().le(c + least))
}
