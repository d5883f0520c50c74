//! A section of a report under construction.

use crate::artifact::{Artifact, TableError};
use crate::chart::{Axis, Curve, Drawing, LineChart, Style};
use crate::claim::{Finding, Readings, Said, fixed, sci};
use crate::journal::JournalError;
use crate::manifest::RunOutcome;
use crate::record::StorageError;
use crate::report::{Block, Figure, Section, Table, Verdict};
use afterbay_analysis::Spacing;
use afterbay_analysis::measured::{Measured, RESOLVED};
use afterbay_analysis::study::stability::MapError;
use afterbay_core::{InputError, IntegrateError};
use serde::Serialize;
use thiserror::Error;

/// An error that prevents a report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A method name that is not in the registry.
    #[error("there is no method {name}; {advice}")]
    Method {
        /// The name.
        name: String,
        /// The nearest name, or all names.
        advice: String,
    },
    /// A study could not be run.
    #[error(transparent)]
    Study(#[from] IntegrateError),
    /// A map could not be drawn.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A study has no reference to compare with.
    #[error("there is no reference to compare to: {0}")]
    NoReference(String),
    /// A table could not be made.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// A finished cell could not be kept, or read.
    #[error(transparent)]
    Journal(#[from] JournalError),
}

impl ReportError {
    /// Whether the user stopped the computation.
    pub fn is_interrupted(&self) -> bool {
        matches!(self, Self::Study(IntegrateError::Interrupted))
    }
}

impl From<TableError> for ReportError {
    fn from(error: TableError) -> Self {
        Self::Storage(error.into())
    }
}

impl From<InputError> for ReportError {
    fn from(error: InputError) -> Self {
        Self::Study(error.into())
    }
}

/// A section with its tables, charts, findings and runs.
pub(crate) struct Sheet {
    pub(crate) section: Section,
    pub(crate) artifacts: Vec<Artifact>,
    pub(crate) findings: Vec<Finding>,
    pub(crate) runs: Vec<RunOutcome>,
    /// Numbers for the charts of a sweep beside those of the findings.
    pub(crate) numbers: Vec<Number>,
}

/// A number for the charts of a sweep.
pub(crate) struct Number {
    /// The run that it belongs to, by its method.
    pub(crate) of: String,
    /// The quantity, as a chart names it.
    pub(crate) what: String,
    pub(crate) value: f64,
}

/// The parts of a report and of its record that come from its sections.
#[derive(Default)]
pub(crate) struct Gathered {
    pub(crate) sections: Vec<Section>,
    pub(crate) artifacts: Vec<Artifact>,
    pub(crate) findings: Vec<Finding>,
    pub(crate) runs: Vec<RunOutcome>,
}

impl Gathered {
    /// With the blocks of each section in the order of [`Block::place`].
    pub(crate) fn in_order(mut self) -> Self {
        self.sections.iter_mut().for_each(|section| section.blocks.sort_by_key(Block::place));
        self
    }
}

impl FromIterator<Sheet> for Gathered {
    fn from_iter<I: IntoIterator<Item = Sheet>>(sheets: I) -> Self {
        let mut all = Self::default();
        for Sheet { section, artifacts, findings, runs, .. } in sheets {
            all.sections.push(section);
            all.artifacts.extend(artifacts);
            all.findings.extend(findings);
            all.runs.extend(runs);
        }
        all
    }
}

impl Sheet {
    pub(crate) fn new(heading: &str) -> Self {
        let section = Section { heading: heading.into(), blocks: Vec::new() };
        let (artifacts, findings, runs) = (Vec::new(), Vec::new(), Vec::new());
        Self { section, artifacts, findings, runs, numbers: Vec::new() }
    }

    pub(crate) fn text(&mut self, text: impl Into<String>) {
        self.section.blocks.push(Block::Text(text.into()));
    }

    /// Adds a finding to the section and to the summary.
    pub(crate) fn find(&mut self, topic: &str, readings: Readings, say: fn(&Readings) -> Said) {
        let finding = Finding::new(topic, readings, say);
        let text = format!("{topic}: {}", finding.statement);
        self.section.blocks.push(Block::Verdict(finding.verdict, text));
        self.findings.push(finding);
    }

    /// Adds a finding about the doubt of the reference, to the section and to the summary, if some
    /// errors are below ten times that doubt.
    pub(crate) fn doubt(&mut self, topic: &str, errors: impl Iterator<Item = Measured>) {
        let (mut all, mut open, mut doubt) = (0_u64, 0_u64, 0.0_f64);
        for error in errors {
            all += 1;
            if !error.is_resolved() {
                open += 1;
                doubt = if error.doubt <= doubt { doubt } else { error.doubt };
            }
        }
        if open > 0 {
            let readings = Readings::default()
                .and("the reference", "doubt", doubt)
                .and("errors", "below ten doubts", open)
                .and("errors", "all", all);
            self.find(&format!("{topic}, reference"), readings, on_doubt);
        }
    }

    pub(crate) fn table(&mut self, header: &[&str], rows: Vec<Vec<String>>) {
        self.section.blocks.push(table(header, rows));
    }

    pub(crate) fn fold(&mut self, summary: &str, blocks: Vec<Block>) {
        self.section.blocks.push(Block::Fold(summary.into(), blocks));
    }

    /// Stores rows as `data/NAME.csv`.
    pub(crate) fn data<R: Serialize>(
        &mut self,
        name: &str,
        rows: &[R],
    ) -> Result<(), StorageError> {
        self.artifacts.push(Artifact::table(format!("data/{name}.csv"), rows)?);
        Ok(())
    }

    /// Stores rows that contain vectors as `data/NAME.csv`, under a header that names each entry.
    pub(crate) fn wide_data<R: Serialize>(
        &mut self,
        name: &str,
        header: &[String],
        rows: &[R],
    ) -> Result<(), StorageError> {
        self.artifacts.push(Artifact::wide_table(format!("data/{name}.csv"), header, rows)?);
        Ok(())
    }

    /// Stores a chart as `figures/NAME.svg` and `figures/NAME.png` and returns its figure. The
    /// numbers of the chart are in `data/DATA.csv`.
    pub(crate) fn figure(
        &mut self,
        name: &str,
        chart: Drawing,
        caption: impl Into<String>,
        data: &str,
    ) -> Figure {
        let (svg, file) = (chart.svg(), format!("figures/{name}.svg"));
        let picture = Some(chart);
        self.artifacts.push(Artifact {
            name: file.clone(),
            text: svg.clone(),
            picture,
            rows: Vec::new(),
        });
        Figure { svg, caption: caption.into(), file, data: format!("data/{data}.csv") }
    }

    /// Shows a chart over the full width.
    pub(crate) fn show(
        &mut self,
        name: &str,
        chart: &LineChart,
        caption: impl Into<String>,
        data: &str,
    ) {
        let figure = self.figure(name, chart.draw(), caption, data);
        self.section.blocks.push(Block::Figure(figure));
    }

    /// Shows two charts side by side.
    pub(crate) fn show_pair(&mut self, left: Figure, right: Figure) {
        self.section.blocks.push(Block::Pair(left, right));
    }

    /// Shows charts in pairs. The last one of an odd number stands alone.
    pub(crate) fn show_pairs(&mut self, figures: impl IntoIterator<Item = Figure>) {
        self.arrange(figures.into_iter().map(|figure| Placed { figure, wide: false }));
    }

    /// Shows charts in order. Two neighbours that are not wide stand side by side.
    pub(crate) fn arrange(&mut self, figures: impl IntoIterator<Item = Placed>) {
        let mut narrow: Option<Figure> = None;
        for Placed { figure, wide } in figures {
            match (wide, narrow.take()) {
                (false, None) => narrow = Some(figure),
                (false, Some(left)) => self.show_pair(left, figure),
                (true, left) => {
                    self.section.blocks.extend(left.map(Block::Figure));
                    self.section.blocks.push(Block::Figure(figure));
                }
            }
        }
        self.section.blocks.extend(narrow.map(Block::Figure));
    }
}

/// A figure, and whether it takes the full width.
pub(crate) struct Placed {
    pub(crate) figure: Figure,
    pub(crate) wide: bool,
}

/// States the doubt of the reference beside the number of errors that are not resolved.
fn on_doubt(r: &Readings) -> Said {
    let count = |what: &str| r.number("errors", what);
    let statement = format!(
        "The reference is known to {} only: {} of {} errors are below {RESOLVED} times its doubt. \
         They are upper bounds and are not used for orders.",
        sci(r.number("the reference", "doubt")),
        count("below ten doubts"),
        count("all"),
    );
    (Verdict::Note, statement)
}

/// A table of the report.
pub(crate) fn table(header: &[&str], rows: Vec<Vec<String>>) -> Block {
    Block::Table(Table { header: header.iter().map(|&name| name.into()).collect(), rows })
}

/// An axis on which values of this spacing are evenly spaced.
pub(crate) fn spaced(label: &str, spacing: Spacing) -> Axis {
    match spacing {
        Spacing::Linear => Axis::linear(label),
        Spacing::Log => Axis::log(label),
    }
}

/// A chart over time.
pub(crate) fn over_time(title: &str, y: Axis, curves: Vec<Curve>) -> LineChart {
    LineChart::new(title, Axis::linear("time t"), y, curves)
}

/// A curve without markers.
pub(crate) fn line(label: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { label: label.into(), points, bounds: Vec::new(), style: Style::Line }
}

/// A curve with a marker at every point.
pub(crate) fn marked(label: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { label: label.into(), points, bounds: Vec::new(), style: Style::LineMarkers }
}

/// Points as dots.
pub(crate) fn dotted(label: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { label: label.into(), points, bounds: Vec::new(), style: Style::Dots }
}

/// A curve of errors. Errors that are not resolved are shown as upper bounds.
pub(crate) fn of_errors(
    label: &str,
    style: Style,
    errors: impl Iterator<Item = (f64, Measured)>,
) -> Curve {
    let (resolved, open): (Vec<_>, Vec<_>) = errors.partition(|(_, error)| error.is_resolved());
    Curve {
        label: label.into(),
        points: resolved.into_iter().map(|(x, error)| (x, error.error)).collect(),
        bounds: open.into_iter().map(|(x, error)| (x, error.bound())).collect(),
        style,
    }
}

/// The cell of a measured error; empty if there is none.
pub(crate) fn measured(error: Option<Measured>) -> String {
    error.map_or(String::new(), |error| error.to_string())
}

/// The cell of a number with three decimals; empty if there is none.
pub(crate) fn decimal(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| fixed(value, 3))
}

/// The cell of a number with two significant digits; empty if there is none.
pub(crate) fn scientific(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or(String::new(), |value| format!("{value:.1e}"))
}
