//! Work against precision: our methods and other people's libraries on the same problems in the
//! same run.
//!
//! A [`Line`] is a method on a [`Scene`] with the steps or tolerances it is run at.
//! [`measure::all`] runs every line of a scene and gives the rows of one table; [`ratios`] reads
//! the time to a wanted error from them, [`report`] draws them.

mod adaptive;
pub mod differential_equations;
pub mod diffsol;
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

/// The peers' lines on a scene: each in the storage it is fastest in.
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
        // The matrices of radau5 are dense: 3072 by 3072 here.
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

/// Tolerances of the peers, relative and absolute alike.
pub(crate) fn tolerances() -> Vec<f64> {
    (3..=14).map(|k| 10_f64.powi(-k)).collect()
}
