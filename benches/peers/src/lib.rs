//! Work-precision comparison of the project's methods and other libraries, on the same problems in
//! the same run.
//!
//! A [`Line`] is a method on a [`Scene`] with its step sizes or tolerances. [`measure::all`] runs
//! every line of a scene and returns the rows of one table. [`ratios`] computes from them the time
//! needed for a given error, and [`report`] draws them.

mod adaptive;
pub mod differential_equations;
pub mod diffsol;
pub mod external;
pub mod fields;
pub mod measure;
pub mod ode_solvers;
pub mod ours;
pub mod ratios;
pub mod report;
pub mod scenes;

pub use fields::Field;
pub use measure::{Line, Row, Run, Setting, Spent, Watch};
pub use scenes::Scene;

/// The lines of the other libraries on a scene, each with its fastest storage.
pub fn lines(scene: &Scene) -> Vec<Line> {
    use fields::{Chain, Duffing, Oscillator, Pendulum, VanDerPol};
    match scene.name {
        "A" => of_one(scene, Oscillator),
        "B" => of_one(scene, Duffing),
        "C1" => of_one(scene, VanDerPol { mu: 1.0 }),
        "C2" => of_one(scene, VanDerPol { mu: 1000.0 }),
        "E" => [
            ode_solvers::lines::<6, _>(scene, Pendulum),
            differential_equations::lines::<6, _>(scene, Pendulum),
            diffsol::dense(scene, Pendulum),
        ]
        .concat(),
        "D64" => {
            let mut lines = chain(scene);
            lines.push(differential_equations::radau5::<192, _>(scene, Chain));
            lines
        }
        // The matrices of radau5 would be dense: 3072 by 3072.
        _ => chain(scene),
    }
}

fn chain(scene: &Scene) -> Vec<Line> {
    let field = fields::Chain;
    [
        ode_solvers::dynamic(scene, field),
        differential_equations::dynamic(scene, field),
        diffsol::sparse(scene, field),
    ]
    .concat()
}

fn of_one<F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    [
        ode_solvers::lines::<3, _>(scene, field),
        differential_equations::lines::<3, _>(scene, field),
        diffsol::dense(scene, field),
    ]
    .concat()
}

/// The tolerances of the other libraries; relative and absolute tolerance are equal.
pub(crate) fn tolerances() -> Vec<f64> {
    (3..=14).map(|k| 10_f64.powi(-k)).collect()
}
