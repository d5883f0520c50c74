//! The accumulation of roundings in K over very many steps.

use super::declared::{Boxed, section};
use crate::claim::{Readings, Said, counted, note};
use crate::findings::long_run::{CAPTION, HEADER, cells, chart, growth, readings};
use crate::findings::{all_completed, ended};
use crate::manifest::RunOutcome;
use crate::scene::{LongRunPlan, Scene};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::long_run::{LongRun, LongRuns, Setup};

/// The number of starts, the scene's and others with slightly larger amplitudes, since a single
/// random walk determines its exponent poorly.
const STARTS: i32 = 8;

pub(super) fn declared<'a>(
    scene: &'a Scene,
    plan: &'a LongRunPlan,
) -> Result<Boxed<'a>, ReportError> {
    let LongRunPlan { methods, step: h, count, compensated } = plan;
    let starts: Vec<Problem> = (0..STARTS)
        .map(|k| {
            let larger =
                |part: &[f64]| part.iter().map(|x| x * (1.0 + f64::from(k) / 1024.0)).collect();
            Problem {
                q: larger(&scene.problem.q),
                p: larger(&scene.problem.p),
                ..scene.problem.clone()
            }
        })
        .collect();
    let mut setups: Vec<Setup> =
        methods.iter().map(|&row| Setup { row, h: *h, compensated: false }).collect();
    if *compensated {
        let able =
            methods.iter().filter(|row| scene.problem.model.bind_compensated::<f64>(row).is_ok());
        setups.extend(able.map(|&row| Setup { row, h: *h, compensated: true }));
    }
    let study = LongRuns::new(starts, setups, *count)?;
    let made = |study: &LongRuns, parts: Vec<_>| sheet(scene, plan, &study.gather(&parts));
    Ok(section(["long-run", "K in a long run"], study, made))
}

fn sheet(scene: &Scene, plan: &LongRunPlan, found: &[LongRun]) -> Result<Sheet, ReportError> {
    let (mut sheet, count) = (Sheet::new("K in a long run"), plan.count);
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.data("long_run", &rows)?;
    let system = scene.problem.model.name();
    sheet.runs.extend(found.iter().map(|run| RunOutcome::of_long_run(run, system)));
    sheet.text(format!(
        "Each method takes {count} steps from each of {STARTS} starts: that of the scene, and \
         starts with amplitudes larger by 1/1024, 2/1024, … of it. K is computed in 106 bits at \
         about a hundred samples in each of four windows per decade. Its deviation is relative to \
         the largest |H| + Σ |w_j| or T of the samples so far, T = ½ Σ |p_j ∂H/∂p_j|. That of a \
         method that keeps K grows like √t if roundings are independent, and like t if they are \
         biased; that of any other method is its truncation error. The exponent is the slope of \
         log rms against log t over the last two decades, with its 95 % confidence interval."
    ));
    sheet.find("K in a long run", readings(found, count), how_k_grows);
    sheet.table(&HEADER, found.iter().map(cells).collect());
    let chart = chart("K in a long run", &scene.units.time("time t"), found);
    sheet.show("long-run", &chart, CAPTION, "long_run");
    Ok(sheet)
}

fn how_k_grows(r: &Readings) -> Said {
    let one = |label: &str| {
        let off = match r.known(label, "rms") {
            Some(rms) => format!("{rms:.0e} of the largest energy, {}", growth(r, label)),
            None => "no window was completed".to_owned(),
        };
        format!("{label}: {off}{}", ended(r, label))
    };
    let steps = counted(r.number("run", "steps"), "step");
    let statement = format!("after {steps}: {}", r.each("rms", one));
    (note(all_completed(r, "rms")), statement)
}
