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
    /// The polynomial is exact to rounding for |τ| up to this: q and p together, and w, which is quadratic in them and
    /// whose series falls more slowly.
    pub reach: f64,
}

impl<V: Vector, const M: usize> Expansion<V, M> {
    /// The expansion about `state`.
    pub fn about<S: System<Series<V::Scalar, M>> + ?Sized>(system: &S, state: &State<V>) -> Self {
        let lift = |part: &V| V::Of::<Series<V::Scalar, M>>::filled(part.as_slice(), Series::constant);
        let (q, p, w) = (lift(&state.q), lift(&state.p), lift(&state.w));
        let mut series = State { q, p, w, t: Series::constant(state.t) };
        expand(system, &mut series);
        let [q, p, w] = [&series.q, &series.p, &series.w].map(Vector::as_slice);
        let reach = limit(&[q, p]).min(limit(&[w]));
        Self { series, reach: if reach.is_nan() { 0.0 } else { reach } }
    }

    /// The state the time τ after the one expanded about.
    pub fn at(&self, tau: V::Scalar) -> State<V> {
        let Self { series, .. } = self;
        let at = |part: &V::Of<Series<V::Scalar, M>>| V::filled(part.as_slice(), |x| x.at(tau));
        State { q: at(&series.q), p: at(&series.p), w: at(&series.w), t: series.t.0[0] + tau }
    }

    /// The reach, or the time to the first kink ([`System::kinks`]) there may be on the way to `ahead`.
    fn clear<S: System<Series<V::Scalar, M>> + ?Sized>(&self, system: &S, ahead: f64) -> f64 {
        let Self { series, reach } = self;
        let (mut clear, way) = (*reach, reach.min(ahead.abs()).copysign(ahead));
        system
            .kinks(series.q.as_slice(), series.p.as_slice(), &mut |x| clear = clear.min(first_zero(&x, way)));
        clear
    }
}

/// A time up to which the series has no zero, infinite if it has none on the `way` from 0: the zero of
///
/// ```text
/// |x_0| + s x_1 τ - Σ_{k≥2} max(0, -s x_k) τ^k ≤ s x(τ)        s = sign x_0
/// ```
///
/// which is concave in τ ≥ 0. Newton's method comes to it from above, and it comes to a simple zero of x quadratically where the
/// expansion is made anew each time. A series that begins with 0, and is not 0, has a zero there.
fn first_zero<T: Scalar, const M: usize>(x: &Series<T, M>, way: f64) -> f64 {
    let start = x.0[0].to_f64();
    let term = |k: usize| x.0[k].to_f64() * start.signum() * way.signum().powi(k as i32);
    // Its value and its slope.
    let bound = |tau: f64| {
        (2..M).rev().chain([1, 0]).fold([0.0, 0.0], |[value, slope], k| {
            let term = if k < 2 { term(k) } else { term(k).min(0.0) };
            [f64::mul_add(value, tau, term), f64::mul_add(slope, tau, value)]
        })
    };
    if start == 0.0 {
        return if x.0.iter().all(|c| *c == T::zero()) { f64::INFINITY } else { 0.0 };
    }
    let mut tau = way.abs();
    let [mut value, mut slope] = bound(tau);
    if value >= 0.0 {
        return f64::INFINITY;
    }
    while value < 0.0 {
        // What is much smaller than τ is lost in the difference.
        let next = (tau - value / slope).max(f64::EPSILON * tau);
        if next >= tau {
            break;
        }
        tau = next;
        [value, slope] = bound(tau);
    }
    // A few roundings short of it.
    tau * (1.0 - 64.0 * f64::EPSILON)
}

