//! Trajectories by each method.

use crate::chart::{Axis, Curve, LineChart};
use crate::claim::{Readings, Said};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::scene::{RunPlan, Scene};
use crate::sheet::{ReportError, Sheet, line, over_time, scientific};
use crate::study::outcome::COMPLETED;
use crate::study::trajectory::{self, Trajectory, TrajectoryRow};

/// The number of degrees of freedom shown.
const SHOWN: usize = 6;
/// The table from which the charts are made.
const DATA: &str = "trajectory";

pub(super) fn sheet(
    scene: &Scene,
    plan: &RunPlan,
    progress: &dyn Progress,
) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Trajectories");
    let (problem, n) = (&scene.problem, scene.problem.model.dof());
    progress.begin("trajectories", plan.methods.len() + plan.adaptive.len());
    let mut found = trajectory::run(problem, &plan.methods, scene.step, plan.every, progress)?;
    let asked = plan.adaptive.iter().zip(plan.tolerance.iter().cycle());
    for (row, &tolerance) in asked {
        let (h, every) = (scene.step, plan.every);
        found.push(trajectory::sampled(problem, row, tolerance, h, every, progress)?);
    }
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data(DATA, &trajectory::columns(n), &rows)?;
    let record =
        |run: &Trajectory| run.ending.record("run", problem.model.name(), run.method, scene.step);
    sheet.runs.extend(found.iter().map(record));
    say(&mut sheet, &found);
    let last = |run: &Trajectory| {
        let mut cells = vec![run.method.into(), run.ending.describe()];
        if let Some(row) = run.rows.last() {
            cells.extend([row.step.to_string(), row.t.to_string(), format!("{:.6}", row.energy)]);
            cells.push(format!("{:.6}", row.w.iter().sum::<f64>()));
            cells.push(scientific(Some(drift(run))));
        }
        cells
    };
    sheet.table(
        &["method", "outcome", "steps", "t", "H", "Σ w", "max |K - K₀| of the states kept"],
        found.iter().map(last).collect(),
    );
    let curves = |value: &dyn Fn(&TrajectoryRow) -> (f64, f64)| -> Vec<Curve> {
        found.iter().map(|run| line(run.method, run.rows.iter().map(value).collect())).collect()
    };
    if n == 1 {
        let over = over_time("Coordinate", Axis::linear("q"), curves(&|row| (row.t, row.q[0])));
        let phase = LineChart {
            title: "Phase plane".into(),
            x: Axis::linear("q"),
            y: Axis::linear("p"),
            curves: curves(&|row| (row.q[0], row.p[0])),
            guides: Vec::new(),
        };
        pair(
            &mut sheet,
            ("coordinate", &over, "q over time."),
            ("phase-plane", &phase, "p against q."),
        );
    } else if let Some(run) = found.first() {
        let of = |name: &str, part: fn(&TrajectoryRow) -> &[f64]| -> Vec<Curve> {
            (0..n.min(SHOWN))
                .map(|j| {
                    let points =
                        run.rows.iter().filter_map(|row| Some((row.t, *part(row).get(j)?)));
                    line(&format!("{name}{}", j + 1), points.collect())
                })
                .collect()
        };
        let some = if n > SHOWN { format!("the first {SHOWN} of {n}") } else { "all".into() };
        let coordinates = over_time(
            &format!("Coordinates by {}", run.method),
            Axis::linear("q_j"),
            of("q", |row| &row.q),
        );
        let reservoirs = over_time(
            &format!("Reservoirs by {}", run.method),
            Axis::linear("w_j"),
            of("w", |row| &row.w),
        );
        pair(
            &mut sheet,
            ("coordinates", &coordinates, &format!("Coordinates over time, {some}.")),
            (
                "reservoirs",
                &reservoirs,
                &format!("The energy each degree of freedom gave up, {some}."),
            ),
        );
    }
    let energy = over_time("Energy", Axis::linear("H"), curves(&|row| (row.t, row.energy)));
    let start = found.first().and_then(|run| run.rows.first()).map_or(0.0, |row| row.total);
    let kept = over_time(
        "Deviation of K",
        Axis::log("|K - K₀|"),
        curves(&|row| (row.t, (row.total - start).abs())),
    );
    pair(
        &mut sheet,
        ("energy", &energy, "H over time."),
        (
            "deviation-of-k",
            &kept,
            "Deviation of K. A logarithmic axis cannot show states at which K is exact.",
        ),
    );
    sheet.text(format!(
        "Methods: {}. The table contains one of every {} states, and the last.",
        found.iter().map(|run| run.method).collect::<Vec<_>>().join(", "),
        plan.every
    ));
    Ok(sheet)
}

fn pair(sheet: &mut Sheet, left: (&str, &LineChart, &str), right: (&str, &LineChart, &str)) {
    let [left, right] =
        [left, right].map(|(name, chart, caption)| sheet.figure(name, chart.draw(), caption, DATA));
    sheet.show_pair(left, right);
}

/// The largest deviation of K in the states that were kept.
fn drift(run: &Trajectory) -> f64 {
    let start = run.rows.first().map_or(0.0, |row| row.total);
    run.rows.iter().fold(0.0, |most: f64, row| most.max((row.total - start).abs()))
}

fn say(sheet: &mut Sheet, found: &[Trajectory]) {
    let readings = found.iter().fold(Readings::default(), |r, run| {
        r.and(run.method, "run", run.ending.outcome).and(run.method, "drift", drift(run))
    });
    sheet.find("Trajectories", readings, where_they_went);
}

fn where_they_went(r: &Readings) -> Said {
    let all = r.of_all("run");
    let done = all.iter().filter(|name| r.word(name, "run") == COMPLETED).count();
    let off = r.numbers("drift").into_iter().map(|(name, drift)| format!("{name} {drift:.0e}"));
    let statement = format!(
        "{done} of {} runs reached the end. K is off by {}; that says nothing of the error of (q, \
         p) and of w, which `afterbay study` measures.",
        all.len(),
        off.collect::<Vec<_>>().join(", "),
    );
    (if done == all.len() { Verdict::Note } else { Verdict::Fails }, statement)
}
