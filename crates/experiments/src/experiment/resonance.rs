//! Resonance curves: the amplitude and the energy per period of each method beside the reference.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, label, of_reference};
use crate::chart::{self, Axis, LineChart, Style};
use crate::claim::{Found, Readings, Said, counted, fixed, in_full, note, sci, significant};
use crate::findings::all_zero;
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, marked, spaced};
use afterbay_analysis::study::bifurcation::Way;
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::outcome::{AT_REST, COMPLETED, Ending};
use afterbay_analysis::study::resonance::{self, Resonance, ResonanceRow, UNSTEADY};
use afterbay_analysis::{Spacing, Variable};
use afterbay_methods::registry::Row;

/// The table from which the charts are made.
const DATA: &str = "resonance";

/// The rows of a method and a step.
struct Curve {
    label: String,
    rows: Vec<ResonanceRow>,
}

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Resonance>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Resonance>, parts| sheet(scene, plan, plan.gather(parts));
    section(["resonance", "resonance"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Resonance>,
    found: Vec<Vec<ResonanceRow>>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new("Resonance"), &scene.problem.model);
    let curve =
        |((row, h), rows): ((&Row, f64), Vec<ResonanceRow>)| Curve { label: label(row, h), rows };
    let found: Vec<Curve> = plan.settings().zip(found).map(curve).collect();
    let rows: Vec<_> = found.iter().flat_map(|curve| &curve.rows).collect();
    sheet.wide_data(DATA, &resonance::columns(model), &rows)?;
    let record = |row: &&ResonanceRow| {
        let ending = Ending { outcome: row.outcome, failure: row.failure.clone() };
        let point = Some(format!("{} = {}", plan.study.parameter, in_full(row.value)));
        let (name, method, h) = (model.name(), row.method, row.h);
        RunOutcome { point, ..RunOutcome::of(&ending, "resonance", name, method, h) }
    };
    sheet.runs.extend(rows.iter().filter(|row| is_failed(row)).map(record));
    sheet.text(prose(plan));
    sheet.find("Resonance", readings(&found), what_is_seen);
    charts(&mut sheet, scene, plan.study.spacing, &found);
    Ok(sheet)
}

/// Whether the run of a row failed.
fn is_failed(row: &ResonanceRow) -> bool {
    ![COMPLETED, UNSTEADY, AT_REST].contains(&row.outcome)
}

fn is_steady(row: &ResonanceRow) -> bool {
    row.outcome == COMPLETED
}

fn prose(plan: &DynamicsPlan<Resonance>) -> String {
    let study = &plan.study;
    format!(
        "The steady motion at {} values of {}, once upwards and once downwards. Each begins where \
         the one before ended, or at the initial state if that came to rest or failed; {} periods \
         pass before {} are measured. The amplitude is the largest |q| between steps, found to \
         rounding. In a steady motion the drive supplies in a period what friction dissipates.{}",
        study.values.len(),
        study.parameter,
        study.transient,
        study.periods,
        of_reference(plan.reference),
    )
}

fn readings(found: &[Curve]) -> Readings {
    let exact = found.iter().find(|curve| curve.label == REFERENCE_LABEL);
    let mut readings = Readings::default();
    for curve in found {
        let mut add = |what: &str, value: Found| readings.add(&curve.label, what, value);
        let (rows, failed) = (curve.rows.len(), curve.rows.iter().filter(|row| is_failed(row)));
        let (steady, failed) = (curve.steady().count(), failed.count());
        let resting = curve.rows.iter().filter(|row| row.outcome == AT_REST).count();
        let amplitudes = curve.steady().filter_map(|row| Some((row.amplitude[0]?, row.frequency)));
        let peak = amplitudes.max_by(|a, b| a.0.total_cmp(&b.0));
        add("peak", peak.map(|peak| peak.0).into());
        add("at", peak.map(|peak| peak.1).into());
        add("balance", curve.imbalance().into());
        add("failed runs", failed.into());
        add("unsteady", (rows - failed - steady - resting).into());
        add("resting", resting.into());
        add("values", rows.into());
        if let Some(exact) = exact.filter(|_| curve.label != REFERENCE_LABEL) {
            add("off", curve.distance(exact).into());
        }
    }
    readings
}

impl Curve {
    fn steady(&self) -> impl Iterator<Item = &ResonanceRow> {
        self.rows.iter().filter(|row| is_steady(row))
    }

    /// The largest difference of the energies supplied and dissipated, relative to the former.
    fn imbalance(&self) -> Option<f64> {
        let off =
            |row: &ResonanceRow| share((row.supplied? - row.dissipated?).abs(), row.supplied?);
        self.steady().filter_map(off).reduce(f64::max)
    }

