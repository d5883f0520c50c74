//! The equation of the step at a Δz: the system at z̄, its second derivatives, and the product with A.

use crate::linear_flow::LinearFlow;
use afterbay_core::{Block, Curvature, Scalar, State, Vector};

/// Roundings by which friction that is linear in the velocities may miss R v.
const ROUNDINGS: f64 = 64.0;

/// S and R at z̄.
#[derive(Clone, Debug)]
pub(super) struct Slopes<V: Vector> {
    /// S = H'', entry by entry
    entries: Vec<(Block, usize, usize, V::Scalar)>,
    /// R by columns where it couples velocities, else its diagonal
    friction: Vec<V::Scalar>,
    coupled: bool,
}

/// The new state while it is being made.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    pub(super) dissipative: bool,
    pub(super) linear: bool,
    pub(super) slopes: Slopes<V>,
    pub(super) flow: LinearFlow<V>,
    /// Δz
    pub(super) dz: [V; 2],
    /// z̄ and z1
    mean: [V; 2],
    pub(super) end: [V; 2],
    /// ∇̄H
    pub(super) gradient: [V; 2],
    /// D̄, and what is left of it at v = 0
    pub(super) d: V,
    pub(super) rest: V,
    /// w1
    pub(super) w: V,
    /// Vectors and what matrices make of them
    pub(super) scratch: [V; 6],
}

impl<V: Vector> Workspace<V> {
    pub(super) fn new<S: Curvature<V::Scalar> + ?Sized>(system: &S) -> Self {
        let n = system.dof();
        let (zeros, pair) = (|| V::zeros(n), || [V::zeros(n), V::zeros(n)]);
        let damping = system.damping();
        let mut count = 0;
        let origin = vec![V::Scalar::zero(); n];
        system.curvature(&origin, &origin, |_, _, _, _| count += 1);
        let width = if damping.coupled { n * n } else { n };
        Self {
            dissipative: !damping.zero,
            linear: system.is_linear(),
            slopes: Slopes {
                entries: Vec::with_capacity(count),
                friction: vec![V::Scalar::zero(); width],
                coupled: damping.coupled,
            },
            flow: LinearFlow::new(n),
            dz: pair(),
            mean: pair(),
            end: pair(),
            gradient: pair(),
            d: zeros(),
            rest: zeros(),
            w: zeros(),
            scratch: [zeros(), zeros(), zeros(), zeros(), zeros(), zeros()],
        }
    }

    /// q, p and w of the new state.
    pub(super) fn end(&self) -> [&[V::Scalar]; 3] {
        [self.end[0].as_slice(), self.end[1].as_slice(), self.w.as_slice()]
    }

    /// z̄ and z1 of Δz.
    pub(super) fn place(&mut self, state: &State<V>) {
        let n = state.dof();
        for (i, start) in [&state.q, &state.p].into_iter().enumerate() {
            let (start, dz) = (&start.as_slice()[..n], &self.dz[i].as_slice()[..n]);
            let (mean, end) = (&mut self.mean[i].as_mut_slice()[..n], &mut self.end[i].as_mut_slice()[..n]);
            for j in 0..n {
                mean[j] = start[j] + dz[j].half();
                end[j] = start[j] + dz[j];
            }
        }
    }

    /// ∇̄H, D̄, S and R of Δz, where H was `start` at z0; then u(0) = f̄ - ½ A Δz.
    pub(super) fn evaluate<S>(&mut self, system: &S, start: V::Scalar)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let [q, p] = &self.mean;
        let [hq, hp] = &mut self.gradient;
        system.gradient(q.as_slice(), p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
        let lambda = if self.linear { V::Scalar::zero() } else { self.lambda(system, start) };
        for (slope, dz) in self.gradient.iter_mut().zip(&self.dz) {
            let pairs = slope.as_mut_slice().iter_mut().zip(dz.as_slice());
            pairs.for_each(|(slope, &dz)| *slope = lambda.mul_add(dz, *slope));
        }
        let [q, p] = [&self.mean[0], &self.mean[1]].map(V::as_slice);
        self.slopes.entries.clear();
        system.curvature(q, p, |block, i, j, x| {
            if matches!(block, Block::Hqq | Block::Hqp | Block::Hpp) {
                self.slopes.entries.push((block, i, j, x));
            }
        });
        if self.dissipative {
            self.rub(system);
        }
        let [a, b, c, d, ..] = &mut self.scratch;
        let dz = [self.dz[0].as_slice(), self.dz[1].as_slice()];
        self.slopes.multiply(dz, [a.as_mut_slice(), b.as_mut_slice()], [c.as_mut_slice(), d.as_mut_slice()]);
        let [u_q, u_p] = &mut self.flow.u;
        let [hq, hp] = [self.gradient[0].as_slice(), self.gradient[1].as_slice()];
        let (a, b, drag) = (a.as_slice(), b.as_slice(), self.d.as_slice());
        for (j, (u_q, u_p)) in u_q.as_mut_slice().iter_mut().zip(u_p.as_mut_slice()).enumerate() {
            *u_q = hp[j] - a[j].half();
            *u_p = -hq[j] - drag[j] - b[j].half();
        }
    }

