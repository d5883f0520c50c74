//! The relaxation parameter γ, the root of K(z0 + γ d, w0 + γ e) = K, and the projection of the
//! step where K hardly depends on γ.

use super::direction::Direction;
use crate::adaptive::Projection;
use crate::kernels::reductions::{max_norm, sum};
use crate::measured_rounding::EnergyRounding;
use crate::rounding::{RESTORED_ROUNDINGS, rounding};
use afterbay_core::{Mask, Quantity, Scalar, State, StepFailure, System, Vector};

/// The largest distance of a root from 1.
const LARGEST_DISTANCE: f64 = 0.5;
/// The least |dK/dγ| at γ = 1, as a share of the absolute terms of d·H''d, with which K determines
/// γ. It is ½ if these terms have one sign. A choice.
const LEAST_CURVATURE: f64 = 1.0 / 16.0;
/// The longest projection, as a share of the increments of q and p. A choice.
const LONGEST_PROJECTION: f64 = 1.0 / 16.0;
/// The largest number of points evaluated.
const MOST_POINTS: u32 = 12;
/// The error of K, in roundings of its terms, at which the search for γ ends.
pub(super) const MET_ROUNDINGS: f64 = 2.0;
/// The error of K, in roundings of its terms, accepted where the search makes no progress.
pub(super) const STALLED_K_ROUNDINGS: f64 = 8.0;
/// The least change of K over a step, in roundings of its terms, that determines γ: twice
/// [`MET_ROUNDINGS`].
const DETERMINING_ROUNDINGS: f64 = 4.0;

/// A point of the chord, and the error of K there.
#[derive(Clone, Copy)]
pub(super) struct Point<T> {
    gamma: T,
    pub(super) excess: T,
}

/// The new state, at the current γ.
#[derive(Clone, Debug)]
pub(super) struct Chord<V: Vector> {
    pub(super) q: V,
    pub(super) p: V,
    pub(super) w: V,
    /// H at (q, p).
    pub(super) energy: V::Scalar,
    gamma: V::Scalar,
    energy_rounding: EnergyRounding<V::Scalar>,
}

impl<V: Vector> Chord<V> {
    pub(super) fn new(n: usize) -> Self {
        let [zero, one] = [V::Scalar::zero(), V::Scalar::one()];
        let energy_rounding = EnergyRounding::new(n);
        let [q, p, w] = [(); 3].map(|()| V::zeros(n));
        Self { q, p, w, energy: zero, gamma: one, energy_rounding }
    }

