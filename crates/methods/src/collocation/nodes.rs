//! The state and the system at the quadrature nodes, and the conversion from and to coefficients.
//!
//! The functions are not inlined into a step, for the reason given in `points`.

use super::rule::{Modes, NODES, Panel};
use crate::kernels::reductions::max_norm;
use crate::points::{dissipation, gradient};
use afterbay_core::{Scalar, System, Vector};

/// The state at a panel of nodes. Aligned for the reason given at [`Modes`].
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Nodes<V> {
    q: [V; NODES],
    p: [V; NODES],
}

/// The system at a panel of nodes. Aligned for the reason given at [`Modes`].
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Slopes<V> {
    pub(super) hq: [V; NODES],
    pub(super) hp: [V; NODES],
    v: [V; NODES],
    d: [V; NODES],
}

fn zeros<V: Vector>(n: usize) -> [V; NODES] {
    std::array::from_fn(|_| V::zeros(n))
}

impl<V: Vector> Nodes<V> {
    pub(super) fn new(n: usize) -> Self {
        Self { q: zeros(n), p: zeros(n) }
    }
}

impl<V: Vector> Slopes<V> {
    pub(super) fn new(n: usize) -> Self {
        Self { hq: zeros(n), hp: zeros(n), v: zeros(n), d: zeros(n) }
    }
}

/// The initial value of a variable, and its step size.
#[derive(Clone, Copy)]
pub(super) struct Start<'a, T> {
    pub(super) at: &'a [T],
    pub(super) h: T,
}

/// The largest |z_j| that a step may reach at its end.
pub(super) fn extent<V: Vector>(start: &V, modes: &[Modes<V::Scalar>], length: f64) -> f64 {
    let most = modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
    max_norm(start.as_slice()) + length * most
}

/// Evaluates a variable at the nodes from its coefficients.
#[inline(never)]
fn place<V: Vector>(
    panel: &Panel<V::Scalar>,
    start: Start<'_, V::Scalar>,
    modes: &[Modes<V::Scalar>],
    to: &mut [V; NODES],
) {
    let n = V::LEN.unwrap_or(modes.len());
    for (j, (modes, &from)) in modes[..n].iter().zip(&start.at[..n]).enumerate() {
        let at = panel.place(from, start.h, modes);
        for i in 0..NODES {
            to[i].as_mut_slice()[j] = at[i];
        }
    }
}

/// Evaluates the polynomial with the given coefficients at the nodes.
#[inline(never)]
fn evaluate<V: Vector>(panel: &Panel<V::Scalar>, modes: &[Modes<V::Scalar>], to: &mut [V; NODES]) {
    let n = V::LEN.unwrap_or(modes.len());
    for (j, modes) in modes[..n].iter().enumerate() {
        let at = panel.value(modes);
        for i in 0..NODES {
            to[i].as_mut_slice()[j] = at[i];
        }
    }
}

/// Adds the coefficients of `f`.
#[inline(never)]
fn project<V: Vector>(panel: &Panel<V::Scalar>, f: &[V; NODES], to: &mut [Modes<V::Scalar>]) {
    let n = V::LEN.unwrap_or(to.len());
    for (j, to) in to[..n].iter_mut().enumerate() {
        panel.project(std::array::from_fn(|i| f[i].as_slice()[j]), to);
    }
}

/// Adds `d` to `f`.
#[inline(never)]
fn add<V: Vector>(d: &[V; NODES], f: &mut [V; NODES]) {
    for i in 0..NODES {
        let (f, d) = (f[i].as_mut_slice(), d[i].as_slice());
        for j in 0..V::LEN.unwrap_or(f.len()) {
            f[j] += d[j];
        }
    }
}

/// Computes q at the nodes from its coefficients.
#[inline]
pub(super) fn place_q<V: Vector>(
    panels: &[Panel<V::Scalar>],
    nodes: &mut [Nodes<V>],
    start: Start<'_, V::Scalar>,
    modes: &[Modes<V::Scalar>],
) {
    for (panel, nodes) in panels.iter().zip(nodes) {
        place(panel, start, modes, &mut nodes.q);
    }
}

/// Computes p at the nodes from its coefficients `modes`, and the coefficients of ∂H/∂p from p and
/// the stored q.
#[inline]
pub(super) fn velocities<V, S>(
    system: &S,
    panels: &[Panel<V::Scalar>],
    nodes: &mut [Nodes<V>],
    slopes: &mut Slopes<V>,
    start: Start<'_, V::Scalar>,
    modes: &[Modes<V::Scalar>],
    to: &mut [Modes<V::Scalar>],
) where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    to.fill(Modes::zero());
    for (panel, nodes) in panels.iter().zip(nodes) {
        place(panel, start, modes, &mut nodes.p);
        gradient(system, &nodes.q, &nodes.p, &mut slopes.hq, &mut slopes.hp);
        project(panel, &slopes.hp, to);
    }
}

/// Computes q at the nodes from its coefficients `modes`, and the coefficients of ∂H/∂q + D from q,
/// the stored p, and the velocity with the coefficients `velocity`.
#[inline]
pub(super) fn forces<V, S>(
    system: &S,
    panels: &[Panel<V::Scalar>],
    nodes: &mut [Nodes<V>],
    slopes: &mut Slopes<V>,
    start: Start<'_, V::Scalar>,
    [modes, velocity]: [&[Modes<V::Scalar>]; 2],
    to: &mut [Modes<V::Scalar>],
) where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    let dissipative = !system.dissipation_form().zero;
    let Slopes { hq, hp, v, d } = slopes;
    to.fill(Modes::zero());
    for (panel, nodes) in panels.iter().zip(nodes) {
        place(panel, start, modes, &mut nodes.q);
        gradient(system, &nodes.q, &nodes.p, hq, hp);
        if dissipative {
            evaluate(panel, velocity, v);
            dissipation(system, &nodes.q, &nodes.p, v, d);
            add(d, hq);
        }
        project(panel, hq, to);
    }
}

/// Σ b_i D·v for each degree of freedom, at the stored nodes and the velocity with the given
/// coefficients.
#[inline]
pub(super) fn losses<V, S>(
    system: &S,
    panels: &[Panel<V::Scalar>],
    nodes: &[Nodes<V>],
    slopes: &mut Slopes<V>,
    velocity: &[Modes<V::Scalar>],
    to: &mut V,
) where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    let n = V::LEN.unwrap_or(velocity.len());
    let to = &mut to.as_mut_slice()[..n];
    let Slopes { v, d, .. } = slopes;
    to.fill(V::Scalar::zero());
    for (panel, nodes) in panels.iter().zip(nodes) {
        evaluate(panel, velocity, v);
        dissipation(system, &nodes.q, &nodes.p, v, d);
        for (j, to) in to.iter_mut().enumerate() {
            *to +=
                panel.integrate(std::array::from_fn(|i| d[i].as_slice()[j] * v[i].as_slice()[j]));
        }
    }
}
