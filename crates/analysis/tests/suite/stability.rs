//! Stability maps: limits and verdicts known from theory, and maps that do not depend on lanes or
//! threads.

mod limits;
mod map;
mod units;
mod verdicts;

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, StabilityRow};
use afterbay_methods::registry::{Row, find};
use afterbay_systems::{Custom, DUFFING, Described, Description, DissipationText};

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).expect("a registered method")).collect()
}

fn spread(count: usize, from: f64, to: f64) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
}

fn custom(potential: &str, dissipation: &[&str], parameters: &[(&str, f64)]) -> Model {
    let description = Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(dissipation.iter().map(|&d| d.into()).collect()),
        parameters: parameters.iter().map(|&(name, value)| (name.into(), value)).collect(),
        ..Default::default()
    };
    Model::Custom(Described::Separable(Custom::new(&description).expect("a good description")))
}

/// One run, as a map with one cell.
fn cell(model: Model, start: [f64; 2], method: &str, h: f64, end: f64) -> StabilityRow {
    let (name, value) = match (model.name(), &model) {
        ("damped-oscillator", Model::Listed(_, values)) => ("b", values[1]),
        ("duffing", Model::Listed(_, values)) => ("c", values[2]),
        ("van-der-pol", Model::Listed(_, values)) => ("mu", values[0]),
        _ => ("c", 0.0),
    };
    let problem = Problem { model, q: vec![start[0]], p: vec![start[1]], end };
    let map = Map { problem, parameter: name, values: &[value], steps: &[h], end, least_steps: 1 };
    let mut cells = map.run(&rows(&[method]), &Silent).expect("a map");
    assert_eq!(cells.len(), 1);
    cells.remove(0)
}

fn well(c: f64) -> Model {
    Model::of(&DUFFING, &[-1.0, 1.0, c])
}
