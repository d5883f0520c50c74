//! The steps as written by hand for a single system: plain `f64` variables in a loop, with all
//! constants computed before it.
//!
//! They share with the generic steps the discrete equations and their order of evaluation (one
//! force at each position; no shortcuts that only a linear force permits), the iterations and the
//! stopping test of the implicit method, and the check that a new state is finite. They omit
//! generic types, the time, counts of evaluations, an observer, and the test every 1024 steps for a
//! state at rest.

use std::hint::cold_path;

/// One run: `steps` steps of size `h` from (q, p) with w = 0. Runs return `None` if a step is not
/// finite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task {
    pub(crate) h: f64,
    pub(crate) steps: u64,
    pub(crate) q: f64,
    pub(crate) p: f64,
}

/// The damped oscillator, V' = k q and D = b p.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    pub(crate) k: f64,
    pub(crate) b: f64,
}

/// The Duffing oscillator, V' = α q + β q³ and D = c p.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Duffing {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) c: f64,
}

/// Tests whether x is finite by arithmetic, which keeps the number in the floating-point unit.
#[inline(always)]
fn finite(x: f64) -> bool {
    x * 0.0 == 0.0
}

/// Leapfrog with a reservoir for the force V' and D = c p.
#[inline(always)]
fn leapfrog(task: Task, force: impl Fn(f64) -> f64, c: f64) -> Option<[f64; 3]> {
    let Task { h, steps, mut q, mut p } = task;
    let mut w = 0.0;
    let half = 0.5 * h;
    let keep = 1.0 / half.mul_add(c, 1.0);
    let (lose, reach, drain) = ((-half).mul_add(c, 1.0), h * keep, half * (c + c));
    for _ in 0..steps {
        let kicked = (-half).mul_add(force(q), p);
        let middle = kicked * keep;
        let q1 = reach.mul_add(kicked, q);
        let p1 = (-half).mul_add(force(q1), middle * lose);
        let w1 = (drain * middle).mul_add(middle, w);
        if !(finite(q1) & finite(p1) & finite(w1)) {
            return None;
        }
        (q, p, w) = (q1, p1, w1);
    }
    Some([q, p, w])
}

/// Leapfrog for the force V' alone.
#[inline(always)]
fn conservative_leapfrog(task: Task, force: impl Fn(f64) -> f64) -> Option<[f64; 3]> {
    let Task { h, steps, mut q, mut p } = task;
    let half = 0.5 * h;
    for _ in 0..steps {
        let middle = (-half).mul_add(force(q), p);
        let q1 = h.mul_add(middle, q);
        let p1 = (-half).mul_add(force(q1), middle);
        if !(finite(q1) & finite(p1)) {
            return None;
        }
        (q, p) = (q1, p1);
    }
    Some([q, p, 0.0])
}

/// The classical Runge-Kutta method on (q, p, w) for the force V' and D = c p.
#[inline(always)]
fn rk4(task: Task, force: impl Fn(f64) -> f64, c: f64) -> Option<[f64; 3]> {
    let Task { h, steps, mut q, mut p } = task;
    let mut w = 0.0;
    let (half, sixth, third) = (0.5 * h, h * (1.0 / 6.0), h * (2.0 / 6.0));
    for _ in 0..steps {
        let (f1, d1, v1) = (force(q), c * p, p);
        let (q2, v2) = (half.mul_add(v1, q), (-half).mul_add(d1, (-half).mul_add(f1, p)));
        let (f2, d2) = (force(q2), c * v2);
        let (q3, v3) = (half.mul_add(v2, q), (-half).mul_add(d2, (-half).mul_add(f2, p)));
        let (f3, d3) = (force(q3), c * v3);
        let (q4, v4) = (h.mul_add(v3, q), (-h).mul_add(d3, (-h).mul_add(f3, p)));
        let (f4, d4) = (force(q4), c * v4);
        let dq = sixth.mul_add(v4, third.mul_add(v3, third.mul_add(v2, sixth * v1)));
        let early = third.mul_add(d3 + f3, third.mul_add(d2 + f2, sixth * (d1 + f1)));
        let dp = sixth.mul_add(d4, sixth.mul_add(f4, early));
        let dw = sixth
            .mul_add(d4 * v4, third.mul_add(d3 * v3, third.mul_add(d2 * v2, sixth * (d1 * v1))));
        let (q1, p1, w1) = (q + dq, p - dp, w + dw);
        if !(finite(q1) & finite(p1) & finite(w1)) {
            return None;
        }
        (q, p, w) = (q1, p1, w1);
    }
    Some([q, p, w])
}

