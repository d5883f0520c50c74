//! A panel of nodes: the state and the system there, and what coefficients they come from and go to.

use super::rule::{Modes, NODES, Panel};
use afterbay_core::{System, Vector};

/// The state at a panel of nodes.
#[derive(Clone, Debug)]
pub(super) struct Nodes<V> {
    pub(super) q: [V; NODES],
    pub(super) p: [V; NODES],
}

#[inline(always)]
pub(super) fn place<V: Vector>(
    panel: &Panel<V::Scalar>,
    start: &[V::Scalar],
    h: V::Scalar,
    modes: &[Modes<V::Scalar>],
    to: &mut [V; NODES],
    n: usize,
) {
    for j in 0..n {
        let at = panel.place(start[j], h, &modes[j]);
        to.iter_mut().zip(at).for_each(|(to, at)| to.as_mut_slice()[j] = at);
    }
}

#[inline(always)]
pub(super) fn values<V: Vector>(
    panel: &Panel<V::Scalar>,
    modes: &[Modes<V::Scalar>],
    to: &mut [V; NODES],
    n: usize,
) {
    for j in 0..n {
        let at = panel.value(&modes[j]);
        to.iter_mut().zip(at).for_each(|(to, at)| to.as_mut_slice()[j] = at);
    }
}

#[inline(always)]
pub(super) fn project<V: Vector>(
    panel: &Panel<V::Scalar>,
    from: &[V; NODES],
    to: &mut [Modes<V::Scalar>],
    n: usize,
) {
    for j in 0..n {
        panel.project(std::array::from_fn(|i| from[i].as_slice()[j]), &mut to[j]);
    }
}

#[inline(always)]
pub(super) fn gradients<V, S>(system: &S, at: &Nodes<V>, hq: &mut [V; NODES], hp: &mut [V; NODES])
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    for i in 0..NODES {
        system.gradient(at.q[i].as_slice(), at.p[i].as_slice(), hq[i].as_mut_slice(), hp[i].as_mut_slice());
    }
}

#[inline(always)]
pub(super) fn dissipations<V, S>(system: &S, at: &Nodes<V>, v: &[V; NODES], d: &mut [V; NODES])
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    for i in 0..NODES {
        system.dissipation(at.q[i].as_slice(), at.p[i].as_slice(), v[i].as_slice(), d[i].as_mut_slice());
    }
}
