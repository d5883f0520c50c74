//! Newton's method for a scalar equation, with chord corrections and continuation.

use super::several::several;
use super::{Equation, Root, Sample, Solver};
use crate::{Mask, Quantity, Scalar, StepFailure};
use std::hint::cold_path;

/// Newton's iteration to rounding: two evaluations where that is enough, which is the ordinary step. Corrections with the last slope (chords) follow while they contract fast, so that
/// an ordinary step needs one division. Where the slopes seen allow for a fold on the way, or nothing converges, the
/// solution is followed from s = 0 instead, and its loss is a failure: of its own, [`StepFailure::SeveralSolutions`], where it is
/// lost to others that are seen. Of numbers side by side none is followed, so that each has what it would have alone:
/// where one needs it, all fail. The slope between the points where it is seen is taken for
/// a parabola, so that a force that turns often within a step may still lead to another solution, unseen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton;

/// Corrections before the direct iteration is given up.
const LIMIT: u32 = 200;
/// What an inverse may miss and still be improved instead of made anew.
const GENTLE: f64 = 0.0625;
/// A slope of F at the start beyond which the solution is followed from s = 0.
const STEEP: f64 = 0.125;
/// The shortest step in s of the continuation.
const SHORTEST: f64 = 1e-6;
/// Evaluations after which the continuation is given up.
const MOST: u32 = 10_000;
/// Corrections of so many roundings may be noise.
const ROUNDINGS: f64 = 64.0;

impl Newton {
    /// The solution where two evaluations give it in every lane, the same to the bit as with more care.
    #[inline(always)]
    pub fn ordinary<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        twice::<_, _, true>(T::one(), start, start, &mut equation).0
    }

    /// The direct iteration alone, without the continuation: none where it does not lead, in every lane, to a solution to
    /// which the slope stays positive, as far as it is seen.
    #[inline(always)]
    pub fn direct<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        iterate::<_, true>(T::one(), start, start, &mut equation).ok()
    }
}

impl Solver for Newton {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        mut equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        match iterate::<_, true>(T::one(), start, start, &mut equation) {
            Ok(root) => Ok(root),
            Err(Stalled { update, evaluations: iterations }) if T::LANES > 1 => {
                Err(StepFailure::NewtonStalled { dof, iterations, update })
            }
            Err(stalled) => follow(dof, start, &mut equation, stalled.evaluations),
        }
    }
}

/// The direct iteration has not led to a solution the slope stays positive to.
struct Stalled {
    update: f64,
    evaluations: u32,
}

/// Solves `x = start - F(s, x)` from `x`, in one stride from s = 0 where it is `DIRECT`: an ordinary equation in two evaluations.
#[inline(always)]
fn iterate<T: Scalar, const DIRECT: bool>(
    s: T,
    x: T,
    start: T,
    equation: &mut impl Equation<T>,
) -> Result<Root<T>, Stalled> {
    match twice::<_, _, DIRECT>(s, x, start, equation) {
        (Some(root), _) => Ok(root),
        (None, samples) => carefully::<T, _, DIRECT>(s, start, samples, equation),
    }
}

/// Where F has been evaluated, and F there.
type Known<T> = [(T, Sample<T>); 2];

/// Newton's correction and one with the inverse of its slope improved: the solution where that is enough, and F where it has
/// been evaluated.
#[inline(always)]
fn twice<T: Scalar, E: Equation<T>, const DIRECT: bool>(
    s: T,
    x: T,
    start: T,
    equation: &mut E,
) -> (Option<Root<T>>, Known<T>) {
    let one = T::one();
    let first = equation.at(s, x);
    let (inverse, rest) = (one - first.slope, first.slope * first.slope);
    let residual = if DIRECT { -first.value } else { start - x - first.value };
    let (previous, middle) = (residual * inverse, residual.mul_add(inverse, x));
    let second = equation.at(s, middle);
    let short = one - inverse;
    let missing = (-second.slope).mul_add(inverse, short);
    let inverse = (-second.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse));
    let residual = start - middle - second.value;
    let (update, end) = (residual * inverse, residual.mul_add(inverse, middle));
    // Rounding as far as it takes the fewest operations to know, less than in `carefully`.
    let scale = T::from_f64(T::EPSILON) * second.rough.mul_add(T::one().half(), end.abs());
    let (next, square) = Correction { previous, update, rest, missing }.next();
    let lost = next.lt(scale * square);
    let gentle = |slope: T| slope.abs().lt(T::from_f64(GENTLE));
    let done = lost.and(gentle(first.slope)).and(gentle(missing)).all();
    (done.then_some(Root { x: end, evaluations: 2 }), [(x, first), (middle, second)])
}

