//! The report: charts of the error against time and evaluations for each scene, with tables.

use super::measure::Row;
use super::{Scene, ratios};
use afterbay_analysis::chart::{Axis, Curve, LineChart, Style};
use afterbay_analysis::data::DataFormat;
use afterbay_analysis::record::{Artifact, Manifest, Output, RunOutcome, StorageError, processor};
use afterbay_analysis::report::{Block, Figure, Report, Section, Table};
use std::path::Path;

const DATA: &str = "data/work_precision.csv";

/// The quantities charted: x and y of a run.
struct StateRef {
    name: &'static str,
    x: (&'static str, fn(&Row) -> Option<f64>),
    y: (&'static str, fn(&Row) -> Option<f64>),
}

const VIEWS: [StateRef; 3] = [
    StateRef {
        name: "time-qp",
        x: ("time of a run [s]", |row| row.seconds),
        y: ("error of (q, p)", |row| row.error_qp),
    },
    StateRef {
        name: "time-w",
        x: ("time of a run [s]", |row| row.seconds),
        y: ("error of w", |row| row.error_w),
    },
    StateRef {
        name: "evaluations-qp",
        x: ("evaluations of the right-hand side", |row| row.evaluations.map(|count| count as f64)),
        y: ("error of (q, p)", |row| row.error_qp),
    },
];

/// Writes the report, the figures and the table of all runs to `folder`.
///
/// # Errors
/// An error if a file cannot be written.
pub fn write(all: &[(Scene, Vec<Row>)], folder: &Path) -> Result<(), StorageError> {
    let rows: Vec<_> = all.iter().flat_map(|(_, rows)| rows).collect();
    let mut artifacts = vec![Artifact::table(DATA, &rows)?];
    let mut sections = vec![summary(all)];
    sections.extend(all.iter().map(|(scene, rows)| section(scene, rows, &mut artifacts)));
    let report = Report {
        title: "Work against precision".into(),
        subtitle: format!(
            "afterbay beside ode_solvers, diffsol and differential-equations, on {}",
            processor()
        ),
        sections,
    };
    let system = |row: &Row| {
        let of = all.iter().find(|(scene, _)| scene.name == row.problem);
        of.map_or("", |(scene, _)| scene.problem.model.name())
    };
    let runs = rows.iter().map(|row| RunOutcome {
        study: "peers",
        system: system(row),
        method: row.method,
        h: row.h.or(row.tolerance).unwrap_or_default(),
        outcome: row.outcome.into(),
        failure: row.failure.clone(),
    });
    let problems: serde_json::Map<_, _> = all
        .iter()
        .map(|(scene, _)| (scene.name.into(), serde_json::json!(&*scene.problem)))
        .collect();
    let manifest = Manifest::new("bench peers", problems.into(), runs.collect());
    Output { report, artifacts, manifest }.write(folder, DataFormat::Csv)
}

fn summary(all: &[(Scene, Vec<Row>)]) -> Section {
    let header = ["scene", "", "1e-4", "1e-8", "1e-11"].map(String::from).into();
    let rows = all.iter().flat_map(|(_, rows)| ratios::table(rows)).map(Vec::from).collect();
    let text = format!(
        "Time to an error of (q, p) at the end, as a multiple of {} in the same run; of C2 in \
         milliseconds. Between two runs of a method the time is interpolated, log-log; beyond the \
         last it is not extrapolated. \"≤\": the coarsest run is as good already. Of our methods \
         those that keep K count, and of these the runs whose drift of K is below 1e-12 of the \
         largest of |H| and Σ|w|. The peers integrate w as one more component for each degree of \
         freedom and control its error as well.",
        ratios::YARDSTICK
    );
    Section {
        heading: "Ratios".into(),
        blocks: vec![Block::Text(text), Block::Table(Table { header, rows })],
    }
}

fn section(scene: &Scene, rows: &[Row], artifacts: &mut Vec<Artifact>) -> Section {
    let mut names: Vec<_> = rows.iter().map(|row| (row.method, row.ours)).collect();
    names.dedup();
    let of = |wanted: &dyn Fn(&str, bool) -> bool| -> Vec<&'static str> {
        names.iter().filter(|(name, ours)| wanted(name, *ours)).map(|(name, _)| *name).collect()
    };
    let mut first: Vec<_> = ratios::best(rows).into_iter().flatten().map(|best| best.0).collect();
    first.sort_unstable();
    first.dedup();
    first.extend(of(&|_, ours| !ours));
    let groups = [
        ("peers", "Other libraries, and the best of ours that keep K.", first),
        (
            "collocation",
            "Energy-preserving collocation.",
            of(&|name, _| name.starts_with("collocation") || name == ratios::YARDSTICK),
        ),
        (
            "others",
            "Our other methods.",
            of(&|name, ours| {
                (ours && !name.starts_with("collocation")) || name == ratios::YARDSTICK
            }),
        ),
    ];
    let problem = &scene.problem;
    let mut blocks = vec![Block::Text(format!(
        "{}, N = {}, to t = {}. Behind each name in a legend stands the drift of K of its run \
         nearest to an error of 1e-8.",
        scene.about,
        scene.dof(),
        problem.end
    ))];
    for (group, about, names) in groups {
        let figures: Vec<_> = VIEWS
            .iter()
            .map(|view| figure(scene, rows, &names, (group, about), view, artifacts))
            .map(Block::Figure)
            .collect();
        if group == "peers" {
            blocks.extend(figures);
        } else {
            blocks.push(Block::Fold(about.into(), figures));
        }
    }
    blocks.push(Block::Fold("Every run".into(), vec![every_run(rows)]));
    Section { heading: format!("{}: {}", scene.name, scene.about), blocks }
}

fn figure(
    scene: &Scene,
    rows: &[Row],
    names: &[&str],
    (group, about): (&str, &str),
    view: &StateRef,
    artifacts: &mut Vec<Artifact>,
) -> Figure {
    let curve = |name: &&str| {
        let of = || rows.iter().filter(|row| row.method == *name);
        let points = of().filter_map(|row| Some(((view.x.1)(row)?, (view.y.1)(row)?))).collect();
        let far = |row: &&Row| {
            row.error_qp.map_or(f64::INFINITY, |error| (error.max(1e-16) / 1e-8).ln().abs())
        };
        let nearest = of().min_by(|a, b| far(a).total_cmp(&far(b)));
        let drift = nearest.map_or(f64::NAN, |row| row.k_drift);
        let label = format!("{name}, ΔK {drift:.0e}");
        Curve { label, points, bounds: Vec::new(), style: Style::LineMarkers }
    };
    let curves: Vec<_> = names.iter().map(curve).filter(|curve| !curve.points.is_empty()).collect();
    let end = scene.problem.end;
    let chart = LineChart {
        title: format!("{}: {}", scene.name, scene.about),
        x: Axis::log(view.x.0),
        y: Axis::log(format!("{} at t = {end}", view.y.0)),
        curves,
        guides: Vec::new(),
    }
    .draw();
    let file = format!("figures/{}-{group}-{}.svg", scene.name.to_lowercase(), view.name);
    let svg = chart.svg();
    artifacts.push(Artifact { name: file.clone(), text: svg.clone(), picture: Some(chart) });
    let caption = format!("{about} {} against {}.", capital(view.y.0), view.x.0);
    Figure { svg, caption, file, data: DATA.into() }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn every_run(rows: &[Row]) -> Block {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.1e}"));
    let count = |x: Option<u64>| x.map_or(String::new(), |x| x.to_string());
    let cells = |row: &Row| {
        vec![
            row.method.into(),
            row.h.or(row.tolerance).map_or(String::new(), |x| format!("{x:.2e}")),
            row.failure.clone().unwrap_or_else(|| row.outcome.into()),
            number(row.error_qp),
            number(row.error_w),
            number(row.error_qp.map(|_| row.k_drift)),
            row.passivity_violations.map_or("not counted".into(), |count| count.to_string()),
            number(row.seconds),
            count(row.steps),
            count(row.evaluations),
        ]
    };
    let header = [
        "method",
        "h or tolerance",
        "outcome",
        "error of (q, p)",
        "error of w",
        "max |K - K₀|",
        "steps with Δw < 0",
        "seconds",
        "steps",
        "evaluations",
    ];
    Block::Table(Table {
        header: header.map(String::from).into(),
        rows: rows.iter().map(cells).collect(),
    })
}
