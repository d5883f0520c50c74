//! Perfect books, wrong decay: the overdamped oscillator at a step the explicit methods cannot take.

use super::sheet::{Sheet, line, marked, over_time};
use super::{PaperError, methods};
use crate::Model;
use crate::chart::Axis;
use crate::progress::Silent;
use crate::report::Verdict;
use crate::study::Problem;
use crate::study::energy::{self, Books};

const STEP: f64 = 0.1;

pub(super) fn sheet() -> Result<Sheet, PaperError> {
    let mut sheet = Sheet::new("Perfect books, wrong decay");
    sheet.text(
        "Midpoint-type discrete gradients are A-stable but not L-stable: a stiff component is reflected, not damped. With \
         b = 200 and h = 0.1 from (1, 1) the momentum should be gone within the first step and the energy of the slow \
         motion fall by a thousandth a step.",
    );
    let model = Model::DampedOscillator { k: 1.0, b: 200.0 };
    let problem = Problem { model, q: vec![1.0], p: vec![1.0], end: 2.0 };
    let books = energy::run(&problem, &methods(&["moddg", "leapfrog", "rk4"]), STEP, 1, &Silent)?;
    let rows: Vec<_> = books.iter().flat_map(|books| &books.rows).collect();
    sheet.wide_data("overdamped_energy", &energy::columns(1), &rows)?;

    let ratio = |books: &Books, step: usize| books.rows.get(step).and_then(|row| row.ratio);
    let exact = |books: &Books, step: usize| {
        let row = books.rows.get(step)?;
        Some(row.ratio? - row.ratio_error?)
    };
    let moddg = &books[0];
    let filling = moddg.violations == Some(0);
    let verdict = match (ratio(moddg, 2), exact(moddg, 2)) {
        (Some(found), Some(exact)) if (found - exact).abs() < 0.01 => Verdict::Holds,
        _ => Verdict::Fails,
    };
    sheet.find("perfect books mean a right decay", verdict, format!(
        "in the second step the energy ratio is exactly {} and modDG gives {}, with K kept to {:.0e} and w {}.",
        exact(moddg, 2).map_or(String::new(), |ratio| format!("{ratio:.4}")),
        ratio(moddg, 2).map_or(String::new(), |ratio| format!("{ratio:.4}")),
        moddg.drift,
        if filling { "rising at every step" } else { "falling at some steps" },
    ));
    let table = (1..=8).map(|step| {
        let mut cells =
            vec![step.to_string(), exact(moddg, step).map_or(String::new(), |ratio| format!("{ratio:.4}"))];
        cells.extend(
            books.iter().map(|books| ratio(books, step).map_or(String::new(), |ratio| format!("{ratio:.4}"))),
        );
        cells
    });
    sheet.table(&["step", "R exact", "R moddg", "R leapfrog", "R rk4"], table.collect());
    for books in &books {
        if let Err(error) = &books.result {
            sheet.text(format!("{}: {error}.", books.method));
        }
    }
    let energies = |books: &Books| books.rows.iter().map(|row| (row.t, row.energy)).collect::<Vec<_>>();
    let solution = problem.solution(STEP / 10.0, (10.0 * problem.end / STEP).round() as usize)?;
    let subject = problem.model.subject::<f64>()?;
    let exact =
        (0..).zip(solution.states()).map(|(i, state)| (f64::from(i) * STEP / 10.0, state.energy(&*subject)));
    let mut curves = vec![line("exact", exact.collect())];
    curves.extend(books[..2].iter().map(|books| marked(books.method, energies(books))));
    let fine = energy::run(&problem, &methods(&["moddg"]), STEP / 200.0, 200, &Silent)?;
    curves.push(marked("moddg, h = 0.0005", energies(&fine[0])));
    let chart = over_time("Energy of the overdamped oscillator, h = 0.1", Axis::linear("energy H"), curves);
    sheet.show(
        "overdamped",
        &chart,
        "Energy of the overdamped oscillator (b = 200). At h = 0.1 modDG and leap-frog reflect the momentum instead of \
         damping it and lose energy far too slowly at first; RK4 (not shown) explodes. At h = 0.0005 modDG lies on the \
         exact curve.",
        "overdamped_energy",
    );
    Ok(sheet)
}
