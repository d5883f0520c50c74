//! Figures 3.1 to 3.4: the empirical orders of the δ variants.

mod claims;

use super::{BASE_STEP, FIGURE_STEP, Paper, Part, STEPS, oscillator};
use crate::chart::{Axis, LineChart};
use crate::claim::Readings;
use crate::report::Block;
use crate::sheet::{ReportError, Sheet, decimal, marked, scientific};
use afterbay_analysis::study::local_order::{LocalErrors, LocalOrder, OrderRow, Statistic, rows};
use afterbay_analysis::study::{VARIABLES, energy};
use afterbay_core::Quad;
use afterbay_methods::registry::Row;

pub(super) const PART: Part = Part {
    heading: "Orders: figures 3.1 to 3.4",
    methods: &[&WITH_Q3, &WITH_P4, &[RAISED_EACH], &ON_HORIZONS],
    sheet,
};

/// Whether a method is one of the paper's, or a variant of its δ.
fn is_of_the_paper(row: &Row) -> bool {
    row.name.starts_with("moddg") || ["leapfrog", "rk4"].contains(&row.name)
}

/// The orders of q, p and w printed in the paper, read from the maxima, with δ₃(q) ...
const PRINTED_Q3: [f64; 3] = [2.99811, 2.98861, 2.0];
/// ... and with δ₄(p). (The order of p is printed as "2.3.89048".)
const PRINTED_P4: [f64; 3] = [7.83681, 3.89048, 7.7702];

/// The variants that the paper may mean by δ₃(q). The first has one δ in all three equations.
const WITH_Q3: [&str; 3] = ["moddg-q3-shared", "moddg-q3-single", "moddg-qp3"];
/// The variants that the paper may mean by δ₄(p). The first has one δ in all three equations.
const WITH_P4: [&str; 5] = [
    "moddg-p4-shared",
    "moddg-p4-single",
    "moddg-p4-shared-printed",
    "moddg-p4-single-printed",
    "moddg-qp4",
];
/// The method with separate δ up to h⁴ in the equations of q and p.
const RAISED_EACH: &str = "moddg-qp4";
/// The methods whose orders are computed on other horizons too.
const ON_HORIZONS: [&str; 3] = ["moddg-q3-shared", "moddg-p4-shared", "moddg-p4-single"];

fn printed(method: &str, variable: &str, statistic: Statistic) -> Option<f64> {
    let column = VARIABLES.iter().position(|&name| name == variable)?;
    let values = if WITH_Q3.contains(&method) {
        PRINTED_Q3
    } else if WITH_P4.contains(&method) {
        PRINTED_P4
    } else {
        return None;
    };
    (statistic == Statistic::Max).then_some(values[column])
}

/// The orders of every variant, and its drift of K relative to the energy at the start.
struct Found {
    orders: Vec<OrderRow>,
    drifts: Vec<(&'static str, f64)>,
}

impl Found {
    fn row(&self, method: &str, column: usize, statistic: Statistic) -> Option<&OrderRow> {
        OrderRow::find(&self.orders, method, VARIABLES[column], statistic)
    }

    fn order(&self, method: &str, column: usize, statistic: Statistic) -> Option<f64> {
        self.row(method, column, statistic)?.order
    }

    fn drift(&self, method: &str) -> Option<f64> {
        self.drifts.iter().find(|(name, _)| *name == method).map(|(_, drift)| *drift)
    }
}

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    let study = LocalOrder { base_step: BASE_STEP, steps: STEPS.to_vec() };
    let all: Vec<_> = paper.registry.iter().filter(|row| is_of_the_paper(row)).collect();
    paper.progress.begin("local errors of every method", all.len() * (STEPS.len() + 1));
    let errors = study.run::<Quad>(&oscillator(), &all, paper.progress)?;
    let found = Found { orders: rows(&errors, printed), drifts: drifts(paper, &all)? };
    sheet.data("local_orders", &found.orders)?;
    sheet.text(
        "One step with each of the paper's six h is taken from each of the 20 001 points of the \
         base grid (spacing 0.001, on [0, 20], q₀ = 2.3, p₀ = -3.1, b = 0.1). The order is the \
         slope of log statistic(T) against log h. All of this is computed in 106 bits, so that the \
         paper's tolerance of 1e-18 is met and errors stay above rounding. The paper reads its \
         orders from the maximum over the grid. A single grid point determines the maximum, while \
         all points determine the median. The drift of K is that of a whole run in f64.",
    );
    let topics = ["figure 3.1", "figure 3.2", "section 4, order of w with δ₃(q)"];
    compare(&mut sheet, &found, topics, &WITH_Q3, PRINTED_Q3);
    let topics = ["figure 3.3", "figure 3.4", "section 4, order of w with δ₄(p)"];
    compare(&mut sheet, &found, topics, &WITH_P4, PRINTED_P4);
    sheet.text(
        "Figure 3.4 is captioned δ₄(q) and prints \"2.3.89048\"; both are read as misprints, of \
         δ₄(p) as in the text above it and of 3.89048.",
    );
    sheet.find(
        "section 4, \"order of the method is p_e = p_t = 4\"",
        of_all(&found, &all),
        claims::fourth_order,
    );
    sheet.find("a δ of its own in each equation", of_each(&found), claims::raised_each);
    let on_horizons = horizons(paper, &study)?;
    sheet.find(
        "orders from the maximum, on other horizons",
        spreads(&on_horizons),
        claims::hang_on_the_horizon,
    );
    for chart in CHARTS {
        chart.show(&mut sheet, &errors);
    }
    sheet.text("The orders of every variant, from the maximum and from the median:");
    sheet.table(&ORDER_HEADER, all.iter().map(|row| cells(&found, row.name)).collect());
    let text = Block::Text("The same regression on other horizons.".into());
    let table = crate::sheet::table(&HORIZON_HEADER, horizon_rows(&on_horizons));
    sheet.fold("How the orders depend on the horizon", vec![text, table]);
    Ok(sheet)
}

