//! The project's methods with step size control on a scene, at given tolerances.

use super::Scene;
use super::measure::{Line, Run, Setting, Spent, write};
use afterbay_core::{InputError, State, Tolerance, Vector};
use afterbay_methods::registry::{self, ADAPTIVE, Row};
use std::ops::ControlFlow;
use std::rc::Rc;

/// The lines of a scene.
pub(crate) fn lines(scene: &Scene) -> impl Iterator<Item = Line> {
    ADAPTIVE.iter().map(|row| line(scene, row))
}

fn line(scene: &Scene, row: &'static Row) -> Line {
    let of = scene.clone();
    Line {
        method: row.name,
        keeps_k: true,
        ours: true,
        settings: (1..=13).map(|k| Setting::Tolerance(10_f64.powi(-k))).collect(),
        bind: Rc::new(move |setting| match setting {
            Setting::Tolerance(tolerance) => {
                bind(&of, row, Tolerance::all(tolerance)).map_err(|error| error.to_string())
            }
            Setting::Step(_) => Err("takes a tolerance".into()),
        }),
    }
}

fn bind(scene: &Scene, row: &Row, tolerance: Tolerance) -> Result<Run, InputError> {
    if scene.dof() == 1 {
        stored::<[f64; 1]>(scene, row, tolerance)
    } else {
        stored::<Vec<f64>>(scene, row, tolerance)
    }
}

/// Creates the run with its state in `V`.
fn stored<V: Vector<Scalar = f64> + 'static>(
    scene: &Scene,
    row: &Row,
    tolerance: Tolerance,
) -> Result<Run, InputError> {
    let method = scene.problem.model.bind(row)?;
    let lift = |part: &[f64]| V::filled(part, |x| x);
    let start = State::new(lift(&scene.problem.q), lift(&scene.problem.p))?;
    let setting = registry::Setting::Tolerance(tolerance, scene.problem.end);
    Ok(Box::new(move |last, watch| {
        let mut state = start.clone();
        let done = match watch {
            None => {
                method.run(setting, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(()))
            }
            Some(watch) => {
                let mut y = vec![0.0; 3 * state.dof()];
                method.run(setting, &mut state, 1, &mut |_, state| {
                    write(state, &mut y);
                    watch(&y);
                    ControlFlow::Continue(())
                })
            }
        };
        let done = done.map_err(|error| error.to_string())?;
        write(state.state_ref(), last);
        let iterations = done.effort.iterations;
        Ok(Spent {
            steps: done.accepted,
            evaluations: done.effort.evaluations,
            iterations: (iterations > 0).then_some(iterations),
            seconds: None,
        })
    }))
}
