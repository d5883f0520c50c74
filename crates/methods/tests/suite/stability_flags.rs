//! The stability flags of the registry, in both directions: methods that claim stability are
//! stable, and methods that do not are unstable on some scene.

use crate::linear_scenes;
use afterbay_core::{IntegrateError, StepFailure};
use afterbay_methods::registry::{Cost, FIXED, Row};
use linear_scenes::{Scene, gentle, scenes};

/// The rounding error of an eigenvalue: in the energy norm, eigenvalues of modulus 1 of a bounded
/// step are well conditioned.
const ROUNDING: f64 = 1e-11;

/// The rounding error for methods that compute the flow of a matrix, which has h |A| roundings.
fn rounding(row: &Row, scene: &Scene, h: f64) -> f64 {
    let flow = matches!(row.cost, Cost::Flow | Cost::Paths);
    if flow { ROUNDING + f64::EPSILON * h * scene.rate } else { ROUNDING }
}
/// The growth of the energy per step from which an orbit counts as growing.
const GROWTH: f64 = 1e-6;

/// Steps from 1e-3 to 1e6, denser where oscillations begin to be unresolved.
fn steps() -> impl Iterator<Item = f64> {
    (-6..=12).map(|i| 10f64.powf(f64::from(i) / 2.0)).chain([0.5, 2.1, 2.9, 5.0])
}

/// The result of a step, or its failure. `None` if the step is beyond the range of the arithmetic.
fn judge<T>(found: Result<T, IntegrateError>) -> Option<Result<T, StepFailure>> {
    match found {
        Ok(found) => Some(Ok(found)),
        Err(IntegrateError::Run(error)) => match error.failure {
            StepFailure::TooLong { .. } => None,
            failure => Some(Err(failure)),
        },
        Err(error) => panic!("{error}"),
    }
}

/// The largest growth of states per step beyond rounding over all scenes and steps (a failure
/// counts as infinite growth), where it occurs, and the number of steps judged.
fn worst(row: &Row, scenes: &[Scene]) -> (f64, String, usize) {
    let (mut most, mut place, mut judged) = (f64::NEG_INFINITY, String::new(), 0);
    for scene in scenes {
        for run in scene.bind(row) {
            for h in steps() {
                let Some(found) = judge(scene.factor(&run, h)) else {
                    assert!(
                        h * scene.rate > 1000.0,
                        "{} on {} refuses h = {h}",
                        row.name,
                        scene.name
                    );
                    continue;
                };
                judged += 1;
                let (factor, why) = match found {
                    Ok(factor) => (factor - 1.0 - rounding(row, scene, h), String::new()),
                    Err(failure) => (f64::INFINITY, failure.to_string()),
                };
                if factor > most {
                    (most, place) = (factor, format!("{}, h = {h:.4}, {why}", scene.name));
                }
            }
        }
    }
    (most, place, judged)
}

#[test]
fn a_stable_is_what_stays_bounded_at_every_step() {
    let scenes = scenes();
    for row in FIXED {
        let (factor, place, judged) = worst(row, &scenes);
        println!("{:24} {} {factor:e} {place} ({judged})", row.name, row.a_stable);
        assert!(judged > 0, "{} was not judged", row.name);
        let holds = |claimed: bool| if claimed { factor <= 0.0 } else { factor > GROWTH };
        assert!(holds(row.a_stable), "{} grows by {factor:e} a step: {place}", row.name);
        assert!(!holds(!row.a_stable), "{} would pass with the other flag", row.name);
    }
}

/// Every eigenvalue of the flow is in the left half-plane, and h is taken as large as possible.
#[test]
fn l_stable_is_what_vanishes_in_one_long_step() {
    for row in FIXED {
        assert!(row.a_stable || !row.l_stable, "{} is L-stable and not A-stable", row.name);
        let mut left = Vec::new();
        for scene in gentle() {
            for run in scene.bind(row) {
                // The longest step that is not refused. A step that fails damps nothing.
                let longest = |exponent: i32| judge(scene.longest(&run, 10f64.powi(exponent)));
                let found = (2..=8).rev().find_map(longest).expect("some step is judged");
                left.push(found.unwrap_or(f64::INFINITY));
            }
        }
        println!("{:24} {} {left:?}", row.name, row.l_stable);
        let holds = |claimed: bool| {
            let holds = |left: &f64| if claimed { *left < 1e-12 } else { *left > 0.5 };
            !left.is_empty() && left.iter().all(holds)
        };
        assert!(holds(row.l_stable), "{} leaves {left:?} of the energy", row.name);
        assert!(!holds(!row.l_stable), "{} would pass with the other flag", row.name);
    }
}