/// max |K - K₀| of each method over the paper's run, relative to the energy at the start.
fn drifts(
    paper: &Paper<'_>,
    all: &[&'static Row],
) -> Result<Vec<(&'static str, f64)>, ReportError> {
    let runs = energy::run(&oscillator(), all, FIGURE_STEP, u64::MAX, paper.progress)?;
    let drift = |run: &energy::EnergyRun| {
        let done = run.ending.is_completed().then_some(run.drift);
        let start = run.rows.first().map_or(f64::NAN, |row| row.energy);
        (run.method, done.unwrap_or(f64::NAN) / start)
    };
    Ok(runs.iter().map(drift).collect())
}

/// Compares the printed orders of q, p and w with those of the scheme with one δ and with those of
/// the variant that fits best.
fn compare(
    sheet: &mut Sheet,
    found: &Found,
    topics: [&str; 3],
    variants: &[&str],
    printed: [f64; 3],
) {
    for (column, topic) in topics.into_iter().enumerate() {
        let of = |names: &[&str]| {
            let paper = Readings::default().and(VARIABLES[column], "printed", printed[column]);
            names.iter().fold(paper, |r, name| {
                r.and(name, "maximum", found.order(name, column, Statistic::Max))
                    .and(name, "median", found.order(name, column, Statistic::Median))
                    .and(name, "drift", found.drift(name))
            })
        };
        let scheme = variants[0];
        let row = found.row(scheme, column, Statistic::Max);
        let readings = of(&[scheme]).and(scheme, "worst t", row.map(|row| row.worst_t)).and(
            scheme,
            "distance to the pole",
            row.and_then(|row| row.pole_distance),
        );
        sheet.find(&format!("{topic}, the scheme with one δ"), readings, claims::the_scheme);
        sheet.find(&format!("{topic}, what fits"), of(variants), claims::what_fits);
    }
}

fn of_all(found: &Found, all: &[&'static Row]) -> Readings {
    all.iter().filter(|row| row.name.starts_with("moddg")).fold(Readings::default(), |r, row| {
        let orders = (0..3).map(|column| found.order(row.name, column, Statistic::Median));
        let least = orders.reduce(|a, b| Some(a?.min(b?))).flatten();
        r.and(row.name, "least order", least).and(row.name, "drift", found.drift(row.name))
    })
}

fn of_each(found: &Found) -> Readings {
    (0..3)
        .fold(Readings::default(), |r, column| {
            let median = found.order(RAISED_EACH, column, Statistic::Median);
            r.and(VARIABLES[column], "median", median)
        })
        .and(RAISED_EACH, "drift", found.drift(RAISED_EACH))
}

const ORDER_HEADER: [&str; 10] = [
    "method",
    "max q",
    "max p",
    "max w",
    "median q",
    "median p",
    "median w",
    "printed q, p, w",
    "worst q: |pole|",
    "K off by",
];

fn cells(found: &Found, method: &str) -> Vec<String> {
    let mut cells = vec![method.to_string()];
    for statistic in [Statistic::Max, Statistic::Median] {
        cells.extend((0..3).map(|column| decimal(found.order(method, column, statistic))));
    }
    let shown = |column: usize| printed(method, VARIABLES[column], Statistic::Max);
    let shown: Vec<_> = (0..3).filter_map(shown).map(|order| order.to_string()).collect();
    cells.push(shown.join(", "));
    cells.push(scientific(found.row(method, 0, Statistic::Max).and_then(|row| row.pole_distance)));
    cells.push(scientific(found.drift(method).filter(|drift| !drift.is_nan())));
    cells
}

/// The chart of a figure of the paper: the local error of a variable, with two variants of δ.
struct Chart {
    number: &'static str,
    delta: &'static str,
    variants: [&'static str; 2],
    column: usize,
    /// The slopes of guide lines.
    guides: &'static [f64],
}

const CHARTS: [Chart; 4] = {
    let q3 = ["moddg-q3-shared", "moddg-qp3"];
    let p4 = ["moddg-p4-shared", "moddg-p4-single-printed"];
    [
        Chart { number: "3.1", delta: "δ₃(q)", variants: q3, column: 0, guides: &[3.0] },
        Chart { number: "3.2", delta: "δ₃(q)", variants: q3, column: 1, guides: &[2.0, 3.0] },
        Chart { number: "3.3", delta: "δ₄(p)", variants: p4, column: 0, guides: &[2.0] },
        Chart { number: "3.4", delta: "δ₄(p)", variants: p4, column: 1, guides: &[2.0, 3.0] },
    ]
};

impl Chart {
    fn show(&self, sheet: &mut Sheet, errors: &[LocalErrors]) {
        let Self { number, delta, variants, column, guides } = *self;
        let variable = VARIABLES[column];
        let what = format!("{number}: local error of {variable} with {delta}");
        let curves = variants.iter().flat_map(|name| {
            [Statistic::Max, Statistic::Median].map(|statistic| {
                let of = errors.iter().filter(|errors| errors.method.name == *name);
                let mut points: Vec<_> =
                    of.map(|errors| (errors.h, errors.variables[column].get(statistic))).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                marked(&format!("{name}, {}", statistic.name()), points)
            })
        });
        let chart = LineChart {
            title: format!("Figure {what}"),
            x: Axis::log("step h"),
            y: Axis::log(format!("local error |T| of {variable}")),
            curves: curves.collect(),
            guides: guides.to_vec(),
        };
        let name = format!("figure-{}", number.replace('.', "-"));
        let caption = format!(
            "The paper's figure {what}. Maximum and median over the base grid at the paper's six \
             steps."
        );
        sheet.show(&name, &chart, caption, "local_orders");
    }
}

/// Orders on several horizons, for each method.
fn horizons(
    paper: &Paper<'_>,
    study: &LocalOrder,
) -> Result<Vec<(f64, Vec<OrderRow>)>, ReportError> {
    let variants = paper.methods(&ON_HORIZONS)?;
    let ends = [2.0, 5.0, 10.0, 20.0, 40.0];
    paper.progress.begin("orders on other horizons", variants.len() * STEPS.len());
    let found = study.run_on_horizons::<Quad>(&oscillator(), &ends, &variants, paper.progress)?;
    Ok(ends.into_iter().zip(found.iter().map(|errors| rows(errors, |_, _, _| None))).collect())
}

const HORIZON_HEADER: [&str; 8] =
    ["method", "horizon", "max q", "max p", "max w", "median q", "median p", "median w"];

fn horizon_rows(on_horizons: &[(f64, Vec<OrderRow>)]) -> Vec<Vec<String>> {
    let mut table = Vec::new();
    for method in ON_HORIZONS {
        for (end, orders) in on_horizons {
            let mut cells = vec![method.to_string(), end.to_string()];
            for statistic in [Statistic::Max, Statistic::Median] {
                let order = |column| {
                    OrderRow::find(orders, method, VARIABLES[column], statistic)
                        .and_then(|row| row.order)
                };
                cells.extend((0..3).map(|column| decimal(order(column))));
            }
            table.push(cells);
        }
    }
    table
}

/// The range of the orders of a variable over the horizons, the largest over methods and variables.
fn spreads(on_horizons: &[(f64, Vec<OrderRow>)]) -> Readings {
    let spread = |statistic: Statistic| {
        let one = |method: &str, column: usize| {
            let orders = on_horizons.iter().map(|(_, orders)| {
                OrderRow::find(orders, method, VARIABLES[column], statistic)
                    .and_then(|row| row.order)
            });
            let apart = orders.map(|order| order.map(|order| (order, order)));
            let apart = apart.reduce(|a, b| Some((a?.0.min(b?.0), a?.1.max(b?.1)))).flatten();
            apart.map(|(least, most)| most - least)
        };
        let all =
            ON_HORIZONS.iter().flat_map(|method| (0..3).map(move |column| one(method, column)));
        all.reduce(|a, b| Some(a?.max(b?))).flatten()
    };
    let ends = on_horizons.iter().map(|(end, _)| *end);
    Readings::default()
        .and("maxima", "spread", spread(Statistic::Max))
        .and("medians", "spread", spread(Statistic::Median))
        .and("horizon", "least", ends.clone().reduce(f64::min))
        .and("horizon", "largest", ends.reduce(f64::max))
}
