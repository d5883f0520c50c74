//! The exact flow as a Taylor series in time, computed by evaluating the system on [`Series`].

use crate::{Correction, Scalar, Separable, Series, State, System, Vector};

/// Fills in the Taylor coefficients in time of q, p and w from their constant terms.
///
/// Picard's iteration `z ← z_0 + ∫ f(z)` makes one more coefficient right each time. It is the definition itself,
/// quadratic in N where recurrences written for one system would be linear.
pub fn expand<V, T, S, const N: usize>(system: &S, state: &mut State<V>)
where
    T: Scalar,
    V: Vector<Scalar = Series<T, N>>,
    S: System<Series<T, N>> + ?Sized,
{
    let n = state.dof();
    let (mut hq, mut hp, mut d) = (V::zeros(n), V::zeros(n), V::zeros(n));
    for _ in 1..N {
        let (q, p) = (state.q.as_slice(), state.p.as_slice());
        system.gradient(q, p, hq.as_mut_slice(), hp.as_mut_slice());
        system.dissipation(q, p, d.as_mut_slice());
        for j in 0..n {
            let (hq, hp, d) = (hq.as_slice()[j], hp.as_slice()[j], d.as_slice()[j]);
            let [q, p, w] =
                [&mut state.q, &mut state.p, &mut state.w].map(|part| &mut part.as_mut_slice()[j]);
            *q = hp.integral(q.0[0]);
            *p = (-hq - d).integral(p.0[0]);
            *w = (d * hp).integral(w.0[0]);
        }
    }
}

/// Carries a state along the exact flow, up to O(h^N): a reference for systems without a closed solution.
pub fn flow<T, S, const D: usize, const N: usize>(system: &S, h: T, state: &mut State<[T; D]>)
where
    T: Scalar,
    S: System<Series<T, N>> + ?Sized,
{
    let lift = |part: [T; D]| part.map(Series::<T, N>::constant);
    let mut series =
        State { q: lift(state.q), p: lift(state.p), w: lift(state.w), t: Series::constant(state.t) };
    expand(system, &mut series);
    let at = |part: [Series<T, N>; D]| part.map(|x| x.at(h));
    *state = State { q: at(series.q), p: at(series.p), w: at(series.w), t: state.t + h };
}

/// δ of the equation for q and of the equation for p at (q, p), for any system with one degree of freedom:
/// the quotients `Δq m / p̄` and `-Δp / (ΔV/Δq + D̄)` along the exact flow, as series in h.
pub fn corrections<T, S>(system: &S, q: T, p: T) -> [Correction<T>; 2]
where
    T: Scalar,
    S: Separable<Series<T, 5>> + ?Sized,
{
    let (q0, p0) = (Series::constant(q), Series::constant(p));
    let mut state = State { q: [q0], p: [p0], w: [Series::zero()], t: Series::zero() };
    expand(system, &mut state);
    let ([q1], [p1]) = (state.q, state.p);
    let (q_mean, p_mean) = ((q0 + q1).half(), (p0 + p1).half());
    let force = system.edge(&[q0], 0, q1).value + system.drag(&[q_mean], &[p_mean], 0).value;
    let delta_q = (q1 - q0) * system.mass(0) / p_mean;
    let delta_p = (p0 - p1) / force;
    [delta_q, delta_p].map(|delta| Correction { third: delta.0[3], fourth: delta.0[4] })
}
