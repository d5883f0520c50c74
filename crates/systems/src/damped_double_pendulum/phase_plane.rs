//! The pendulum along one angle or one momentum at a time, in closed form.
//!
//! With ψ = q_j - q_i, i the other rod, the kinetic energy is T = N/(2 det M), N = M22 p1² + M11
//! p2² - 2 B cos ψ p1 p2. Along an edge of q_j, from a to b, with m = (a + b)/2, e = (b - a)/2 (of
//! ψ) and σ = sin e / e, differences come from products:
//!
//! ```text
//! Δcos ψ/Δψ = -σ sin m        Δsin² ψ/Δψ = 2 σ cos e sin m cos m
//! Δ(1 - cos q_j)/Δq_j = σ sin (mean of q_j)
//! ΔT/Δψ = [ΔN/Δψ - (T_a + T_b) Δdet/Δψ] / (det_a + det_b)
//! ```
//!
//! exact at any length of the edge. H is quadratic in p_j: its mean slope is that at the middle.

use super::DampedDoublePendulum;
use afterbay_core::{Mean, PhasePlane, PlaneDissipation, Scalar, Slopes};

/// sin x / x, and its derivative.
#[inline(always)]
fn sinc<T: Scalar>(x: T, sin: T, cos: T) -> [T; 2] {
    let zero = x.abs().le(T::zero());
    let value = T::select(zero, T::one(), sin / T::select(zero, T::one(), x));
    // (cos x - sin x / x) / x cancels near 0, where -x/3 + x³/30 is as good for steering.
    let near = x.abs().lt(T::from_f64(0.01));
    let series = x * (x * x / T::from_f64(10.0) - T::one()) / T::from_f64(3.0);
    let slope = T::select(near, series, (cos - value) / T::select(near, T::one(), x));
    [value, slope]
}

/// A pair of momenta with that of `j` replaced.
#[inline(always)]
fn with<T: Scalar>(z: &[T], j: usize, at: T) -> [T; 2] {
    if j == 0 { [at, z[1]] } else { [z[0], at] }
}

impl<T: Scalar> PhasePlane<T> for DampedDoublePendulum<T> {
    #[inline]
    fn slopes(&self, q: &[T], p: &[T], j: usize, [q_j, p_j]: [T; 2]) -> Slopes<T> {
        let motion = self.motion(&with(q, j, q_j), &with(p, j, p_j));
        let ([sin, cos], [v1, v2]) = (motion.arm, motion.v);
        let [u1, u2] = [0, 1].map(|i| motion.by_angle(i));
        let whirl = sin * v1 * v2;
        let (weight, (sin_q, cos_q)) = (self.weight()[j], q_j.sin_cos());
        let (whirl, hqp) = if j == 0 { (whirl, u1) } else { (-whirl, -u2) };
        Slopes {
            hq: weight.mul_add(sin_q, whirl),
            hp: motion.v[j],
            hqq: weight.mul_add(cos_q, (cos * v1).mul_add(v2, sin * (u1 * v2 + v1 * u2))),
            hqp,
            hpp: motion.diagonal[j],
        }
    }

    fn along_q(&self, q: &[T], p: &[T], j: usize, [from, to]: [T; 2], p_j: T) -> Mean<T> {
        let ([m1, m2], [l1, l2], other) = (self.m, self.l, 1 - j);
        let (two, lever) = (T::from_f64(2.0), m2 * l1 * l2);
        let square = lever * lever;
        // M without the entry beside the diagonal, and the terms of N and det M.
        let mass = [(m1 + m2) * l1 * l1, m2 * l2 * l2];
        let (cross, heavy) = (lever * (p_j * p[other]), m1 * lever * l1 * l2);
        let still = mass[other] * p_j * p_j + mass[j] * p[other] * p[other];

        let (middle, e) = (from + (to - from).half(), (to - from).half());
        let ((s, c), (sin_e, cos_e)) = ((middle - q[other]).sin_cos(), e.sin_cos());
        let [sigma, sigma_slope] = sinc(e, sin_e, cos_e);
        // sin ψ, cos ψ, det M, T and v_j at the ends.
        let [start, end] = [-sin_e, sin_e].map(|sin_e| {
            let (sin, cos) = (s.mul_add(cos_e, c * sin_e), c.mul_add(cos_e, -(s * sin_e)));
            let det = (square * sin).mul_add(sin, heavy);
            let kinetic = (still - two * cross * cos) / (two * det);
            let v = (mass[other] * p_j - lever * cos * p[other]) / det;
            [sin, cos, det, kinetic, v]
        });
        let (both, kinetic) = (start[2] + end[2], start[3] + end[3]);
        // Δcos/Δψ, Δsin²/Δψ and their derivatives by the end.
        let (cos_slope, turn) = (-(sigma * s), two * s * c);
        let sin_slope = turn * sigma * cos_e;
        let cos_bend = -(c * sigma + s * sigma_slope).half();
        let sin_bend =
            (c * c - s * s) * sigma * cos_e + (turn * (sigma_slope * cos_e - sigma * sin_e)).half();
        // The derivatives of det M and T at the end.
        let det_end = two * square * end[0] * end[1];
        let kinetic_end = (cross * end[0] - end[3] * det_end) / end[2];

        let whirl = -(two * cross * cos_slope + kinetic * square * sin_slope) / both;
        let whirl_end = -(two * cross * cos_bend
            + square * (kinetic_end * sin_slope + kinetic * sin_bend)
            + whirl * det_end)
            / both;
        let by_other =
            -(two * lever * p[other] * cos_slope + (start[4] + end[4]) * square * sin_slope) / both;
        let (weight, (sin_q, cos_q)) = (self.weight()[j], middle.sin_cos());
        Mean {
            value: weight.mul_add(sin_q * sigma, whirl),
            by_end: weight.mul_add((cos_q * sigma + sin_q * sigma_slope).half(), whirl_end),
            by_other,
        }
    }

    #[inline]
    fn along_p(&self, q: &[T], p: &[T], j: usize, q_j: T, [from, to]: [T; 2]) -> Mean<T> {
        let motion = self.motion(&with(q, j, q_j), &with(p, j, from + (to - from).half()));
        let by_angle = motion.by_angle(j);
        Mean {
            value: motion.v[j],
            by_end: motion.diagonal[j].half(),
            by_other: if j == 0 { by_angle } else { -by_angle },
        }
    }

    #[inline(always)]
    fn plane_dissipation(
        &self,
        _q: &[T],
        _p: &[T],
        j: usize,
        _at: [T; 2],
        v: T,
    ) -> PlaneDissipation<T> {
        let c = self.c[j];
        PlaneDissipation { value: c * v, by_q: T::zero(), by_p: T::zero(), by_v: c }
    }
}
