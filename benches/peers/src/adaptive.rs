//! Our adaptive collocation on a scene, told a tolerance.

use super::Scene;
use super::measure::{Line, Run, Setting, Spent};
use super::ours::write;
use afterbay_analysis::Model;
use afterbay_core::{Curvature, InputError, State, Tolerance, Vector, integrate_within};
use afterbay_methods::AdaptiveCollocation;
use afterbay_systems::{DampedDoublePendulum, DampedOscillator, Duffing, FputChain, VanDerPol};
use std::ops::ControlFlow;
use std::rc::Rc;

/// The line of a scene whose system has one here.
pub(crate) fn line(scene: &Scene) -> Line {
    let of = scene.clone();
    Line {
        method: "adaptive-collocation",
        keeps_k: true,
        ours: true,
        settings: (1..=13).map(|k| Setting::Tolerance(10_f64.powi(-k))).collect(),
        bind: Rc::new(move |setting| match setting {
            Setting::Tolerance(tolerance) => {
                bind(&of, Tolerance::all(tolerance)).map_err(|error| error.to_string())
            }
            Setting::Step(_) => Err("takes a tolerance".into()),
        }),
    }
}

fn bind(scene: &Scene, tolerance: Tolerance) -> Result<Run, InputError> {
    match scene.problem.model {
        Model::DampedOscillator { k, b } => {
            stored::<[f64; 1], _>(scene, DampedOscillator::new(k, b)?, tolerance)
        }
        Model::Duffing { alpha, beta, c } => {
            stored::<[f64; 1], _>(scene, Duffing::new(alpha, beta, c)?, tolerance)
        }
        Model::VanDerPol { mu } => stored::<[f64; 1], _>(scene, VanDerPol::new(mu)?, tolerance),
        Model::FputChain { n, beta, c } => {
            stored::<Vec<f64>, _>(scene, FputChain::new(n, beta, c)?, tolerance)
        }
        Model::DampedDoublePendulum { m1, m2, l1, l2, g, c1, c2 } => {
            let pendulum = DampedDoublePendulum::new([m1, m2], [l1, l2], g, [c1, c2])?;
            stored::<[f64; 2], _>(scene, pendulum, tolerance)
        }
        Model::ModifiedVanDerPol { .. } | Model::VanDerPolRing { .. } => Err(InputError::Unsupported {
            method: "adaptive-collocation",
            why: "no scene here has this system",
        }),
    }
}

/// The run with its state in `V`.
fn stored<V, S>(scene: &Scene, system: S, tolerance: Tolerance) -> Result<Run, InputError>
where
    V: Vector<Scalar = f64> + 'static,
    S: Curvature<f64> + 'static,
{
    let lift = |part: &[f64]| V::filled(part, |x| x);
    let start = State::new(lift(&scene.problem.q), lift(&scene.problem.p))?;
    let end = scene.problem.end;
    Ok(Box::new(move |last, watch| {
        let mut state = start.clone();
        let method = AdaptiveCollocation;
        let done = match watch {
            None => integrate_within(&method, &system, &tolerance, end, &mut state, &mut ()),
            Some(watch) => {
                let mut y = vec![0.0; 3 * state.dof()];
                let mut look = |_: u64, state: &State<V>| {
                    write(state.view(), &mut y);
                    watch(&y);
                    ControlFlow::Continue(())
                };
                integrate_within(&method, &system, &tolerance, end, &mut state, &mut look)
            }
        };
        let done = done.map_err(|error| error.to_string())?;
        write(state.view(), last);
        let iterations = done.effort.iterations;
        Ok(Spent {
            steps: done.accepted,
            evaluations: done.effort.evaluations,
            iterations: (iterations > 0).then_some(iterations),
        })
    }))
}
