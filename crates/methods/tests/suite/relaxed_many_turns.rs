//! Relaxation of an angle after many turns, whose rounding moves H.

use afterbay_core::{Abilities, Grid, State};
use afterbay_methods::registry::{bind, find};
use afterbay_systems::{Custom, Description, DissipationText};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The force of V = -cos q, and with it the effect of a rounding of q on K, may be 0 where a step
/// begins and 1 where it ends. K is kept to roundings of q.
#[test]
fn no_step_fails_at_a_large_angle() {
    let description = Description {
        potential: "-cos(q1)".into(),
        dissipation: DissipationText::Forces(vec!["0.1*v1".into()]),
        ..Description::default()
    };
    let system: Arc<dyn Abilities<f64>> = Arc::new(Custom::new(&description).unwrap());
    for method in ["relaxed-rk4", "relaxed-dop853", "relaxed-verner98"] {
        let run = bind(find(method).unwrap(), system.clone()).unwrap();
        for power in 0..9 {
            for i in 0..50 {
                let q = 10.0_f64.powi(power) * (1.0 + 0.01 * f64::from(i));
                let mut state = State::new(vec![q], vec![1.0]).unwrap();
                let (mut drift, total) = (0.0_f64, state.total(&*system));
                let done = run.run(Grid::of(0.05, 200).unwrap(), &mut state, 1, &mut |_, state| {
                    drift = drift.max((state.total(&*system) - total).abs());
                    ControlFlow::Continue(())
                });
                done.unwrap_or_else(|error| panic!("{method} from {q}: {error}"));
                assert!(drift <= 8.0 * f64::EPSILON * q, "{method} from {q}: K {drift:e}");
            }
        }
    }
}
