//! Newton's iteration where two evaluations are not enough in every lane.

use super::bracket::Bracket;
use super::grain::{Grain, Point, grain};
use super::twice::{Correction, Twice};
use super::{Equation, GENTLE, Outcome, Sample};
use crate::numbers::{Mask, Scalar};
use std::hint::cold_path;

/// Corrections before the direct iteration is given up.
const LIMIT: u32 = 200;
/// Evaluations after which the iteration stays between residuals of opposite signs.
const FREE: u32 = 16;
/// A slope of F at the start beyond which the solution is followed from s = 0.
const STEEP: f64 = 0.125;
/// Corrections of so many roundings may be noise.
const ROUNDINGS: f64 = 64.0;

/// Corrects until every lane has converged or stalled.
#[cold]
#[inline(never)]
pub(super) fn carefully<T: Scalar, E: Equation<T>, const DIRECT: bool>(
    s: T,
    start: T,
    twice: Twice<T>,
    equation: &mut E,
) -> Outcome<T> {
    // What is gentle is where it would be here, to the bit.
    let (mut course, mut evaluations) = match twice.second {
        Some((middle, second)) if DIRECT && twice.gentle.or(twice.done).all() => {
            (Course::after(&twice, middle, second), 2)
        }
        _ => (Course::new(&twice), 0),
    };
    let mut looked = if evaluations > 1 { course.judge(s, start, equation) } else { 0 };
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
            looked += course.judge(s, start, equation);
        }
    }
    let Course { x, stalled, correction: Correction { update, .. }, .. } = course;
    Outcome { x, stalled, update, evaluations: evaluations + looked }
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
    /// The last two points.
    seen: [Point<T>; 2],
    argument_rounding: T,
    value_rounding: T,
    /// The rounding of F that has been seen.
    rounding: T,
    /// Corrections that grew and may be noise.
    grown: T,
    bracket: Bracket<T>,
    /// Lanes in which one of the last two moves was to the middle of the bracket.
    halved: [T::Mask; 2],
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
            seen: [Point { x: zero, slope: one, residual: zero }; 2],
            argument_rounding: zero,
            value_rounding: zero,
            rounding: zero,
            grown: zero,
            bracket: Bracket::none(),
            halved: [none; 2],
        }
    }

    /// Both corrections are made.
    #[inline(always)]
    fn after(twice: &Twice<T>, middle: T, second: Sample<T>) -> Self {
        let (one, [before, residual]) = (T::one(), twice.residuals);
        let (x, first) = twice.first;
        let Correction { missing, .. } = twice.correction;
        Self {
            x: twice.end,
            inverse: twice.inverse,
            correction: twice.correction,
            rest: missing * missing,
            seen: [
                Point { x, slope: one + first.slope, residual: before },
                Point { x: middle, slope: one + second.slope, residual },
            ],
            argument_rounding: second.argument_rounding,
            value_rounding: second.value_rounding,
            ..Self::new(twice)
        }
    }

    /// Newton's correction with an inverse that is improved, or made anew.
    #[inline(always)]
    fn correct<const DIRECT: bool>(&mut self, start: T, f: Sample<T>, evaluations: u32) {
        let (zero, one) = (T::zero(), T::one());
        let mut open = self.done.or(self.stalled).not();
        // Newton's iteration for the inverse, y ← y (2 - (1 + F') y), squares what y misses, and
        // nothing waits for a division. An inverse that misses much is made anew: also the one of
        // any slope that is not positive.
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
            // At s, F has been passed up to s x: where it changes much on the way from 0, the way
            // is taken in strides.
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
        self.seen = [self.seen[1], Point { x: self.x, slope: one + f.slope, residual }];
        let mut end = residual.mul_add(self.inverse, self.x);
        if evaluations > FREE {
            cold_path();
            end = self.within(end);
        }
        self.x = T::select(open, end, self.x);
        (self.argument_rounding, self.value_rounding) = (f.argument_rounding, f.value_rounding);
    }

    /// The end of a correction, or the middle of the bracket where the correction would leave it or
    /// is more than half of the move before.
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

    /// Marks the lanes that are done, and those that have stalled. Gives the evaluations that took.
    #[inline(always)]
    fn judge<E: Equation<T>>(&mut self, s: T, start: T, equation: &mut E) -> u32 {
        let open = self.done.or(self.stalled).not();
        let Correction { previous, update, .. } = self.correction;
        let (size, largest, steep) = (update.abs(), previous.abs(), self.inverse.abs());
        let scale =
            T::from_f64(T::EPSILON) * (start.abs() + self.argument_rounding).mul_add(steep, self.x.abs());
        // Done where the next correction would be lost in rounding. A move to the middle tells
        // nothing of the next.
        let corrected = self.halved[0].or(self.halved[1]).not();
        let lost = open.and(corrected).and(self.correction.lost_near_rest(scale));
        // What has decayed to where a share of it is no number is rounded by the smallest there
        // are.
        let scale = scale + T::from_f64(f64::MIN_POSITIVE);
        self.done = self.done.or(lost);
        let unsure = open.and(self.anew.or(lost.not()));
        if !unsure.any() {
            return 0;
        }
        cold_path();
        let (zero, one) = (T::zero(), T::one());
        let noise = T::from_f64(T::EPSILON.sqrt() / T::EPSILON) * scale;
        let noise = noise.mul_add(self.seen[0].slope.abs(), self.rounding + self.rounding);
        let bent = unsure.and(rises(self.seen, previous, noise).not());
        self.done = self.done.and(bent.not());
        // Corrections that shrink, however slowly, are none of noise; those of noise grow now and
        // then.
        let noise = (T::from_f64(T::EPSILON) * self.value_rounding).mul_add(steep, scale);
        let seen = (self.rounding + self.rounding) * steep;
        let open = self.done.or(self.stalled).or(bent).not();
        let small = open.and(size.le(T::from_f64(ROUNDINGS).mul_add(noise, seen)));
        self.grown = T::select(small.and(largest.le(size)), self.grown + one, self.grown);
        let settled = size.le(zero).or(one.lt(self.grown));
        self.done = self.done.or(small.and(settled)).or(open.and(self.bracket.within(scale)));
        if !bent.any() {
            return 0;
        }
        // A closer look shows rounding, or that x + F does not rise.
        let Grain { size, rounding, evaluations } = grain(s, start, self.seen, bent, equation);
        let more = rounding.and(self.rounding.lt(size));
        self.rounding = T::select(more, size, self.rounding);
        self.stalled = self.stalled.or(bent.and(rounding.not()));
        evaluations
    }
}

/// Whether x + F rises all along an edge of that width, as far as its slopes a and b at the ends and
/// its rise tell? Its slope is about the parabola a (1-t)² + 2 c t (1-t) + b t² of mean (a + c +
/// b)/3, which vanishes nowhere if c > -√(ab). Half of that leaves a margin, and a rise of the
/// noise is none.
#[inline(always)]
fn rises<T: Scalar>([from, to]: [Point<T>; 2], width: T, noise: T) -> T::Mask {
    let (a, b, rise) = (from.slope, to.slope, from.residual - to.residual);
    let c = rise * T::from_f64(3.0) - (a + b) * width;
    let c = T::select(width.lt(T::zero()), -c, c);
    let product = a * b;
    let least = product.abs().sqrt().half().mul_add(width.abs(), noise);
    T::zero().lt(a).and(T::zero().lt(b)).and(T::zero().le(c + least))
}
