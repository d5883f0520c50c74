//! The equation of the step at a given Δz: the system at z̄, its second derivatives, and products
//! with A.

use super::slopes::Slopes;
use crate::gonzalez::lambda::Lambda;
use crate::linear_flow::LinearFlow;
use crate::measured_rounding::EnergyRounding;
use afterbay_core::{Curvature, InputError, Scalar, State, Vector};

/// The new state and the memory of the iteration.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    pub(super) dissipative: bool,
    pub(super) linear: bool,
    /// The number of degrees of freedom before the motors of a drive, which λ leaves alone: their
    /// velocity is 1.
    pub(super) free: usize,
    /// Whether λ exceeds its rounding error; decided once per step.
    pub(super) resolved: Option<bool>,
    pub(super) slopes: Slopes<V>,
    pub(super) flow: LinearFlow<V>,
    /// Δz
    pub(super) dz: [V; 2],
    /// z̄ and z1
    mean: [V; 2],
    pub(super) end: [V; 2],
    /// ∇̄H
    pub(super) gradient: [V; 2],
    /// D̄, and D at v = 0
    pub(super) d: V,
    pub(super) rest: V,
    /// w1
    pub(super) w: V,
    /// Intermediate vectors
    pub(super) scratch: [V; 6],
    pub(super) energy_rounding: EnergyRounding<V::Scalar>,
}

impl<V: Vector> Workspace<V> {
    /// Allocates the vectors of a step.
    ///
    /// # Errors
    /// Those of [`Slopes::new`].
    pub(super) fn new<S: Curvature<V::Scalar> + ?Sized>(system: &S) -> Result<Self, InputError> {
        let n = system.dof();
        let (zeros, pair) = (|| V::zeros(n), || [V::zeros(n), V::zeros(n)]);
        Ok(Self {
            dissipative: !system.dissipation_form().zero,
            linear: system.is_linear(),
            free: n - system.motors(),
            resolved: None,
            slopes: Slopes::new(system)?,
            flow: LinearFlow::new(n),
            dz: pair(),
            mean: pair(),
            end: pair(),
            gradient: pair(),
            d: zeros(),
            rest: zeros(),
            w: zeros(),
            scratch: [zeros(), zeros(), zeros(), zeros(), zeros(), zeros()],
            energy_rounding: EnergyRounding::new(n),
        })
    }

    /// q, p and w of the new state.
    pub(super) fn ends(&self) -> [&[V::Scalar]; 3] {
        [self.end[0].as_slice(), self.end[1].as_slice(), self.w.as_slice()]
    }

    /// Sets z̄ and z1 from Δz.
    pub(super) fn place(&mut self, state: &State<V>) {
        let n = state.dof();
        for (i, start) in [&state.q, &state.p].into_iter().enumerate() {
            let (start, dz) = (&start.as_slice()[..n], &self.dz[i].as_slice()[..n]);
            let (mean, end) =
                (&mut self.mean[i].as_mut_slice()[..n], &mut self.end[i].as_mut_slice()[..n]);
            for j in 0..n {
                mean[j] = start[j] + dz[j].half();
                end[j] = start[j] + dz[j];
            }
        }
    }

    /// Evaluates ∇̄H, D̄, S and R at Δz, where `start` = H(z0), and then u(0) = f̄ - ½ A Δz.
    pub(super) fn evaluate<S>(&mut self, system: &S, h: V::Scalar, start: V::Scalar)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let [q, p] = &self.mean;
        let [hq, hp] = &mut self.gradient;
        system.gradient(q.as_slice(), p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
        let lambda = if self.linear { V::Scalar::zero() } else { self.lambda(system, h, start) };
        for (slope, dz) in self.gradient.iter_mut().zip(&self.dz) {
            let pairs = slope.as_mut_slice().iter_mut().zip(&dz.as_slice()[..self.free]);
            pairs.for_each(|(slope, &dz)| *slope = lambda.mul_add(dz, *slope));
        }
        let [q, p] = [&self.mean[0], &self.mean[1]].map(V::as_slice);
        self.slopes.evaluate(system, [q, p]);
        if self.dissipative {
            let [probe, found, ..] = &mut self.scratch;
            let parts = [&mut self.rest, &mut self.d, probe, found].map(V::as_mut_slice);
            self.slopes.resist(system, [q, p], self.gradient[1].as_slice(), parts);
        }
        let [a, b, c, d, ..] = &mut self.scratch;
        let dz = [self.dz[0].as_slice(), self.dz[1].as_slice()];
        self.slopes.multiply(
            dz,
            [a.as_mut_slice(), b.as_mut_slice()],
            [c.as_mut_slice(), d.as_mut_slice()],
        );
        let [u_q, u_p] = &mut self.flow.u;
        let [hq, hp] = [self.gradient[0].as_slice(), self.gradient[1].as_slice()];
        let (a, b, drag) = (a.as_slice(), b.as_slice(), self.d.as_slice());
        for (j, (u_q, u_p)) in u_q.as_mut_slice().iter_mut().zip(u_p.as_mut_slice()).enumerate() {
            *u_q = hp[j] - a[j].half();
            *u_p = -hq[j] - drag[j] - b[j].half();
        }
    }

    /// λ, or 0 where it is not resolved ([`Lambda::if_resolved`]).
    fn lambda<S>(&mut self, system: &S, h: V::Scalar, start: V::Scalar) -> V::Scalar
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let zero = V::Scalar::zero();
        let (mut along, mut square) = (zero, zero);
        for (slope, dz) in self.gradient.iter().zip(&self.dz) {
            let pairs = slope.as_slice().iter().zip(dz.as_slice());
            along = pairs.fold(along, |along, (&slope, &dz)| slope.mul_add(dz, along));
            let own = &dz.as_slice()[..self.free];
            square = own.iter().fold(square, |square, &dz| dz.mul_add(dz, square));
        }
        let [q, p] = [&self.end[0], &self.end[1]].map(V::as_slice);
        let energies = || [start, system.energy(q, p)];
        let lambda = Lambda::of(along, square, energies, self.energy_rounding.largest());
        lambda.if_resolved(h, &mut self.resolved).value
    }
}
