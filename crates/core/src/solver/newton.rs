//! Newton's method for a scalar equation, with chord corrections and continuation.

use super::several::several;
use super::{Equation, Root, Sample, Solver};
use crate::{Mask, Quantity, Scalar, StepFailure};
use std::hint::cold_path;

/// Newton's iteration to rounding: two evaluations where that is enough, which is the ordinary step. Corrections with the last slope (chords) follow while they contract fast, so that
/// an ordinary step needs one division. Where the slopes seen allow for a fold on the way, or nothing converges, the
/// solution is followed from s = 0 instead, and its loss is a failure: of its own, [`StepFailure::SeveralSolutions`], where it is
/// lost to others that are seen. Numbers side by side are each iterated and followed as they would be alone, and wait where they
/// are done; where one is lost, all fail. The slope between the points where it is seen is taken for
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
        let first = equation.at(T::one(), start);
        let twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        twice.done.all().then_some(twice.root())
    }

    /// The direct iteration alone, without the continuation: none where it does not lead, in every lane, to a solution to
    /// which the slope stays positive, as far as it is seen.
    #[inline(always)]
    pub fn direct<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        let first = equation.at(T::one(), start);
        let twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        if twice.done.all() {
            return Some(twice.root());
        }
        let outcome = carefully::<_, _, true>(T::one(), start, twice, &mut equation);
        (!outcome.stalled.any()).then_some(Root { x: outcome.x, evaluations: outcome.evaluations })
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
        let first = equation.at(T::one(), start);
        let mut twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        if twice.done.all() {
            return Ok(twice.root());
        }
        cold_path();
        twice.rest();
        if twice.done.all() {
            return Ok(twice.root());
        }
        let outcome = carefully::<_, _, true>(T::one(), start, twice, &mut equation);
        if outcome.stalled.any() {
            return follow(dof, start, first.value, outcome, &mut equation);
        }
        Ok(Root { x: outcome.x, evaluations: outcome.evaluations })
    }
}

/// Where an iteration has led, each lane by itself.
struct Outcome<T: Scalar> {
    x: T,
    /// Lanes in which it has not led to a solution the slope stays positive to.
    stalled: T::Mask,
    update: T,
    evaluations: u32,
}

/// Solves `x = start - F(s, x)` from `x`, which is on the way from s = 0. Lanes that wait stay.
#[inline(always)]
fn iterate<T: Scalar>(s: T, x: T, start: T, waiting: T::Mask, equation: &mut impl Equation<T>) -> Outcome<T> {
    let first = equation.at(s, x);
    if !is_gentle(first.slope).and(waiting.not()).any() {
        return carefully::<_, _, false>(s, start, Twice::once(x, waiting, first), equation);
    }
    let mut twice = twice::<_, false>(s, x, start, first, equation);
    twice.end = T::select(waiting, x, twice.end);
    twice.done = twice.done.or(waiting);
    if twice.done.all() {
        let none = T::one().lt(T::zero());
        return Outcome { x: twice.end, stalled: none, update: T::zero(), evaluations: 2 };
    }
    carefully::<_, _, false>(s, start, twice, equation)
}

/// Two evaluations, or the first of them, and what they show.
struct Twice<T: Scalar> {
    end: T,
    /// Lanes in which `end` is the solution.
    done: T::Mask,
    /// Lanes in which the slopes are such that it may be.
    gentle: T::Mask,
    inverse: T,
    residuals: [T; 2],
    correction: Correction<T>,
    /// A rounding of `end`.
    scale: T,
    /// Where F has been evaluated, and F there.
    first: (T, Sample<T>),
    second: Option<(T, Sample<T>)>,
}

impl<T: Scalar> Twice<T> {
    /// One evaluation where a second one at the same place would not do in any lane.
    #[inline(always)]
    fn once(x: T, done: T::Mask, first: Sample<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        Self {
            end: x,
            done,
            gentle: one.lt(zero),
            inverse: one,
            residuals: [zero; 2],
            correction: Correction::none(),
            scale: zero,
            first: (x, first),
            second: None,
        }
    }

    #[inline(always)]
    fn root(&self) -> Root<T> {
        Root { x: self.end, evaluations: 2 }
    }

    /// Where the first point is the solution, as at rest, no share of a correction is less than the other; and near rest the
    /// products of corrections may be too small for numbers.
    #[inline(always)]
    fn rest(&mut self) {
        let none = self.correction.previous.abs().le(T::zero());
        let lost = self.correction.lost_near_rest(self.scale);
        self.done = self.done.or(self.gentle.and(none.or(lost)));
    }
}

