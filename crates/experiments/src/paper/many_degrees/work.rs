//! Work against precision on a long chain and on the double pendulum.

use super::orders::{ANY, SEPARABLE};
use super::{chain, pendulum};
use crate::findings::work::{HEADER, cells, cheapest};
use crate::findings::work_charts::{Runs, TIME, as_measured};
use crate::manifest::RunOutcome;
use crate::paper::{Extent, Paper};
use crate::sheet::{ReportError, Sheet, scientific, table};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::work_precision;
use afterbay_core::larger_or_nan;
use afterbay_methods::registry::ADAPTIVE;

/// The chain whose runs are timed.
pub(super) fn long_chain(extent: Extent) -> Problem {
    chain(extent.pick(64, 24), extent.pick(20.0, 2.0))
}

/// The pendulum whose runs are timed.
pub(super) fn long_pendulum(extent: Extent) -> Problem {
    pendulum(extent.pick(10.0, 2.0))
}

pub(in crate::paper) fn add(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let Paper { extent, progress, .. } = *paper;
    let count = extent.pick(5, 3);
    let steps: Vec<f64> = (0..count).map(|k| 0.2 / f64::from(1 << k)).collect();
    let tolerances: Vec<f64> = (0..count).map(|k| 10_f64.powi(-3 - 2 * k)).collect();
    let adaptive: Vec<_> = ADAPTIVE.iter().collect();
    for (name, problem, names) in [
        ("fput-chain", long_chain(extent), &SEPARABLE[..]),
        ("damped-double-pendulum", long_pendulum(extent), &ANY),
    ] {
        let rows = paper.methods(names)?;
        let runs = rows.len() * steps.len() + adaptive.len() * tolerances.len();
        progress.begin(&format!("cost of accuracy: {name}"), 2 * runs);
        let all = work_precision::Runs {
            methods: &rows,
            steps: &steps,
            adaptive: &adaptive,
            tolerances: &tolerances,
        };
        let found = work_precision::run(&problem, all, progress)?;
        let doubt = found
            .iter()
            .map(|row| larger_or_nan(row.doubt_qp, row.doubt_w))
            .fold(0.0, larger_or_nan);
        let data = format!("{name}/work_precision");
        sheet.data(&data, &found)?;
        sheet.runs.extend(found.iter().map(|row| RunOutcome::of_work(row, problem.model.name())));
        let title = format!("{name} with N = {}", problem.model.dof());
        cheapest(sheet, &title, &found);
        let methods: Vec<_> =
            names.iter().copied().chain(ADAPTIVE.iter().map(|row| row.name)).collect();
        let (end, methods, curve) = (problem.end, &methods[..], as_measured);
        let runs = Runs { name: Some(&title), end, methods, found: &found, curve };
        let [mut qp, w] = runs.against(&TIME);
        if doubt > 0.0 {
            qp.1 += &format!(" The doubt of the reference is {}.", scientific(Some(doubt)));
        }
        let [left, right] = [qp, w].map(|(file, caption, chart)| {
            sheet.figure(&format!("{name}-{file}"), chart.draw(), caption, &data)
        });
        sheet.show_pair(left, right);
        let table = table(&HEADER, found.iter().map(cells).collect());
        sheet.fold(&format!("{title}: every run"), vec![table]);
    }
    Ok(())
}
