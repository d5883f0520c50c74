//! The scene, as the last section of a report.

use crate::claim::{Finding, Readings, Said, list as listed};
use crate::report::Verdict;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::Model;
use afterbay_analysis::is_linear;
use afterbay_analysis::study::events::Action;
use afterbay_core::{Passive, State};
use afterbay_systems::Described;

/// Describes the scene.
pub(super) fn sheet(scene: &Scene) -> Result<Sheet, ReportError> {
    let (mut sheet, problem) = (Sheet::new("The scene"), &scene.problem);
    let system = problem.model.system::<f64>()?;
    let start: State<Vec<f64>> = problem.start()?;
    let table = &scene.document.system;
    let mut rows = vec![vec!["system".into(), problem.model.name().into()]];
    let mut row = |name: &str, value: String| rows.push(vec![name.into(), value]);
    let model = match &problem.model {
        Model::Driven(model, _) => model,
        model => model,
    };
    match model {
        Model::Custom(custom) => {
            for (name, expression) in table.expressions() {
                row(&name, expression);
            }
            if let Described::Separable(custom) = custom {
                let degree = custom.structure().degree;
                let degree = degree.map_or("not a polynomial".into(), |degree| degree.to_string());
                row("degree of V", degree);
            }
            let coupling = model.system::<f64>()?.coupling();
            row("coupling", format!("{coupling:?}").to_lowercase());
        }
        Model::Listed(known, _) => row("equations", known.equations.into()),
        Model::Driven(..) => {}
    }
    let drive = scene.document.drive.as_ref();
    for (name, force) in drive.iter().flat_map(|drive| drive.force.named("F")) {
        row(&name, force);
    }
    let of_drive = drive.iter().flat_map(|drive| &drive.parameters);
    for (name, value) in table.parameters.iter().chain(of_drive) {
        row(name, value.text());
    }
    row("degrees of freedom", problem.model.degrees().to_string());
    let alone = model.system::<f64>()?;
    let linear = if is_linear(&alone) { "yes" } else { "no" };
    let apart = if drive.is_some() { ", apart from the drive" } else { "" };
    row("equations are linear", format!("{linear}{apart}"));
    let damping = alone.dissipation_form();
    row(
        "friction",
        match (damping.zero, problem.model.passive()?) {
            (true, _) if drive.is_some() => "none: w stays 0".into(),
            (true, _) => "none: H itself is constant".into(),
            (_, Passive::Each) => "passive: every w_j only fills".into(),
            (_, Passive::InSum) => "passive in sum: Σ w_j only fills".into(),
            (_, Passive::No) => "active, or not known to be passive: w may fall".into(),
        },
    );
    row("q at t = 0", list(&problem.q));
    row("p at t = 0", list(&problem.p));
    row("H at t = 0, which K keeps", start.energy(&*system).to_string());
    row("end of time", problem.end.to_string());
    row("step", scene.step.to_string());
    sheet.table(&["what", "value"], rows);
    Ok(sheet)
}

/// The first few numbers of a list.
fn list(numbers: &[f64]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<_> = numbers.iter().take(SHOWN).map(ToString::to_string).collect();
    let more = if numbers.len() > SHOWN {
        format!(", … ({} in all)", numbers.len())
    } else {
        String::new()
    };
    format!("{}{more}", shown.join(", "))
}

/// The action of an event that ends a run.
const STOP: &str = "stop";
/// The topic of the finding on events.
const TOPIC: &str = "Events";
/// The topic of the finding on a sweep.
const SWEEP: &str = "Sweep";
/// The reading of a quantity that the sweep varies.
const VARIED: &str = "varied";

/// The finding that measurements go on where an event ends a run; none without such an event.
pub fn stops(scene: &Scene) -> Option<Finding> {
    of_stops(scene).map(|readings| Finding::new(TOPIC, readings, they_go_on))
}

/// Adds the finding of [`stops`].
pub(super) fn beyond_stops(mut sheet: Sheet, scene: &Scene) -> Sheet {
    if let Some(readings) = of_stops(scene) {
        sheet.find(TOPIC, readings, they_go_on);
    }
    sheet
}

/// The finding that `pick` does not follow a sweep; none without a sweep.
pub fn unswept(scene: &Scene) -> Option<Finding> {
    of_sweep(scene).map(|readings| Finding::new(SWEEP, readings, it_is_not_followed))
}

/// Adds the finding of [`unswept`].
pub(super) fn beside_sweep(mut sheet: Sheet, scene: &Scene) -> Sheet {
    if let Some(readings) = of_sweep(scene) {
        sheet.find(SWEEP, readings, it_is_not_followed);
    }
    sheet
}

fn of_sweep(scene: &Scene) -> Option<Readings> {
    let names = scene.sweep.as_ref()?.names.iter();
    Some(names.fold(Readings::default(), |r, name| r.and(name, "in the sweep", VARIED)))
}

fn it_is_not_followed(r: &Readings) -> Said {
    let all = r.of_all("in the sweep").into_iter();
    let varied = all.filter(|name| r.word(name, "in the sweep") == VARIED).map(str::to_owned);
    let statement = format!(
        "`pick` does not follow the sweep of {}: it takes the values in [system] and [initial].",
        listed(varied)
    );
    (Verdict::Note, statement)
}

fn of_stops(scene: &Scene) -> Option<Readings> {
    let stops = scene.run.as_ref()?.events_that(|action| action == Action::Stop);
    let of_end = Readings::default().and("the motion", "end", scene.problem.end);
    let all = |of_end| stops.iter().fold(of_end, |r: Readings, name| r.and(name, "action", STOP));
    (!stops.is_empty()).then(|| all(of_end))
}

fn they_go_on(r: &Readings) -> Said {
    let all = r.of_all("action").into_iter();
    let stops = all.filter(|name| r.word(name, "action") == STOP).map(str::to_owned);
    let end = r.number("the motion", "end");
    let statement = format!(
        "{} would end a run; studies and `pick` follow the motion to its end at t = {end}.",
        listed(stops)
    );
    (Verdict::Note, statement)
}