/// Two corrections, one after the other.
struct Correction<T> {
    previous: T,
    update: T,
    rest: T,
    missing: T,
}

impl<T: Scalar> Correction<T> {
    /// What the next correction is at most, times the square of the previous one; and that square.
    ///
    /// An error e becomes e (r + c + d): r the rest the inverse misses, c what the slope changes over e/2, d what a
    /// slope that is not quite the derivative is off by. The correction before shows them: it shrank by r + c + d,
    /// and the slope has changed by 2 c since, so that r + 2 c was missing. The next r and c are smaller by a
    /// factor, d is not.
    #[inline(always)]
    fn next(&self) -> (T, T) {
        let (size, largest) = (self.update.abs(), self.previous.abs());
        let off = (self.rest + self.missing).half().mul_add(-self.previous, self.update).abs();
        let contraction = self.missing.abs().mul_add(largest, size);
        (contraction.mul_add(contraction, off * largest) * size, largest * largest)
    }
}

/// The same where that is not enough. F is known where it has been evaluated.
#[cold]
#[inline(never)]
fn carefully<T: Scalar, E: Equation<T>, const DIRECT: bool>(
    s: T,
    start: T,
    [(mut x, first), (middle, second)]: Known<T>,
    equation: &mut E,
) -> Result<Root<T>, Stalled> {
    let (zero, one) = (T::zero(), T::one());
    let (mut inverse, mut rest) = (one, zero);
    let (mut update, mut last) = (zero, [zero; 2]);
    // Corrections that grew and may be noise, in each lane.
    let mut grown = zero;
    // Lanes that are done wait for the others.
    let mut done = one.lt(zero);
    for evaluations in 1..LIMIT + 1 {
        let f = match evaluations {
            1 => first,
            2 if x == middle => second,
            _ => equation.at(s, x),
        };
        // Newton's iteration for the inverse, y ← y (2 - (1 + F') y), squares what y misses, and nothing waits for a
        // division. An inverse that misses much is made anew: also the one of any slope that is not positive.
        let (before, short) = (rest, one - inverse);
        let missing = (-f.slope).mul_add(inverse, short);
        rest = missing * missing;
        let anew = T::from_f64(GENTLE).le(missing.abs());
        let turned = anew.any();
        inverse = if DIRECT && evaluations == 2 {
            // As in `twice`, to the bit; the square of a small inverse would vanish.
            (-f.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse))
        } else {
            inverse.mul_add(missing, inverse)
        };
        if turned {
            cold_path();
            let derivative = one + f.slope;
            if !zero.lt(derivative).all() {
                return Err(Stalled { update: update.to_f64(), evaluations });
            }
            rest = T::select(anew, zero, rest);
            inverse = T::select(anew, derivative.recip(), inverse);
            // At s, F has been passed up to s x: where it changes much on the way from 0, the way is taken in strides.
            if DIRECT && evaluations == 1 && T::from_f64(STEEP).lt(f.slope.abs()).any() {
                return Err(Stalled { update: f64::NAN, evaluations });
            }
        }
        let (previous, [slope_before, residual_before]) = (update, last);
        let residual = if DIRECT && evaluations == 1 { -f.value } else { start - x - f.value };
        update = residual * inverse;
        last = [f.slope, residual];
        x = T::select(done, x, residual.mul_add(inverse, x));
        if evaluations == 1 {
            continue;
        }
        let (size, largest) = (update.abs(), previous.abs());
        let scale = T::from_f64(T::EPSILON) * (start.abs() + f.rough).mul_add(inverse.abs(), x.abs());
        // What has decayed to where a share of it is no number is rounded by the smallest there are.
        let scale = scale + T::from_f64(f64::MIN_POSITIVE);
        let (next, square) = Correction { previous, update, rest: before, missing }.next();
        let waiting = done;
        // Done where the next correction would be lost in rounding.
        done = done.or(next.lt(scale * square));
        if turned || !done.all() {
            cold_path();
            let ends = [one + slope_before, one + f.slope];
            let noise = T::from_f64(T::EPSILON.sqrt() / T::EPSILON) * scale;
            if !waiting.or(rises(ends, residual_before - residual, previous, noise)).all() {
                return Err(Stalled { update: update.to_f64(), evaluations });
            }
        }
        if !done.all() {
            // Corrections that shrink, however slowly, are none of noise; those of noise grow now and then.
            let noise = (T::from_f64(T::EPSILON) * f.blur).mul_add(inverse.abs(), scale);
            let small = size.le(T::from_f64(ROUNDINGS) * noise);
            grown = T::select(small.and(largest.le(size)), grown + one, grown);
            done = done.or(small.and(size.le(zero).or(one.lt(grown))));
            if !done.all() {
                continue;
            }
        }
        return Ok(Root { x, evaluations });
    }
    Err(Stalled { update: update.to_f64(), evaluations: LIMIT })
}

