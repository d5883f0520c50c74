//! An energy that depends on the time: a swing whose gravity is modulated at twice its frequency.
//! `cargo run --example swing`

use afterbay_core::{
    Clocked, Formulas, FromFormulas, Grid, Motors, Scalar, State, accounts, integrate, with_motors,
};
use afterbay_methods::{Composition, Increment};
use std::{error::Error, f64::consts::PI, sync::Arc};

/// The friction per unit of mass and velocity.
const FRICTION: f64 = 0.1;

/// The share by which gravity is modulated.
struct Swing(f64);

impl Formulas for Swing {
    /// The angle, and the time as the last coordinate.
    fn dof(&self) -> usize {
        2
    }

    /// V(q, t) = (1 + a cos 2t) (1 - cos q)
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let gravity = T::one() + T::from_f64(self.0) * (q[1] + q[1]).cos();
        gravity * (T::one() - q[0].cos())
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], _j: usize) -> T {
        T::from_f64(FRICTION) * v[0]
    }

    fn may_be_singular(&self) -> bool {
        false
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let method = Increment::new(Composition::pair());
    let motors = Motors { has_clock: true, driven: Vec::new() };
    for a in [0.1, 0.3] {
        let system = Clocked::new::<f64>(Arc::new(FromFormulas(Swing(a))))?;
        let mut state = with_motors(&State::new(vec![0.1], vec![0.0])?, motors.count());
        let before = state.total(&system);
        integrate(&method, &system, Grid::of(PI / 100.0, 10_000)?, &mut state, &mut ())?;

        // K = H + w - s_t, with the energy s_t that the modulation has pumped in.
        let energies = accounts(state.state_ref(), &motors)?;
        let (pumped, lost) = (energies.pumped.ok_or("no clock")?, energies.w[0]);
        let drift = (state.total(&system) - before).abs();
        println!("a = {a}: {pumped:9.4} pumped, {lost:9.4} dissipated, K off by {drift:.0e}");
        // The swing rises where a is more than twice the friction, and comes to rest elsewhere.
        if (pumped > 1.0) != (a > 2.0 * FRICTION) || drift > 1e-12 {
            return Err("it does not swing where it should, or K is lost".into());
        }
    }
    Ok(())
}