    /// λ = [H(z1) - H(z0) - ∇H(z̄)·Δz] / |Δz|², 0 where rounding decides it.
    fn lambda<S: Curvature<V::Scalar> + ?Sized>(&self, system: &S, start: V::Scalar) -> V::Scalar {
        let zero = V::Scalar::zero();
        let (mut along, mut square) = (zero, zero);
        for (slope, dz) in self.gradient.iter().zip(&self.dz) {
            for (&slope, &dz) in slope.as_slice().iter().zip(dz.as_slice()) {
                along = slope.mul_add(dz, along);
                square = dz.mul_add(dz, square);
            }
        }
        if square.to_f64() <= f64::MIN_POSITIVE / V::Scalar::EPSILON {
            return zero;
        }
        let end = system.energy(self.end[0].as_slice(), self.end[1].as_slice());
        (end - start - along) / square
    }

    /// D̄ and R at z̄: D(z̄, v) = D(z̄, 0) + R v.
    fn rub<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let n = self.d.as_slice().len();
        let [q, p] = [self.mean[0].as_slice(), self.mean[1].as_slice()];
        let (rest, v) = (self.rest.as_mut_slice(), self.gradient[1].as_slice());
        let [probe, found, ..] = &mut self.scratch;
        let (probe, found) = (probe.as_mut_slice(), found.as_mut_slice());
        let (zero, one) = (V::Scalar::zero(), V::Scalar::one());
        let friction = &mut self.slopes.friction;
        let d = self.d.as_mut_slice();
        probe.fill(zero);
        system.dissipation(q, p, probe, rest);
        if !self.slopes.coupled {
            // Linear in p is linear in v; else the secant, where there is one.
            for (probe, &v) in probe.iter_mut().zip(v) {
                *probe = if system.damping().linear || v == zero { one } else { v };
            }
            system.dissipation(q, p, probe, found);
            for j in 0..n {
                friction[j] = (found[j] - rest[j]) / probe[j];
                d[j] = friction[j].mul_add(v[j], rest[j]);
            }
            return;
        }
        for (k, column) in friction.chunks_exact_mut(n.max(1)).enumerate() {
            probe.fill(zero);
            probe[k] = one;
            system.dissipation(q, p, probe, found);
            for j in 0..n {
                column[j] = found[j] - rest[j];
            }
        }
        system.dissipation(q, p, v, found);
        // R v, and what it is made of.
        d.copy_from_slice(rest);
        probe.fill(zero);
        for (k, column) in friction.chunks_exact(n.max(1)).enumerate() {
            for j in 0..n {
                d[j] = column[j].mul_add(v[k], d[j]);
                probe[j] += (column[j] * v[k]).abs();
            }
        }
        let off = |j: usize| (found[j] - d[j]).abs().to_f64();
        let rounding = |j: usize| V::Scalar::EPSILON * (probe[j] + rest[j].abs()).to_f64();
        if (0..n).any(|j| off(j) > ROUNDINGS * rounding(j)) {
            friction.fill(zero);
            rest.copy_from_slice(found);
            d.copy_from_slice(found);
        }
    }
}

impl<V: Vector> Slopes<V> {
    /// S x
    pub(super) fn bend(&self, [q, p]: [&[V::Scalar]; 2], [sq, sp]: [&mut [V::Scalar]; 2]) {
        sq.fill(V::Scalar::zero());
        sp.fill(V::Scalar::zero());
        for &(block, i, j, x) in &self.entries {
            match block {
                Block::Hqq => sq[i] = x.mul_add(q[j], sq[i]),
                Block::Hpp => sp[i] = x.mul_add(p[j], sp[i]),
                Block::Hqp => {
                    sq[i] = x.mul_add(p[j], sq[i]);
                    sp[j] = x.mul_add(q[i], sp[j]);
                }
                Block::Dq | Block::Dp => {}
            }
        }
    }

    /// Adds R v to `to`.
    pub(super) fn rub(&self, v: &[V::Scalar], to: &mut [V::Scalar]) {
        if self.coupled {
            for (column, &v) in self.friction.chunks_exact(v.len().max(1)).zip(v) {
                to.iter_mut().zip(column).for_each(|(to, &r)| *to = r.mul_add(v, *to));
            }
        } else {
            to.iter_mut().zip(&self.friction).zip(v).for_each(|((to, &r), &v)| *to = r.mul_add(v, *to));
        }
    }

    /// A x = (s_p, -s_q - R s_p) with s = S x, of which `s` is the place.
    pub(super) fn multiply(
        &self,
        x: [&[V::Scalar]; 2],
        [a, b]: [&mut [V::Scalar]; 2],
        [sq, sp]: [&mut [V::Scalar]; 2],
    ) {
        self.bend(x, [&mut *sq, &mut *sp]);
        self.rub(sp, sq);
        a.copy_from_slice(sp);
        b.iter_mut().zip(&*sq).for_each(|(b, &s)| *b = -s);
    }
}
