//! Events: a ball bounces, and w takes the energy lost. `cargo run --example bounces`

use afterbay_core::{
    Direction, Event, EventState, Formulas, FromFormulas, Grid, Scalar, State, StateRef,
    integrate_with_events,
};
use afterbay_methods::registry::{bind, find};
use std::{error::Error, ops::ControlFlow, sync::Arc};

const GRAVITY: f64 = 9.81;
const RESTITUTION: f64 = 0.8;

struct Ball;

impl Formulas for Ball {
    fn dof(&self) -> usize {
        1
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        T::from_f64(GRAVITY) * q[0]
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
        T::zero()
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = Arc::new(FromFormulas(Ball));
    let run = bind::<f64>(find("increment-2").ok_or("no such method")?, system.clone())?;
    let mut state = State::new(vec![1.0], vec![0.0])?;
    let before = state.total(&*system);

    let height = |state: StateRef<'_, f64>| state.q[0];
    let floor = Event { function: &height, direction: Direction::Falling, is_wall: true };
    let mut times = Vec::new();
    let mut bounce = |_: usize, EventState { p, w, t, .. }: EventState<'_>| {
        times.push(t);
        w[0] += (1.0 - RESTITUTION * RESTITUTION) * p[0] * p[0] / 2.0;
        p[0] *= -RESTITUTION;
        ControlFlow::Continue(())
    };
    // A method with a fixed step needs no tolerance.
    let (mut step, grid) = (run.stepper(None, 3.0)?, Grid::new(0.05, 3.0)?);
    let mut see = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    integrate_with_events(&mut *step, grid, &mut state, &[floor], &mut bounce, &mut see)?;

    let (mut exact, mut error) = ((2.0 / GRAVITY).sqrt(), 0.0_f64);
    let mut flight = 2.0 * RESTITUTION * exact;
    for (i, t) in times.iter().enumerate() {
        println!("bounce {} at {t:.9}", i + 1);
        error = error.max((t - exact).abs());
        (exact, flight) = (exact + flight, RESTITUTION * flight);
    }
    let drift = (state.total(&*system) - before).abs();
    println!("The times are off by {error:.0e}, and K by {drift:.0e}.");
    if times.len() > 4 && error.max(drift) < 1e-12 { Ok(()) } else { Err("a wrong bounce".into()) }
}
