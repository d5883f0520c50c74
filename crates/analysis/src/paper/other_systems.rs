//! Systems that the paper announces without results: the same study for Duffing, Van der Pol and
//! modified Van der Pol.

use super::{BASE_STEP, FIGURE_STEP, Paper, Part, STEPS};
use crate::Model;
use crate::chart::Axis;
use crate::claim::{Readings, Said, fixed, list, sci, verdict};
use crate::findings::{KEPT, kept};
use crate::report::Block;
use crate::sheet::{ReportError, Sheet, decimal, line, over_time, scientific};
use crate::study::local_order::{LocalOrder, Statistic, rows};
use crate::study::{Problem, VARIABLES, energy};
use afterbay_systems::{DUFFING, MODIFIED_VAN_DER_POL, VAN_DER_POL};

/// The problems, by the names of their folders. The paper names these systems without defining
/// them.
pub(super) fn problems() -> [(&'static str, Problem); 4] {
    [
        (
            "duffing",
            Problem {
                model: Model::of(&DUFFING, &[1.0, 0.5, 0.1]),
                q: vec![2.3],
                p: vec![-3.1],
                end: 20.0,
            },
        ),
        (
            "duffing-double-well",
            Problem {
                model: Model::of(&DUFFING, &[-1.0, 1.0, 0.1]),
                q: vec![1.5],
                p: vec![0.5],
                end: 20.0,
            },
        ),
        (
            "van-der-pol",
            Problem {
                model: Model::of(&VAN_DER_POL, &[1.0]),
                q: vec![2.0],
                p: vec![0.5],
                end: 20.0,
            },
        ),
        (
            "modified-van-der-pol",
            Problem {
                model: Model::of(&MODIFIED_VAN_DER_POL, &[1.0, -1.0, 1.0]),
                q: vec![2.0],
                p: vec![0.5],
                end: 20.0,
            },
        ),
    ]
}

const STUDIED: [&str; 7] =
    ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-p4-shared", "moddg-qp3", "moddg-qp4"];

pub(super) const PART: Part = Part {
    heading: "Announced but not shown: Duffing, Van der Pol, modified Van der Pol",
    methods: &[&STUDIED],
    sheet,
};

/// The tolerance of a median order of 2. On nonlinear systems the next term of the error bends the
/// line more.
const AGREEMENT: f64 = 0.1;

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    let Paper { extent, progress, .. } = *paper;
    sheet.text(
        "The paper names these systems without defining them. The definitions used here are: \
         Duffing V = α q²/2 + β q⁴/4 with D = c p, single well (α = 1, β = 0.5, c = 0.1) and \
         double well (α = -1, β = 1, c = 0.1); Van der Pol V = q²/2 with D = -μ (1 - q²) p, μ = 1; \
         modified Van der Pol: that D on the double-well Duffing potential. The study repeats that \
         of the orders above on the same base grid and steps, with Taylor series for the reference \
         and for δ.",
    );
    let base_step = extent.pick(BASE_STEP, 0.01);
    let steps = extent.pick(STEPS.to_vec(), vec![0.04, 0.03, 0.02]);
    let study = LocalOrder { base_step, steps };
    let rows_of = paper.methods(&STUDIED)?;
    for (name, problem) in problems() {
        progress.begin(
            &format!("local errors and energies of {name}"),
            rows_of.len() * (study.steps.len() + 1),
        );
        let errors = study.run::<f64>(&problem, &rows_of, progress)?;
        let orders = rows(&errors, |_, _, _| None);
        sheet.data(&format!("{name}/local_orders"), &orders)?;
        let median = |method: &str, variable: &str| {
            let mut of =
                orders.iter().filter(|row| row.method == method && row.variable == variable);
            of.find(|row| row.statistic == Statistic::Median.name()).and_then(|row| row.order)
        };

        let runs = energy::run(&problem, &rows_of, FIGURE_STEP, 1, progress)?;
        let all: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
        sheet.wide_data(&format!("{name}/energy"), &energy::columns(&problem.model), &all)?;

        let drift = |run: &energy::EnergyRun| {
            let done = run.ending.is_completed().then_some(run.drift);
            Some(done? / run.rows.first()?.energy.abs())
        };
        let of = |name: &str| runs.iter().find(|run| run.method == name);
        let mut readings = VARIABLES.iter().fold(Readings::default(), |r, variable| {
            r.and(variable, "median", median("moddg", variable))
        });
        for method in ["moddg", "leapfrog", "rk4"] {
            readings.add(method, "drift", of(method).and_then(drift));
        }
        let fell =
            of("moddg").map(|run| run.rows.windows(2).filter(|pair| pair[1].w < pair[0].w).count());
        readings.add("w", "steps", of("moddg").map(|run| run.rows.len() as f64 - 1.0));
        readings.add("w", "falls", fell.map(|count| count as f64));
        sheet.find(&format!("modDG on {name}"), readings, second_order_with_k);
        let table = rows_of.iter().zip(&runs).map(|(row, run)| {
            let mut cells = vec![row.name.to_string()];
            cells.extend(VARIABLES.map(|variable| decimal(median(row.name, variable))));
            let w_error = run.rows.iter().map(|row| row.w_error.abs()).fold(0.0, f64::max);
            cells.extend([scientific(Some(run.drift)), scientific(Some(w_error))]);
            cells.push(run.violations.map_or("not counted".into(), |count| count.to_string()));
            cells.push(run.ending.describe());
            cells
        });
        let header = [
            "method",
            "median order q",
            "p",
            "w",
            "max |K - K₀|",
            "max |w - w(t)|",
            "steps with Δw < 0",
            "run",
        ];
        let table = crate::sheet::table(&header, table.collect());
        sheet.fold(
            &format!("{name}: orders and energies of every method"),
            vec![
                Block::Text(format!(
                    "Local orders from the median; energies at h = {FIGURE_STEP} on [0, 20]."
                )),
                table,
            ],
        );
        let curves = ["moddg", "rk4", "leapfrog"].map(|method| {
            let rows =
                runs.iter().find(|run| run.method == method).map_or(&[][..], |run| &run.rows);
            line(method, rows.iter().map(|row| (row.t, row.drift.abs())).collect())
        });
        let reservoir = over_time(&format!("{name}: energy"), Axis::linear("energy H"), {
            let rows = &runs[0].rows;
            vec![line("H", rows.iter().map(|row| (row.t, row.energy)).collect())]
        });
        let chart =
            over_time(&format!("{name}: deviation of K"), Axis::log("|K - K₀|"), curves.into());
        let left = sheet.figure(
            &format!("{name}-drift"),
            chart.draw(),
            "Deviation of K from its initial value.",
            &format!("{name}/energy"),
        );
        let right = sheet.figure(
            &format!("{name}-energy"),
            reservoir.draw(),
            "Energy of the system along the run of modDG.",
            &format!("{name}/energy"),
        );
        sheet.show_pair(left, right);
    }
    Ok(sheet)
}

