//! The paper's experiment: its figures made again, and the results that it announces but does not
//! show.
//!
//! Each module makes one part of the report, a list of findings (`claim.rs`). The rule that judges
//! them is in `rule.rs`. The paper gives no end of time for its figures; it is 20 here unless
//! something else is said.

mod energy_balance;
mod errata;
pub(crate) mod many_degrees;
mod orders;
mod other_systems;
mod overdamped;
pub(crate) mod rule;
mod stability;
pub(crate) mod work;

use crate::claim::{Finding, counted};
use crate::manifest::{Manifest, RunOutcome, processor};
use crate::record::Output;
use crate::report::{Block, Report, Section};
use crate::scene::suggestion;
use crate::sheet::{Gathered, ReportError, Sheet};
use afterbay_analysis::Model;
use afterbay_analysis::progress::Progress;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::outcome::Ending;
use afterbay_core::IntegrateError;
use afterbay_methods::registry::{FIXED, Row};
use afterbay_systems::DAMPED_OSCILLATOR;
use serde::Serialize;

/// The damped oscillator of the paper, section 5, on [0, 20].
pub fn oscillator() -> Problem {
    Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]),
        q: vec![2.3],
        p: vec![-3.1],
        end: 20.0,
    }
}

/// The paper's base grid.
const BASE_STEP: f64 = 0.001;
/// The paper's steps.
const STEPS: [f64; 6] = [0.036, 0.03, 0.028, 0.02, 0.017, 0.01];
/// The step of the figures over time; the paper does not say which it took.
const FIGURE_STEP: f64 = 0.01;

/// The extent of the paper's experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// All of it.
    Full,
    /// All studies, on coarser maps and with fewer steps.
    Quick,
}

impl Extent {
    fn pick<T>(self, full: T, quick: T) -> T {
        match self {
            Self::Full => full,
            Self::Quick => quick,
        }
    }
}

/// The experiment to run: its extent, its methods, and the receiver of its progress.
#[derive(Clone, Copy)]
struct Paper<'a> {
    extent: Extent,
    registry: &'static [Row],
    progress: &'a dyn Progress,
}

impl Paper<'_> {
    /// The rows of methods by name.
    fn methods(&self, names: &[&str]) -> Result<Vec<&'static Row>, ReportError> {
        names.iter().map(|name| self.method(name)).collect()
    }

    fn method(&self, name: &str) -> Result<&'static Row, ReportError> {
        self.registry.iter().find(|row| row.name == name).ok_or_else(|| {
            let known: Vec<String> = self.registry.iter().map(|row| row.name.into()).collect();
            ReportError::Method { name: name.into(), advice: suggestion(name, &known, "there are") }
        })
    }
}

/// A part of the report: its heading, the methods it names, and the function that makes it.
struct Part {
    heading: &'static str,
    methods: &'static [&'static [&'static str]],
    sheet: fn(&Paper<'_>, Sheet) -> Result<Sheet, ReportError>,
}

const PARTS: [Part; 8] = [
    orders::PART,
    errata::PART,
    energy_balance::PART,
    other_systems::PART,
    work::PART,
    stability::PART,
    overdamped::PART,
    many_degrees::PART,
];

/// Runs the paper's experiment, and returns the output and its findings.
///
/// # Errors
/// [`ReportError`] if a study is refused; a run that fails is a row in its table.
pub fn run(extent: Extent, progress: &dyn Progress) -> Result<(Output, Vec<Finding>), ReportError> {
    run_with(FIXED, extent, progress)
}

/// Runs the paper with the methods of another registry. Every name the paper needs is looked up in
/// it before anything is computed.
///
/// # Errors
/// Those of [`run`], and [`ReportError::Method`] where a name is missing.
pub fn run_with(
    registry: &'static [Row],
    extent: Extent,
    progress: &dyn Progress,
) -> Result<(Output, Vec<Finding>), ReportError> {
    let paper = Paper { extent, registry, progress };
    for part in &PARTS {
        part.methods.iter().try_for_each(|names| paper.methods(names).map(drop))?;
    }
    let mut sheets = Vec::new();
    for part in &PARTS {
        if progress.stopped() {
            sheets.push(interrupted(part));
            continue;
        }
        let made = match (part.sheet)(&paper, Sheet::new(part.heading)) {
            Err(ReportError::Study(IntegrateError::Interrupted)) => None,
            made => Some(made?),
        };
        // A part that was interrupted holds unfinished runs. The report states no result of it.
        sheets.push(made.filter(|_| !progress.stopped()).unwrap_or_else(|| interrupted(part)));
    }
    let scene = serde_json::json!({
        "problem": oscillator(),
        "others": other_systems::problems(),
        "many_degrees": many_degrees::problems(extent),
        "base_step": BASE_STEP,
        "steps": STEPS,
        "figure_step": FIGURE_STEP,
        "extent": extent,
    });
    let Gathered { sections, artifacts, findings, runs } = sheets.into_iter().collect();
    let manifest = Manifest::new("paper", scene, runs);
    let report = Report {
        title: "Dissipative systems with an energy reservoir: the paper, run again".into(),
        subtitle: format!(
            "afterbay {} on {} ({}). A. Kobus, Forced extension of GNI techniques to \
             dissipative systems. \
             All quantities are dimensionless (m = k = 1).",
            manifest.version,
            processor(),
            counted(manifest.threads, "thread")
        ),
        sections: std::iter::once(summary(&findings)).chain(sections).collect(),
    };
    Ok((Output { report, artifacts, manifest }, findings))
}

/// The section of a part that was not finished.
fn interrupted(part: &Part) -> Sheet {
    let mut sheet = Sheet::new(part.heading);
    sheet.text("Interrupted: this part was not finished, and nothing is said of it.");
    sheet.runs.push(RunOutcome::of(&Ending::interrupted(), part.heading, "all", "all", 0.0));
    sheet
}

/// The first section: every finding in brief.
fn summary(findings: &[Finding]) -> Section {
    let mut blocks = vec![Block::Text(
        "K alone proves nothing: any method keeps K if one sets w = K₀ - H. So three figures \
             stand side by side throughout and are never mixed: the error of (q, p), the error of \
             w against the reference, and the drift of K; and where a system is passive, the \
             number of steps that took energy back from the reservoir."
            .into(),
    )];
    blocks.extend(rule::paragraphs().map(Block::Text));
    blocks.extend(findings.iter().map(|finding| {
        Block::Verdict(finding.verdict, format!("{}: {}", finding.topic, finding.statement))
    }));
    Section { heading: "What holds".into(), blocks }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_analysis::progress::Silent;

    #[test]
    fn a_misspelt_method_is_an_error_that_names_the_nearest() {
        let paper = Paper { extent: Extent::Quick, registry: FIXED, progress: &Silent };
        let misspelt = paper.methods(&["moddg", "mdodg"]).unwrap_err().to_string();
        assert_eq!(misspelt, "there is no method mdodg; did you mean moddg?");
    }
}