/// Newton's correction and one with the inverse of its slope improved. At s = 1 this is `DIRECT`ly from the start.
#[inline(always)]
fn twice<T: Scalar, const DIRECT: bool>(
    s: T,
    x: T,
    start: T,
    first: Sample<T>,
    equation: &mut impl Equation<T>,
) -> Twice<T> {
    let one = T::one();
    let (inverse, rest) = (one - first.slope, first.slope * first.slope);
    let before = if DIRECT { -first.value } else { start - x - first.value };
    let (previous, middle) = (before * inverse, before.mul_add(inverse, x));
    let second = equation.at(s, middle);
    let short = one - inverse;
    let missing = (-second.slope).mul_add(inverse, short);
    let inverse = (-second.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse));
    let residual = start - middle - second.value;
    let (update, end) = (residual * inverse, residual.mul_add(inverse, middle));
    // Rounding as far as it takes the fewest operations to know, less than in `carefully`.
    let scale = T::from_f64(T::EPSILON) * second.rough.mul_add(T::one().half(), end.abs());
    let correction = Correction { previous, update, rest, missing };
    let lost = correction.lost(scale);
    let gentle = is_gentle(first.slope).and(is_gentle(missing));
    Twice {
        end,
        done: lost.and(gentle),
        gentle,
        inverse,
        residuals: [before, residual],
        correction,
        scale,
        first: (x, first),
        second: Some((middle, second)),
    }
}

/// May an inverse that misses so much be improved, or the inverse of 1 + F' be 1 - F' at first?
#[inline(always)]
fn is_gentle<T: Scalar>(missing: T) -> T::Mask {
    missing.abs().lt(T::from_f64(GENTLE))
}

/// Two corrections, one after the other.
#[derive(Clone, Copy)]
struct Correction<T> {
    previous: T,
    update: T,
    rest: T,
    missing: T,
}

impl<T: Scalar> Correction<T> {
    #[inline(always)]
    fn none() -> Self {
        let zero = T::zero();
        Self { previous: zero, update: zero, rest: zero, missing: zero }
    }

    /// Is the next correction less than `scale`?
    ///
    /// An error e becomes e (r + c + d): r the rest the inverse misses, c what the slope changes over e/2, d what a
    /// slope that is not quite the derivative is off by. The correction before shows them: it shrank by r + c + d,
    /// and the slope has changed by 2 c since, so that r + 2 c was missing. The next r and c are smaller by a
    /// factor, d is not. All of it times the square of the correction before, so that nothing waits for a division.
    #[inline(always)]
    fn lost(&self, scale: T) -> T::Mask {
        let (size, largest) = (self.update.abs(), self.previous.abs());
        let off = (self.rest + self.missing).half().mul_add(-self.previous, self.update).abs();
        let contraction = self.missing.abs().mul_add(largest, size);
        let next = contraction.mul_add(contraction, off * largest) * size;
        next.lt(scale * (largest * largest))
    }

    /// The same, where the products are too small for numbers by the shares of the correction before.
    #[inline(always)]
    fn lost_near_rest(&self, scale: T) -> T::Mask {
        let largest = self.previous.abs();
        let vanishing = (scale * (largest * largest)).lt(T::from_f64(f64::MIN_POSITIVE));
        let lost = self.lost(scale);
        if !vanishing.any() {
            return lost;
        }
        cold_path();
        let share = largest.recip();
        let shares = Self { previous: self.previous * share, update: self.update * share, ..*self };
        lost.or(vanishing.and(shares.lost(scale * share)))
    }
}

/// The same where that is not enough in every lane.
#[cold]
#[inline(never)]
fn carefully<T: Scalar, E: Equation<T>, const DIRECT: bool>(
    s: T,
    start: T,
    twice: Twice<T>,
    equation: &mut E,
) -> Outcome<T> {
    // What is gentle is where it would be here, to the bit.
    let (mut course, mut evaluations) = match twice.second {
        Some((_, second)) if DIRECT && twice.gentle.or(twice.done).all() => {
            let mut course = Course::after(&twice, second);
            course.judge(start);
            (course, 2)
        }
        _ => (Course::new(&twice), 0),
    };
    let second = twice.second.map(|(middle, f)| (T::select(twice.done, twice.end, middle), f));
    while !course.done.or(course.stalled).all() {
        if evaluations == LIMIT {
            course.stalled = course.done.not();
            break;
        }
        evaluations += 1;
        let f = match (evaluations, second) {
            (1, _) => twice.first.1,
            (2, Some((middle, f))) if course.x == middle => f,
            _ => equation.at(s, course.x),
        };
        course.correct::<DIRECT>(start, f, evaluations);
        if evaluations > 1 {
            course.judge(start);
        }
    }
    let Course { x, stalled, correction: Correction { update, .. }, .. } = course;
    Outcome { x, stalled, update, evaluations }
}