    /// The largest relative difference of the amplitudes from those of the reference, where both
    /// are steady.
    fn distance(&self, exact: &Curve) -> Option<f64> {
        let pairs = self.rows.iter().zip(&exact.rows);
        let both = pairs.filter(|(own, exact)| is_steady(own) && is_steady(exact));
        let off = |(own, exact): (&ResonanceRow, &ResonanceRow)| {
            share((own.amplitude[0]? - exact.amplitude[0]?).abs(), exact.amplitude[0]?)
        };
        both.filter_map(off).reduce(f64::max)
    }

    /// A quantity against the frequency, upwards or downwards.
    fn branch(&self, way: Way, value: fn(&ResonanceRow) -> Option<f64>) -> chart::Curve {
        let rows = self.rows.iter().filter(|row| row.branch == way);
        let points = rows.filter_map(|row| Some((row.frequency, value(row)?))).collect();
        let way = if way == Way::Up { "up" } else { "down" };
        marked(&format!("{}, {way}", self.label), points)
    }
}

/// A difference relative to a value, which is not defined where the value is 0.
fn share(difference: f64, of: f64) -> Option<f64> {
    (of != 0.0).then(|| difference / of.abs())
}

/// Rings round the motions that are not steady; none if all are.
fn unsteady(found: &[Curve], value: fn(&ResonanceRow) -> Option<f64>) -> Option<chart::Curve> {
    let rows = found.iter().flat_map(|curve| &curve.rows);
    let rows = rows.filter(|row| row.outcome == UNSTEADY);
    let points: Vec<_> = rows.filter_map(|row| Some((row.frequency, value(row)?))).collect();
    let ring = |points| chart::Curve { style: Style::Ring, ..marked("not steady", points) };
    (!points.is_empty()).then(|| ring(points))
}

fn charts(sheet: &mut Sheet, scene: &Scene, spacing: Spacing, found: &[Curve]) {
    let chart = |title: &str, y: String, value: fn(&ResonanceRow) -> Option<f64>| {
        let branches = |curve: &Curve| [Way::Up, Way::Down].map(|way| curve.branch(way, value));
        let x = spaced("angular frequency of the drive", spacing);
        let curves = found.iter().flat_map(branches).chain(unsteady(found, value)).collect();
        LineChart::new(title, x, Axis::linear(y), curves)
    };
    let amplitude = scene.units.variable(Variable::Q, "amplitude of q1");
    let amplitude = chart("Amplitude", amplitude, |row| row.amplitude[0]);
    sheet.show("resonance-amplitude", &amplitude, "Largest |q1| of the motion.", DATA);
    let energy = scene.units.energy("energy supplied in a period");
    let energy = chart("Energy", energy, |row| row.supplied);
    sheet.show("resonance-energy", &energy, "Energy that the drive supplies in a period.", DATA);
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let number = |what: &str| r.number(label, what);
        let off = match number("off") {
            off if off.is_nan() => String::new(),
            off => format!(", off by up to {} % of the reference", fixed(100.0 * off, 1)),
        };
        let fails = match number("failed runs") {
            failed if failed > 0.0 => format!("; {} failed", counted(failed, "run")),
            _ => String::new(),
        };
        if number("values") == 0.0 {
            return format!("{label}: nothing computed");
        }
        let resting = match number("resting") {
            0.0 => String::new(),
            count => format!("; {count} of {} come to rest", counted(number("values"), "motion")),
        };
        if number("peak").is_nan() {
            let motions = counted(number("values"), "motion");
            return format!("{label}: none of {motions} is steady{resting}{fails}");
        }
        let balance = match number("balance") {
            balance if balance.is_nan() => String::new(),
            balance => {
                format!("; supplied and dissipated energy differ by {} of it at most", sci(balance))
            }
        };
        let unsteady = match number("unsteady") {
            0.0 => String::new(),
            count => format!("; {count} of {} not steady", counted(number("values"), "motion")),
        };
        format!(
            "{label}: largest steady amplitude of q1 {} at {}{off}{balance}{unsteady}{resting}\
             {fails}",
            significant(number("peak"), 5),
            significant(number("at"), 5),
        )
    };
    (note(all_zero(r, "failed runs")), r.each("peak", one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::REFERENCE;

    #[test]
    fn motions_that_are_not_steady_are_ringed() {
        let row = |outcome| ResonanceRow {
            method: REFERENCE.name,
            h: 0.1,
            value: 1.0,
            branch: Way::Up,
            frequency: 1.0,
            amplitude: vec![Some(2.0)],
            supplied: None,
            dissipated: None,
            outcome,
            failure: None,
        };
        let found = |outcome| [Curve { label: "rk4".into(), rows: vec![row(outcome)] }];
        let ringed = |outcome| unsteady(&found(outcome), |row| row.amplitude[0]);
        let ring = ringed(UNSTEADY).expect("a ring");
        assert_eq!((ring.points, ring.style), (vec![(1.0, 2.0)], Style::Ring));
        assert!(ringed(COMPLETED).is_none());
    }

    #[test]
    fn there_is_no_share_of_nothing() {
        assert_eq!((share(0.0, 0.0), share(1.0, -2.0)), (None, Some(0.5)));
    }
}
