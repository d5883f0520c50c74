//! Relaxation on steps so short that each changes K by roundings alone.

use afterbay_core::{Abilities, Grid, State};
use afterbay_methods::registry::{bind, find};
use afterbay_systems::{Custom, Description, DissipationText};
use std::ops::ControlFlow;
use std::sync::Arc;

/// V = 50 q², D = 200 (1 + q²/2) v: overdamped, so that K hardly depends on γ. On the slow motion
/// the fourth differences of w are below its rounding, of which they show 16.
#[test]
fn no_state_stands_out() {
    let description = Description {
        potential: "50*q1^2".into(),
        dissipation: DissipationText::Forces(vec!["200*(1 + q1^2/2)*v1".into()]),
        ..Description::default()
    };
    let system: Arc<dyn Abilities<f64>> = Arc::new(Custom::new(&description).unwrap());
    for method in ["relaxed-rk4", "relaxed-dop853", "relaxed-verner98"] {
        let run = bind(find(method).unwrap(), system.clone()).unwrap();
        let mut state = State::new(vec![1.0], vec![5.0]).unwrap();
        let (mut w, mut drift) = (Vec::new(), 0.0_f64);
        let total = state.total(&*system);
        run.run(Grid::of(1e-5, 30_000).unwrap(), &mut state, 1, &mut |_, state| {
            w.push(state.w[0]);
            drift = drift.max((state.total(&*system) - total).abs());
            ControlFlow::Continue(())
        })
        .unwrap();
        let difference = |w: &[f64]| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs();
        let most = w[10_000..].windows(5).map(difference).fold(0.0, f64::max);
        assert!(most < 1e-11 && drift < 1e-12, "{method}: {most:e}, K {drift:e}");
        assert!(w.windows(2).all(|pair| pair[0] <= pair[1]), "{method}: w falls");
    }
}
