//! The exact flow over steps of any length: K, q, p and w to rounding, up to h |A| = 1e9.

use super::scenes::{Rubs, Web, falls, wave};
use crate::bind::Curved;
use afterbay_core::{ExactFlow, Method, Quad, State};
use afterbay_methods::LinearExact;
use afterbay_systems::DampedOscillator;

/// Undamped, damped, nearly defective, stiff.
const OSCILLATORS: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [1.0, 0.1],
    [1.0, 2.0],
    [1.0, 2.0 + 1e-9],
    [1.0, 5000.0],
    [1e6, 1.0],
    [1e-4, 30.0],
    [1e6, 3000.0],
];

/// Comparison with the closed form in 31 digits.
#[test]
fn an_oscillator_is_exact_over_any_step() {
    for [k, b] in OSCILLATORS {
        let system: &Curved<f64> = &DampedOscillator::new(k, b).unwrap();
        let rate = k.sqrt().max(b);
        for reach in [0.3, 1.0, 7.0, 1e3, 1e6, 1e9] {
            let h = reach / rate;
            let mut state = State::new(vec![1.0], vec![0.5]).unwrap();
            let before = state.total(system);
            LinearExact
                .step(system, h, &mut state, &mut LinearExact.workspace(system).unwrap())
                .unwrap();
            let quad = Quad::from_f64;
            let mut exact = State::new([quad(1.0)], [quad(0.5)]).unwrap();
            DampedOscillator::new(quad(k), quad(b)).unwrap().flow(quad(h), &mut exact);
            // A rounding of an entry of e^{hA} is a rounding of the number it multiplies, in units
            // of the energy.
            let units = [1.0 + 0.5 / k.sqrt(), 0.5 + k.sqrt(), before];
            for ((found, exact), unit) in
                [(state.q[0], exact.q[0]), (state.p[0], exact.p[0]), (state.w[0], exact.w[0])]
                    .into_iter()
                    .zip(units)
            {
                let off = (quad(found) - exact).0.abs() / unit;
                assert!(
                    off < 4.0 * f64::EPSILON,
                    "k = {k}, b = {b}, h |A| = {reach:e}: {found} is off by {off:e}"
                );
            }
            let off = (state.total(system) - before).abs() / before;
            assert!(
                off < 4.0 * f64::EPSILON,
                "k = {k}, b = {b}, h |A| = {reach:e}: K is off by {off:e}"
            );
        }
    }
}

/// All-to-all coupling, including skew friction. Skew friction moves energy between the reservoirs,
/// and K is off by roundings of these amounts.
#[test]
fn k_is_kept_over_any_step() {
    for n in [2, 5, 12] {
        for (c, g) in [(0.4, 0.0), (0.4, 0.5), (0.0, 0.5)] {
            let web: &Curved<f64> = &Web::new(n, 3.0, c, g, 0.0, Rubs::Linearly);
            let mut workspace = LinearExact.workspace(web).unwrap();
            for h in [0.1, 1.0, 1e3, 1e6] {
                let mut state = State::new(wave(n, 1.0), wave(n, 0.3)).unwrap();
                let before = state.clone();
                LinearExact.step(web, h, &mut state, &mut workspace).unwrap();
                let size = before.total(web) + state.w.iter().map(|w| w.abs()).sum::<f64>();
                let off = (state.total(web) - before.total(web)).abs() / (f64::EPSILON * size);
                assert!(
                    off < 16.0,
                    "N = {n}, c = {c}, g = {g}, h = {h}: K is off by {off} roundings"
                );
                assert_eq!(
                    falls(web.dissipation_form().passive, &before.w, &state.w),
                    0,
                    "N = {n}, {c}, {g}, {h}"
                );
                assert!(web.is_constant());
            }
        }
    }
}

/// Beyond the tables K is conserved to 1 + h |A| roundings.
#[test]
fn fifty_keep_k_to_the_roundings_of_their_rates() {
    let web: &Curved<f64> = &Web::new(50, 3.0, 0.4, 0.5, 0.0, Rubs::Linearly);
    for h in [0.1, 1.0, 10.0] {
        let mut state = State::new(wave(50, 1.0), wave(50, 0.3)).unwrap();
        let before = state.clone();
        LinearExact.step(web, h, &mut state, &mut LinearExact.workspace(web).unwrap()).unwrap();
        let size = before.total(web) + state.w.iter().map(|w| w.abs()).sum::<f64>();
        let off = (state.total(web) - before.total(web)).abs() / (f64::EPSILON * size);
        println!("N = 50, h = {h}: K is off by {off} roundings");
        assert!(off < 4.0 * (1.0 + 20.0 * h), "h = {h}: {off}");
    }
}
