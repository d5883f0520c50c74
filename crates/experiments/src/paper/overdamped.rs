//! The overdamped oscillator at a step too long for explicit methods: K is exact while the decay is
//! wrong.

mod claims;

use super::{Paper, Part};
use crate::chart::Axis;
use crate::claim::Readings;
use crate::sheet::{ReportError, Sheet, line, marked, over_time, scientific};
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::decay::{self, DecayRow};
use afterbay_analysis::study::energy::{self, EnergyRun};
use afterbay_methods::registry::Row;
use afterbay_systems::DAMPED_OSCILLATOR;

pub(super) const PART: Part =
    Part { heading: "An exact balance, a wrong decay", methods: &[&SHOWN, &[L_STABLE]], sheet };

const SHOWN: [&str; 3] = ["moddg", "leapfrog", "rk4"];
/// A method with R(∞) = 0, whose energy is charted beside the exact one.
const L_STABLE: &str = "locally-exact";

const STEP: f64 = 0.1;
/// A step that resolves the fast motion, and the number of such steps in one step of the others.
const FINE: (f64, u64) = (STEP / 200.0, 200);
/// The friction, and a friction for which e^{-b h} is beyond any order.
const FRICTION: [f64; 2] = [200.0, 5000.0];

fn problem(b: f64) -> Problem {
    Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[1.0, b]),
        q: vec![1.0],
        p: vec![1.0],
        end: 2.0,
    }
}

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    sheet.text(
        "As h λ → -∞ a step of a midpoint-type discrete gradient multiplies the state by -1: the \
         methods are A-stable but not L-stable. Here b = 200, h = 0.1, from (1, 1).",
    );
    let problem = problem(FRICTION[0]);
    let runs = energy::run(&problem, &paper.methods(&SHOWN)?, STEP, 1, &Silent)?;
    let rows: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data("overdamped_energy", &energy::columns(&problem.model), &rows)?;

    let ratio = |run: &EnergyRun, step: usize| run.rows.get(step).and_then(|row| row.ratio);
    let exact = |run: &EnergyRun, step: usize| {
        let row = run.rows.get(step)?;
        Some(row.ratio? - row.ratio_error?)
    };
    let moddg = &runs[0];
    let start = moddg.rows.first().map(|row| row.energy);
    let readings = Readings::default()
        .and("moddg", "R", ratio(moddg, 2))
        .and("the solution", "R", exact(moddg, 2))
        .and("moddg", "drift", start.map(|start| moddg.drift / start))
        .and("moddg", "falls of w", moddg.violations)
        .and("moddg", "run", moddg.ending.outcome);
    sheet.find("an exact balance means a right decay", readings, claims::balance_and_decay);
    let four = |ratio: Option<f64>| ratio.map_or(String::new(), |ratio| format!("{ratio:.4}"));
    let table = (1..=8).map(|step| {
        let mut cells = vec![step.to_string(), four(exact(moddg, step))];
        cells.extend(runs.iter().map(|run| four(ratio(run, step))));
        cells
    });
    sheet.table(&["step", "R exact", "R moddg", "R leapfrog", "R rk4"], table.collect());
    for run in &runs {
        if let Some(failure) = &run.ending.failure {
            sheet.text(format!("{}: {failure}.", run.method));
        }
    }
    every_method(paper, &mut sheet)?;
    energies(paper, &mut sheet, &problem, &runs)?;
    Ok(sheet)
}

