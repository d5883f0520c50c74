//! The derivatives of systems against dual numbers, and divided differences against 31 digits.

use afterbay_core::{Quad, Scalar, Separable};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};
use num_dual::Dual64;
use proptest::prelude::*;

/// A system in the three scalars needed here.
struct Trio<'a> {
    plain: &'a dyn Separable<f64>,
    dual: &'a dyn Separable<Dual64>,
    quad: &'a dyn Separable<Quad>,
    /// The sums of the absolute values of the terms: of V as ½ A q² + ¼ B q⁴, of D as C (1 + q²)
    /// |p|.
    size: [f64; 3],
}

/// Calls `$check` with each system, made of the same three numbers.
macro_rules! for_every_system {
    ($parameters:expr, $check:expr) => {{
        let [x, y, z]: [f64; 3] = $parameters;
        let k = x.abs() + 0.1;
        for_every_system!(@one $check, DampedOscillator::new(k, y), [k, 0.0, y]);
        for_every_system!(@one $check, Duffing::new(x, y, z), [x, y, z]);
        for_every_system!(@one $check, VanDerPol::new(x), [1.0, 0.0, x]);
        for_every_system!(@one $check, ModifiedVanDerPol::new(x, y, z), [y, z, x]);
    }};
    (@one $check:expr, $system:expr, $size:expr) => {{
        let system = $system.unwrap();
        let (dual, quad) = (system.map(Dual64::from_f64), system.map(Quad::from_f64));
        let size = $size.map(f64::abs);
        $check(Trio { plain: &system, dual: &dual, quad: &quad, size });
    }};
}

/// A few roundings of `size`.
fn assert_close(found: f64, exact: f64, size: f64) {
    assert!((found - exact).abs() <= 4.0 * f64::EPSILON * size, "{found} {exact}, of size {size}");
}

fn gradients_are_derivatives(system: &Trio, q: f64, p: f64) {
    let along = |dq: f64, dp: f64| ([Dual64::new(q, dq)], [Dual64::new(p, dp)]);
    let (by_q, by_p) = (along(1.0, 0.0), along(0.0, 1.0));
    let [a, b, c] = system.size;

    let (mut hq, mut hp, mut d) = ([0.0], [0.0], [0.0]);
    system.plain.gradient(&[q], &[p], &mut hq, &mut hp);
    let force = a * q.abs() + b * q.abs().powi(3);
    assert_close(hq[0], system.dual.energy(&by_q.0, &by_q.1).eps, force);
    assert_close(hp[0], system.dual.energy(&by_p.0, &by_p.1).eps, p.abs());
    assert_close(system.plain.partial(&[q], 0, q), hq[0], force);

    system.plain.dissipation(&[q], &[p], &[p], &mut d);
    let drag = system.plain.dissipation_of(&[q], &[p], 0);
    let of = |(q, p): ([Dual64; 1], [Dual64; 1])| {
        let mut d = [Dual64::from_f64(0.0)];
        system.dual.dissipation(&q, &p, &p, &mut d);
        d[0].eps
    };
    assert_close(drag.value, d[0], c * (1.0 + q * q) * p.abs());
    assert_close(drag.by_q, of(by_q), 2.0 * c * (q * p).abs());
    assert_close(drag.by_p, of(by_p), c * (1.0 + q * q));
}

fn edges_are_divided_differences(system: &Trio, from: f64, to: f64) {
    let [a, b, _] = system.size;
    let edge = system.plain.divided_difference(&[from], 0, to);
    let sum = from.abs() + to.abs();
    let squares = from * from + to * to;
    let size = sum * (a / 2.0 + b / 4.0 * squares);

    let v = |q: f64| system.quad.energy(&[Quad::from_f64(q)], &[Quad::ZERO]);
    let width = Quad::from_f64(to) - Quad::from_f64(from);
    let exact = if from == to {
        system.quad.partial(&[Quad::ZERO], 0, Quad::from_f64(to))
    } else {
        (v(to) - v(from)) / width
    };
    // V itself is known to 1e-31 only, and its divided difference to that over the width.
    let blur = if from == to { 0.0 } else { 1e-30 * (a + b * squares) * squares / width.0.abs() };
    assert!((edge.value - exact.0).abs() <= 4.0 * f64::EPSILON * size + blur, "{edge:?} {exact:?}");

    let dual = system.dual.divided_difference(&[Dual64::from_f64(from)], 0, Dual64::new(to, 1.0));
    assert_close(dual.value.re, edge.value, size);
    assert_close(edge.slope, dual.value.eps, a / 2.0 + b * (squares + sum * sum));
}

proptest! {
    #[test]
    fn gradients(x in -2.0..2.0_f64, y in -2.0..2.0_f64, z in -2.0..2.0_f64,
                 q in -3.0..3.0_f64, p in -3.0..3.0_f64) {
        for_every_system!([x, y, z], |system: Trio| gradients_are_derivatives(&system, q, p));
    }

    #[test]
    fn edges(x in -2.0..2.0_f64, y in -2.0..2.0_f64, z in -2.0..2.0_f64, from in -3.0..3.0_f64,
             to in -3.0..3.0_f64, digits in 0..16_i32) {
        // Long edges, and short ones down to a rounding.
        for to in [to, from + (to - from) * 10f64.powi(-digits), from, -from] {
            for_every_system!([x, y, z], |system: Trio| {
                edges_are_divided_differences(&system, from, to);
            });
        }
    }
}