/// An iteration on its way, in each lane.
struct Course<T: Scalar> {
    x: T,
    /// Lanes that are done, or have stalled, wait for the others.
    done: T::Mask,
    stalled: T::Mask,
    inverse: T,
    /// Lanes in which it has just been made anew.
    anew: T::Mask,
    /// The last two corrections.
    correction: Correction<T>,
    /// What the inverse misses of the last slope, squared.
    rest: T,
    /// The last two slopes, and residuals.
    slopes: [T; 2],
    residuals: [T; 2],
    rough: T,
    blur: T,
    /// Corrections that grew and may be noise.
    grown: T,
}

impl<T: Scalar> Course<T> {
    /// Nothing is corrected yet.
    #[inline(always)]
    fn new(twice: &Twice<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let none = one.lt(zero);
        Self {
            x: T::select(twice.done, twice.end, twice.first.0),
            done: twice.done,
            stalled: none,
            inverse: one,
            anew: none,
            correction: Correction::none(),
            rest: zero,
            slopes: [zero; 2],
            residuals: [zero; 2],
            rough: zero,
            blur: zero,
            grown: zero,
        }
    }

    /// Both corrections are made.
    #[inline(always)]
    fn after(twice: &Twice<T>, second: Sample<T>) -> Self {
        let Correction { missing, .. } = twice.correction;
        Self {
            x: twice.end,
            inverse: twice.inverse,
            correction: twice.correction,
            rest: missing * missing,
            slopes: [twice.first.1.slope, second.slope],
            residuals: twice.residuals,
            rough: second.rough,
            blur: second.blur,
            ..Self::new(twice)
        }
    }

    /// Newton's correction with an inverse that is improved, or made anew.
    #[inline(always)]
    fn correct<const DIRECT: bool>(&mut self, start: T, f: Sample<T>, evaluations: u32) {
        let (zero, one) = (T::zero(), T::one());
        let mut open = self.done.or(self.stalled).not();
        // Newton's iteration for the inverse, y ← y (2 - (1 + F') y), squares what y misses, and nothing waits for a
        // division. An inverse that misses much is made anew: also the one of any slope that is not positive.
        let (before, inverse) = (self.rest, self.inverse);
        let short = one - inverse;
        let missing = (-f.slope).mul_add(inverse, short);
        self.rest = missing * missing;
        self.anew = open.and(T::from_f64(GENTLE).le(missing.abs()));
        self.inverse = if DIRECT && evaluations == 2 {
            // As in `twice`, to the bit; the square of a small inverse would vanish.
            (-f.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse))
        } else {
            inverse.mul_add(missing, inverse)
        };
        if self.anew.any() {
            cold_path();
            let derivative = one + f.slope;
            let mut stalled = zero.lt(derivative).not();
            // At s, F has been passed up to s x: where it changes much on the way from 0, the way is taken in strides.
            if DIRECT && evaluations == 1 {
                stalled = stalled.or(T::from_f64(STEEP).lt(f.slope.abs()));
            }
            self.stalled = self.stalled.or(self.anew.and(stalled));
            open = open.and(self.stalled.not());
            self.rest = T::select(self.anew, zero, self.rest);
            self.inverse = T::select(self.anew, derivative.recip(), self.inverse);
        }
        let residual = if DIRECT && evaluations == 1 { -f.value } else { start - self.x - f.value };
        let update = residual * self.inverse;
        self.correction = Correction { previous: self.correction.update, update, rest: before, missing };
        self.x = T::select(open, residual.mul_add(self.inverse, self.x), self.x);
        (self.slopes, self.residuals) = ([self.slopes[1], f.slope], [self.residuals[1], residual]);
        (self.rough, self.blur) = (f.rough, f.blur);
    }

    /// Which lanes are done, and which have stalled?
    #[inline(always)]
    fn judge(&mut self, start: T) {
        let (zero, one) = (T::zero(), T::one());
        let open = self.done.or(self.stalled).not();
        let Correction { previous, update, .. } = self.correction;
        let (size, largest, steep) = (update.abs(), previous.abs(), self.inverse.abs());
        let scale = T::from_f64(T::EPSILON) * (start.abs() + self.rough).mul_add(steep, self.x.abs());
        // Done where the next correction would be lost in rounding.
        let lost = open.and(self.correction.lost_near_rest(scale));
        // What has decayed to where a share of it is no number is rounded by the smallest there are.
        let scale = scale + T::from_f64(f64::MIN_POSITIVE);
        self.done = self.done.or(lost);
        let unsure = open.and(self.anew.or(lost.not()));
        if !unsure.any() {
            return;
        }
        cold_path();
        let noise = T::from_f64(T::EPSILON.sqrt() / T::EPSILON) * scale;
        let ([a, b], [above, below]) = (self.slopes.map(|slope| one + slope), self.residuals);
        let bent = unsure.and(rises([a, b], above - below, previous, noise).not());
        (self.stalled, self.done) = (self.stalled.or(bent), self.done.and(bent.not()));
        // Corrections that shrink, however slowly, are none of noise; those of noise grow now and then.
        let noise = (T::from_f64(T::EPSILON) * self.blur).mul_add(steep, scale);
        let open = self.done.or(self.stalled).not();
        let small = open.and(size.le(T::from_f64(ROUNDINGS) * noise));
        self.grown = T::select(small.and(largest.le(size)), self.grown + one, self.grown);
        self.done = self.done.or(small.and(size.le(zero).or(one.lt(self.grown))));
    }
}