/// Charts the energies over time beside the exact one.
fn energies(
    paper: &Paper<'_>,
    sheet: &mut Sheet,
    problem: &Problem,
    runs: &[EnergyRun],
) -> Result<(), ReportError> {
    let energies =
        |run: &EnergyRun| run.rows.iter().map(|row| (row.t, row.energy)).collect::<Vec<_>>();
    let solution =
        problem.solution(STEP / 10.0, (10.0 * problem.end / STEP).round() as usize, &Silent)?;
    let system = problem.model.system::<f64>()?;
    let exact = solution.states().map(|state| state.energy(&*system));
    let exact: Vec<_> =
        (0..).zip(exact).map(|(i, energy)| (f64::from(i) * STEP / 10.0, energy)).collect();
    let fine = energy::run(problem, &paper.methods(&["moddg"])?, FINE.0, FINE.1, &Silent)?;
    let l_stable = energy::run(problem, &paper.methods(&[L_STABLE])?, STEP, 1, &Silent)?;
    let charted = [
        (format!("moddg, h = {STEP}"), &runs[0]),
        (format!("leapfrog, h = {STEP}"), &runs[1]),
        (format!("moddg, h = {}", FINE.0), &fine[0]),
        (format!("{L_STABLE}, h = {STEP}"), &l_stable[0]),
    ];
    let mut readings = Readings::default();
    for (label, run) in charted
        .iter()
        .map(|(label, run)| (label.as_str(), *run))
        .chain([("rk4, h = 0.1", &runs[2])])
    {
        // Every state shown is at a whole multiple of the step, ten states of the solution further
        // on.
        let off = run
            .rows
            .iter()
            .zip(exact.iter().step_by(10))
            .map(|(row, exact)| (row.energy - exact.1).abs());
        let off = off.reduce(|a, b| if a >= b || a.is_nan() { a } else { b });
        let whole = run.ending.is_completed();
        readings.add(label, "off H₀ by", off.filter(|_| whole).map(|off| off / exact[0].1));
    }
    sheet.find("energies beside the exact one", readings, claims::energies);
    let mut curves = vec![line("exact", exact)];
    curves.extend(charted.iter().map(|(label, run)| marked(label, energies(run))));
    let chart = over_time("Energy of the overdamped oscillator", Axis::linear("energy H"), curves);
    sheet.show(
        "overdamped",
        &chart,
        "Energy of the overdamped oscillator (b = 200).",
        "overdamped_energy",
    );
    Ok(())
}

/// The table of all methods at both frictions, and the finding on which of them decay rightly.
fn every_method(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let all: Vec<&'static Row> = paper.registry.iter().collect();
    let run = |b: f64| -> Result<Vec<DecayRow>, ReportError> {
        let problem = problem(b);
        let runs = energy::run(&problem, &all, STEP, 1, &Silent)?;
        Ok(decay::rows(&problem, b, STEP, &runs, &Silent)?)
    };
    let [found, stiffer] = [run(FRICTION[0])?, run(FRICTION[1])?];
    let rows: Vec<&DecayRow> = found.iter().chain(&stiffer).collect();
    sheet.data("overdamped", &rows)?;
    let ratio = |ratio: Option<f64>| {
        ratio.map_or(String::new(), |ratio| {
            if ratio < 100.0 { format!("{ratio:.4}") } else { format!("{ratio:.1e}") }
        })
    };
    let table = found.iter().zip(&stiffer).map(|(row, stiffer)| {
        vec![
            row.method.into(),
            ratio(row.ratio),
            format!("{:.4}", row.exact),
            scientific(row.k_drift),
            row.decay.to_string(),
            stiffer.decay.to_string(),
        ]
    });
    let header = ["method", "R, step 2", "R exact", "max |K - K₀|", "b = 200", "b = 5000"];
    sheet.text(
        "Every method, from the same state with the same step: the energy ratio R of the second \
         step beside the exact one, the drift of K in 20 steps, and the verdict. A decay is right \
         if the loss 1 - R is within a tenth of the exact loss. A run has diverged if its energy \
         exceeds that at the start. The last column is for b = 5000.",
    );
    sheet.table(&header, table.collect());
    let readings = found.iter().zip(&stiffer).fold(Readings::default(), |r, (row, stiffer)| {
        r.and(row.method, "b = 200", row.decay.to_string()).and(
            row.method,
            "b = 5000",
            stiffer.decay.to_string(),
        )
    });
    sheet.find("methods that decay rightly on an overdamped system", readings, claims::trusted);
    Ok(())
}
