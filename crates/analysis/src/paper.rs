//! The paper's experiment, what its figures show when they are made again, and what it announces but does not show.
//!
//! One module a part of the report. The paper gives no horizon for its figures; [0, 20] stands for it wherever nothing
//! else is said.

mod books;
mod errata;
mod many_degrees;
mod orders;
mod other_systems;
mod overdamped;
mod sheet;
mod stability;
mod work;

pub use sheet::Finding;

use crate::Model;
use crate::progress::Progress;
use crate::record::{Manifest, Output, StorageError, processor};
use crate::report::Report;
use crate::study::Problem;
use crate::study::stability::MapError;
use afterbay_core::{InputError, IntegrateError};
use afterbay_methods::registry::{self, Row};
use serde::Serialize;
use thiserror::Error;

/// The damped oscillator of the paper, section 5, on [0, 20].
pub fn oscillator() -> Problem {
    Problem { model: Model::DampedOscillator { k: 1.0, b: 0.1 }, q: vec![2.3], p: vec![-3.1], end: 20.0 }
}

/// The paper's base grid.
const BASE_STEP: f64 = 0.001;
/// The paper's steps.
const STEPS: [f64; 6] = [0.036, 0.03, 0.028, 0.02, 0.017, 0.01];
/// The step of the figures over time; the paper does not say which it took.
const FIGURE_STEP: f64 = 0.01;

/// How much of it to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// All of it.
    Full,
    /// The same studies on coarser maps and with fewer steps.
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

/// Why the paper could not be run.
#[derive(Debug, Error)]
pub enum PaperError {
    /// A study could not be run.
    #[error(transparent)]
    Study(#[from] IntegrateError),
    /// A map could not be drawn.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A table could not be made.
    #[error(transparent)]
    Storage(#[from] StorageError),
}

impl From<InputError> for PaperError {
    fn from(error: InputError) -> Self {
        Self::Study(error.into())
    }
}

/// Runs the paper. Gives all there is to write down, and the findings in brief.
///
/// # Errors
/// [`PaperError`] if a study is refused; a run that fails is a row in its table.
pub fn run(extent: Extent, progress: &dyn Progress) -> Result<(Output, Vec<Finding>), PaperError> {
    let sheets = [
        orders::sheet(progress)?,
        errata::sheet()?,
        books::sheet(progress)?,
        other_systems::sheet(extent, progress)?,
        work::sheet(extent, progress)?,
        stability::sheet(extent, progress)?,
        overdamped::sheet()?,
        many_degrees::sheet(extent, progress)?,
    ];
    let scene = serde_json::json!({
        "problem": oscillator(),
        "others": other_systems::problems(),
        "many_degrees": many_degrees::problems(extent),
        "base_step": BASE_STEP,
        "steps": STEPS,
        "figure_step": FIGURE_STEP,
        "extent": extent,
    });
    let findings: Vec<Finding> = sheets.iter().flat_map(|sheet| sheet.findings.iter().cloned()).collect();
    let runs = sheets.iter().flat_map(|sheet| sheet.runs.iter().cloned()).collect();
    let manifest = Manifest::new("paper", scene, runs);
    let mut report = Report {
        title: "Dissipative systems with an energy reservoir: the paper, run again".into(),
        subtitle: format!(
            "afterbay {} on {} ({} threads). A. Kobus, Forced extension of GNI techniques to dissipative systems. \
             All quantities are dimensionless (m = k = 1).",
            manifest.version,
            processor(),
            manifest.threads
        ),
        sections: vec![sheet::summary(&findings)],
    };
    let mut artifacts = Vec::new();
    for sheet in sheets {
        artifacts.extend(sheet.artifacts);
        report.sections.push(sheet.section);
    }
    Ok((Output { report, artifacts, manifest }, findings))
}

/// The rows of methods by name.
fn methods(names: &[&str]) -> Vec<&'static Row> {
    names.iter().filter_map(|name| registry::find(name)).collect()
}
