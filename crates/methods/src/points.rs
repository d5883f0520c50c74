//! The fields of a system at several points.
//!
//! The functions are not inlined into a step: there the compiler could not prove that their inputs
//! and outputs do not alias, and would not vectorise them.

use afterbay_core::{System, Vector};

/// Computes ∂H/∂q and ∂H/∂p at K points.
#[inline(never)]
pub(crate) fn gradient<V: Vector, S: System<V::Scalar> + ?Sized, const K: usize>(
    system: &S,
    q: &[V; K],
    p: &[V; K],
    hq: &mut [V; K],
    hp: &mut [V; K],
) {
    if system.has_batches() {
        let [q, p] = [q, p].map(|x| x.each_ref().map(V::as_slice));
        let [mut hq, mut hp] = [hq, hp].map(|x| x.each_mut().map(V::as_mut_slice));
        return system.gradients(&q, &p, &mut hq, &mut hp);
    }
    for i in 0..K {
        let (q, p) = (q[i].as_slice(), p[i].as_slice());
        system.gradient(q, p, hq[i].as_mut_slice(), hp[i].as_mut_slice());
    }
}

/// Computes D at K points.
#[inline(never)]
pub(crate) fn dissipation<V: Vector, S: System<V::Scalar> + ?Sized, const K: usize>(
    system: &S,
    q: &[V; K],
    p: &[V; K],
    v: &[V; K],
    d: &mut [V; K],
) {
    if system.has_batches() {
        let [q, p, v] = [q, p, v].map(|x| x.each_ref().map(V::as_slice));
        return system.dissipations(&q, &p, &v, &mut d.each_mut().map(V::as_mut_slice));
    }
    for i in 0..K {
        system.dissipation(q[i].as_slice(), p[i].as_slice(), v[i].as_slice(), d[i].as_mut_slice());
    }
}
