//! Equations whose updates stop at the rounding of F: each is solved, alone and in lanes to the
//! bit.

use super::random;
use crate::error::StepFailure;
use crate::numbers::f64x8;
use crate::solver::{FixedPoint, Newton, Sample, Solver};

/// F, ∂F/∂x, and the size of the terms F is made of.
type Force = fn(&Case, f64, f64) -> [f64; 3];

/// A coordinate at `q` with the momentum `p` between two neighbours, and the force on it.
#[derive(Clone, Copy)]
struct Case {
    force: Force,
    h: f64,
    q: f64,
    p: f64,
    beside: [f64; 2],
}

impl Case {
    /// The sample that a step of the increments passes to the solver.
    fn sample(&self, s: f64, v: f64) -> Sample<f64> {
        let Self { force, h, q, beside: [left, right], .. } = *self;
        let by_q = s * h / 2.0;
        let [value, slope, _] = force(self, s, v);
        let reach = q.abs().max(left.abs()).max(right.abs());
        Sample { value, slope, argument_rounding: by_q * q.abs(), value_rounding: by_q * reach }
    }

    /// 64 roundings of x, of the start, of a position and of the terms of F, over 1 + F'.
    fn bound(&self, x: f64) -> f64 {
        let [_, slope, terms] = (self.force)(self, 1.0, x);
        let sizes = terms + self.p.abs() + self.h / 2.0 * self.q.abs() * slope.abs().max(1.0);
        64.0 * (f64::EPSILON / 2.0) * (x.abs() + sizes / (1.0 + slope)) + f64::MIN_POSITIVE
    }

    /// Halves a bracket of x + F = p to neighbouring numbers: F rises.
    fn halved(&self) -> f64 {
        let [force, ..] = (self.force)(self, 1.0, self.p);
        let reach = 2.0 * (force.abs() + self.p.abs()) + 1e-300;
        let (mut low, mut high) = (self.p - reach, self.p + reach);
        loop {
            let middle = low / 2.0 + high / 2.0;
            if middle <= low || middle >= high {
                return middle;
            }
            let [force, ..] = (self.force)(self, 1.0, middle);
            if middle - self.p + force < 0.0 { low = middle } else { high = middle }
        }
    }

    fn solve(&self) -> Result<f64, StepFailure> {
        Newton.solve(0, self.p, |s, v| self.sample(s, v)).map(|root| root.x)
    }
}

/// Bonds of V = e^r - r - 1 to both neighbours, each of which is 0 to rounding near rest, and
/// friction.
fn toda(case: &Case, s: f64, v: f64) -> [f64; 3] {
    let (pull, to) = (s * case.h / 2.0, case.q + s * case.h * v);
    let [left, right] = [(to - case.beside[0]).exp(), (case.beside[1] - to).exp()];
    let value = pull * ((left - 1.0) - (right - 1.0) + 0.1 * v);
    [value, pull * (s * case.h * (left + right) + 0.1), case.h * (left + right)]
}

/// Saturated friction 0.2 tanh(v/0.003) in the well q²/2.
fn sticking(case: &Case, s: f64, v: f64) -> [f64; 3] {
    let (pull, to) = (s * case.h / 2.0, case.q + s * case.h * v);
    let friction = (v / 0.003).tanh();
    let slope = 0.2 / 0.003 * (1.0 - friction) * (1.0 + friction);
    let value = pull * ((case.q + to) / 2.0 + 0.2 * friction);
    [value, pull * (s * case.h / 2.0 + slope), case.h * (case.q.abs() + to.abs() + 0.2)]
}

/// Two forces of 1e10 that cancel but for the spring q.
fn cancelling(case: &Case, s: f64, v: f64) -> [f64; 3] {
    let (pull, to) = (s * case.h / 2.0, case.q + s * case.h * v);
    [pull * ((1e10 + to) - 1e10), pull * s * case.h, case.h * 1e10]
}

/// A pendulum whose angle is far from 0.
fn angle(case: &Case, s: f64, v: f64) -> [f64; 3] {
    let (pull, to) = (s * case.h / 2.0, case.q + s * case.h * v);
    [pull * to.sin(), pull * s * case.h * to.cos(), case.h]
}

