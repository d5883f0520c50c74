//! Steps chosen by a tolerance: a satellite on an eccentric orbit through a thin gas.
//! `cargo run --example tolerance`

use afterbay_core::{Formulas, FromFormulas, Scalar, State, Tolerance, integrate_within};
use afterbay_methods::AdaptiveDop853;
use std::error::Error;
use std::ops::ControlFlow;

/// The drag per unit of mass and velocity, with GM = 1.
struct Satellite(f64);

impl Formulas for Satellite {
    fn dof(&self) -> usize {
        2
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        -(q[0] * q[0] + q[1] * q[1]).sqrt().recip()
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(self.0) * v[j]
    }
}

/// The state at t = 100.
fn orbit(tolerance: f64) -> Result<State<[f64; 2]>, Box<dyn Error>> {
    let system = FromFormulas(Satellite(1e-3));
    // The aphelion of an ellipse with the eccentricity 0.9.
    let mut state = State::new([1.9, 0.0], [0.0, (0.1_f64 / 1.9).sqrt()])?;
    let (before, mut drift) = (state.total(&system), 0.0_f64);
    let mut watch = |_, state: &State<[f64; 2]>| {
        drift = drift.max((state.total(&system) - before).abs());
        ControlFlow::Continue(())
    };
    let (method, bound) = (AdaptiveDop853, Tolerance::all(tolerance));
    let steps = integrate_within(&method, &system, &bound, 100.0, &mut state, &mut watch)?;
    println!(
        "tolerance {tolerance:.0e}: {} steps of {:.4} to {:.4}, K off by {drift:.0e} on the way",
        steps.accepted, steps.least, steps.largest
    );
    // At the perihelion H is the difference of two numbers of the size of 10.
    if drift < 1e-12 { Ok(state) } else { Err("K is not kept".into()) }
}

fn main() -> Result<(), Box<dyn Error>> {
    let best = orbit(1e-12)?;
    for tolerance in [1e-6, 1e-9] {
        let state = orbit(tolerance)?;
        let error = (state.q[0] - best.q[0]).hypot(state.q[1] - best.q[1]);
        println!("  the position is off by {error:.0e}; dissipated: {:.9}", state.reservoir());
        if error > tolerance {
            return Err("the error is beyond the tolerance".into());
        }
    }
    Ok(())
}
