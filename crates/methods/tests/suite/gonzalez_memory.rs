//! Steps do not allocate, for every linear solver.

use crate::bind::Curved;
use crate::systems;
use afterbay_core::{Method, State};
use afterbay_methods::{Gonzalez, LinearSolver};
use allocation_counter::measure;
use systems::{Springs, Twisted, start};

fn allocations(system: &Curved<f64>, solver: Option<LinearSolver>, h: f64) -> u64 {
    let method = Gonzalez { solver };
    let (q, p) = start::<f64>(system.dof());
    let mut state = State::new(q, p).unwrap();
    let mut workspace = method.workspace(system).unwrap();
    let mut failed = 0;
    let taken = measure(|| {
        for _ in 0..50 {
            failed += u64::from(method.step(system, h, &mut state, &mut workspace).is_err());
        }
    });
    assert!(failed == 0 || h > 1.0);
    taken.count_total
}

#[test]
fn a_step_allocates_nothing() {
    for h in [0.1, 5.0] {
        assert_eq!(allocations(&Springs::chain(100, 0.1), None, h), 0);
        assert_eq!(allocations(&Springs::ring(100, 0.1), None, h), 0);
        assert_eq!(allocations(&Springs::ring(10, 0.1), None, h), 0);
        assert_eq!(allocations(&Springs::dense(60, 0.1), None, h), 0);
        assert_eq!(allocations(&Springs::dense(150, 0.1), None, h), 0);
        assert_eq!(allocations(&Twisted { c: 0.2, offset: 0.0 }, None, h), 0);
        for solver in [LinearSolver::Small, LinearSolver::Sparse, LinearSolver::Dense] {
            assert_eq!(allocations(&Twisted { c: 0.2, offset: 0.0 }, Some(solver), h), 0);
            assert_eq!(allocations(&Springs::ring(50, 0.1), Some(solver), h), 0);
        }
    }
}