/// The classical Runge-Kutta method on (q, p) for the force V' alone.
#[inline(always)]
fn conservative_rk4(task: Task, force: impl Fn(f64) -> f64) -> Option<[f64; 3]> {
    let Task { h, steps, mut q, mut p } = task;
    let (half, sixth, third) = (0.5 * h, h * (1.0 / 6.0), h * (2.0 / 6.0));
    for _ in 0..steps {
        let (f1, v1) = (force(q), p);
        let (q2, v2) = (half.mul_add(v1, q), (-half).mul_add(f1, p));
        let f2 = force(q2);
        let (q3, v3) = (half.mul_add(v2, q), (-half).mul_add(f2, p));
        let f3 = force(q3);
        let (q4, v4) = (h.mul_add(v3, q), (-h).mul_add(f3, p));
        let f4 = force(q4);
        let q1 = q + sixth.mul_add(v4, third.mul_add(v3, third.mul_add(v2, sixth * v1)));
        let p1 = p - sixth.mul_add(f4, third.mul_add(f3, third.mul_add(f2, sixth * f1)));
        if !(finite(q1) & finite(p1)) {
            return None;
        }
        (q, p) = (q1, p1);
    }
    Some([q, p, 0.0])
}

impl Oscillator {
    pub(crate) fn leapfrog(self, task: Task) -> Option<[f64; 3]> {
        leapfrog(task, |q| self.k * q, self.b)
    }

    pub(crate) fn rk4(self, task: Task) -> Option<[f64; 3]> {
        rk4(task, |q| self.k * q, self.b)
    }

    /// modDG in closed form.
    pub(crate) fn moddg(self, task: Task) -> Option<[f64; 3]> {
        let Task { h, steps, mut q, mut p } = task;
        let Self { k, b } = self;
        let mut w = 0.0;
        let friction = (0.5 * h).mul_add(k, b);
        let inverse = 1.0 / (0.5 * h).mul_add(friction, 1.0);
        let reach = h * inverse;
        let (back, pull, slow) = (reach * (0.5 * h * k), reach * k, reach * friction);
        let (by_q, drain) = (0.5 * pull, h * b);
        for _ in 0..steps {
            let v = (-by_q).mul_add(q, inverse * p);
            let q1 = reach.mul_add(p, (-back).mul_add(q, q));
            let p1 = (-pull).mul_add(q, (-slow).mul_add(p, p));
            let w1 = (drain * v).mul_add(v, w);
            if !(finite(q1) & finite(p1) & finite(w1)) {
                return None;
            }
            (q, p, w) = (q1, p1, w1);
        }
        Some([q, p, w])
    }

    /// modDG solved by iteration to rounding, without use of the closed form.
    pub(crate) fn moddg_by_newton(self, task: Task) -> Option<[f64; 3]> {
        let Task { h, steps, mut q, mut p } = task;
        let mut w = 0.0;
        let (half, half_k) = (0.5 * h, 0.5 * self.k);
        let (damp, drain) = (half * self.b, h * self.b);
        let slope = (half * h).mul_add(half_k, damp);
        for _ in 0..steps {
            let v = solve(p, q.abs() / h, |v| {
                let to = h.mul_add(v, q);
                (half.mul_add(half_k * (q + to), damp * v), slope)
            })?;
            let q1 = h.mul_add(v, q);
            let p1 = 2.0_f64.mul_add(v, -p);
            let w1 = (drain * v).mul_add(v, w);
            if !(finite(q1) & finite(p1) & finite(w1)) {
                return None;
            }
            (q, p, w) = (q1, p1, w1);
        }
        Some([q, p, w])
    }
}

impl Duffing {
    fn force(self) -> impl Fn(f64) -> f64 {
        move |q| q * self.beta.mul_add(q * q, self.alpha)
    }

    pub(crate) fn leapfrog(self, task: Task) -> Option<[f64; 3]> {
        leapfrog(task, self.force(), self.c)
    }

    pub(crate) fn conservative_leapfrog(self, task: Task) -> Option<[f64; 3]> {
        conservative_leapfrog(task, self.force())
    }

    pub(crate) fn rk4(self, task: Task) -> Option<[f64; 3]> {
        rk4(task, self.force(), self.c)
    }

    pub(crate) fn conservative_rk4(self, task: Task) -> Option<[f64; 3]> {
        conservative_rk4(task, self.force())
    }

