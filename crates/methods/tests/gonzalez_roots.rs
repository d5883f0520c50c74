//! Among several solutions of a step the one is taken that continues from h = 0.

#![cfg(test)]

use afterbay_core::{Block, Coupling, Curvature, Damping, Method, Passive, State, System};
use afterbay_methods::Gonzalez;
use proptest::prelude::*;

/// A particle between two wells, V = k (q² - 1)²/4, D = c v.
#[derive(Clone, Copy, Debug)]
struct Wells {
    k: f64,
    c: f64,
}

impl System<f64> for Wells {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + self.k * (q[0] * q[0] - 1.0).powi(2) / 4.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (self.k * q[0] * (q[0] * q[0] - 1.0), p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = self.c * v[0];
    }
    fn damping(&self) -> Damping {
        Damping { passive: Passive::Each, ..Damping::LINEAR }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl Curvature<f64> for Wells {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 0, self.k * (3.0 * q[0] * q[0] - 1.0));
        put(Block::Hpp, 0, 0, 1.0);
        put(Block::Dp, 0, 0, self.c);
    }
}

impl Wells {
    /// What Δz misses of h (∇̄H_p, -∇̄H_q - D̄), λ in closed form: for V of degree four and a quadratic kinetic energy,
    /// `H1 - H0 - ∇H(z̄)·Δz = V'''(q̄) Δq³/24`.
    fn missing(&self, h: f64, [q0, p0]: [f64; 2], [dq, dp]: [f64; 2]) -> [f64; 2] {
        let (q, p) = (q0 + dq / 2.0, p0 + dp / 2.0);
        let square = dq * dq + dp * dp;
        let lambda = if square == 0.0 { 0.0 } else { self.k * q * dq.powi(3) / (4.0 * square) };
        let v = p + lambda * dp;
        [h * v - dq, -h * (self.k * q * (q * q - 1.0) + lambda * dq + self.c * v) - dp]
    }

    /// The solution near `guess`, by Newton's iteration with differences for derivatives.
    fn nearby(&self, h: f64, z: [f64; 2], guess: [f64; 2]) -> Option<[f64; 2]> {
        let [mut x, mut y] = guess;
        for _ in 0..30 {
            let [a, b] = self.missing(h, z, [x, y]);
            let e = 1e-7 * (x.abs() + y.abs());
            let slope = |dx, dy| {
                let (ahead, behind) =
                    (self.missing(h, z, [x + dx, y + dy]), self.missing(h, z, [x - dx, y - dy]));
                [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * e))
            };
            let ([ax, bx], [ay, by]) = (slope(e, 0.0), slope(0.0, e));
            let det = ax * by - ay * bx;
            let (dx, dy) = ((ay * b - by * a) / det, (bx * a - ax * b) / det);
            (x, y) = (x + dx, y + dy);
            if dx.abs() + dy.abs() < 1e-9 * (x.abs() + y.abs()) {
                return Some([x, y]);
            }
        }
        None
    }

    /// Does this solution for h shrink to nothing with h, followed in small strides?
    fn continues(&self, h: f64, z: [f64; 2], found: [f64; 2]) -> bool {
        let (mut s, mut increment) = (1.0, found);
        while s > 1e-3 {
            let next = s * 0.995;
            // Along the ray: the strides are short.
            match self.nearby(next * h, z, increment.map(|x| x * 0.995)) {
                Some(found) => increment = found,
                None => return false,
            }
            s = next;
        }
        let force = self.missing(s * h, z, [0.0; 2]);
        let size = |[x, y]: [f64; 2]| x.abs() + y.abs();
        size(increment) < 2.0 * size(force)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    #[test]
    fn a_solution_continues_from_no_step(
        k in 0.5..3.0, c in 0.0..1.0, h in 0.1..4.0, q in -2.0..2.0, p in -2.0..2.0,
    ) {
        let system = Wells { k, c };
        let mut state = State::new([q], [p]).unwrap();
        let mut workspace = Gonzalez::default().workspace(&system).unwrap();
        // From rest, and from guesses.
        for step in 0..6 {
            let z = [state.q[0], state.p[0]];
            if Gonzalez::default().step(&system, h, &mut state, &mut workspace).is_err() {
                break;
            }
            let increment = [state.q[0] - z[0], state.p[0] - z[1]];
            prop_assert!(system.continues(h, z, increment), "step {step} {system:?} {h} {z:?}: {increment:?}");
        }
    }
}

#[test]
fn steps_are_found_as_far_as_they_continue() {
    let mut found = 0;
    let mut all = 0;
    for i in 0..2000 {
        let x = |a: f64| (f64::from(i) * a).sin();
        let (system, h) = (Wells { k: 1.0, c: 0.1 }, 0.1 + 1.9 * x(0.37).abs());
        let mut state = State::new([2.0 * x(1.3)], [2.0 * x(2.9)]).unwrap();
        let mut workspace = Gonzalez::default().workspace(&system).unwrap();
        all += 1;
        found += i32::from(Gonzalez::default().step(&system, h, &mut state, &mut workspace).is_ok());
    }
    println!("{found} of {all}");
    assert!(f64::from(found) > 0.9 * f64::from(all), "{found} of {all}");
}
