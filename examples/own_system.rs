//! A system of your own: two pendulums on a torsion spring, with a drag that grows with the square
//! of the speed. `cargo run --example own_system`

use afterbay_core::{Every, Formulas, FromFormulas, Grid, Scalar, State, integrate};
use afterbay_methods::{Composition, Increment};
use std::{error::Error, ops::ControlFlow};

struct Pendulums {
    /// The moment of inertia of each, in kg m².
    inertia: [f64; 2],
    /// The stiffness of the spring, in N m.
    spring: f64,
    /// The coefficient of the drag, in kg m².
    drag: f64,
}

/// The formulas are written once for every scalar `T`, so constants become `T` by `T::from_f64`.
impl Formulas for Pendulums {
    fn dof(&self) -> usize {
        2
    }

    /// V(q): gravity, 0 with both pendulums at the bottom, and the spring.
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let raised = |angle: T| T::from_f64(9.81) * (T::one() - angle.cos());
        let twist = q[1] - q[0];
        raised(q[0]) + raised(q[1]) + (T::from_f64(self.spring) * twist * twist).half()
    }

    /// D_j(q, v), a force against the velocity v_j.
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(self.drag) * v[j].abs() * v[j]
    }

    fn kinks<T: Scalar>(&self, _q: &[T], v: &[T], put: &mut dyn FnMut(T)) {
        v.iter().for_each(|&v| put(v)); // |v_j| is not smooth at 0
    }

    fn mass(&self, j: usize) -> f64 {
        self.inertia[j]
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = FromFormulas(Pendulums { inertia: [1.0, 1.5], spring: 2.0, drag: 0.1 });
    let mut state = State::new([2.0, 0.0], [0.0, 0.0])?;
    let before = state.total(&system);
    println!("  t       q1       q2      H       w1      w2");
    let mut print = Every::new(500, |_, state: &State<[f64; 2]>| {
        let (h, [q1, q2], [w1, w2]) = (state.energy(&system), state.q, state.w);
        println!("{:4.1} {q1:8.4} {q2:8.4} {h:7.4} {w1:7.4} {w2:7.4}", state.t);
        ControlFlow::Continue(())
    });
    let method = Increment::new(Composition::pair());
    integrate(&method, &system, Grid::new(0.01, 20.0)?, &mut state, &mut print)?;

    let drift = (state.total(&system) - before).abs() / before;
    println!("K = H + w1 + w2 is off by {drift:.0e} of itself.");
    if drift < 1e-12 { Ok(()) } else { Err("K is not kept".into()) }
}
