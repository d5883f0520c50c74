//! A run of a long chain uses ten vectors, including the state, and its steps do not allocate.

use crate::catalog::chain;
use afterbay_core::{Coupling, Method, State, System};
use afterbay_methods::{Composition, Increment, Tiled};

const N: usize = 100_000;

fn check<S: System<f64> + ?Sized>(method: &impl Method<Vec<f64>, S>, chain: &S) {
    let all = allocation_counter::measure(|| {
        let q = (0..N).map(|j| (0.1 * j as f64).sin()).collect();
        let mut state = State::new(q, vec![0.0; N]).unwrap();
        let mut workspace = method.workspace(chain).unwrap();
        let steps = allocation_counter::measure(|| {
            for _ in 0..3 {
                method.step(chain, 0.1, &mut state, &mut workspace).unwrap();
            }
        });
        assert_eq!(steps.count_total, 0);
    });
    let vectors = all.bytes_max as f64 / (8 * N) as f64;
    assert!(vectors < 10.0, "{vectors} vectors");
}

#[test]
fn one_member_at_a_time() {
    let method = Increment::new(Composition::pair()).in_order(Coupling::Chain.coloured(N));
    check(&method, &*chain(N, 1.0, 0.1).separable::<f64>());
}

#[test]
fn eight_members_at_a_time() {
    check(&Tiled::new(Composition::kahan_li8()), &*chain(N, 1.0, 0.1).members());
}
