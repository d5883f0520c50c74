//! The rounding errors that a compensated increment carries from step to step: they belong to one
//! state, and a failed step leaves them unchanged.

use crate::compensated::{N, bits, chain, pair, sine};
use afterbay_core::{
    Corrected, Dissipation, DissipationForm, Method, Separable, State, StepFailure, System,
};
use afterbay_methods::Compensated;
use afterbay_systems::FputChain;

type OfChain = Compensated<FputChain<Corrected<f64>>>;
type Scratch = <OfChain as Method<[f64; N], FputChain<f64>>>::Workspace;

/// A chain in which the force on one mass is NaN.
struct Torn {
    chain: FputChain<f64>,
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
    pair().compensated(chain(0.1).map(Corrected::from))
}

/// The state and the workspace after some steps.
fn travelled(method: &OfChain) -> (State<[f64; N]>, Scratch) {
    let mut state = sine();
    let mut workspace = method.workspace(&chain(0.1)).unwrap();
    (0..20).for_each(|_| {
        method.step(&chain(0.1), 0.2, &mut state, &mut workspace).unwrap();
    });
    (state, workspace)
}

/// The state after some further steps.
fn carry(method: &OfChain, state: &State<[f64; N]>, workspace: &mut Scratch) -> Vec<u64> {
    let mut state = state.clone();
    for _ in 0..20 {
        method.step(&chain(0.1), 0.2, &mut state, workspace).unwrap();
    }
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
        let torn = Torn { chain: chain(0.1), at };
        let failure = method.step(&torn, 0.2, &mut tried, &mut workspace).unwrap_err();
        assert!(matches!(failure, StepFailure::NonFinite { dof, .. } if dof == at), "{failure}");
        assert_eq!(bits(&tried), bits(&state));
    }
    for h in [1e200, f64::NAN] {
        assert!(method.step(&chain(0.1), h, &mut tried, &mut workspace).is_err());
        assert_eq!(bits(&tried), bits(&state));
    }
    assert_eq!(carry(&method, &tried, &mut workspace), undisturbed);
}

#[test]
fn what_is_carried_belongs_to_one_state_only() {
    let method = of_chain();
    let (state, workspace) = travelled(&method);
    let fresh = || method.workspace(&chain(0.1)).unwrap();
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