    /// modDG solved by iteration to rounding; `None` if the iteration does not converge.
    pub(crate) fn moddg(self, task: Task) -> Option<[f64; 3]> {
        let Task { h, steps, mut q, mut p } = task;
        let mut w = 0.0;
        let (half, drain) = (0.5 * h, h * self.c);
        let (damp, bend) = (half * self.c, half * h);
        let (half_alpha, half_beta, quarter_beta) =
            (0.5 * self.alpha, 0.5 * self.beta, 0.25 * self.beta);
        for _ in 0..steps {
            let (square, reach) = (q * q, q.abs() / h);
            let v = solve(p, reach, |v| {
                let to = h.mul_add(v, q);
                let sum = q + to;
                let stiffness = quarter_beta.mul_add(to.mul_add(to, square), half_alpha);
                let slope = (half_beta * to).mul_add(sum, stiffness);
                (half.mul_add(sum * stiffness, damp * v), bend.mul_add(slope, damp))
            })?;
            let q1 = h.mul_add(v, q);
            let p1 = 2.0_f64.mul_add(v, -p);
            let w1 = (drain * v).mul_add(v, w);
            if !(finite(q1) & finite(p1) & finite(w1)) {
                return None;
            }
            (q, p, w) = (q1, p1, w1);
        }
        Some([q, p, w])
    }

    /// modDG without friction.
    pub(crate) fn conservative_moddg(self, task: Task) -> Option<[f64; 3]> {
        let Task { h, steps, mut q, mut p } = task;
        let (half, bend) = (0.5 * h, 0.5 * h * h);
        let (half_alpha, half_beta, quarter_beta) =
            (0.5 * self.alpha, 0.5 * self.beta, 0.25 * self.beta);
        for _ in 0..steps {
            let (square, reach) = (q * q, q.abs() / h);
            let v = solve(p, reach, |v| {
                let to = h.mul_add(v, q);
                let sum = q + to;
                let stiffness = quarter_beta.mul_add(to.mul_add(to, square), half_alpha);
                let slope = (half_beta * to).mul_add(sum, stiffness);
                (half * (sum * stiffness), bend * slope)
            })?;
            let q1 = h.mul_add(v, q);
            let p1 = 2.0_f64.mul_add(v, -p);
            if !(finite(q1) & finite(p1)) {
                return None;
            }
            (q, p) = (q1, p1);
        }
        Some([q, p, 0.0])
    }
}

const EPSILON: f64 = f64::EPSILON / 2.0;

/// Solves `x = start - F(x)` to rounding, with the iteration and the stopping test of
/// `afterbay_core::solver::Newton`, but without its continuation where these fail. `f` returns F
/// and F'. Two evaluations are usually sufficient.
#[inline(always)]
fn solve(start: f64, reach: f64, f: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let (value, slope) = f(start);
    let (plain, square) = (1.0 - slope, slope * slope);
    let (inverse, rest) = (plain.mul_add(square, plain), square * square);
    let (previous, x) = (-value * inverse, (-value).mul_add(inverse, start));
    let gentle = slope.abs() < 0.0625;
    let (value, slope) = f(x);
    let missing = (-slope).mul_add(inverse, 1.0 - inverse);
    let inverse = (-slope).mul_add(inverse * inverse, inverse * (2.0 - inverse));
    let residual = start - x - value;
    let (update, x) = (residual * inverse, residual.mul_add(inverse, x));
    let share = 1.0 / previous;
    let ratio = update * share;
    let off = (ratio - 0.5 * (rest + missing)).abs();
    let contraction = missing.abs() + ratio.abs();
    let next = contraction.mul_add(contraction, off) * ratio.abs();
    if gentle & (missing.abs() < 0.0625) & (next < (EPSILON * x.abs() * share).abs()) {
        return Some(x);
    }
    slowly(start, reach, f)
}

/// Continues the iteration where two evaluations are not sufficient.
#[cold]
#[inline(never)]
fn slowly(start: f64, reach: f64, f: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let (mut x, mut update, mut rising) = (start, f64::NAN, true);
    let (mut inverse, mut rest) = (1.0_f64, 0.0);
    for _ in 0..50 {
        let (value, slope) = f(x);
        let derivative = 1.0 + slope;
        rising &= derivative > 0.0;
        let before = rest;
        let missing = (-derivative).mul_add(inverse, 1.0);
        rest = missing * missing;
        inverse = (-slope).mul_add(inverse * inverse, inverse * (2.0 - inverse));
        if missing.abs() > 0.0625 {
            cold_path();
            rest = 0.0;
            inverse = 1.0 / derivative;
        }
        let residual = start - x - value;
        let previous = update;
        update = residual * inverse;
        let size = update.abs();
        x = residual.mul_add(inverse, x);
        let scale = start.abs().mul_add(inverse.abs(), x.abs());
        let shrunk = update / previous;
        let off = (shrunk - 0.5 * (before + missing)).abs();
        let contraction = missing.abs() + shrunk.abs();
        let lost = contraction.mul_add(contraction, off) * size <= EPSILON * scale;
        let small = EPSILON.sqrt() * (slope * inverse).abs().mul_add(reach, scale);
        let noise = (size <= small) & (previous.abs() <= 2.0 * size);
        if lost | noise {
            return rising.then_some(x);
        }
    }
    None
}
