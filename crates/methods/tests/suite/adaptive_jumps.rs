//! Jumps of the force that methods with step size control pass.

use crate::adaptive_accuracy::{described, head, line, run};
use afterbay_methods::registry::ADAPTIVE;

/// The motion of q'' = -(q - c) - 2a q', where c is `centres[0]` for q below the edge and
/// `centres[1]` above it: q and q' at the end, from (2, 0).
///
/// ```text
/// q = c + exp(-a t) (x cos(bt) + y sin(bt))        b² = 1 - a²
/// q' = exp(-a t) ((b y - a x) cos(bt) - (a y + b x) sin(bt))
/// ```
fn two_springs(edge: f64, centres: [f64; 2], a: f64, end: f64) -> [f64; 2] {
    let b = (1.0 - a * a).sqrt();
    let (mut left, [mut q, mut v], mut above) = (end, [2.0, 0.0], true);
    loop {
        let c = centres[usize::from(above)];
        let x = q - c;
        let y = (v + a * x) / b;
        let at = |t: f64| {
            let (sin, cos) = (b * t).sin_cos();
            let decay = (-a * t).exp();
            let velocity = (b * y - a * x) * cos - (a * y + b * x) * sin;
            [c + decay * (x * cos + y * sin), decay * velocity]
        };
        let is_here = |t: f64| (at(t)[0] > edge) == above;
        let times = |i: u32| 1e-6 + 0.01 * f64::from(i);
        let i = (1..).find(|&i| !is_here(times(i)) || times(i) > left).unwrap();
        let [mut before, mut after] = [times(i - 1), times(i)];
        while before.midpoint(after) != before && before.midpoint(after) != after {
            let middle = before.midpoint(after);
            if is_here(middle) { before = middle } else { after = middle }
        }
        if after >= left {
            return at(left);
        }
        [q, v] = [edge, at(after)[1]];
        (left, above) = (left - after, !above);
    }
}

/// The force jumps where q passes an edge. No step across the jump is within a tight tolerance,
/// since the roundings of t move the jump by more.
#[test]
fn jumps_of_the_force_are_passed_at_any_tolerance() {
    head();
    for (potential, edge, centres) in [
        ("q1^2/2 + 0.2*abs(q1 - 0.7)", 0.7, [0.2, -0.2]),
        ("q1^2/2 + 3*max(q1 - 0.5, 0)", 0.5, [0.0, -3.0]),
    ] {
        let system = described(potential, &["0.001*v1"]);
        let (start, end): ([&[f64]; 2], f64) = ([&[2.0], &[0.0]], 200.0);
        let [q, v] = two_springs(edge, centres, 0.0005, end);
        let potential = |q: f64| {
            0.5 * q * q + 0.5 * (centres[0] - centres[1]) * (q - edge).abs()
                - 0.5 * (centres[0] + centres[1]) * q
        };
        let exact = [vec![q], vec![v], vec![potential(2.0) - potential(q) - 0.5 * v * v]];
        for row in ADAPTIVE {
            line(row, &system.curved(), start, end, &exact);
        }
    }
}

/// V = q²/2 + 0.2 |q - 0.7|: the motion turns at 0.7 + δ, so that it passes the jump and returns
/// within a small part of a step. In time t from its other turn it is
///
/// ```text
/// q = 0.2 - A cos t             q < 0.7, A = 0.5 + δ
/// q = -0.2 + 0.9 cos s + u sin s    q > 0.7, u the velocity at 0.7, s the time from there
/// ```
#[test]
fn a_jump_that_is_passed_for_a_moment_is_seen() {
    let system = described("q1^2/2 + 0.2*abs(q1 - 0.7)", &["0*v1"]);
    for depth in [1e-2_f64, 1e-3, 1e-4, 1e-5] {
        let width = 0.5 + depth;
        let there = (-0.5 / width).acos();
        let beyond = 2.0 * (width * there.sin()).atan2(0.9);
        let rest = 20.0_f64.rem_euclid(2.0 * there + beyond);
        let back = rest - there - beyond;
        let phase = if back > 0.0 { there - back } else { rest };
        assert!(phase < there, "the end is on the side of 0.2");
        let exact = 0.2 - width * phase.cos();
        for row in ADAPTIVE {
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let start: [&[f64]; 2] = [&[0.2 - width], &[0.0]];
                let ([q, ..], _) = run(row, &system.curved(), start, 20.0, tolerance);
                // An error of the width changes the time beyond the jump by 1/√δ of it.
                let bound = 20.0 * tolerance / depth.sqrt();
                let error = (q[0] - exact).abs();
                assert!(error < bound, "{} {tolerance:e} {depth:e}: {error:e}", row.name);
            }
        }
    }
}
