//! Systems that the paper announces without results: the same study for Duffing, Van der Pol and
//! modified Van der Pol.

use super::{BASE_STEP, FIGURE_STEP, Paper, Part, STEPS};
use crate::chart::Axis;
use crate::claim::{Readings, Said, fixed, list, sci, verdict};
use crate::findings::{KEPT, kept};
use crate::report::Block;
use crate::sheet::{ReportError, Sheet, decimal, line, over_time, scientific, table};
use afterbay_analysis::Model;
use afterbay_analysis::study::energy::EnergyRun;
use afterbay_analysis::study::local_order::{LocalOrder, OrderRow, Statistic, rows};
use afterbay_analysis::study::{Problem, VARIABLES, energy};
use afterbay_core::larger_or_nan;
use afterbay_systems::{DUFFING, MODIFIED_VAN_DER_POL, VAN_DER_POL};

/// The problems, by the names of their folders. The paper names these systems without defining
/// them.
pub(super) fn problems() -> [(&'static str, Problem); 4] {
    let problem = |model, q, p| Problem { model, q: vec![q], p: vec![p], end: 20.0 };
    let duffing = |parameters: [f64; 3]| Model::of(&DUFFING, &parameters);
    let modified = Model::of(&MODIFIED_VAN_DER_POL, &[1.0, -1.0, 1.0]);
    [
        ("duffing", problem(duffing([1.0, 0.5, 0.1]), 2.3, -3.1)),
        ("duffing-double-well", problem(duffing([-1.0, 1.0, 0.1]), 1.5, 0.5)),
        ("van-der-pol", problem(Model::of(&VAN_DER_POL, &[1.0]), 2.0, 0.5)),
        ("modified-van-der-pol", problem(modified, 2.0, 0.5)),
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
    let methods = paper.methods(&STUDIED)?;
    for (name, problem) in problems() {
        progress.begin(
            &format!("local errors and energies of {name}"),
            methods.len() * (study.steps.len() + 1),
        );
        let errors = study.run::<f64>(&problem, &methods, progress)?;
        let orders = rows(&errors, |_, _, _| None);
        sheet.data(&format!("{name}/local_orders"), &orders)?;
        let runs = energy::run(&problem, &methods, FIGURE_STEP, 1, progress)?;
        let states: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
        sheet.wide_data(&format!("{name}/energy"), &energy::columns(&problem.model), &states)?;
        let found = Found { orders, runs };
        sheet.find(&format!("modDG on {name}"), found.readings(), second_order_with_k);
        let text =
            format!("Local orders from the median; energies at h = {FIGURE_STEP} on [0, 20].");
        let cells = found.runs.iter().map(|run| found.cells(run));
        sheet.fold(
            &format!("{name}: orders and energies of every method"),
            vec![Block::Text(text), table(&HEADER, cells.collect())],
        );
        found.charts(&mut sheet, name);
    }
    Ok(sheet)
}

/// The orders and the energies of every method on a system.
struct Found {
    orders: Vec<OrderRow>,
    runs: Vec<EnergyRun>,
}

const HEADER: [&str; 8] = [
    "method",
    "median order q",
    "p",
    "w",
    "max |K - K₀|",
    "max |w - w(t)|",
    "steps with Δw < 0",
    "run",
];

impl Found {
    fn median(&self, method: &str, variable: &str) -> Option<f64> {
        OrderRow::find(&self.orders, method, variable, Statistic::Median)?.order
    }

    fn run(&self, method: &str) -> Option<&EnergyRun> {
        self.runs.iter().find(|run| run.method == method)
    }

    fn readings(&self) -> Readings {
        let drift = |run: &EnergyRun| {
            let done = run.ending.is_completed().then_some(run.drift);
            Some(done? / run.rows.first()?.energy.abs())
        };
        let falls =
            |run: &EnergyRun| run.rows.windows(2).filter(|pair| pair[1].w < pair[0].w).count();
        let mut readings = VARIABLES.iter().fold(Readings::default(), |r, variable| {
            r.and(variable, "median", self.median("moddg", variable))
        });
        for method in ["moddg", "leapfrog", "rk4"] {
            readings.add(method, "drift", self.run(method).and_then(drift));
        }
        let own = self.run("moddg");
        readings.add("w", "steps", own.map(|run| run.rows.len() as f64 - 1.0));
        readings.add("w", "falls", own.map(|run| falls(run) as f64));
        readings
    }

    fn cells(&self, run: &EnergyRun) -> Vec<String> {
        let mut cells = vec![run.method.to_string()];
        cells.extend(VARIABLES.map(|variable| decimal(self.median(run.method, variable))));
        let w_error = run.rows.iter().map(|row| row.w_error.abs()).fold(0.0, larger_or_nan);
        cells.extend([scientific(Some(run.drift)), scientific(Some(w_error))]);
        cells.push(run.violations.map_or("not counted".into(), |count| count.to_string()));
        cells.push(run.ending.describe());
        cells
    }

    /// Shows the deviation of K of three methods, and the energy of the first method.
    fn charts(&self, sheet: &mut Sheet, name: &str) {
        let data = format!("{name}/energy");
        let drifts = ["moddg", "rk4", "leapfrog"].map(|method| {
            let rows = self.run(method).map_or(&[][..], |run| &run.rows);
            line(method, rows.iter().map(|row| (row.t, row.drift.abs())).collect())
        });
        let title = format!("{name}: deviation of K");
        let drift = over_time(&title, Axis::log("|K - K₀|"), drifts.into()).draw();
        let caption = "Deviation of K from its initial value.";
        let left = sheet.figure(&format!("{name}-drift"), drift, caption, &data);
        let rows = self.runs[0].rows.iter().map(|row| (row.t, row.energy));
        let (title, y) = (format!("{name}: energy"), Axis::linear("energy H"));
        let energy = over_time(&title, y, vec![line("H", rows.collect())]).draw();
        let caption = "Energy of the system along the run of modDG.";
        let right = sheet.figure(&format!("{name}-energy"), energy, caption, &data);
        sheet.show_pair(left, right);
    }
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
