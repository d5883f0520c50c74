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

use crate::runge_kutta::Stages;
use afterbay_core::{Mask, Scalar, State, System, Vector};
use std::cmp::Ordering;

/// 2⁻¹⁶, the time to a kink, in steps, below which parts are not shortened further. The impulse of
/// max(x, 0)^1.5 in V over so short a time errs by about 1e-12.
const SHORT: f64 = 1.0 / (1 << 16) as f64;
/// The longest parts ahead of a kink and behind it, as shares of τ. On both sides the nearer end is
/// then twice as far from the kink as the part is long. Choices.
const SHARES: [f64; 2] = [1.0 / 3.0, 0.5];
/// 1 - 2⁻¹⁶, the share of the time to a kink that a part takes there. Newton's method errs less.
const BEFORE: f64 = 1.0 - 1.0 / (1 << 16) as f64;
/// The length of the part across a kink, in roundings of the step.
const ACROSS: f64 = 512.0;

/// The functions x at the start of a part, and the point at which their slopes are measured.
#[derive(Clone, Debug)]
pub(super) struct Kinks<V: Vector> {
    x: Vec<V::Scalar>,
    q: V,
    p: V,
}

/// The length of a part.
#[derive(Clone, Copy)]
pub(super) struct Part<T> {
    pub(super) length: T,
    /// Whether it leads across a kink that is very near.
    pub(super) crosses: bool,
}

impl<V: Vector> Kinks<V> {
    pub(super) fn new(dof: usize) -> Self {
        Self { x: Vec::new(), q: V::zeros(dof), p: V::zeros(dof) }
    }

    /// Whether the forces have kinks at values of q and p.
    pub(super) fn exist<S: System<V::Scalar> + ?Sized>(
        system: &S,
        q: &[V::Scalar],
        p: &[V::Scalar],
    ) -> bool {
        let mut any = false;
        system.kinks_of_state(q, p, &mut |_| any = true);
        any
    }

    /// The length of a part from `state` of at most `most`, in a step h.
    pub(super) fn part<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        [h, most]: [V::Scalar; 2],
        state: &State<V>,
        stages: &Stages<V>,
    ) -> Part<V::Scalar> {
        let Self { x, q, p } = self;
        x.clear();
        system.kinks_of_state(state.q.as_slice(), state.p.as_slice(), &mut |value| x.push(value));
        // Half of the digits of x are those of its slope.
        let ahead = h * V::Scalar::from_f64(V::Scalar::EPSILON.sqrt());
        let [velocity, force] = stages.at_start();
        for (to, from, slope) in [(&mut *q, &state.q, velocity), (&mut *p, &state.p, force)] {
            let slopes = from.as_slice().iter().zip(slope.as_slice());
            for (to, (&from, &slope)) in to.as_mut_slice().iter_mut().zip(slopes) {
                *to = ahead.mul_add(slope, from);
            }
        }
        let mut part = Part { length: most, crosses: false };
        let mut x = x.iter();
        system.kinks_of_state(q.as_slice(), p.as_slice(), &mut |moved| {
            let Some(&x) = x.next() else { return };
            let time = -(x * ahead) / (moved - x);
            if time.is_finite().all() {
                let found = near(time, h);
                let shorter = found.length.to_f64().abs() < part.length.to_f64().abs();
                part = if shorter { found } else { part };
            }
        });
        part
    }

    /// Whether a point lies on the other side of a kink than the start.
    pub(super) fn passed<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        q: &[V::Scalar],
        p: &[V::Scalar],
    ) -> bool {
        self.any(system, [q, p], |before, now| before != Ordering::Equal && now == before.reverse())
    }

    /// Whether a point lies beside a kink on another side than the start. One that starts at the
    /// kink has no side.
    pub(super) fn left<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        q: &[V::Scalar],
        p: &[V::Scalar],
    ) -> bool {
        self.any(system, [q, p], |before, now| now != Ordering::Equal && now != before)
    }

    /// Whether the sides of a kink on which the start and a point are meet a condition.
    fn any<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        [q, p]: [&[V::Scalar]; 2],
        condition: impl Fn(Ordering, Ordering) -> bool,
    ) -> bool {
        let (mut any, mut before) = (false, self.x.iter());
        system.kinks_of_state(q, p, &mut |now| {
            any |= before.next().is_some_and(|&before| condition(side(before), side(now)));
        });
        any
    }
}

fn side<T: Scalar>(x: T) -> Ordering {
    x.to_f64().partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// The length of the shortest part across, in a step h.
pub(super) fn across<T: Scalar>(h: T) -> T {
    h * T::from_f64(ACROSS * T::EPSILON)
}

/// The longest part of a step h that begins at this time before a kink, or after it, if the time
/// has another sign than h.
fn near<T: Scalar>(time: T, h: T) -> Part<T> {
    let (steps, least) = ((time / h).to_f64(), across(h));
    let length = if steps < -SHORT {
        -time * T::from_f64(SHARES[1])
    } else if steps < 0.0 {
        h * T::from_f64(SHORT)
    } else if steps > SHORT {
        time * T::from_f64(SHARES[0])
    } else if steps > ACROSS * T::EPSILON {
        time * T::from_f64(BEFORE)
    } else {
        return Part { length: time + least, crosses: true };
    };
    Part { length, crosses: false }
}
