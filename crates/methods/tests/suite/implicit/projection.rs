//! A failed projection has its own failure, and a step that follows its advice succeeds.

use afterbay_core::{Adaptive, State, StepFailure, Tolerance};
use afterbay_methods::{AdaptiveCollocation, AdaptiveDop853};
use afterbay_systems::Duffing;

/// A sample so far from the beginning of its step that the error exceeds the allowed one.
#[test]
fn a_sample_that_cannot_be_projected_is_named() {
    let system = Duffing::new(-1.0, 1.0, 0.1).unwrap();
    let before = State::new([1.5], [0.5]).unwrap();
    let dop853 = |relative: f64| {
        let (mut to, tolerance) = (before.clone(), Tolerance::all(relative));
        let mut workspace = AdaptiveDop853.workspace(&system, &tolerance, 10.0).unwrap();
        AdaptiveDop853.between(&system, 1.0, &before, &mut workspace, &mut to).map(|_| to)
    };
    let collocation = |relative: f64| {
        let (mut to, tolerance) = (before.clone(), Tolerance::all(relative));
        let mut workspace = AdaptiveCollocation.workspace(&system, &tolerance, 10.0).unwrap();
        AdaptiveCollocation.between(&system, 1.0, &before, &mut workspace, &mut to).map(|_| to)
    };
    let failure = dop853(1e-12).unwrap_err();
    let StepFailure::ProjectionFailed { excess } = failure else { panic!("{failure}") };
    assert!(excess != 0.0 && excess.abs() < 1e-2, "{failure}");
    // A larger tolerance, and the other method.
    for (name, found) in [("larger", dop853(1e-2)), ("other", collocation(1e-12))] {
        let found = found.unwrap_or_else(|failure| panic!("{name}: {failure}"));
        assert!((found.total(&system) - before.total(&system)).abs() < 1e-14, "{name}: {found:?}");
    }
}