    /// Finds γ and sets the new state. `now` is K at `state`; `total` is the value of K to be
    /// reached.
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
        let unit = rounding::<V::Scalar>(direction.size(state) + now.to_f64().abs());
        let plain = self.place(system, state, direction, one, total)?;
        let excess = plain.excess.to_f64();
        if excess.abs() <= MET_ROUNDINGS * unit {
            return Ok(one);
        }
        let lost = (plain.excess - (now - total)).to_f64().abs();
        // If the step changes K by roundings alone, they would decide γ, and move z by far more
        // than a rounding. Terms that cancel inside H give it roundings that |H| does not show.
        let noise = rounding::<V::Scalar>(self.energy_rounding.largest());
        let is_noise = excess.abs() <= RESTORED_ROUNDINGS * noise;
        if lost <= DETERMINING_ROUNDINGS * unit.max(noise)
            && (self.take_from_reservoir(direction, plain.excess) || is_noise)
        {
            return Ok(one);
        }
        let root = self.search(system, state, direction, [now - total, total], plain, unit);
        if root.is_none() && self.project(system, state, direction, total) {
            return Ok(one);
        }
        if let Some(root) =
            root.filter(|root| root.excess.to_f64().abs() <= STALLED_K_ROUNDINGS * unit)
        {
            if root.gamma != self.gamma {
                self.place(system, state, direction, root.gamma, total)?;
            }
            return Ok(root.gamma);
        }
        // On steps so short that the effect of γ is below rounding, the error of K is accepted.
        if lost <= STALLED_K_ROUNDINGS * unit {
            self.place(system, state, direction, one, total)?;
            return Ok(one);
        }
        if direction.begins_at_rest(state.dof() - system.motors())
            && self.leave_rest(system, state, direction, total, unit)?
        {
            return Ok(one);
        }
        let start = [state.q.as_slice(), state.p.as_slice()];
        let at_end = STALLED_K_ROUNDINGS * rounding::<V::Scalar>(direction.size_at_end(state));
        // γ = 1 first: if it keeps K to rounding, roundings decide the root.
        for point in [plain].into_iter().chain(root) {
            let off = point.excess.to_f64().abs();
            let is_noise = self.energy_rounding.allows(system, start, |measured| {
                off <= at_end.max(RESTORED_ROUNDINGS * rounding::<V::Scalar>(measured.largest()))
            })?;
            if is_noise {
                self.place(system, state, direction, point.gamma, total)?;
                return Ok(point.gamma);
            }
        }
        Err(StepFailure::NoRelaxationRoot { excess })
    }

    /// Takes the error of K from the w_j that gains most, if it still gains energy then.
    fn take_from_reservoir(&mut self, direction: &Direction<V>, excess: V::Scalar) -> bool {
        let gained = direction.w.as_slice().iter().zip(self.w.as_mut_slice());
        let most = gained.max_by(|a, b| a.0.to_f64().total_cmp(&b.0.to_f64()));
        match most {
            Some((gain, w)) if excess.abs().lt(*gain).all() => {
                *w -= excess;
                true
            }
            _ => false,
        }
    }

    /// Finds the point near 1 with the smallest error of K: first from the parabola through γ = 0,
    /// with its slope there, and γ = 1; then by the secant method. There is none where K hardly
    /// depends on γ: the step would end far from the solution.
    fn search<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        [offset, total]: [V::Scalar; 2],
        plain: Point<V::Scalar>,
        unit: f64,
    ) -> Option<Point<V::Scalar>>
    where
        S: System<V::Scalar> + ?Sized,
    {
        let one = V::Scalar::one();
        // The error of K as offset + slope γ + square γ², and its derivative at 1.
        let slope = direction.slope();
        let square = plain.excess - offset - slope;
        let derivative = slope + square + square;
        let least = LEAST_CURVATURE * direction.curvature_terms().to_f64();
        if derivative.to_f64().abs() < least {
            return None;
        }
        let Point { excess, .. } = plain;
        let four = V::Scalar::from_f64(4.0);
        let discriminant = derivative.mul_add(derivative, -(square * excess * four));
        let is_real = V::Scalar::zero().lt(discriminant).all();
        let root = if is_real { discriminant.sqrt() } else { V::Scalar::zero() };
        let root = if derivative.lt(V::Scalar::zero()).all() { -root } else { root };
        let (mut last, mut best) = (plain, plain);
        let mut next = one - (excess + excess) / (derivative + root);
        for _ in 0..MOST_POINTS {
            let near = (next - one).to_f64().abs() <= LARGEST_DISTANCE;
            if !near {
                break;
            }
            let Ok(point) = self.place(system, state, direction, next, total) else { break };
            let (found, least) = (point.excess.to_f64().abs(), best.excess.to_f64().abs());
            if found < least {
                best = point;
            }
            if found <= MET_ROUNDINGS * unit
                || (found >= least / 2.0 && least <= STALLED_K_ROUNDINGS * unit)
            {
                break;
            }
            let secant = (point.excess - last.excess) / (point.gamma - last.gamma);
            last = point;
            next = point.gamma - point.excess / secant;
        }
        Some(best)
    }

    /// Moves (q, p) from γ = 1, where the new state is, along ∇H until K is `total`, by the
    /// shortest change relative to the increments of q and p. Returns whether that succeeds.
    #[cold]
    fn project<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        direction: &Direction<V>,
        total: V::Scalar,
    ) -> bool
    where
        S: System<V::Scalar> + ?Sized,
    {
        let n = state.dof() - system.motors();
        let [hq, hp] = direction.end_slopes();
        let projection = Projection {
            slope: [hq.as_slice(), hp.as_slice()],
            target: total - sum([self.w.as_slice()], |[w]| w),
            size: direction.size(state),
            scales: [&direction.q, &direction.p].map(|part| max_norm(&part.as_slice()[..n])),
            share: LONGEST_PROJECTION,
        };
        let point = [self.q.as_mut_slice(), self.p.as_mut_slice()];
        projection.apply(system, point, &mut self.energy).is_ok()
    }

    /// Sets the new state to γ, and returns the error of K.
    pub(super) fn place<S>(
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
        self.gamma = gamma;
        let n = state.dof();
        let parts = [
            (&mut self.q, &state.q, &direction.q),
            (&mut self.p, &state.p, &direction.p),
            (&mut self.w, &state.w, &direction.w),
        ];
        for (new, old, change) in parts {
            along(new, old, change, gamma, n);
        }
        let excess = self.excess(system, total);
        if excess.is_finite().all() {
            return Ok(Point { gamma, excess });
        }
        let (q, p, w) = (self.q.as_slice(), self.p.as_slice(), self.w.as_slice());
        let energy = [self.energy];
        Err(StepFailure::non_finite(&[
            (Quantity::Coordinate, q),
            (Quantity::Momentum, p),
            (Quantity::Reservoir, w),
            (Quantity::Energy, &energy),
        ]))
    }

    /// Computes H at the new state, and returns the error of K.
    #[inline]
    pub(super) fn excess<S>(&mut self, system: &S, total: V::Scalar) -> V::Scalar
    where
        S: System<V::Scalar> + ?Sized,
    {
        self.energy = system.energy(self.q.as_slice(), self.p.as_slice());
        self.energy + sum([self.w.as_slice()], |[w]| w) - total
    }
}

/// Sets the first n entries of `new` to old + γ change.
#[inline(always)]
pub(super) fn along<V: Vector>(new: &mut V, old: &V, change: &V, gamma: V::Scalar, n: usize) {
    let (old, change) = (&old.as_slice()[..n], &change.as_slice()[..n]);
    for (j, new) in new.as_mut_slice()[..n].iter_mut().enumerate() {
        *new = gamma.mul_add(change[j], old[j]);
    }
}
