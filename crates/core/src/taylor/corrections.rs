//! The exact δ of a step of modDG, as series in h.

use super::expand;
use crate::numbers::{Scalar, Series};
use crate::system::{Correction, Separable, State};

/// δ of the equation for q and of the equation for p at (q, p), for any system with one degree of
/// freedom: the quotients `Δq m / p̄` and `-Δp / (ΔV/Δq + D̄)` along the exact flow, as series in
/// h.
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
    let force = system.divided_difference(&[q0], 0, q1).value
        + system.dissipation_of(&[q_mean], &[p_mean], 0).value;
    let delta_q = (q1 - q0) * system.mass(0) / p_mean;
    let delta_p = (p0 - p1) / force;
    [delta_q, delta_p].map(|delta| Correction { third: delta.c[3], fourth: delta.c[4] })
}
