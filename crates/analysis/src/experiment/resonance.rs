//! Resonance curves: the amplitude and the energy per period of each method beside the reference.

use super::declared::{Boxed, section};
use super::poincare::of_reference;
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, fixed, sci};
use crate::record::RunOutcome;
use crate::report::Verdict;
use crate::scene::{DynamicsPlan, Scene, Spacing, Variable};
use crate::sheet::{ReportError, Sheet, marked};
use crate::study::bifurcation::Way;
use crate::study::outcome::COMPLETED;
use crate::study::resonance::{self, Resonance, ResonanceRow, UNSTEADY};
use afterbay_methods::registry::{REFERENCE, Row};

/// The table from which the charts are made.
const DATA: &str = "resonance";
/// The label of the reference.
const EXACT: &str = REFERENCE.name;

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
    let mut sheet = Sheet::new("Resonance");
    let DynamicsPlan { study, .. } = plan;
    let model = &scene.problem.model;
    let curve = |((row, h), rows): ((&Row, f64), Vec<ResonanceRow>)| {
        let label =
            if row.name == EXACT { EXACT.into() } else { format!("{}, h = {h:.4}", row.name) };
        Curve { label, rows }
    };
    let found: Vec<Curve> = plan.settings().zip(found).map(curve).collect();
    let rows: Vec<_> = found.iter().flat_map(|curve| &curve.rows).collect();
    sheet.wide_data(DATA, &resonance::columns(model), &rows)?;
    let failed = |row: &ResonanceRow| ![COMPLETED, UNSTEADY].contains(&row.outcome);
    let steady = |row: &&ResonanceRow| row.outcome == COMPLETED;
    sheet.runs.extend(rows.iter().filter(|row| failed(row)).map(|row| RunOutcome {
        study: "resonance",
        system: model.name(),
        method: row.method,
        h: row.h,
        outcome: row.outcome.into(),
        failure: row.failure.clone(),
    }));
    sheet.text(format!(
        "The steady motion at {} values of {}, once upwards and once downwards. Each begins where \
         the one before ended; {} periods pass before {} are measured. The amplitude is the largest \
         |q| between steps, found to rounding. In a steady motion the drive supplies in a period \
         what friction dissipates.{}",
        study.values.len(),
        study.parameter,
        study.transient,
        study.periods,
        of_reference(plan.reference),
    ));
    let exact = found.iter().find(|curve| curve.label == EXACT);
    let mut readings = Readings::default();
    for curve in &found {
        let rows = || curve.rows.iter().filter(steady);
        let amplitudes = || rows().filter_map(|row| Some((row.amplitude[0]?, row)));
        let peak = amplitudes().max_by(|a, b| a.0.total_cmp(&b.0));
        let off = |row: &ResonanceRow| {
            Some((row.supplied? - row.dissipated?).abs() / row.supplied?.abs())
        };
        let unbalanced = rows().filter_map(off).reduce(f64::max);
        let failed = curve.rows.iter().filter(|row| failed(row)).count();
        let unsteady = curve.rows.len() - failed - rows().count();
        readings.add(&curve.label, "peak", peak.map(|peak| peak.0));
        readings.add(&curve.label, "at", peak.map(|peak| peak.1.frequency));
        readings.add(&curve.label, "balance", unbalanced);
        readings.add(&curve.label, "failed runs", failed);
        readings.add(&curve.label, "unsteady", unsteady);
        readings.add(&curve.label, "values", curve.rows.len());
        if let Some(exact) = exact.filter(|_| curve.label != EXACT) {
            let pairs = curve.rows.iter().zip(&exact.rows);
            let off = |(own, exact): (&ResonanceRow, &ResonanceRow)| {
                if !steady(&own) || !steady(&exact) {
                    return None;
                }
                Some((own.amplitude[0]? - exact.amplitude[0]?).abs() / exact.amplitude[0]?)
            };
            let worst = pairs.filter_map(off).reduce(f64::max);
            readings.add(&curve.label, "off", worst);
        }
    }
    sheet.find("Resonance", readings, what_is_seen);
    let frequency = || match study.spacing {
        Spacing::Linear => Axis::linear("angular frequency of the drive"),
        Spacing::Log => Axis::log("angular frequency of the drive"),
    };
    let chart = |title: &str, y: Axis, value: fn(&ResonanceRow) -> Option<f64>| LineChart {
        title: title.into(),
        x: frequency(),
        y,
        curves: found
            .iter()
            .flat_map(|curve| [Way::Up, Way::Down].map(|way| (curve, way)))
            .map(|(curve, way)| {
                let rows = curve.rows.iter().filter(|row| row.branch == way);
                let points = rows.filter_map(|row| Some((row.frequency, value(row)?))).collect();
                let way = if way == Way::Up { "up" } else { "down" };
                marked(&format!("{}, {way}", curve.label), points)
            })
            .collect(),
        guides: Vec::new(),
    };
    let amplitude = Axis::linear(scene.units.variable(Variable::Q, "amplitude of q1"));
    let amplitude = chart("Amplitude", amplitude, |row| row.amplitude[0]);
    sheet.show("resonance-amplitude", &amplitude, "Largest |q1| of the steady motion.", DATA);
    let energy = Axis::linear(scene.units.energy("energy supplied in a period"));
    let energy = chart("Energy", energy, |row| row.supplied);
    sheet.show("resonance-energy", &energy, "Energy that the drive supplies in a period.", DATA);
    Ok(sheet)
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let number = |what: &str| r.number(label, what);
        let off = match number("off") {
            off if off.is_nan() => String::new(),
            off => format!(", off by up to {} % of the reference", fixed(100.0 * off, 1)),
        };
        let fails = match number("failed runs") {
            failed if failed > 0.0 => format!("; {failed} runs fail"),
            _ => String::new(),
        };
        if number("peak").is_nan() {
            return format!("{label}: none of {} motions is steady{fails}", number("values"));
        }
        let unsteady = match number("unsteady") {
            0.0 => String::new(),
            count => format!("; {count} of {} motions are not steady", number("values")),
        };
        format!(
            "{label}: largest steady amplitude {} at {}{off}; supplied and dissipated energy \
             differ by {} of it at most{unsteady}{fails}",
            fixed(number("peak"), 4),
            fixed(number("at"), 4),
            sci(number("balance")),
        )
    };
    let all = r.of_all("peak");
    let done = r.numbers("failed runs").iter().all(|(_, failed)| *failed == 0.0);
    let verdict = if done { Verdict::Note } else { Verdict::Fails };
    (verdict, format!("{}.", all.into_iter().map(one).collect::<Vec<_>>().join("; ")))
}
