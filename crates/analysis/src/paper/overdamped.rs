//! Perfect books, wrong decay: the overdamped oscillator at a step the explicit methods cannot take.

use super::methods;
use crate::Model;
use crate::chart::Axis;
use crate::progress::Silent;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, line, marked, over_time, scientific};
use crate::study::Problem;
use crate::study::decay::{self, Decay, DecayRow};
use crate::study::energy::{self, Books};
use afterbay_methods::registry::{METHODS, Row, find};

const STEP: f64 = 0.1;
/// The friction, and one at which e^{-b h} is beyond any order.
const FRICTION: [f64; 2] = [200.0, 5000.0];

fn problem(b: f64) -> Problem {
    Problem { model: Model::DampedOscillator { k: 1.0, b }, q: vec![1.0], p: vec![1.0], end: 2.0 }
}

pub(super) fn sheet() -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Perfect books, wrong decay");
    sheet.text(
        "Midpoint-type discrete gradients are A-stable but not L-stable: a stiff component is reflected, not damped. With \
         b = 200 and h = 0.1 from (1, 1) the momentum should be gone within the first step and the energy of the slow \
         motion fall by a thousandth a step.",
    );
    let problem = problem(FRICTION[0]);
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
        if let Some(failure) = &books.ending.failure {
            sheet.text(format!("{}: {failure}.", books.method));
        }
    }
    every_method(&mut sheet)?;
    let energies = |books: &Books| books.rows.iter().map(|row| (row.t, row.energy)).collect::<Vec<_>>();
    let solution = problem.solution(STEP / 10.0, (10.0 * problem.end / STEP).round() as usize, &Silent)?;
    let subject = problem.model.subject::<f64>()?;
    let exact =
        (0..).zip(solution.states()).map(|(i, state)| (f64::from(i) * STEP / 10.0, state.energy(&*subject)));
    let mut curves = vec![line("exact", exact.collect())];
    curves.extend(books[..2].iter().map(|books| marked(books.method, energies(books))));
    let fine = energy::run(&problem, &methods(&["moddg"]), STEP / 200.0, 200, &Silent)?;
    curves.push(marked("moddg, h = 0.0005", energies(&fine[0])));
    let exact = energy::run(&problem, &methods(&["locally-exact"]), STEP, 1, &Silent)?;
    curves.push(marked(exact[0].method, energies(&exact[0])));
    let chart = over_time("Energy of the overdamped oscillator, h = 0.1", Axis::linear("energy H"), curves);
    sheet.show(
        "overdamped",
        &chart,
        "Energy of the overdamped oscillator (b = 200). At h = 0.1 modDG and leap-frog reflect the momentum instead of \
         damping it and lose energy far too slowly at first; RK4 (not shown) explodes. At h = 0.0005 modDG lies on the \
         exact curve, and locally-exact does at h = 0.1.",
        "overdamped_energy",
    );
    Ok(sheet)
}

/// The table of all methods, at both frictions, and which of them are to be trusted.
fn every_method(sheet: &mut Sheet) -> Result<(), ReportError> {
    let all: Vec<&'static Row> = METHODS.iter().collect();
    let run = |b: f64| -> Result<Vec<DecayRow>, ReportError> {
        let problem = problem(b);
        let books = energy::run(&problem, &all, STEP, 1, &Silent)?;
        Ok(decay::rows(&problem, b, STEP, &books, &Silent)?)
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
        "Every method, from the same state with the same step: the energy ratio R of the second step beside the exact one, how far K moves in \
         20 steps, and what to make of both. A decay is called right where the loss 1 - R is within a tenth of itself; diverged is \
         what has more energy than at the start. The last column is the same at b = 5000.",
    );
    sheet.table(&header, table.collect());
    sheet.find("which methods to trust on an overdamped system", Verdict::Holds, trusted(&found, &stiffer));
    Ok(())
}

/// Those that are right, and which of them stay so.
fn trusted(found: &[DecayRow], stiffer: &[DecayRow]) -> String {
    let names = |wanted: &dyn Fn(&DecayRow, &DecayRow) -> bool| {
        let rows = found.iter().zip(stiffer).filter(|(row, stiffer)| wanted(row, stiffer));
        rows.map(|(row, _)| row.method).collect::<Vec<_>>()
    };
    let both = names(&|row, stiffer| row.decay.is_right() && stiffer.decay.is_right());
    let once = names(&|row, stiffer| row.decay.is_right() && !stiffer.decay.is_right());
    let books = names(&|row, _| row.decay == Decay::WrongWithK);
    let l_stable = both.iter().all(|name| find(name).is_some_and(|row| row.l_stable));
    format!(
        "trust {}: right at b = 200 and at b = 5000{}. {} right at b = 200 only: there the order still resolves \
         e^{{-bh}} = e^{{-20}}, beyond it they reflect as moddg does. {} methods keep K exactly and decay wrongly.",
        both.join(" and "),
        if l_stable {
            ", for they are L-stable, R(∞) = 0: what is fast against the step is gone after it"
        } else {
            ""
        },
        match once.as_slice() {
            [] => "None is".into(),
            [one] => format!("{one} is"),
            all => format!("{} are", all.join(", ")),
        },
        books.len(),
    )
}
