//! Limit cycles of each method beside those of the reference, and their branches.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, label, of_reference};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, list, note, sci, significant};
use crate::findings::all_completed;
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, decimal, line, scientific};
use afterbay_analysis::Variable;
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::limit_cycle::{self, Cycle, Cycles, Event, LimitCycle};
use afterbay_analysis::study::outcome::COMPLETED;

/// The table from which the chart is made.
const DATA: &str = "limit_cycle";
/// The most bifurcations that a sentence names.
const MOST_NAMED: usize = 6;
/// A cycle is neutral if its largest multiplier differs from 1 by at most this much. A choice: some
/// orders more than its rounding.
const NEUTRAL: f64 = 1e-6;
/// The distance from 1 of the reference's multiplier along a cycle above which it is in doubt. A
/// choice: multipliers are printed with two digits.
const DOUBTED: f64 = 1e-3;
/// Amplitudes below this share of the largest are not shown, where there are others. A choice.
const NEGLIGIBLE: f64 = 1e-9;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<LimitCycle>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<LimitCycle>, parts| sheet(scene, plan, plan.gather(parts));
    section(["limit-cycle", "limit cycle"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<LimitCycle>,
    found: Vec<Cycles>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new("Limit cycle"), &scene.problem.model);
    let parameter = plan.study.branch.as_ref().map(|branch| branch.parameter.as_str());
    let rows: Vec<_> =
        found.iter().flat_map(|cycles| cycles.rows(parameter, model.degrees())).collect();
    sheet.wide_data(DATA, &limit_cycle::columns(model), &rows)?;
    sheet.runs.extend(found.iter().map(|cycles| {
        RunOutcome::of(&cycles.ending, "limit-cycle", model.name(), cycles.row.name, cycles.h)
    }));
    let shown = shown(&found);
    let amplitude = format!("amplitude of q{}", shown + 1);
    sheet.text(prose(plan, parameter, shown));
    let readings = readings(parameter, &found, shown);
    let header = [
        "method and step",
        "run",
        "period",
        &amplitude,
        "largest multiplier",
        "relative error of the period",
        "of the amplitude",
    ];
    sheet.table(&header, found.iter().map(|cycles| cells(cycles, &readings)).collect());
    sheet.find("Limit cycle", readings, what_is_seen);
    if let Some(parameter) = parameter {
        let curve = |cycles: &Cycles| line(&label(cycles.row, cycles.h), points(cycles, shown));
        let title = format!("Amplitude against {parameter}");
        let y = Axis::linear(scene.units.variable(Variable::Q, &amplitude));
        let curves = found.iter().map(curve).collect();
        let chart = LineChart::new(title, Axis::linear(parameter), y, curves);
        sheet.show("limit-cycle", &chart, "Stable and unstable cycles.", DATA);
    }
    Ok(sheet)
}

/// The degree of freedom whose amplitude is shown: the first whose amplitude is not negligible in
/// the first cycle found.
fn shown(found: &[Cycles]) -> usize {
    let Some(cycle) = found.iter().find_map(first) else { return 0 };
    let largest = cycle.amplitude.iter().copied().fold(0.0, f64::max);
    cycle.amplitude.iter().position(|own| *own > NEGLIGIBLE * largest).unwrap_or(0)
}

fn prose(plan: &DynamicsPlan<LimitCycle>, parameter: Option<&str>, shown: usize) -> String {
    let along = parameter.map_or(String::new(), |name| {
        format!(" The branch is followed in {name}; a value may occur more than once.")
    });
    format!(
        "The cycle of each method near its state at t = {}: n steps that lead back to their start, \
         found by Newton's method. The amplitude is max |q{j}|, at steps and between them; of an \
         angle that turns, half the range of q{j} less its uniform rotation. The multipliers are \
         those by which small displacements grow over a period; the cycle is stable if all are \
         less than 1, but for the one along a cycle without a drive, and neutral if the largest of \
         the others is 1 to a millionth. A multiplier that is lost in the roundings of the largest \
         is left out of the table, and only its bound is said.{along}{}",
        plan.study.transient,
        of_reference(plan.reference),
        j = shown + 1,
    )
}

