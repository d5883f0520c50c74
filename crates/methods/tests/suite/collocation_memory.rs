//! Steps do not allocate, by sweeps, by Newton's iteration, and with more nodes; except for the
//! first step that needs large matrices or the exact derivative.

use crate::bind::Curved;
use crate::catalog::{chain, pendulum, van_der_pol};
use afterbay_core::{Method, State};
use afterbay_methods::Collocation;
use allocation_counter::measure;

fn allocations(system: &Curved<f64>, stages: usize, h: f64) -> u64 {
    let method = Collocation::new(stages);
    let q = (0..system.dof()).map(|j| 1.5 + (j as f64).sin()).collect();
    let start = State::new(q, vec![0.1; system.dof()]).unwrap();
    let mut state = start.clone();
    let mut workspace = method.workspace(system).unwrap();
    let mut go = || {
        // `clone_from` of a state would allocate.
        let parts = [(&mut state.q, &start.q), (&mut state.p, &start.p), (&mut state.w, &start.w)];
        parts.into_iter().for_each(|(part, start)| part.copy_from_slice(start));
        for _ in 0..20 {
            let _ = method.step(system, h, &mut state, &mut workspace);
        }
    };
    go();
    measure(go).count_total
}

#[test]
fn a_step_allocates_nothing() {
    for stages in [1, 4, 8] {
        for h in [0.01, 0.3] {
            let pendulum = pendulum([1.0; 2], [1.0; 2], 9.81, [0.1; 2]).curved();
            assert_eq!(allocations(&*pendulum, stages, h), 0);
            assert_eq!(allocations(&*van_der_pol(1000.0).curved(), stages, h), 0);
            assert_eq!(allocations(&*chain(20, 0.5, 0.1).curved(), stages, h), 0);
            assert_eq!(allocations(&*chain(600, 0.5, 0.1).curved(), stages, h), 0);
        }
    }
}
