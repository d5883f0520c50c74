//! Driven oscillators whose motion has a closed form.

use super::{Case, distance, narrow, widen};
use afterbay_core::{Quad, Scalar};
use afterbay_methods::registry::Number;

const K: [f64; 5] = [1.0, 1.0, 4.0, 1.0, 2.25];
const B: [f64; 5] = [0.5, 5.0, 4.0, 0.125, 0.75];
const OMEGA: [f64; 5] = [1.25, 0.375, 2.0, 8.0, 1.5];
const F: f64 = 0.75;

/// [q, p, w, s] of the steady state of x'' + b x' + k x = f cos ωt, with w = s = 0 at t0.
fn steady(i: usize, t0: Quad, t: Quad) -> [Vec<Quad>; 4] {
    let [k, b, omega, f] = [K[i], B[i], OMEGA[i], F].map(Quad::from_f64);
    let (re, im) = (k - omega * omega, omega * b);
    let share = f / (re * re + im * im);
    let at = |t: Quad| {
        let (sin, cos) = (omega * t).sin_cos();
        let x = share * (re * cos + im * sin);
        let (c, s) = (share * omega * im, -(share * omega * re));
        let v = c * cos + s * sin;
        let (half, quarter) = (t.half(), sin * cos.half() / omega);
        let lost =
            b * (c * c * (half + quarter) + s * s * (half - quarter) + c * s * sin * sin / omega);
        (x, v, lost, (v * v + k * x * x).half())
    };
    let ((_, _, before, h0), (x, v, after, h1)) = (at(t0), at(t));
    let lost = after - before;
    [vec![x], vec![v], vec![lost], vec![lost + (h1 - h0)]]
}

fn steady_to<T: Number>(allowed: f64) {
    for i in 0..K.len() {
        let case = Case::oscillator(K[i], B[i], &format!("{F:?}*cos({:?}*t)", OMEGA[i]));
        let run = case.bound::<T>().unwrap();
        // These times are added without rounding.
        for (t0, h, steps) in
            [(0.0, 0.0009765625, 40), (0.0, 0.375, 20), (1024.5, 3.25, 8), (-4.0, 96.0, 3)]
        {
            let [q, p, ..] = steady(i, Quad::from_f64(t0), Quad::from_f64(t0));
            let mut state = case.start::<T>([&[0.0], &[0.0]], t0);
            (state.q[0], state.p[0]) = (narrow(q[0]), narrow(p[0]));
            for _ in 0..steps {
                run.step(T::from_f64(h), &mut state).unwrap();
                let exact = steady(i, Quad::from_f64(t0), widen(state.q[1]));
                let far = distance(&case.parts(&state), &exact);
                let size = exact[2][0].to_f64().max(1.0);
                assert!(far < allowed * size, "{i} h = {h} from {t0}: off by {far:e}");
            }
        }
    }
}

#[test]
fn a_steady_state_stays() {
    steady_to::<f64>(4e-15);
    steady_to::<Quad>(4e-29);
}

/// A period dissipates and supplies π b ω A².
#[test]
fn a_period_dissipates_what_it_supplies() {
    for i in 0..K.len() {
        let case = Case::oscillator(K[i], B[i], &format!("{F:?}*cos({:?}*t)", OMEGA[i]));
        let run = case.bound::<f64>().unwrap();
        let amplitude = F / (K[i] - OMEGA[i] * OMEGA[i]).hypot(OMEGA[i] * B[i]);
        let exact = std::f64::consts::PI * B[i] * OMEGA[i] * amplitude * amplitude;
        let [q, p, ..] = steady(i, Quad::ZERO, Quad::ZERO).map(|x| x[0].to_f64());
        for steps in [1, 10, 1000] {
            let mut state = case.start::<f64>([&[q], &[p]], 0.0);
            let h = std::f64::consts::TAU / OMEGA[i] / f64::from(steps);
            for _ in 0..steps {
                run.step(h, &mut state).unwrap();
            }
            let [.., w, s] = case.parts(&state);
            for (what, found) in [("dissipated", w[0]), ("supplied", s[0])] {
                let off = (found.to_f64() - exact).abs();
                assert!(off < 1e-13 * exact, "{i} in {steps} steps: {what} is off by {off:e}");
            }
        }
    }
}

/// x'' + ω² x = f cos ωt grows as f t sin(ωt)/2ω.
#[test]
fn resonance_without_friction_grows() {
    let case = Case::oscillator(2.25, 0.0, "0.75*cos(1.5*t)");
    let run = case.bound::<f64>().unwrap();
    let [omega, f, x0, v0] = [1.5, 0.75, 0.25, -0.5].map(Quad::from_f64);
    for (h, steps) in [(0.0009765625, 40), (0.5, 40), (20.0, 10), (64.0, 4)] {
        let mut state = case.start::<f64>([&[0.25], &[-0.5]], 0.0);
        for step in 1..=steps {
            run.step(h, &mut state).unwrap();
            let t = Quad::from_f64(h * f64::from(step));
            let ((sin, cos), push) = ((omega * t).sin_cos(), f.half() / omega);
            let x = x0 * cos + v0 / omega * sin + push * t * sin;
            let v = v0 * cos - x0 * omega * sin + push * (sin + omega * t * cos);
            let energy = |x: Quad, v: Quad| (v * v + omega * omega * x * x).half();
            let s = energy(x, v) - energy(x0, v0);
            let far = distance(&case.parts(&state), &[vec![x], vec![v], vec![Quad::ZERO], vec![s]]);
            let size = energy(x, v).to_f64().max(1.0);
            assert!(far < 1e-14 * size, "h = {h}, step {step}: off by {far:e} of {size:e}");
        }
    }
}
