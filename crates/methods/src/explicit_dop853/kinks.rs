//! The parts of a step near kinks of the forces.
//!
//! ```text
//! τ = -x/(dx/dt)        part ≤ τ/3 ahead of a kink (τ > 0),    part ≤ |τ|/2 behind it
//! ```
//!
//! x is one of [`System::kinks_of_state`], and τ the time until it is 0 along the slope at the
//! start of the part. Parts so short resolve a force like a power of max(x, 0) on both sides of its
//! kink, where its derivatives have no bounds. Closer to the kink than [`SHORT`] steps, Newton's
//! method for x = 0 leads to a few roundings before it, and a part of some roundings of the step
//! crosses it. So no stage lies beyond a jump of the force, and the end of the step depends on its
//! start like the motion itself, which the differences of `f64` roundings in 106 bits show: the
//! tangent of the motion jumps with the force.

use super::division::{Division, nowhere, shortest};
use crate::runge_kutta::Stages;
use afterbay_core::{Mask, Scalar, State, System, Vector};

/// 2⁻¹⁶, the time to a kink, in steps, below which parts are not shortened further. The impulse of
/// max(x, 0)^1.5 in V over so short a time errs by about 1e-12.
const SHORT: f64 = 1.0 / (1 << 16) as f64;
/// The longest parts ahead of a kink and behind it, as shares of τ. On both sides the nearer end is
/// then twice as far from the kink as the part is long. Choices.
const SHARES: [f64; 2] = [1.0 / 3.0, 0.5];
/// 1 - 2⁻¹⁶, the share of the time to a kink that a part takes there. Newton's method errs less.
const BEFORE: f64 = 1.0 - 1.0 / (1 << 16) as f64;

/// The functions x at the start of a part, and the point at which their slopes are measured.
#[derive(Clone, Debug)]
pub(super) struct Kinks<V: Vector> {
    x: Vec<V::Scalar>,
    q: V,
    p: V,
}

/// The length of a part.
pub(super) struct Part<T: Scalar> {
    pub(super) length: T,
    /// Whether it leads across a kink that is very near.
    pub(super) crosses: T::Mask,
}

impl<V: Vector> Kinks<V> {
    pub(super) fn new(dof: usize) -> Self {
        Self { x: Vec::new(), q: V::zeros(dof), p: V::zeros(dof) }
    }

    /// The next part of a step from `state`, of at most `most`.
    pub(super) fn part<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        division: &Division<V::Scalar>,
        most: V::Scalar,
        state: &State<V>,
        stages: &Stages<V>,
    ) -> Part<V::Scalar> {
        let Self { x, q, p } = self;
        x.clear();
        system.kinks_of_state(state.q.as_slice(), state.p.as_slice(), &mut |value| x.push(value));
        let mut part = Part { length: most, crosses: division.at_kink() };
        if x.is_empty() {
            return part;
        }
        // Half of the digits of x are those of its slope.
        let ahead = division.h() * V::Scalar::from_f64(V::Scalar::EPSILON.sqrt());
        let [velocity, force] = stages.slopes(0);
        for (to, from, slope) in [(&mut *q, &state.q, velocity), (&mut *p, &state.p, force)] {
            let slopes = from.as_slice().iter().zip(slope.as_slice());
            for (to, (&from, &slope)) in to.as_mut_slice().iter_mut().zip(slopes) {
                *to = ahead.mul_add(slope, from);
            }
        }
        let mut x = x.iter();
        system.kinks_of_state(q.as_slice(), p.as_slice(), &mut |moved| {
            let Some(&x) = x.next() else { return };
            let time = -(x * ahead) / (moved - x);
            let found = near(time, division);
            let nearer = time.is_finite().and(found.length.lt(part.length));
            part.length = V::Scalar::select(nearer, found.length, part.length);
            part.crosses = nearer.and(found.crosses).or(nearer.not().and(part.crosses));
        });
        part
    }

    /// Whether a point lies on the other side of a kink than the start.
    pub(super) fn passed<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        q: &[V::Scalar],
        p: &[V::Scalar],
    ) -> <V::Scalar as Scalar>::Mask {
        self.any(system, [q, p], |[below, above], [now_below, now_above]| {
            below.and(now_above).or(above.and(now_below))
        })
    }

    /// Whether a point lies beside a kink, and not on the side of the start. One that starts at the
    /// kink has no side.
    pub(super) fn leaves<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        q: &[V::Scalar],
        p: &[V::Scalar],
    ) -> <V::Scalar as Scalar>::Mask {
        self.any(system, [q, p], |[below, above], [now_below, now_above]| {
            above.not().and(now_above).or(below.not().and(now_below))
        })
    }

    /// Whether the sides of a kink on which the start and a point are, below or above, meet a
    /// condition.
    fn any<M: Mask, S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        [q, p]: [&[V::Scalar]; 2],
        condition: impl Fn([M; 2], [M; 2]) -> M,
    ) -> M
    where
        V::Scalar: Scalar<Mask = M>,
    {
        let mut any = nowhere::<V::Scalar>();
        if self.x.is_empty() {
            return any;
        }
        let mut before = self.x.iter();
        system.kinks_of_state(q, p, &mut |now| {
            let Some(&before) = before.next() else { return };
            any = any.or(condition(sides(before), sides(now)));
        });
        any
    }
}

/// Whether x is below 0, and above it.
fn sides<T: Scalar>(x: T) -> [T::Mask; 2] {
    [x.lt(T::zero()), T::zero().lt(x)]
}

/// The longest part that begins at this time before a kink, or after it, if the time is negative.
fn near<T: Scalar>(time: T, division: &Division<T>) -> Part<T> {
    let h = division.h();
    let [ahead, behind] = SHARES.map(T::from_f64);
    let short = h * T::from_f64(SHORT);
    let after = T::select(time.lt(-short), -time * behind, short);
    let before = T::select(short.lt(time), time * ahead, time * T::from_f64(BEFORE));
    let (is_after, is_before) = (time.lt(T::zero()), shortest(h).lt(time));
    let at_kink = T::select(is_before, before, time + division.across());
    Part { length: T::select(is_after, after, at_kink), crosses: is_after.or(is_before).not() }
}
