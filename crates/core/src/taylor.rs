//! The exact flow as a Taylor series in time, computed by evaluating the system on [`Series`].

use crate::{Correction, InputError, Scalar, Separable, Series, State, System, Vector};

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
        system.dissipation(q, p, hp.as_slice(), d.as_mut_slice());
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

/// The exact flow from one state as a polynomial of degree M - 1 in time, and the time it can be trusted for.
#[derive(Clone)]
pub struct Expansion<V: Vector, const M: usize> {
    series: State<V::Of<Series<V::Scalar, M>>>,
    /// The polynomial is exact to rounding for |τ| up to this.
    pub reach: f64,
}

impl<V: Vector, const M: usize> Expansion<V, M> {
    /// The expansion about `state`.
    pub fn about<S: System<Series<V::Scalar, M>> + ?Sized>(system: &S, state: &State<V>) -> Self {
        let lift = |part: &V| V::Of::<Series<V::Scalar, M>>::filled(part.as_slice(), Series::constant);
        let (q, p, w) = (lift(&state.q), lift(&state.p), lift(&state.w));
        let mut series = State { q, p, w, t: Series::constant(state.t) };
        expand(system, &mut series);
        // The last two terms stay below a rounding of the largest entry.
        let size = |k: usize| {
            let entries = series.q.as_slice().iter().chain(series.p.as_slice());
            entries.map(|x| x.0[k].abs().to_f64()).fold(0.0, f64::max)
        };
        let limit = |k: usize| match size(k) {
            0.0 => f64::INFINITY,
            last => (V::Scalar::EPSILON * (size(0) / last)).powf(1.0 / k as f64),
        };
        let reach = limit(M - 1).min(limit(M - 2));
        Self { series, reach: if reach.is_nan() { 0.0 } else { reach } }
    }

    /// The state the time τ after the one expanded about.
    pub fn at(&self, tau: V::Scalar) -> State<V> {
        let Self { series, .. } = self;
        let at = |part: &V::Of<Series<V::Scalar, M>>| V::filled(part.as_slice(), |x| x.at(tau));
        State { q: at(&series.q), p: at(&series.p), w: at(&series.w), t: series.t.0[0] + tau }
    }
}

/// The exact flow from `start` at the times `i h`, i = 0..=count, from expansions with M terms: a reference for systems
/// without a closed solution.
///
/// # Errors
/// [`InputError::Length`] and [`InputError::NotFinite`] where `start` is no state of the system,
/// [`InputError::SolutionEnds`] where the solution leaves the numbers: the reach of the expansions shrinks to nothing.
pub fn trajectory<S, V, const M: usize>(
    system: &S,
    start: &State<V>,
    h: V::Scalar,
    count: usize,
) -> Result<Vec<State<V>>, InputError>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    let dof = system.dof();
    start.check(dof)?;
    let mut states = Vec::with_capacity(count + 1);
    let mut expansion = Expansion::<V, M>::about(system, start);
    // Time since the point expanded about.
    let mut origin = V::Scalar::zero();
    for i in 0..=count {
        let t = V::Scalar::from_f64(i as f64) * h;
        while (t - origin).to_f64().abs() > expansion.reach {
            let stride = expansion.reach.copysign(h.to_f64());
            let mut state = expansion.at(V::Scalar::from_f64(stride));
            if state.check(dof).is_err() || expansion.reach <= 1e-12 * t.to_f64().abs() {
                return Err(InputError::SolutionEnds { t: (start.t + origin).to_f64() });
            }
            state.settle();
            origin += V::Scalar::from_f64(stride);
            expansion = Expansion::about(system, &state);
        }
        states.push(State { t: start.t + t, ..expansion.at(t - origin) });
    }
    Ok(states)
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
