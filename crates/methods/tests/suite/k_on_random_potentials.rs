//! K at any step on random potentials, in `f64` and in `Quad`, under increments and `ModDg`.

use crate::exact_edges::custom;
use crate::k_on_expressions::TERMS;
use afterbay_core::{Method, Quad, Scalar, Separable, State};
use afterbay_methods::{Composition, Increment, ModDg};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// In 106 bits rounding hides no error: a mean with a relative error of 1e-16 changes K by that
    /// amount.
    #[test]
    fn k_is_kept_on_random_systems_at_any_step(
        picks in prop::collection::vec((0..TERMS.len(), 0.1..2.0_f64), 1..4),
        exponent in -3.0..2.0_f64, c in 0.0..1.0_f64, alone: bool,
        q in prop::array::uniform2(-2.0..2.0_f64), p in prop::array::uniform2(-4.0..4.0_f64),
    ) {
        let n = if alone { 1 } else { 2 };
        let mut potential = (1..=n).map(|j| format!("q{j}^2/20")).collect::<Vec<_>>().join(" + ");
        for (term, scale) in picks {
            potential += &format!(" + {scale:?}*{}", TERMS[term]);
        }
        let potential = if alone { potential.replace("q2", "0.3") } else { potential };
        let (custom, h) = (custom(&potential, n, c), 10f64.powf(exponent));
        let (system, quad) = (&*custom.separable::<f64>(), &*custom.separable::<Quad>());
        let state = State::new(q[..n].to_vec(), p[..n].to_vec()).unwrap();
        let lift = |x: &[f64]| x.iter().map(|&x| Quad::from(x)).collect::<Vec<_>>();
        let exact = State::new(lift(&state.q), lift(&state.p)).unwrap();
        let methods = [Composition::sweep(), Composition::pair(), Composition::suzuki4()];
        for (method, suzuki) in methods.map(Increment::new).into_iter().zip([false, false, true]) {
            // Some substeps run backwards, and the energy that friction supplies there is rounded.
            let along = if suzuki { largest_within(system, h, &state) } else { 0.0 };
            let (mut plain, mut fine) = (state.clone(), exact.clone());
            let mut workspace = method.workspace(system).unwrap();
            if method.step(system, h, &mut plain, &mut workspace).is_ok() {
                kept(system, [&state, &plain], along, 3e-13, &potential)?;
            }
            let mut workspace = method.workspace(quad).unwrap();
            if method.step(quad, Quad::from(h), &mut fine, &mut workspace).is_ok() {
                kept(quad, [&exact, &fine], along, 1e-26, &potential)?;
            }
        }
        if alone {
            let (mut plain, mut fine) = (state.clone(), exact.clone());
            if ModDg::newton().step(system, h, &mut plain, &mut ()).is_ok() {
                kept(system, [&state, &plain], 0.0, 1e-13, &potential)?;
            }
            if ModDg::newton().step(quad, Quad::from(h), &mut fine, &mut ()).is_ok() {
                kept(quad, [&exact, &fine], 0.0, 1e-26, &potential)?;
            }
        }
    }
}

/// The sum of the terms of K.
fn size<T: Scalar>(system: &dyn Separable<T>, state: &State<Vec<T>>) -> f64 {
    let rest = vec![T::zero(); state.dof()];
    let squares: f64 = state.p.iter().map(|p| p.to_f64().powi(2)).sum();
    let bends = |j: usize| (system.partial(&state.q, j, state.q[j]) * state.q[j]).to_f64().abs();
    let bends: f64 = (0..state.dof()).map(bends).sum();
    let gains: f64 = state.w.iter().map(|w| w.to_f64().abs()).sum();
    1.0 + squares + bends + gains + system.energy(&state.q, &rest).to_f64().abs()
}

/// The largest sum of the terms of K between the five pairs of sweeps of Suzuki's composition.
fn largest_within(system: &dyn Separable<f64>, h: f64, start: &State<Vec<f64>>) -> f64 {
    let method = Increment::new(Composition::pair());
    let (mut state, mut workspace) = (start.clone(), method.workspace(system).unwrap());
    let outer = 1.0 / (4.0 - 4.0_f64.cbrt());
    let steps = [outer, outer, 1.0 - 4.0 * outer, outer, outer];
    steps.iter().fold(0.0, |most: f64, share| {
        let _ = method.step(system, share * h, &mut state, &mut workspace);
        most.max(size(system, &state))
    })
}

/// Checks that K is unchanged relative to its terms at both ends and `along` the step.
fn kept<T: Scalar>(
    system: &dyn Separable<T>,
    [before, after]: [&State<Vec<T>>; 2],
    along: f64,
    bound: f64,
    potential: &str,
) -> Result<(), TestCaseError> {
    let drift = (after.total(system) - before.total(system)).to_f64().abs();
    let size = size(system, before) + size(system, after) + along;
    prop_assert!(drift <= bound * size, "{potential}: K moves by {drift:e} of {size:e}");
    Ok(())
}
