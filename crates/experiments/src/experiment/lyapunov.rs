//! Lyapunov exponents of each method beside those of the reference.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, label, of_reference};
use crate::chart::{Axis, Curve, LineChart};
use crate::claim::{Readings, Said, fixed, note, sci};
use crate::findings::all_completed;
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, decimal, line};
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::lyapunov::{self, Lyapunov, LyapunovRow, Spectrum};
use afterbay_analysis::study::outcome::COMPLETED;

/// The table from which the chart is made.
const DATA: &str = "lyapunov";
/// The standard errors beyond which two numbers differ.
const DIFFERENT: f64 = 3.0;
/// Growth that is not exponential is that of a power of t up to this one.
const ALGEBRAIC: f64 = 4.0;
/// The rounding of an exponent, relative to it. A motion at rest has the same rate in each
/// interval, and a standard error of 0.
const ROUNDING: f64 = 1e-11;
/// The rounding of an exponent, in roundings of the displacements a step. A choice: those of an
/// oscillator without friction are off by up to a fiftieth of it.
const STEP_ROUNDINGS: f64 = 16.0;
/// The difference of the sum of the exponents from the divergence, in units of the largest
/// exponent, above which they differ, and a reference is in doubt. A choice: the divergence is a
/// mean over the steps.
const DOUBTED: f64 = 0.1;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Lyapunov>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Lyapunov>, parts| sheet(scene, plan, plan.gather(parts));
    section(["lyapunov", "Lyapunov exponents"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Lyapunov>,
    found: Vec<Spectrum>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new("Lyapunov exponents"), &scene.problem.model);
    let rows: Vec<_> = found.iter().flat_map(|spectrum| &spectrum.rows).collect();
    sheet.wide_data(DATA, &lyapunov::columns(model), &rows)?;
    sheet.runs.extend(found.iter().map(|spectrum| {
        RunOutcome::of(&spectrum.ending, "lyapunov", model.name(), spectrum.row.name, spectrum.h)
    }));
    sheet.text(prose(plan));
    sheet.table(&HEADER, found.iter().map(cells).collect());
    // At a jump of D volumes change, too, which the divergence does not count.
    let has_kinks = scene.problem.has_kinks().unwrap_or(true);
    sheet.find("Lyapunov exponents", readings(&found, has_kinks), what_is_seen);
    let title = "Largest Lyapunov exponent";
    let x = Axis::linear("time of the measurement");
    let y = Axis::linear("mean over the time so far");
    let chart = LineChart::new(title, x, y, found.iter().map(curve).collect());
    sheet.show("lyapunov", &chart, "Its convergence.", DATA);
    Ok(sheet)
}

fn prose(plan: &DynamicsPlan<Lyapunov>) -> String {
    let study = &plan.study;
    format!(
        "The mean rates at which small displacements of (q, p) grow under the steps of a method, \
         over t = {} after {} that are not measured. Each has the standard error that its {} \
         intervals show. The sum of the exponents is that at which volumes grow, and the \
         divergence of the equations is its value as h → 0. A largest exponent above 0 by \
         {DIFFERENT} standard errors counts if displacements grow more from the first to the \
         second half of this time than t^{ALGEBRAIC} does: neighbours that separate like t show an \
         exponent above 0 too, which only a longer time takes to 0. It counts as chaos if the \
         motion stays bounded, and as unstable if it grows from the first to the second half like \
         small displacements, or rests.{}",
        study.time,
        study.transient,
        study.rows,
        of_reference(plan.reference),
    )
}

fn readings(found: &[Spectrum], has_kinks: bool) -> Readings {
    let mut readings = Readings::default();
    for spectrum in found {
        let label = label(spectrum.row, spectrum.h);
        let done = spectrum.rows.last().filter(|_| spectrum.ending.is_completed());
        readings.add(&label, "run", spectrum.ending.outcome);
        readings.add(&label, "largest", done.and_then(|row| row.exponents[0]));
        readings.add(&label, "standard error", done.and_then(|row| row.standard_errors[0]));
        readings.add(&label, "sum", done.and_then(|row| row.sum));
        readings.add(&label, "divergence", done.and_then(|row| row.mean_divergence));
        if !has_kinks {
            readings.add(&label, "volumes off", done.and_then(|row| volumes_off(row, spectrum.h)));
        }
        readings.add(&label, "rounding", done.map(|_| rounding(spectrum.h)));
        readings.add(&label, "growth of the motion", done.and(spectrum.growth));
        readings.add(&label, "power of t", done.and(spectrum.power));
    }
    readings
}

