//! The rounding errors that a compensated increment carries from step to step: they belong to one
//! state, and a failed step leaves them unchanged.

use crate::bind::AnySeparable;
use crate::compensated::{Exact, N, bits, chain, pair, sine};
use afterbay_core::{Dissipation, DissipationForm, Method, Separable, State, StepFailure, System};
use afterbay_methods::Compensated;
use std::sync::Arc;

type OfChain = Compensated<Exact>;
type Scratch = <OfChain as Method<Vec<f64>, dyn Separable<f64>>>::Workspace;

/// A chain in which the force on one mass is NaN.
struct Torn {
    chain: Arc<AnySeparable<f64>>,
    at: usize,
}

impl System<f64> for Torn {
    fn dof(&self) -> usize {
        self.chain.dof()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.chain.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.chain.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        self.chain.dissipation(q, p, v, d);
    }
    fn dissipation_form(&self) -> DissipationForm {
        self.chain.dissipation_form()
    }
}

impl Separable<f64> for Torn {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        if j == self.at { f64::NAN } else { self.chain.partial(q, j, at) }
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        self.chain.dissipation_of(q, p, j)
    }
}

fn of_chain() -> OfChain {
    pair().compensated(chain(0.1).corrected())
}

/// The state and the workspace after some steps.
fn travelled(method: &OfChain) -> (State<Vec<f64>>, Scratch) {
    let (mut state, mut workspace) = (sine(), fresh(method));
    steps(method, &mut state, &mut workspace);
    (state, workspace)
}

fn fresh(method: &OfChain) -> Scratch {
    method.workspace(&*chain(0.1).separable::<f64>()).unwrap()
}

fn steps(method: &OfChain, state: &mut State<Vec<f64>>, workspace: &mut Scratch) {
    let system = &*chain(0.1).separable::<f64>();
    for _ in 0..20 {
        method.step(system, 0.2, state, workspace).unwrap();
    }
}

/// The state after some further steps.
fn carry(method: &OfChain, state: &State<Vec<f64>>, workspace: &mut Scratch) -> Vec<u64> {
    let mut state = state.clone();
    steps(method, &mut state, workspace);
    bits(&state)
}

#[test]
fn a_failed_step_leaves_everything_as_it_was() {
    let method = of_chain();
    let (state, mut workspace) = travelled(&method);
    let undisturbed = carry(&method, &state, &mut workspace.clone());
    let mut tried = state.clone();
    // In the first coordinate, after one other has moved, and after all others have moved.
    for at in [0, 1, N - 1] {
        let torn: &dyn Separable<f64> = &Torn { chain: chain(0.1).separable(), at };
        let failure = method.step(torn, 0.2, &mut tried, &mut workspace).unwrap_err();
        assert!(matches!(failure, StepFailure::NonFinite { dof, .. } if dof == at), "{failure}");
        assert_eq!(bits(&tried), bits(&state));
    }
    let system = &*chain(0.1).separable::<f64>();
    for h in [1e200, f64::NAN] {
        assert!(method.step(system, h, &mut tried, &mut workspace).is_err());
        assert_eq!(bits(&tried), bits(&state));
    }
    assert_eq!(carry(&method, &tried, &mut workspace), undisturbed);
}

#[test]
fn what_is_carried_belongs_to_one_state_only() {
    let method = of_chain();
    let (state, workspace) = travelled(&method);
    let fresh = || fresh(&method);
    assert_ne!(
        carry(&method, &state, &mut workspace.clone()),
        carry(&method, &state, &mut fresh())
    );
    for part in 0..3 {
        for j in [0, N - 1] {
            let mut other = state.clone();
            let x = &mut [&mut other.q, &mut other.p, &mut other.w][part][j];
            *x = x.next_up();
            assert_eq!(
                carry(&method, &other, &mut workspace.clone()),
                carry(&method, &other, &mut fresh())
            );
        }
    }
}