/// Does x + F rise all along an edge, as far as its slopes a and b at the ends and its rise tell? Its slope is about the parabola
/// a (1-t)² + 2 c t (1-t) + b t² of mean (a + c + b)/3, which vanishes nowhere if c > -√(ab). Half of that leaves a margin, and a
/// width within the noise is none.
#[cold]
#[inline(never)]
fn rises<T: Scalar>([a, b]: [T; 2], rise: T, width: T, noise: T) -> T::Mask {
    let c = rise * T::from_f64(3.0) - (a + b) * width;
    let c = T::select(width.lt(T::zero()), -c, c);
    let product = a * b;
    let least = product.abs().sqrt().half().mul_add(width.abs(), noise * a.abs());
    T::zero().lt(a).and(T::zero().lt(b)).and(T::zero().le(c + least))
}

/// Follows the solution from s = 0 to s = 1.
#[cold]
fn follow<T: Scalar>(
    dof: usize,
    start: T,
    equation: &mut impl Equation<T>,
    mut evaluations: u32,
) -> Result<Root<T>, StepFailure> {
    let force = equation.at(T::one(), start).value;
    if !force.is_finite().all() {
        return Err(StepFailure::NonFinite { quantity: Quantity::Force, dof, value: force.to_f64() });
    }
    let (mut x, mut s, mut stride) = (start, 0.0_f64, 0.25_f64);
    while s < 1.0 {
        let next = (s + stride).min(1.0);
        match iterate::<_, false>(T::from_f64(next), x, start, equation) {
            Ok(root) => {
                evaluations += root.evaluations;
                (x, s) = (root.x, next);
                stride *= 2.0;
            }
            Err(stalled) => {
                evaluations += stalled.evaluations;
                stride *= 0.25;
                if stride < SHORTEST || evaluations > MOST {
                    // Just before the end of a branch it has another beside it, just after a fork two.
                    for share in [s, next, 1.0] {
                        if several(T::from_f64(share), x, start, equation) {
                            return Err(StepFailure::SeveralSolutions { dof, share });
                        }
                    }
                    return Err(StepFailure::NewtonStalled {
                        dof,
                        iterations: evaluations,
                        update: stalled.update,
                    });
                }
            }
        }
    }
    Ok(Root { x, evaluations })
}

#[cfg(test)]
mod tests;
