//! What the paper announces but does not show: the same study for Duffing, Van der Pol and modified Van der Pol.

use super::{BASE_STEP, Extent, FIGURE_STEP, STEPS, methods};
use crate::Model;
use crate::chart::Axis;
use crate::progress::Progress;
use crate::report::{Block, Verdict};
use crate::sheet::{ReportError, Sheet, decimal, line, over_time, scientific};
use crate::study::local_order::{LocalOrder, Statistic, rows};
use crate::study::{Problem, VARIABLES, energy};

/// The problems by the names of their folders. Only the names of the systems are the paper's: it does not define them.
pub(super) fn problems() -> [(&'static str, Problem); 4] {
    [
        (
            "duffing",
            Problem {
                model: Model::Duffing { alpha: 1.0, beta: 0.5, c: 0.1 },
                q: vec![2.3],
                p: vec![-3.1],
                end: 20.0,
            },
        ),
        (
            "duffing-double-well",
            Problem {
                model: Model::Duffing { alpha: -1.0, beta: 1.0, c: 0.1 },
                q: vec![1.5],
                p: vec![0.5],
                end: 20.0,
            },
        ),
        (
            "van-der-pol",
            Problem { model: Model::VanDerPol { mu: 1.0 }, q: vec![2.0], p: vec![0.5], end: 20.0 },
        ),
        (
            "modified-van-der-pol",
            Problem {
                model: Model::ModifiedVanDerPol { mu: 1.0, alpha: -1.0, beta: 1.0 },
                q: vec![2.0],
                p: vec![0.5],
                end: 20.0,
            },
        ),
    ]
}

const STUDIED: [&str; 7] =
    ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-p4-shared", "moddg-qp3", "moddg-qp4"];

pub(super) fn sheet(extent: Extent, progress: &dyn Progress) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Announced but not shown: Duffing, Van der Pol, modified Van der Pol");
    sheet.text(
        "The paper names these systems without defining them. Ours: Duffing V = α q²/2 + β q⁴/4 with D = c p, single well \
         (α = 1, β = 0.5, c = 0.1) and double well (α = -1, β = 1, c = 0.1); Van der Pol V = q²/2 with D = -μ (1 - q²) p, \
         μ = 1; modified Van der Pol: that D on the double-well Duffing potential. The same study as above, with the \
         same base grid and steps, against Taylor series that are exact to rounding; δ comes from such series as well.",
    );
    let base_step = extent.pick(BASE_STEP, 0.01);
    let steps = extent.pick(STEPS.to_vec(), vec![0.04, 0.03, 0.02]);
    let study = LocalOrder { base_step, steps };
    let rows_of = methods(&STUDIED);
    for (name, problem) in problems() {
        progress.begin(&format!("local errors and books of {name}"), rows_of.len() * (study.steps.len() + 1));
        let errors = study.run::<f64>(&problem, &rows_of, progress)?;
        let orders = rows(&errors, |_, _, _| None);
        sheet.data(&format!("{name}/local_orders"), &orders)?;
        let median = |method: &str, variable: &str| {
            let mut of = orders.iter().filter(|row| row.method == method && row.variable == variable);
            of.find(|row| row.statistic == Statistic::Median.name()).and_then(|row| row.order)
        };

        let books = energy::run(&problem, &rows_of, FIGURE_STEP, 1, progress)?;
        let all: Vec<_> = books.iter().flat_map(|books| &books.rows).collect();
        sheet.wide_data(&format!("{name}/energy"), &energy::columns(problem.model.dof()), &all)?;

        let drift = |method: &str| {
            books.iter().find(|books| books.method == method).map_or(f64::NAN, |books| books.drift)
        };
        let (least, most) = ["q", "p", "w"]
            .iter()
            .filter_map(|variable| median("moddg", variable))
            .fold((f64::MAX, f64::MIN), |(least, most), order| (least.min(order), most.max(order)));
        let holds = drift("moddg") < 1e-12 && (least - 2.0).abs() < 0.1 && (most - 2.0).abs() < 0.1;
        let nature = if books.iter().any(|books| books.violations.is_some()) {
            "passive"
        } else {
            "active: it feeds and drains the reservoir by turns"
        };
        sheet.find(&format!("modDG on {name}"), if holds { Verdict::Holds } else { Verdict::Fails }, format!(
            "modDG has order 2 in q, p and w (medians {least:.3} to {most:.3}) and keeps K to {:.0e} where leap-frog drifts by {:.0e} and RK4 by {:.0e}. The system is {nature}.",
            drift("moddg"), drift("leapfrog"), drift("rk4"),
        ));
        let table = rows_of.iter().zip(&books).map(|(row, books)| {
            let mut cells = vec![row.name.to_string()];
            cells.extend(VARIABLES.map(|variable| decimal(median(row.name, variable))));
            let w_error = books.rows.iter().map(|row| row.w_error.abs()).fold(0.0, f64::max);
            cells.extend([scientific(Some(books.drift)), scientific(Some(w_error))]);
            cells.push(books.violations.map_or("none owed".into(), |count| count.to_string()));
            cells.push(books.ending.describe());
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
            &format!("{name}: orders and books of every method"),
            vec![
                Block::Text(format!("Local orders from the median; books at h = {FIGURE_STEP} on [0, 20].")),
                table,
            ],
        );
        let curves = ["moddg", "rk4", "leapfrog"].map(|method| {
            let rows = books.iter().find(|books| books.method == method).map_or(&[][..], |books| &books.rows);
            line(method, rows.iter().map(|row| (row.t, row.drift.abs())).collect())
        });
        let reservoir = over_time(&format!("{name}: energy"), Axis::linear("energy H"), {
            let rows = &books[0].rows;
            vec![line("H", rows.iter().map(|row| (row.t, row.energy)).collect())]
        });
        let chart = over_time(&format!("{name}: deviation of K"), Axis::log("|K - K₀|"), curves.into());
        let left = sheet.figure(
            &format!("{name}-drift"),
            chart.svg(),
            "Deviation of K from its initial value.",
            &format!("{name}/energy"),
        );
        let right = sheet.figure(
            &format!("{name}-energy"),
            reservoir.svg(),
            "Energy of the system along the run of modDG.",
            &format!("{name}/energy"),
        );
        sheet.show_pair(left, right);
    }
    Ok(sheet)
}
