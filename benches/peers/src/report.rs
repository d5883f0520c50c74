//! The report: charts of the error against time and evaluations for each scene, with tables.

use super::Scene;
use super::measure::Row;
use super::ratios::{self, Part};
use afterbay_experiments::artifact::Artifact;
use afterbay_experiments::chart::{Axis, Curve, LineChart, Panels, Style};
use afterbay_experiments::data::Files;
use afterbay_experiments::manifest::{Manifest, RunOutcome, processor};
use afterbay_experiments::record::{Output, StorageError};
use afterbay_experiments::report::{Block, Figure, Report, Section, Table};
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
    let mut sections = vec![summary(all, &mut artifacts)];
    sections.extend(all.iter().map(|(scene, rows)| section(scene, rows, &mut artifacts)));
    let report = Report {
        title: "Work against precision".into(),
        subtitle: format!("afterbay beside {}, on {}", libraries(all).join(", "), processor()),
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
        point: None,
        outcome: row.outcome.into(),
        failure: row.failure.clone(),
    });
    let problems: serde_json::Map<_, _> = all
        .iter()
        .map(|(scene, _)| (scene.name.into(), serde_json::json!(&*scene.problem)))
        .collect();
    let manifest = Manifest::new("bench peers", problems.into(), runs.collect());
    Output { report, artifacts, manifest }.write(folder, Files::default())
}

/// The libraries that have runs.
fn libraries(all: &[(Scene, Vec<Row>)]) -> Vec<&'static str> {
    let has = |prefix: &str| {
        all.iter().flat_map(|(_, rows)| rows).any(|row| row.method.starts_with(prefix))
    };
    ratios::LIBRARIES.iter().filter(|library| has(library.1)).map(|library| library.0).collect()
}

fn summary(all: &[(Scene, Vec<Row>)], artifacts: &mut Vec<Artifact>) -> Section {
    let header = ratios::HEADER.map(String::from).into();
    let rows = all.iter().flat_map(|(_, rows)| ratios::table(rows)).map(Vec::from).collect();
    let text = "Time to an error at the end, the least of alternating passes in one run. Between \
                two runs of a method the time is interpolated, log-log; beyond the last it is not \
                extrapolated. \"≤\": the coarsest run is as good already. Of our methods those \
                that keep K and take any system count, and of these the runs whose drift of K is \
                below 1e-12 of the largest of |H| and Σ|w|. LSODA shows only its end. The others \
                integrate w as one more component for each degree of freedom and control its \
                error as well.";
    let slower: Vec<_> = all.iter().flat_map(|(_, rows)| ratios::slower(rows)).collect();
    let slower = if slower.is_empty() {
        "No other library is faster in any of these cases.".into()
    } else {
        format!("Another library is faster in these cases. {}", slower.join(" "))
    };
    Section {
        heading: "Times".into(),
        blocks: vec![
            Block::Text(text.into()),
            Block::Figure(overview(all, artifacts)),
            Block::Text(slower),
            Block::Table(Table { header, rows }),
        ],
    }
}

/// The smallest and the largest time of the overview, in units of our time to an error of 1e-8. A
/// choice.
const OVERVIEW: std::ops::RangeInclusive<f64> = 0.05..=50.0;

/// The envelope of each library on each scene. Times are relative, so that scenes compare.
fn overview(all: &[(Scene, Vec<Row>)], artifacts: &mut Vec<Artifact>) -> Figure {
    let ours = ("afterbay, K exact", "");
    let of = |row: &Row, prefix: &str| {
        if prefix.is_empty() { ratios::is_ours(row) } else { row.method.starts_with(prefix) }
    };
    let panel = |(scene, rows): &(Scene, Vec<Row>)| {
        let unit = ratios::ours(rows, Part::Qp)[1].map_or(f64::NAN, |(_, time)| time.seconds());
        let curve = |(label, prefix): (&str, &str)| {
            let points = ratios::points(rows.iter().filter(|row| of(row, prefix)), Part::Qp);
            let points = ratios::envelope(points)
                .into_iter()
                .map(|(seconds, error)| (seconds / unit, error.max(f64::EPSILON)))
                .filter(|(time, _)| OVERVIEW.contains(time))
                .collect();
            let label = label.into();
            Curve { label, points, bounds: Vec::new(), style: Style::LineMarkers }
        };
        let curves = std::iter::once(ours).chain(ratios::LIBRARIES).map(curve).collect();
        (format!("{}: {}", scene.name, scene.about), curves)
    };
    let chart = Panels {
        title: "Error of (q, p) at the end against the time of a run".into(),
        x: Axis::log("time / time of afterbay to 1e-8"),
        own_x: false,
        y: Axis::log("error of (q, p)"),
        panels: all.iter().map(panel).collect(),
    }
    .draw();
    let svg = chart.svg();
    let file = "figures/overview.svg".to_owned();
    artifacts.push(Artifact {
        name: file.clone(),
        text: svg.clone(),
        picture: Some(chart),
        ..Artifact::default()
    });
    let caption = "The best methods of each library: error of (q, p) at the end against the time \
                   of a run, in units of the time in which the fastest of ours reaches 1e-8.";
    Figure { svg, caption: caption.into(), file, data: DATA.into() }
}

fn section(scene: &Scene, rows: &[Row], artifacts: &mut Vec<Artifact>) -> Section {
    let mut names: Vec<_> = rows.iter().map(|row| (row.method, row.ours)).collect();
    names.dedup();
    let of = |wanted: &dyn Fn(&str, bool) -> bool| -> Vec<&'static str> {
        names.iter().filter(|(name, ours)| wanted(name, *ours)).map(|(name, _)| *name).collect()
    };
    let mut first: Vec<_> = Part::BOTH
        .into_iter()
        .flat_map(|part| ratios::ours(rows, part).into_iter().flatten().map(|found| found.0))
        .collect();
    first.sort_unstable();
    first.dedup();
    first.extend(of(&|_, ours| !ours));
    let groups = [
        ("peers", "Other libraries, and the best of ours that keep K.", first),
        (
            "collocation",
            "Energy-preserving collocation.",
            of(&|name, _| name.starts_with("collocation")),
        ),
        (
            "others",
            "Our other methods.",
            of(&|name, ours| ours && !name.starts_with("collocation")),
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
    artifacts.push(Artifact {
        name: file.clone(),
        text: svg.clone(),
        picture: Some(chart),
        ..Artifact::default()
    });
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