/// Holds if modDG has order 2 in q, p and w and keeps K.
fn second_order_with_k(r: &Readings) -> Said {
    let medians = r.numbers("median");
    let second = |order: f64| (order - 2.0).abs() <= AGREEMENT;
    let has = medians.iter().filter(|(_, order)| second(*order));
    let has: Vec<_> = has.map(|(variable, _)| variable.to_string()).collect();
    let all = medians.iter().map(|(variable, order)| format!("{variable} {}", fixed(*order, 3)));
    let drift = |name: &str| r.number(name, "drift");
    let order = if has.len() == medians.len() {
        "modDG has order 2 in all variables".to_owned()
    } else {
        format!("modDG has order 2 in {} of the variables", list(has.iter().cloned()))
    };
    let (falls, steps) = (r.number("w", "falls"), r.number("w", "steps"));
    let reservoir = if falls == 0.0 {
        format!("w never falls in {steps} steps")
    } else {
        format!("w falls at {falls} of {steps} steps")
    };
    let statement = format!(
        "{order} (medians: {}) and {}. max |K - K₀|/K₀ is {} with moddg, {} with leapfrog and {} \
         with rk4. Along the run of moddg {reservoir}.",
        list(all),
        kept(drift("moddg")),
        sci(drift("moddg")),
        sci(drift("leapfrog")),
        sci(drift("rk4")),
    );
    let holds = has.len() == medians.len() && !medians.is_empty() && drift("moddg") <= KEPT;
    (verdict(holds), statement)
}