fn readings(parameter: Option<&str>, found: &[Cycles], shown: usize) -> Readings {
    let mut readings = Readings::default();
    let exact = found.iter().find(|cycles| cycles.row.name == REFERENCE_LABEL).and_then(first);
    for cycles in found {
        let (label, cycle) = (label(cycles.row, cycles.h), first(cycles));
        readings.add(&label, "run", cycles.ending.outcome);
        readings.add(&label, "period", cycle.map(|cycle| cycle.period));
        readings.add(&label, "amplitude", cycle.map(|cycle| cycle.amplitude[shown]));
        readings.add(&label, "coordinate", format!("q{}", shown + 1));
        readings.add(&label, "multiplier", cycle.and_then(largest));
        readings.add(&label, "lost below", cycle.and_then(|cycle| cycle.lost_below));
        if cycles.row.name == REFERENCE_LABEL {
            let along = cycles.points.iter().filter_map(|point| point.cycle.off_along());
            readings.add(&label, "off along", along.reduce(f64::max));
        }
        if let Some((cycle, exact)) =
            cycle.zip(exact).filter(|_| cycles.row.name != REFERENCE_LABEL)
        {
            let off = |own: f64, exact: f64| (own - exact).abs() / exact;
            readings.add(&label, "period off", off(cycle.period, exact.period));
            let off = off(cycle.amplitude[shown], exact.amplitude[shown]);
            readings.add(&label, "amplitude off", off);
        }
        if let Some(parameter) = parameter {
            readings.add(&label, "bifurcations", bifurcations(cycles, parameter));
        }
    }
    readings
}

fn cells(cycles: &Cycles, readings: &Readings) -> Vec<String> {
    let (label, cycle) = (label(cycles.row, cycles.h), first(cycles));
    let number = |what: &str| scientific(readings.known(&label, what));
    vec![
        label.clone(),
        cycles.ending.describe(),
        decimal(cycle.map(|cycle| cycle.period)),
        decimal(readings.known(&label, "amplitude")),
        number("multiplier"),
        number("period off"),
        number("amplitude off"),
    ]
}

fn first(cycles: &Cycles) -> Option<&Cycle> {
    cycles.points.first().map(|point| &point.cycle)
}

fn points(cycles: &Cycles, shown: usize) -> Vec<(f64, f64)> {
    let place = |cycle: &Cycle| Some((cycle.value?, cycle.amplitude[shown]));
    cycles.points.iter().filter_map(|point| place(&point.cycle)).collect()
}

/// The largest |μ| of the nontrivial multipliers, if one of them is known.
fn largest(cycle: &Cycle) -> Option<f64> {
    let known = cycle.nontrivial().into_iter().filter_map(|of| cycle.known(of));
    known.map(|[re, im]| re.hypot(im)).reduce(f64::max)
}

