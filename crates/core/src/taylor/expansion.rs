//! A Taylor expansion of the flow in time.

use super::kink::first_zero;
use super::reach::{reach, sizes};
use crate::numbers::{Scalar, Series, Vector};
use crate::system::{State, System};

/// Computes the Taylor coefficients in time of q, p and w from their constant terms.
///
/// Each of Picard's iterations `z ← z_0 + ∫ f(z)` computes one more coefficient of q and p from
/// those known so far. No derivative depends on w, which is integrated once, after the last.
pub fn expand<V, T, S, const N: usize>(system: &S, state: &mut State<V>)
where
    T: Scalar,
    V: Vector<Scalar = Series<T, N>>,
    S: System<Series<T, N>> + ?Sized,
{
    let n = state.dof();
    let (mut hq, mut hp, mut d) = (V::zeros(n), V::zeros(n), V::zeros(n));
    for x in state.q.as_mut_slice().iter_mut().chain(state.p.as_mut_slice()) {
        *x = x.first();
    }
    for _ in 1..N {
        let (q, p) = (state.q.as_slice(), state.p.as_slice());
        system.gradient(q, p, hq.as_mut_slice(), hp.as_mut_slice());
        system.dissipation(q, p, hp.as_slice(), d.as_mut_slice());
        for j in 0..n {
            let (hq, hp, d) = (hq.as_slice()[j], hp.as_slice()[j], d.as_slice()[j]);
            let (q, p) = (&mut state.q.as_mut_slice()[j], &mut state.p.as_mut_slice()[j]);
            *q = hp.integral(q.c[0]);
            *p = (-hq - d).integral(p.c[0]);
        }
    }
    for (w, (d, hp)) in
        state.w.as_mut_slice().iter_mut().zip(d.as_slice().iter().zip(hp.as_slice()))
    {
        *w = (*d * *hp).integral(w.c[0]);
    }
}

/// The kinds of entries, each with a unit of its own: q, p and w, and behind them q and p of
/// motors, which are times and energies.
pub(super) const KINDS: usize = 5;

/// The kinds of q_j, p_j and w_j, where degrees of freedom from `free` on are motors.
pub(super) fn kinds(free: usize, j: usize) -> [usize; 3] {
    if j < free { [0, 1, 2] } else { [3, 4, 2] }
}

/// The flow from one state as a polynomial of degree M - 1 in time.
#[derive(Clone)]
pub struct Expansion<V: Vector, const M: usize> {
    pub(super) series: State<V::Of<Series<V::Scalar, M>>>,
    /// The largest coefficients of each kind of entry.
    sizes: [[f64; M]; KINDS],
    /// The number of degrees of freedom that are not motors.
    free: usize,
    /// The estimate of the largest |τ| at which the terms left out of q, p and w are below a
    /// rounding. The coefficients do not show features that are narrower than the distance to them;
    /// the [defect](super::Defect) does.
    pub reach: f64,
}

impl<V: Vector, const M: usize> Expansion<V, M> {
    /// The expansion about `state`.
    pub fn about<S>(system: &S, state: &State<V>) -> Self
    where
        S: System<Series<V::Scalar, M>> + ?Sized,
    {
        let lift =
            |part: &V| V::Of::<Series<V::Scalar, M>>::filled(part.as_slice(), Series::constant);
        let (q, p, w) = (lift(&state.q), lift(&state.p), lift(&state.w));
        let mut series = State { q, p, w, t: Series::constant(state.t) };
        expand(system, &mut series);
        let free = state.dof() - system.motors();
        let [(q, times), (p, energies)] =
            [&series.q, &series.p].map(|part| part.as_slice().split_at(free));
        let sizes = [q, p, series.w.as_slice(), times, energies].map(sizes);
        let reaches = sizes.each_ref().map(|sizes| reach(sizes, V::Scalar::EPSILON));
        Self { reach: reaches.into_iter().fold(f64::INFINITY, f64::min), series, sizes, free }
    }

    /// The state at the time τ after the point of expansion, or before it for τ < 0. It is accurate
    /// up to |τ| = `reach`.
    pub fn at(&self, tau: V::Scalar) -> State<V> {
        let Self { series, .. } = self;
        let at = |part: &V::Of<Series<V::Scalar, M>>| V::filled(part.as_slice(), |x| x.at(tau));
        State { q: at(&series.q), p: at(&series.p), w: at(&series.w), t: series.t.c[0] + tau }
    }

    /// The kinds of q_j, p_j and w_j.
    pub(super) fn kinds(&self, j: usize) -> [usize; 3] {
        kinds(self.free, j)
    }

    /// The largest terms of each kind at a time τ ≥ 0. That of w is at least p v, the scale of the
    /// kinetic energy.
    pub(super) fn scales(&self, tau: f64) -> [f64; KINDS] {
        let largest =
            |sizes: &[f64]| sizes.iter().rev().fold(0.0, |most: f64, &size| size.max(most * tau));
        let [q, p, w, times, energies] = self.sizes.each_ref().map(|sizes| largest(sizes));
        [q, p, w.max(p * largest(&self.sizes[0][1..])), times, energies]
    }

    /// A time up to which there is no kink ([`System::kinks`]), at most |limit|.
    pub(super) fn clear<S>(&self, system: &S, limit: f64) -> f64
    where
        S: System<Series<V::Scalar, M>> + ?Sized,
    {
        let (q, p) = (self.series.q.as_slice(), self.series.p.as_slice());
        let mut clear = limit.abs();
        system.kinks(q, p, &mut |x| clear = clear.min(first_zero(&x, limit)));
        clear
    }
}
