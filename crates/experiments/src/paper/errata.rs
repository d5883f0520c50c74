//! The coefficients of the paper's δ: from the exact flow, in closed form, and as printed.

use super::{Paper, Part};
use crate::claim::{Readings, Said, sci, verdict};
use crate::sheet::{ReportError, Sheet};
use afterbay_core::{
    Correction, InputError, Misprinted, OrderRaising, Quad, Scalar, Series, larger_or_nan, taylor,
};
use afterbay_systems::DampedOscillator;
use serde::Serialize;

pub(super) const PART: Part =
    Part { heading: "Errata of the printed coefficients", methods: &[], sheet };

/// A row of `errata.csv`.
#[derive(Clone, Debug, Serialize)]
struct Erratum {
    coefficient: &'static str,
    b: f64,
    q: f64,
    p: f64,
    /// From the Taylor series of the exact flow, in 106 bits.
    from_the_flow: f64,
    closed_form: f64,
    as_printed: f64,
}

const POINTS: [[f64; 3]; 3] = [[0.1, 2.3, -3.1], [0.1, 1.0, 0.5], [0.0, 2.3, -3.1]];

/// The largest error of a coefficient c that counts as right, relative to 1 + |c|.
const RIGHT: f64 = 1e-12;

fn sheet(_paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    let mut rows = Vec::new();
    for [b, q, p] in POINTS {
        rows.extend(errata(b, q, p)?);
    }
    sheet.data("errata", &rows)?;
    sheet.text(
        "δ₃ and δ₄ follow from the exact flow: δ(q) = Δq/p̄ and δ(p) = Δp/(ΔV/Δq + D̄)·(-1), \
         expanded in h. Here they are computed that way, in 106 bits and without any algebra, \
         beside closed forms and the printed ones. The closed forms are the printed ones with \
         these changes: δ₄(q) has the term -p'''/(24 p), which is missing in print; δ₃(p) has 2bp \
         for \"22bp\"; δ₄(p) = -b (p² + q² + b p q)/(24 (q + b p)²).",
    );
    for coefficient in ["δ3(q)", "δ4(q)", "δ3(p)", "δ4(p)"] {
        let off = |value: fn(&Erratum) -> f64| {
            let of = rows.iter().filter(|row| row.coefficient == coefficient);
            let share = |row: &Erratum| {
                (value(row) - row.from_the_flow).abs() / (1.0 + row.from_the_flow.abs())
            };
            of.map(share).reduce(larger_or_nan)
        };
        let readings = Readings::default()
            .and("the printed form", "off the flow by", off(|row| row.as_printed))
            .and("the closed form", "off the flow by", off(|row| row.closed_form));
        sheet.find(&format!("coefficient {coefficient}"), readings, as_printed);
    }
    let cells = |row: &Erratum| {
        // Adding 0 turns a coefficient of -0 into 0.
        let number = |x: f64| format!("{:.9}", x + 0.0);
        let mut cells = vec![
            row.coefficient.to_string(),
            row.b.to_string(),
            row.q.to_string(),
            row.p.to_string(),
        ];
        cells.extend([row.from_the_flow, row.closed_form, row.as_printed].map(number));
        cells
    };
    sheet.table(
        &["coefficient", "b", "q", "p", "from the flow", "closed form", "as printed"],
        rows.iter().map(cells).collect(),
    );
    Ok(sheet)
}

/// Holds if the printed coefficient is that of the flow.
fn as_printed(r: &Readings) -> Said {
    let of = |form: &str| r.number(form, "off the flow by");
    let (theirs, ours) = (of("the printed form"), of("the closed form"));
    let says = match (theirs <= RIGHT, ours <= RIGHT) {
        (true, true) => "right as printed, and the closed form with it",
        (true, false) => "right as printed, and the closed form is not",
        (false, true) => "not right as printed; the closed form is",
        (false, false) => "not right as printed, nor is the closed form",
    };
    let statement = format!(
        "{says}. Beside the flow the printed form is off by {}, the closed form by {}.",
        share(theirs),
        share(ours)
    );
    (verdict(theirs <= RIGHT), statement)
}

/// A relative error in words.
fn share(error: f64) -> String {
    if error < 1e-15 { "no more than rounding".into() } else { format!("up to {}", sci(error)) }
}

fn errata(b: f64, q: f64, p: f64) -> Result<Vec<Erratum>, InputError> {
    let system = DampedOscillator::new(1.0, b)?;
    let exact = system.map(|x| Series::constant(Quad::from_f64(x)));
    let flow = taylor::corrections(&exact, Quad::from_f64(q), Quad::from_f64(p));
    let closed = [system.delta_q(q, p), system.delta_p(q, p)];
    let printed = [system.printed_delta_q(q, p), system.printed_delta_p(q, p)];
    let names = [["δ3(q)", "δ4(q)"], ["δ3(p)", "δ4(p)"]];
    let both = |correction: Correction<f64>| [correction.third, correction.fourth];
    let mut rows = Vec::new();
    for (equation, names) in names.into_iter().enumerate() {
        let flow = [flow[equation].third, flow[equation].fourth].map(Scalar::to_f64);
        let (closed, printed) = (both(closed[equation]), both(printed[equation]));
        for (i, coefficient) in names.into_iter().enumerate() {
            let (from_the_flow, closed_form, as_printed) = (flow[i], closed[i], printed[i]);
            rows.push(Erratum { coefficient, b, q, p, from_the_flow, closed_form, as_printed });
        }
    }
    Ok(rows)
}
