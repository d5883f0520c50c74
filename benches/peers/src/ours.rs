//! The project's methods with fixed steps. To add one, add its name to `FIXED`, or a [`Line`] to
//! [`lines`].

use super::measure::{Line, Run, Setting, Spent, Watch, write};
use super::{Scene, adaptive};
use afterbay_core::{Effort, Grid, InputError, IntegrateError, State, StateRef, Vector};
use afterbay_methods::registry::{self, Order, Row};
use std::ops::ControlFlow;
use std::rc::Rc;

/// Rows of the registry that are run at fixed steps; those that do not apply to a scene have no
/// line.
const FIXED: [&str; 24] = [
    "rk4",
    "leapfrog",
    "moddg",
    "increment-2",
    "increment-4",
    "increment-6",
    "increment-8",
    "gonzalez",
    "collocation-2",
    "collocation-4",
    "collocation-6",
    "collocation-8",
    "collocation-10",
    "collocation-12",
    "collocation-14",
    "collocation-16",
    "relaxed-rk4",
    "relaxed-dop853",
    "relaxed-verner98",
    "splitting-2",
    "splitting-4",
    "splitting-6",
    "locally-exact",
    "linear-exact",
];

/// The lines of the project's methods on a scene.
pub fn lines(scene: &Scene) -> Vec<Line> {
    let fixed = FIXED.iter().filter_map(|name| fixed(scene, registry::find(name)?));
    fixed.chain(adaptive::lines(scene)).collect()
}

/// The line of a row of the registry at fixed steps; `None` if it does not apply.
fn fixed(scene: &Scene, row: &'static Row) -> Option<Line> {
    scene.problem.model.bind(row).ok()?;
    let (of, end) = (scene.clone(), scene.problem.end);
    let step = |count: f64| Setting::Step(end / count.round());
    // The error of a high-order method decreases fast, and a splitting method is fastest just below
    // its limit of stability, so that step sizes are close to each other.
    let (first, ratio, count) = match row.order() {
        Order::Exact => (1.0 / scene.coarsest as f64, 4.0, 8),
        _ if row.name.starts_with("splitting") => (1.0, 2.0_f64.sqrt(), 16),
        Order::Of(0..=2) => (16.0, 2.0, 11),
        Order::Of(3..=4) => (4.0, 2.0, 11),
        Order::Of(_) => (1.0, 2.0_f64.sqrt(), 16),
    };
    Some(Line {
        method: row.name,
        keeps_k: row.keeps_k,
        ours: true,
        settings: (0..count).map(|k| step(scene.coarsest as f64 * first * ratio.powi(k))).collect(),
        bind: Rc::new(move |setting| match setting {
            Setting::Step(h) => bind(&of, row, h).map_err(|error| error.to_string()),
            Setting::Tolerance(_) => Err("takes a step".into()),
        }),
    })
}

fn bind(scene: &Scene, row: &'static Row, h: f64) -> Result<Run, InputError> {
    let method = scene.problem.model.bind(row)?;
    let grid = Grid::of(h, (scene.problem.end / h).round() as u64)?;
    if scene.dof() == 1 {
        stored::<[f64; 1]>(scene, method, grid)
    } else {
        stored::<Vec<f64>>(scene, method, grid)
    }
}

/// Creates the run with its state in `V`.
fn stored<V: Vector<Scalar = f64> + 'static>(
    scene: &Scene,
    method: registry::Run<f64>,
    grid: Grid<f64>,
) -> Result<Run, InputError> {
    let lift = |part: &[f64]| V::filled(part, |x| x);
    let start = State::new(lift(&scene.problem.q), lift(&scene.problem.p))?;
    Ok(Box::new(move |last, watch| {
        let mut state = start.clone();
        let spent = carry(&method, grid, &mut state, watch).map_err(|error| error.to_string())?;
        write(state.state_ref(), last);
        let Effort { evaluations, iterations } = spent;
        Ok(Spent {
            steps: grid.steps,
            evaluations,
            iterations: (iterations > 0).then_some(iterations),
            seconds: None,
        })
    }))
}

fn carry<V: Vector<Scalar = f64>>(
    method: &registry::Run<f64>,
    grid: Grid<f64>,
    state: &mut State<V>,
    watch: Option<Watch<'_>>,
) -> Result<Effort, IntegrateError> {
    let Some(watch) = watch else {
        let look = &mut |_, _: StateRef<'_, f64>| ControlFlow::Continue(());
        return Ok(method.run(grid, state, u64::MAX, look)?.effort);
    };
    let mut y = vec![0.0; 3 * state.dof()];
    let done = method.run(grid, state, 1, &mut |_, state| {
        write(state, &mut y);
        watch(&y);
        ControlFlow::Continue(())
    })?;
    Ok(done.effort)
}