/// The bifurcations of a branch, in words.
fn bifurcations(cycles: &Cycles, parameter: &str) -> String {
    let all: Vec<String> = cycles
        .points
        .iter()
        .filter_map(|point| Some((point.event?, point.cycle.value?)))
        .map(|(event, value)| {
            let name = match event {
                Event::Fold => "fold",
                Event::Branching => "branching",
                Event::PeriodDoubling => "period doubling",
                Event::NeimarkSacker => "torus",
            };
            format!("{name} at {parameter} = {}", significant(value, 7))
        })
        .collect();
    let more = all.len().saturating_sub(MOST_NAMED);
    let named = list(all.into_iter().take(MOST_NAMED));
    if more > 0 { format!("{named}, and {more} more") } else { named }
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let number = |what: &str| r.number(label, what);
        if number("period").is_nan() {
            return format!("{label}: no cycle ({})", r.word(label, "run"));
        }
        let (below, largest) = match number("multiplier") {
            lost if lost.is_nan() => ("below ", number("lost below")),
            known => ("", known),
        };
        let stable = match largest - 1.0 {
            off if off.abs() <= NEUTRAL => "neutral",
            off if off < 0.0 => "stable",
            _ => "unstable",
        };
        let off = match number("period off") {
            off if off.is_nan() => String::new(),
            off => {
                let amplitude = sci(number("amplitude off"));
                format!(", off by {} of the period and {amplitude} of the amplitude", sci(off))
            }
        };
        let events = match r.word(label, "bifurcations") {
            "" => String::new(),
            events => format!("; bifurcations: {events}"),
        };
        let end = match r.word(label, "run") {
            COMPLETED => String::new(),
            run => format!(" (the branch ends: {run})"),
        };
        let doubt = match number("off along") {
            off if off > DOUBTED => format!(
                "; it is in doubt, since a multiplier that is 1 is off by {}: take a smaller step",
                sci(off)
            ),
            _ => String::new(),
        };
        let of = match r.word(label, "coordinate") {
            "q1" => String::new(),
            other => format!(" of {other}"),
        };
        format!(
            "{label}: period {}, amplitude{of} {}, {stable} (largest multiplier {below}{}){off}\
             {events}{end}{doubt}",
            significant(number("period"), 7),
            significant(number("amplitude"), 7),
            sci(largest),
        )
    };
    let doubted = r.numbers("off along").iter().any(|(_, off)| *off > DOUBTED);
    (note(all_completed(r, "run") && !doubted), r.each("run", one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Verdict;
    use afterbay_analysis::study::limit_cycle::Point;
    use afterbay_analysis::study::outcome::Ending;
    use afterbay_methods::registry::REFERENCE;

    /// A cycle that has these multipliers.
    fn cycle(multipliers: [f64; 2], multiple: Option<u64>) -> Cycle {
        Cycle {
            value: None,
            h: 0.01,
            period: 5.0,
            multiple,
            start: [vec![0.0], vec![1.0]],
            amplitude: vec![1.0],
            multipliers: multipliers.map(|re| [re, 0.0]).to_vec(),
            lost_below: None,
        }
    }

    /// The verdict and the sentence on a cycle of the reference.
    fn said_of(cycle: Cycle) -> Said {
        let points = vec![Point { cycle, event: None }];
        let cycles = Cycles { row: &REFERENCE, h: 0.01, points, ending: Ending::completed() };
        let found = [cycles];
        what_is_seen(&readings(None, &found, shown(&found)))
    }

    #[test]
    fn the_amplitude_shown_is_not_negligible() {
        for (amplitude, of) in [
            (vec![1e-20, 2.0, 1.0], "amplitude of q2 2.0"),
            (vec![1e-3, 2.0], "amplitude 0.001"),
            (vec![0.0, 0.0], "amplitude 0"),
        ] {
            let (_, statement) = said_of(Cycle { amplitude, ..cycle([1.0, 0.5], None) });
            assert!(statement.contains(of), "{statement}");
        }
    }

    #[test]
    fn a_reference_without_the_multiplier_along_its_cycle_is_in_doubt() {
        let (verdict, statement) = said_of(cycle([1.25, 0.5], None));
        assert_eq!(verdict, Verdict::Fails);
        let doubt = "; it is in doubt, since a multiplier that is 1 is off by 2.5e-1: take a \
                     smaller step.";
        assert!(statement.ends_with(doubt), "{statement}");
        for (multipliers, multiple) in [([1.0005, 0.5], None), ([1.25, 0.5], Some(1))] {
            let (verdict, statement) = said_of(cycle(multipliers, multiple));
            assert!(verdict == Verdict::Note && !statement.contains("doubt"), "{statement}");
        }
    }
}