/// The τ up to which the last two terms of series that belong together stay below a rounding of their largest term: the entries of
/// a coefficient count by the largest of them.
fn limit<T: Scalar, const M: usize>(parts: &[&[Series<T, M>]]) -> f64 {
    let size = |k: usize| parts.iter().copied().flatten().map(|x| x.0[k].abs().to_f64()).fold(0.0, f64::max);
    let last = |last: usize| match size(last) {
        0.0 => f64::INFINITY,
        least => (0..last)
            .map(|k| (T::EPSILON * (size(k) / least)).powf(1.0 / (last - k) as f64))
            .fold(0.0, f64::max),
    };
    last(M - 1).min(last(M - 2))
}

/// Short strides one after the other that no kink takes, and how many of them make the leap over it twice as long.
const SHORT: u32 = 128;
const TWICE: u32 = 4;

/// The exact flow from `start` at the times `i h`, i = 0..=count, from expansions with M terms: a reference for systems
/// without a closed solution.
///
/// Between [`System::kinks`] the flow is analytic. Expansions end short of a kink, ever nearer, until a stride of some roundings of t
/// leaps over it: what the field jumps by counts for no longer than that.
///
/// # Errors
/// [`InputError::Length`] and [`InputError::NotFinite`] where `start` is no state of the system,
/// [`InputError::SolutionEnds`] where the solution leaves the numbers: the reach of the expansions shrinks to nothing. So it does at
/// a singularity such as √x at 0, and the time between kinks where the flow sticks to one.
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
    let end = V::Scalar::from_f64(count as f64) * h;
    let mut expansion = Expansion::<V, M>::about(system, start);
    let mut clear = expansion.clear(system, end.to_f64());
    // The time of the point expanded about.
    let mut origin = V::Scalar::zero();
    let mut short = 0;
    for i in 0..=count {
        let t = V::Scalar::from_f64(i as f64) * h;
        while (t - origin).to_f64().abs() > clear {
            let brief = 1e-12 * t.to_f64().abs();
            short = if clear > brief { 0 } else { short + 1 };
            let leap = 4.0 * V::Scalar::EPSILON * t.to_f64().abs() * 2f64.powi((short / TWICE) as i32);
            let stride = clear.max(leap).copysign(h.to_f64());
            let mut state = expansion.at(V::Scalar::from_f64(stride));
            if state.check(dof).is_err() || expansion.reach <= brief || short > SHORT {
                return Err(InputError::SolutionEnds { t: (start.t + origin).to_f64() });
            }
            state.settle();
            origin += V::Scalar::from_f64(stride);
            expansion = Expansion::about(system, &state);
            clear = expansion.clear(system, (end - origin).to_f64());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quad;

    /// H = Σ (p_j² + q_j²)/2 + q1⁴/4 + (q1 - q2)²/2, D_j = c (1 + q_j²) v_j
    struct Pair {
        c: f64,
    }

    impl<T: Scalar> System<T> for Pair {
        fn dof(&self) -> usize {
            2
        }
        fn energy(&self, q: &[T], p: &[T]) -> T {
            let (r, s) = (q[0] - q[1], q[0] * q[0]);
            (p[0] * p[0] + p[1] * p[1] + s + q[1] * q[1] + s * s.half() + r * r).half()
        }
        fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
            let r = q[0] - q[1];
            (hq[0], hq[1]) = (q[0] + q[0] * q[0] * q[0] + r, q[1] - r);
            hp.copy_from_slice(p);
        }
        fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
            (0..2).for_each(|j| d[j] = T::from_f64(self.c) * (T::one() + q[j] * q[j]) * v[j]);
        }
    }

    /// What q and p, and what w are off by at the end of the reach, in roundings of the largest of each, beside 48 terms in
    /// 31 digits. Those are good to 1e-31 there.
    fn off<T: Scalar>(
        system: &Pair,
        [q, p]: [[f64; 2]; 2],
        back: bool,
        value: impl Fn(T) -> Quad,
    ) -> [f64; 2] {
        fn start<T: Scalar>(q: [f64; 2], p: [f64; 2]) -> State<[T; 2]> {
            State { q: q.map(T::from_f64), p: p.map(T::from_f64), w: [T::zero(); 2], t: T::zero() }
        }
        let short = Expansion::<[T; 2], 24>::about(system, &start(q, p));
        let tau = if back { -short.reach } else { short.reach };
        let found = short.at(T::from_f64(tau));
        let exact = Expansion::<[Quad; 2], 48>::about(system, &start(q, p)).at(Quad::from_f64(tau));
        let off = |found: &[T], exact: &[Quad]| {
            let most = |x: &mut dyn Iterator<Item = Quad>| x.map(|x| x.abs().to_f64()).fold(0.0, f64::max);
            let apart = most(&mut found.iter().zip(exact).map(|(&a, &b)| value(a) - b));
            apart / (T::EPSILON * most(&mut exact.iter().copied()))
        };
        [off(&[found.q, found.p].concat(), &[exact.q, exact.p].concat()), off(&found.w, &exact.w)]
    }

    #[test]
    fn q_p_and_w_are_exact_to_rounding_at_the_end_of_the_reach() {
        let starts = [[[1.0, -0.5], [0.3, 0.8]], [[1.5, 0.2], [0.0; 2]], [[0.0; 2], [0.1, -2.0]]];
        for c in [0.01, 0.3, 5.0] {
            for from in starts {
                for back in [false, true] {
                    let system = Pair { c };
                    let found = [
                        off::<f64>(&system, from, back, Quad::from_f64),
                        off::<Quad>(&system, from, back, |x| x),
                    ];
                    println!("c = {c}, {from:?}: {found:.1?}");
                    assert!(found.iter().flatten().all(|&off| off < 16.0), "{c} {from:?} {back}: {found:?}");
                }
            }
        }
    }

    /// H = p²/2 + |q|: parabolas that meet at q = 0.
    struct Roof;

    impl<T: Scalar> System<T> for Roof {
        fn dof(&self) -> usize {
            1
        }
        fn energy(&self, q: &[T], p: &[T]) -> T {
            (p[0] * p[0]).half() + q[0].abs()
        }
        fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
            hq[0] = T::select(q[0].lt(T::zero()), -T::one(), T::one());
            hp.copy_from_slice(p);
        }
        fn dissipation(&self, _q: &[T], _p: &[T], _v: &[T], d: &mut [T]) {
            d[0] = T::zero();
        }
        fn kinks(&self, q: &[T], _p: &[T], put: &mut dyn FnMut(T)) {
            put(q[0]);
        }
    }

    /// From (1, 0) to q = 0 in √2, and round in 4 √2, forward and back.
    #[test]
    fn a_force_that_jumps_is_followed_from_kink_to_kink() {
        let quarter = Quad::from_f64(2.0).sqrt();
        for h in [0.75, -0.75] {
            let start = State::new([Quad::from_f64(1.0)], [Quad::from_f64(0.0)]).unwrap();
            let states = trajectory::<_, _, 24>(&Roof, &start, Quad::from_f64(h), 40).unwrap();
            for (i, state) in states.iter().enumerate() {
                // The time since the last top or bottom, and which it was.
                let t = Quad::from_f64(i as f64 * 0.75);
                let half = ((t.to_f64() + quarter.to_f64()) / (2.0 * quarter.to_f64())).floor();
                let (side, t) = (1.0 - 2.0 * (half % 2.0), t - Quad::from_f64(2.0 * half) * quarter);
                let (q, p) = (Quad::from_f64(1.0) - (t * t).half(), -t * Quad::from_f64(h.signum()));
                let side = Quad::from_f64(side);
                let off = [state.q[0] - side * q, state.p[0] - side * p].map(|x| x.to_f64().abs());
                // At each kink the force, which jumps by 2, is that before it for up to two leaps.
                let elapsed = i as f64 * 0.75;
                let leap = 4.0 * <Quad as Scalar>::EPSILON * (0.75 + elapsed);
                let allowed = (1.0 + half) * 2.0 * 2.0 * leap * (1.0 + elapsed);
                assert!(off.iter().all(|&x| x < allowed), "{h} {i}: {off:?} {allowed:e}");
            }
        }
    }
}
