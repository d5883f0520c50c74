//! The root γ of K along the chord from the old state, K(z0 + γ d, w0 + γ e) = K.

use super::direction::Direction;
use afterbay_core::{Mask, Quantity, Scalar, State, StepFailure, System, Vector};

/// The farthest a root may lie from 1.
const REACH: f64 = 0.5;
/// Points tried.
const LIMIT: u32 = 12;
/// K is met when it is off by no more than so many roundings of what it is made of,
const MET: f64 = 2.0;
/// or by so many where it comes no nearer.
const NOISE: f64 = 8.0;

/// A point of the chord, and what K is off by there.
#[derive(Clone, Copy)]
struct Point<T> {
    gamma: T,
    excess: T,
}

/// The new state while its γ is sought.
#[derive(Clone, Debug)]
pub(super) struct Chord<V> {
    pub(super) q: V,
    pub(super) p: V,
    pub(super) w: V,
}

impl<V: Vector> Chord<V> {
    pub(super) fn new(n: usize) -> Self {
        Self { q: V::zeros(n), p: V::zeros(n), w: V::zeros(n) }
    }

    /// Finds γ and places the new state there. K is `now` at `state` and should become `total`.
    pub(super) fn relax<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        [now, total]: [V::Scalar; 2],
    ) -> Result<V::Scalar, StepFailure>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let one = V::Scalar::one();
        let rounding = V::Scalar::EPSILON * (direction.size(state) + now.to_f64().abs());
        let plain = self.place(system, state, direction, one, total)?;
        let excess = plain.excess.to_f64();
        if excess.abs() <= MET * rounding {
            return Ok(one);
        }
        let root = self.search(system, state, direction, [now - total, total], plain, rounding);
        if let Some(root) = root.filter(|root| root.excess.to_f64().abs() <= NOISE * rounding) {
            self.place(system, state, direction, root.gamma, total)?;
            return Ok(root.gamma);
        }
        // Where the step is so short that γ does less than rounding, what K is off by stays.
        if (plain.excess - (now - total)).to_f64().abs() <= NOISE * rounding {
            self.place(system, state, direction, one, total)?;
            return Ok(one);
        }
        Err(StepFailure::NoRelaxationRoot { excess })
    }

    /// The point near 1 where K is met best: by the parabola through the start, with its slope
    /// there, and γ = 1, then by secants.
    fn search<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        [offset, total]: [V::Scalar; 2],
        plain: Point<V::Scalar>,
        rounding: f64,
    ) -> Option<Point<V::Scalar>>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let one = V::Scalar::one();
        // off + slope γ + bend γ², and its slope at 1.
        let slope = direction.slope();
        let bend = plain.excess - offset - slope;
        let ahead = slope + bend + bend;
        let Point { excess, .. } = plain;
        let square = ahead.mul_add(ahead, -(bend * excess * V::Scalar::from_f64(4.0)));
        let positive = V::Scalar::zero().lt(square).all();
        let spread = if positive { square.sqrt() } else { V::Scalar::zero() };
        let spread = if ahead.lt(V::Scalar::zero()).all() { -spread } else { spread };
        let (mut last, mut best) = (plain, plain);
        let mut next = one - (excess + excess) / (ahead + spread);
        for _ in 0..LIMIT {
            let near = (next - one).to_f64().abs() <= REACH;
            let point = if near {
                self.place(system, state, direction, next, total).ok()?
            } else {
                return None;
            };
            let (found, least) = (point.excess.to_f64().abs(), best.excess.to_f64().abs());
            if found < least {
                best = point;
            }
            if found <= MET * rounding || (found >= least / 2.0 && least <= NOISE * rounding) {
                break;
            }
            let secant = (point.excess - last.excess) / (point.gamma - last.gamma);
            last = point;
            next = point.gamma - point.excess / secant;
        }
        Some(best)
    }

    /// Places the new state at γ, and gives what K is off by.
    fn place<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        gamma: V::Scalar,
        total: V::Scalar,
    ) -> Result<Point<V::Scalar>, StepFailure>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let parts = [
            (&mut self.q, &state.q, &direction.q),
            (&mut self.p, &state.p, &direction.p),
            (&mut self.w, &state.w, &direction.w),
        ];
        for (new, old, change) in parts {
            let (old, change) = (&old.as_slice()[..n], &change.as_slice()[..n]);
            for (j, new) in new.as_mut_slice()[..n].iter_mut().enumerate() {
                *new = gamma.mul_add(change[j], old[j]);
            }
        }
        let (q, p, w) = (self.q.as_slice(), self.p.as_slice(), self.w.as_slice());
        let energy = system.energy(q, p);
        let excess = energy + w.iter().fold(V::Scalar::zero(), |sum, &w| sum + w) - total;
        if excess.is_finite().all() {
            return Ok(Point { gamma, excess });
        }
        let energy = [energy];
        Err(StepFailure::non_finite(&[
            (Quantity::Coordinate, q),
            (Quantity::Momentum, p),
            (Quantity::Reservoir, w),
            (Quantity::Energy, &energy),
        ]))
    }
}
