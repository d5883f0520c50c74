//! Gonzalez's discrete gradient on random states and steps: K is kept to rounding, and reservoirs
//! of a passive system only fill.

use crate::bind::Curved;
use crate::systems::{Springs, Twisted};
use afterbay_core::{Curvature, Method, Passive, State, StepFailure};
use afterbay_methods::Gonzalez;
use proptest::prelude::*;

const METHOD: Gonzalez = Gonzalez { solver: None };

/// Takes one step from `state`, and returns |ΔK| over the rounding of its terms.
///
/// With residuals (a, b) of the equations, `ΔK = ∇̄H_q·a + ∇̄H_p·b` plus the roundings of H and w.
/// Rounding contributes to a and b that of z, of z1 and of h ∇H; the latter is h ∇∇H z.
fn drift(system: &Curved<f64>, h: f64, state: &mut State<Vec<f64>>) -> Result<f64, StepFailure> {
    let before = state.clone();
    let mut workspace = METHOD.workspace(system).unwrap();
    METHOD.step(system, h, state, &mut workspace)?;
    let n = state.dof();
    let mean = |a: &[f64], b: &[f64]| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| (a + b) / 2.0).collect()
    };
    let (q, p) = (mean(&before.q, &state.q), mean(&before.p, &state.p));
    let (mut hq, mut hp, mut d) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    system.gradient(&q, &p, &mut hq, &mut hp);
    system.dissipation(&q, &p, &hp, &mut d);
    let size = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let total = |x: &[f64]| x.iter().map(|x| x.abs()).sum::<f64>();
    let mut bend = 0.0_f64;
    system.curvature(&q, &p, |_, _, _, value| bend = bend.max(value.abs()));
    let z =
        [&before.q, &before.p, &state.q, &state.p].map(|x| size(x)).into_iter().fold(0.0, f64::max);
    let change: f64 = before
        .q
        .iter()
        .zip(&state.q)
        .chain(before.p.iter().zip(&state.p))
        .map(|(a, b)| (b - a).powi(2))
        .sum();
    let along: f64 = (0..n)
        .map(|j| hq[j] * (state.q[j] - before.q[j]) + hp[j] * (state.p[j] - before.p[j]))
        .sum();
    let lambda = if change == 0.0 {
        0.0
    } else {
        (state.energy(system) - before.energy(system) - along) / change
    };
    let gradient = total(&hq) + total(&hp) + lambda.abs() * change.sqrt() * 2.0 * n as f64;
    let held = before.energy(system).abs()
        + state.energy(system).abs()
        + total(&before.w)
        + total(&state.w);
    let scale = held + (1.0 + h * bend) * z * (gradient + total(&d));
    Ok((state.total(system) - before.total(system)).abs() / (f64::EPSILON / 2.0 * scale))
}

fn checked(system: &Curved<f64>, h: f64, q: Vec<f64>, p: Vec<f64>) -> Result<(), TestCaseError> {
    let mut state = State::new(q, p).unwrap();
    for _ in 0..3 {
        let before = state.clone();
        match drift(system, h, &mut state) {
            Ok(drift) => prop_assert!(drift < 8.0, "K drifts by {drift} roundings"),
            Err(failure) => {
                prop_assert_eq!(&before, &state, "{}", failure);
                // Short steps may not fail. If a longer step fails, a shorter one must succeed.
                let shorter = |h: f64| drift(system, h, &mut before.clone()).is_ok();
                let excused =
                    h > 0.1 && (1..=6).any(|halvings| shorter(h / f64::from(1 << halvings)));
                prop_assert!(excused, "h = {}: {}", h, failure);
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn k_is_kept_without_separability(
        h in prop_oneof![1e-6..0.1, 0.1..10.0], c in -0.5..2.0,
        z in prop::array::uniform4(-2.0..2.0),
    ) {
        checked(&Twisted { c, offset: 0.0 }, h, z[..2].to_vec(), z[2..].to_vec())?;
    }

    #[test]
    fn k_is_kept_by_springs(
        h in prop_oneof![1e-6..0.1, 0.1..10.0], c in -0.5..2.0,
        (q, p) in (1_usize..40).prop_flat_map(|n| {
            let part = || prop::collection::vec(-1.5..1.5, n);
            (part(), part())
        }),
        kind in 0..3,
    ) {
        let n = q.len();
        let system = match kind {
            0 => Springs::chain(n, c),
            1 if n > 2 => Springs::ring(n, c),
            _ => Springs::dense(n, c),
        };
        checked(&system, h, q, p)?;
    }

    /// D_j = c m_j v_j: Δw_j = c m_j (Δq_j/h) Δq_j has one sign, and rounding is monotonic.
    #[test]
    fn every_reservoir_only_fills_where_r_is_diagonal(
        h in prop_oneof![1e-6..0.1, 0.1..10.0], c in 0.0..5.0,
        (masses, q, p) in (1_usize..20).prop_flat_map(|n| {
            let part = || prop::collection::vec(-1.5..1.5, n);
            (prop::collection::vec(0.1..10.0, n), part(), part())
        }),
        kind in 0..3,
    ) {
        let n = q.len();
        let springs = match kind {
            0 => Springs::chain(n, c),
            1 if n > 2 => Springs::ring(n, c),
            _ => Springs::dense(n, c),
        };
        let system: &Curved<f64> = &Springs { masses, ..springs };
        let mut state = State::new(q, p).unwrap();
        let mut workspace = METHOD.workspace(system).unwrap();
        for _ in 0..6 {
            let before = state.w.clone();
            if METHOD.step(system, h, &mut state, &mut workspace).is_err() {
                break;
            }
            for (before, after) in before.iter().zip(&state.w) {
                prop_assert!(after >= before, "{before:e} {after:e}");
            }
        }
    }

    /// D = R v with R coupled and positive definite, so energy may move from one reservoir to
    /// another. The computed Δq·R Δq/h is positive, since the rounding errors of its products are
    /// smaller than it; then each w_j is rounded once.
    #[test]
    fn the_reservoirs_together_only_fill_where_r_is_coupled(
        h in prop_oneof![1e-6..0.1, 0.1..10.0], c in 0.0..5.0,
        z in prop::array::uniform4(-2.0..2.0),
    ) {
        let system: &Curved<f64> = &Twisted { c, offset: 0.0 };
        let mut state = State::new(z[..2].to_vec(), z[2..].to_vec()).unwrap();
        let mut workspace = METHOD.workspace(system).unwrap();
        for _ in 0..6 {
            let before = state.w.clone();
            if METHOD.step(system, h, &mut state, &mut workspace).is_err() {
                break;
            }
            prop_assert!(!Passive::InSum.violated(&before, &state.w), "{:?} {:?}", before, state.w);
        }
    }
}