/// A spring of stiffness 1e12.
fn stiff(case: &Case, s: f64, v: f64) -> [f64; 3] {
    let (pull, to) = (s * case.h / 2.0, case.q + s * case.h * v / 2.0);
    [pull * 1e12 * to, pull * s * case.h * 0.5e12, case.h * 1e12 * case.q.abs()]
}

/// Random cases with numbers about 10^size, eight at a time.
fn eight(seed: &mut u64, force: Force, [least, most]: [f64; 2], sizes: [f64; 2]) -> [Case; 8] {
    [(); 8].map(|()| {
        let h = 10_f64.powf(random(seed, least, most));
        let mut number = || 10_f64.powf(random(seed, sizes[0], sizes[1])) * random(seed, -1.0, 1.0);
        let [q, p, left, right] = [(); 4].map(|()| number());
        Case { force, h, q, p, beside: [left, right] }
    })
}

/// Every case is solved within its bound of the root by halving, and in lanes as alone.
fn check(name: &str, force: Force, steps: [f64; 2], sizes: [f64; 2]) {
    let mut seed = 5;
    for _ in 0..500 {
        let cases = eight(&mut seed, force, steps, sizes);
        let alone = cases.map(|case| {
            let Case { h, q, p, beside, .. } = case;
            let found = case.solve();
            let x =
                found.unwrap_or_else(|e| panic!("{name}: h = {h:e}, {q:e} {p:e} {beside:?}: {e}"));
            let (exact, bound) = (case.halved(), case.bound(x));
            let off = (x - exact).abs();
            assert!(
                off <= bound,
                "{name}: h = {h:e}, {q:e} {p:e}: {x:e} is off by {off:e}, {bound:e}"
            );
            x
        });
        let start = f64x8::new(cases.map(|case| case.p));
        let together = Newton.solve(0, start, |s: f64x8, v: f64x8| {
            let (s, v) = (s.to_array(), v.to_array());
            let f: [Sample<f64>; 8] = std::array::from_fn(|k| cases[k].sample(s[k], v[k]));
            let each = |of: fn(&Sample<f64>) -> f64| f64x8::new(f.each_ref().map(of));
            Sample {
                value: each(|f| f.value),
                slope: each(|f| f.slope),
                argument_rounding: each(|f| f.argument_rounding),
                value_rounding: each(|f| f.value_rounding),
            }
        });
        let lanes = together.unwrap_or_else(|e| panic!("{name}: {e}")).x.to_array();
        assert_eq!(lanes.map(f64::to_bits), alone.map(f64::to_bits), "{name}");
    }
}

#[test]
fn a_chain_at_rest_is_solved() {
    check("at rest", toda, [-3.0, 0.0], [-19.0, -13.0]);
    check("partly at rest", toda, [-3.0, 0.0], [-30.0, 0.0]);
}

#[test]
fn tails_that_underflow_are_solved() {
    check("tails", toda, [-3.0, 0.0], [-323.0, -290.0]);
    check("tails", angle, [-3.0, 0.0], [-323.0, -290.0]);
}

#[test]
fn saturated_friction_is_solved() {
    check("sticking", sticking, [-3.0, 1.0], [-6.0, 0.5]);
    check("sticking at rest", sticking, [-3.0, 0.0], [-20.0, -3.0]);
}

#[test]
fn forces_that_cancel_are_solved() {
    check("cancelling", cancelling, [-3.0, 0.0], [-8.0, 1.0]);
}

#[test]
fn large_angles_are_solved() {
    check("angles", angle, [-3.0, 0.0], [6.0, 8.0]);
}

#[test]
fn stiff_forces_are_solved() {
    check("stiff", stiff, [-4.0, 0.0], [-3.0, 1.0]);
}

/// The rounding of F stops fixed-point iterations too.
#[test]
fn simple_iteration_ends_where_its_updates_are_rounding() {
    let mut seed = 5;
    for _ in 0..500 {
        for case in eight(&mut seed, toda, [-3.0, -0.5], [-19.0, -13.0]) {
            let found = FixedPoint.solve(0, case.p, |s: f64, v: f64| case.sample(s, v));
            let Case { h, q, p, beside, .. } = case;
            let x = found.unwrap_or_else(|e| panic!("h = {h:e}, {q:e} {p:e} {beside:?}: {e}")).x;
            let off = (x - case.halved()).abs();
            assert!(off <= case.bound(x), "h = {h:e}, {q:e} {p:e}: {x:e} is off by {off:e}");
        }
    }
}
