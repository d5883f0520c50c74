//! A method of your own: the explicit midpoint rule for (q, p, w). `cargo run --example own_method`

use afterbay_core::integrate;
use afterbay_core::{Effort, Grid, InputError, Method, Quantity, State, StepFailure, System};
use afterbay_systems::FputChain;
use std::error::Error;

/// `z1 = z0 + h f(z0 + h/2 f(z0))`, of order 2. K is not kept.
struct ExplicitMidpoint;

impl<S: System<f64> + ?Sized> Method<Vec<f64>, S> for ExplicitMidpoint {
    /// ∂H/∂q, ∂H/∂p, D, and the state computed last.
    type Workspace = ([Vec<f64>; 3], State<Vec<f64>>);

    fn workspace(&self, system: &S) -> Result<Self::Workspace, InputError> {
        let zeros = || vec![0.0; system.dof()];
        Ok(([zeros(), zeros(), zeros()], State::new(zeros(), zeros())?))
    }

    fn step(
        &self,
        system: &S,
        h: f64,
        state: &mut State<Vec<f64>>,
        ([hq, hp, d], next): &mut Self::Workspace,
    ) -> Result<Effort, StepFailure> {
        next.clone_from(state);
        for ahead in [h / 2.0, h] {
            system.gradient(&next.q, &next.p, hq, hp);
            system.dissipation(&next.q, &next.p, hp, d);
            for j in 0..hq.len() {
                next.q[j] = state.q[j] + ahead * hp[j];
                next.p[j] = state.p[j] - ahead * (hq[j] + d[j]);
                next.w[j] = state.w[j] + ahead * d[j] * hp[j];
            }
        }
        if !next.q.iter().chain(&next.p).chain(&next.w).all(|x| x.is_finite()) {
            let [q, p] = [(Quantity::Coordinate, &next.q[..]), (Quantity::Momentum, &next.p[..])];
            return Err(StepFailure::non_finite(&[q, p, (Quantity::Reservoir, &next.w)]));
        }
        std::mem::swap(state, next);
        Ok(Effort { evaluations: 2, iterations: 0 })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = FputChain::new(8, 0.5, 0.05)?;
    let drift = |h: f64| -> Result<f64, Box<dyn Error>> {
        let mut state = State::new((0..8).map(|j| f64::from(j).sin()).collect(), vec![0.0; 8])?;
        let before = state.total(&system);
        integrate(&ExplicitMidpoint, &system, Grid::new(h, 1.0)?, &mut state, &mut ())?;
        Ok((state.total(&system) - before).abs())
    };
    let (coarse, fine) = (drift(0.002)?, drift(0.001)?);
    println!("K is off by {coarse:.1e} at h = 0.002 and by {fine:.1e} at h = 0.001.");
    // Of order 2: half the step, a quarter of the error.
    if (coarse / fine - 4.0).abs() < 0.1 { Ok(()) } else { Err("the order is not 2".into()) }
}