/// Does x + F rise all along an edge, as far as its slopes a and b at the ends and its rise tell? Its slope is about the parabola
/// a (1-t)² + 2 c t (1-t) + b t² of mean (a + c + b)/3, which vanishes nowhere if c > -√(ab). Half of that leaves a margin, and a
/// width within the noise is none.
#[inline(always)]
fn rises<T: Scalar>([a, b]: [T; 2], rise: T, width: T, noise: T) -> T::Mask {
    let c = rise * T::from_f64(3.0) - (a + b) * width;
    let c = T::select(width.lt(T::zero()), -c, c);
    let product = a * b;
    let least = product.abs().sqrt().half().mul_add(width.abs(), noise * a.abs());
    T::zero().lt(a).and(T::zero().lt(b)).and(T::zero().le(c + least))
}

/// Follows the solution from s = 0 to s = 1 where the direct iteration has not led to it, each lane in its own strides.
#[cold]
#[inline(never)]
fn follow<T: Scalar, E: Equation<T>>(
    dof: usize,
    start: T,
    force: T,
    direct: Outcome<T>,
    equation: &mut E,
) -> Result<Root<T>, StepFailure> {
    let (zero, one) = (T::zero(), T::one());
    let Outcome { x, stalled, mut evaluations, .. } = direct;
    if !force.is_finite().or(stalled.not()).all() {
        return Err(StepFailure::NonFinite { quantity: Quantity::Force, dof, value: force.to_f64() });
    }
    let (mut x, mut s) = (T::select(stalled, start, x), T::select(stalled, zero, one));
    let mut stride = T::from_f64(0.25);
    loop {
        let arrived = one.le(s);
        if arrived.all() {
            return Ok(Root { x, evaluations });
        }
        let next = s + stride;
        let next = T::select(next.lt(one), next, one);
        let outcome = iterate(next, x, start, arrived, equation);
        evaluations += outcome.evaluations;
        let stalled = outcome.stalled;
        stride *= T::select(stalled, T::from_f64(0.25), T::from_f64(2.0));
        if stalled.any() {
            cold_path();
            if stalled.and(stride.lt(T::from_f64(SHORTEST))).any() || evaluations > MOST {
                // Just before the end of a branch it has another beside it, just after a fork two.
                for share in [s, next, one] {
                    if T::LANES == 1 && several(share, x, start, equation) {
                        return Err(StepFailure::SeveralSolutions { dof, share: share.to_f64() });
                    }
                }
                let update = outcome.update.to_f64();
                return Err(StepFailure::NewtonStalled { dof, iterations: evaluations, update });
            }
        }
        (x, s) = (T::select(stalled, x, outcome.x), T::select(stalled, s, next));
    }
}

#[cfg(test)]
mod tests;