/// The rounding of an exponent that steps h leave.
fn rounding(h: f64) -> f64 {
    STEP_ROUNDINGS * f64::EPSILON / h
}

/// The difference of the sum from the divergence, in units of the largest exponent. If all
/// exponents are roundings, so is the difference.
fn volumes_off(row: &LyapunovRow, h: f64) -> Option<f64> {
    let sizes = row.exponents.iter().flatten().map(|exponent| exponent.abs());
    let largest = sizes.reduce(f64::max)?.max(rounding(h) / DOUBTED);
    Some((row.sum? - row.mean_divergence?).abs() / largest)
}

const HEADER: [&str; 7] = [
    "method and step",
    "run",
    "largest exponent",
    "standard error",
    "least exponent",
    "sum",
    "mean divergence",
];

fn cells(spectrum: &Spectrum) -> Vec<String> {
    let last = spectrum.rows.last();
    let number = |of: fn(&LyapunovRow) -> Option<f64>| decimal(last.and_then(of));
    vec![
        label(spectrum.row, spectrum.h),
        spectrum.ending.outcome.to_owned(),
        number(|row| row.exponents[0]),
        number(|row| row.standard_errors[0]),
        number(|row| row.exponents.last().copied().flatten()),
        number(|row| row.sum),
        number(|row| row.mean_divergence),
    ]
}

/// The largest exponent over the time of the measurement.
fn curve(spectrum: &Spectrum) -> Curve {
    let points = spectrum.rows.iter().filter_map(|row| Some((row.t, row.exponents[0]?)));
    line(&label(spectrum.row, spectrum.h), points.collect())
}

fn what_is_seen(r: &Readings) -> Said {
    let exact = (r.number(REFERENCE_LABEL, "largest"), r.number(REFERENCE_LABEL, "standard error"));
    let one = |label: &str| {
        let run = r.word(label, "run");
        if run != COMPLETED {
            return format!("{label}: {run}");
        }
        let (largest, error) = (r.number(label, "largest"), r.number(label, "standard error"));
        let growth = r.number(label, "growth of the motion");
        let power = r.number(label, "power of t");
        // Neighbours on orbits of different periods separate like a power of t.
        let slow = format!(
            "undecided: displacements grow like t^{} from the first to the second half, run longer",
            fixed(power, 1)
        );
        let rounding = r.number(label, "rounding");
        let kind = match largest / error.max(rounding) {
            share if share > DIFFERENT && power <= ALGEBRAIC => &slow,
            share if share > DIFFERENT && power.is_nan() => "undecided",
            // A motion that grows like its displacements, or that rests, is no chaos.
            share if share > DIFFERENT && growth <= 0.5 * largest => "chaos",
            share if share > DIFFERENT && growth.is_nan() => "unstable, at rest",
            share if share > DIFFERENT => "unstable, the motion grows",
            share if share < -DIFFERENT => "no chaos",
            share if share.is_nan() => "undecided",
            _ => "0 within the error",
        };
        let rounding = rounding.max(ROUNDING * largest.abs());
        let distance = (largest - exact.0).abs();
        let apart = distance / error.hypot(exact.1).max(rounding);
        let beside = match label {
            REFERENCE_LABEL => String::new(),
            _ if apart > DIFFERENT => {
                format!(", not that of the reference, {} away", sci(distance))
            }
            _ if apart <= DIFFERENT => ", as the reference within the errors".to_owned(),
            _ => String::new(),
        };
        let off = r.number(label, "volumes off") > DOUBTED;
        let doubt = match label {
            REFERENCE_LABEL if off => "; it is in doubt, since these differ: take a smaller step",
            _ if off => {
                "; these differ: the step is too long, or the motion rests at its roundings"
            }
            _ => "",
        };
        format!(
            "{label}: largest exponent {} ± {}{beside} ({kind}), sum {} where the divergence is \
             {}{doubt}",
            fixed(largest, 4),
            sci(error),
            fixed(r.number(label, "sum"), 5),
            fixed(r.number(label, "divergence"), 5),
        )
    };
    let doubted = r.number(REFERENCE_LABEL, "volumes off") > DOUBTED;
    (note(all_completed(r, "run") && !doubted), r.each("run", one))
}
