//! The flags of the registry for large systems: the claims of every row hold on every scene here.
//! Methods that do not claim to conserve K lose it on at least one scene, and explicit methods,
//! none of which is A-stable, grow or fail on one.

use super::scenes::{Rubs, Web, drift, falls, wave};
use crate::bind::{Curved, separable};
use afterbay_core::{InputError, IntegrateError, State, StepFailure};
use afterbay_methods::registry::{self, FIXED, Needs, Row, Run};
use afterbay_systems::FputChain;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The error of K in roundings of its terms: a composition of 34 sweeps has those of each sweep.
const ROUNDINGS: f64 = 64.0;
/// An error of K, in roundings, that counts as lost.
const LOST: f64 = 1e6;
const STEPS: u32 = 4;

/// The worst results of a row.
#[derive(Clone, Debug, Default)]
struct Seen {
    /// |ΔK| over the rounding of its terms
    drift: f64,
    /// The number of reservoirs of passive systems that decreased
    fell: usize,
    /// On linear scenes: steps that failed, or that increased the energy
    unstable: Vec<String>,
    runs: usize,
}

/// Takes a few steps with every row that can be bound.
fn watch(
    seen: &mut BTreeMap<&'static str, Seen>,
    name: &str,
    system: &Curved<f64>,
    steps: &[f64],
    bind: &dyn Fn(&Row) -> Result<Run<f64>, InputError>,
) {
    let n = system.dof();
    let start = State::new(wave(n, 1.0), wave(n, 0.3)).unwrap();
    for row in FIXED.iter().filter(|row| !matches!(row.needs, Needs::OneDegree | Needs::Printed)) {
        let run = match bind(row) {
            Ok(run) => run,
            Err(InputError::Unsupported { .. }) => continue,
            Err(error) => panic!("{} on {name}: {error}", row.name),
        };
        for &h in steps {
            let found = seen.entry(row.name).or_default();
            found.runs += 1;
            let mut state = start.clone();
            for _ in 0..STEPS {
                let before = state.clone();
                match run.step(h, &mut state) {
                    Ok(_) => {
                        found.drift = found.drift.max(drift(system, h, &before, &state));
                        found.fell += falls(system.dissipation_form().passive, &before.w, &state.w);
                        let more = state.energy(system) > before.energy(system) * (1.0 + 1e-12);
                        if system.is_constant() && more {
                            found.unstable.push(format!("{name}, h = {h}: H grows"));
                        }
                    }
                    Err(IntegrateError::Run(error)) => {
                        let long = matches!(error.failure, StepFailure::TooLong { .. });
                        if system.is_constant() && !long {
                            found.unstable.push(format!("{name}, h = {h}: {error}"));
                        }
                        break;
                    }
                    Err(error) => panic!("{} on {name}: {error}", row.name),
                }
            }
        }
    }
}

fn chain(seen: &mut BTreeMap<&'static str, Seen>, name: &str, beta: f64, steps: &[f64]) {
    let system = FputChain::new(2000, beta, 0.1).unwrap();
    watch(seen, name, &system, steps, &|row| registry::bind::<f64>(row, Arc::new(system)));
}

fn web(seen: &mut BTreeMap<&'static str, Seen>, name: &str, system: &Web, steps: &[f64]) {
    // Increments with skew friction are tested separately.
    let why = "friction is skew";
    watch(seen, name, system, steps, &|row| match row.name.starts_with("increment")
        && system.g != 0.0
    {
        true => Err(InputError::Unsupported { method: row.name, why }),
        false => separable(row, system.clone()),
    });
}

#[test]
fn every_flag_holds_at_size_both_ways() {
    let mut seen = BTreeMap::new();
    chain(&mut seen, "chain of 2000", 0.0, &[0.3, 3.0, 30.0]);
    chain(&mut seen, "nonlinear chain of 2000", 1.0, &[0.3]);
    let linear = |g: f64| Web::new(50, 3.0, 0.4, g, 0.0, Rubs::Linearly);
    web(&mut seen, "50", &linear(0.0), &[0.3, 3.0, 30.0]);
    web(&mut seen, "50, skew", &linear(0.5), &[0.3, 3.0, 30.0]);
    web(&mut seen, "50 in the wind", &Web::new(50, 3.0, 0.3, 0.0, 1.0, Rubs::Wind), &[0.1]);
    web(
        &mut seen,
        "50, uneven and skew",
        &Web::new(50, 3.0, 0.02, 0.5, 1.0, Rubs::Unevenly),
        &[0.1],
    );
    for row in FIXED {
        let Some(seen) = seen.get(row.name) else { continue };
        println!(
            "{:20} {:9.1e} roundings, {} fell, {:?}",
            row.name,
            seen.drift,
            seen.fell,
            seen.unstable.first()
        );
        let kept = if row.keeps_k { seen.drift < ROUNDINGS } else { seen.drift > LOST };
        assert!(
            kept,
            "{} keeps K: {}, and K is off by {} roundings",
            row.name, row.keeps_k, seen.drift
        );
        assert!(!row.passive || seen.fell == 0, "{} is passive, and reservoirs fell", row.name);
        let stable = seen.unstable.is_empty();
        // Compositions with backward sweeps are unstable too, on scenes of `stability_flags`.
        let owed = !row.name.starts_with("increment");
        let held = if row.a_stable { stable } else { !stable || !owed };
        assert!(held, "{} A-stable: {}, {:?}", row.name, row.a_stable, seen.unstable);
    }
}
