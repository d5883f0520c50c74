//! Methods with step size control allocate their memory once.

use crate::bind::Curved;
use crate::catalog::{chain, duffing, pendulum, van_der_pol};
use afterbay_core::{Adaptive, State, Tolerance};
use afterbay_methods::{
    AdaptiveCollocation, AdaptiveDop853, AdaptiveRadau, AdaptiveVerner87, AdaptiveVerner98,
};

/// Steps by sweeps or stages do not allocate, whether accepted or rejected.
#[test]
fn steps_allocate_nothing() {
    fn check<M: Adaptive<Vec<f64>, Curved<f64>>>(method: &M, system: &Curved<f64>) {
        for tolerance in [1e-4, 1e-9] {
            let n = system.dof();
            let mut state =
                State::new((0..n).map(|j| (j as f64).sin()).collect(), vec![0.5; n]).unwrap();
            let mut workspace = method.workspace(system, &Tolerance::all(tolerance), 10.0).unwrap();
            let allocated = allocation_counter::measure(|| {
                for i in 0..100 {
                    let h = if i % 5 == 0 { 0.03 } else { 0.02 };
                    if method
                        .attempt(system, h, &state, &mut workspace)
                        .is_ok_and(|attempt| attempt.error < 1.0)
                    {
                        method.accept(&mut state, &mut workspace);
                    }
                }
            });
            assert_eq!(allocated.count_total, 0);
        }
    }
    fn all(system: &Curved<f64>) {
        check(&AdaptiveCollocation, system);
        check(&AdaptiveDop853, system);
        check(&AdaptiveVerner98, system);
        check(&AdaptiveVerner87, system);
        check(&AdaptiveRadau, system);
    }
    all(&*duffing(-1.0, 1.0, 0.1).curved());
    all(&*chain(20, 0.5, 0.1).curved());
    all(&*pendulum([1.0; 2], [1.0; 2], 9.81, [0.1; 2]).curved());
}

/// Newton's method allocates memory when it is first needed, and never again.
#[test]
fn only_the_first_step_of_newton_s_method_allocates() {
    let system: &Curved<f64> = &*van_der_pol(1000.0).curved();
    let mut state = State::new(vec![2.0], vec![0.0]).unwrap();
    let method = AdaptiveCollocation;
    let mut workspace = method.workspace(system, &Tolerance::all(1e-6), 2000.0).unwrap();
    let (mut h, mut longest, mut allocating) = (1e-5, 0.0_f64, Vec::new());
    for step in 0..200 {
        let mut error = 0.0;
        let allocated = allocation_counter::measure(|| {
            match method.attempt(system, h, &state, &mut workspace) {
                Ok(attempt) => error = attempt.error,
                Err(_) => error = f64::INFINITY,
            }
            if error < 1.0 {
                Adaptive::<_, Curved<f64>>::accept(&method, &mut state, &mut workspace);
                longest = longest.max(h);
            }
        });
        if allocated.count_total > 0 {
            allocating.push(step);
        }
        h *= if error < 0.1 {
            1.5
        } else if error < 1.0 {
            1.0
        } else {
            0.5
        };
    }
    // So long a step requires Newton's method.
    assert!(longest > 1.0, "{longest}");
    assert_eq!(allocating.len(), 1, "{allocating:?}");
}
