//! Charts of accuracy against cost.

use crate::chart::{Axis, Curve, LineChart, Style};
use crate::sheet::{marked, of_errors};
use afterbay_analysis::Measured;
use afterbay_analysis::study::work_precision::WorkRow;

/// A measure of the cost of a run: its names in files, captions and axes, and its value.
pub(crate) struct Cost {
    file: &'static str,
    said: &'static str,
    axis: &'static str,
    of: fn(&WorkRow) -> Option<f64>,
}

/// The time of the whole run.
pub(crate) const TIME: Cost =
    Cost { file: "work", said: "time", axis: "seconds", of: |row| row.seconds };
/// The number of evaluations of the force.
pub(crate) const EVALUATIONS: Cost = Cost {
    file: "evaluations",
    said: "evaluations",
    axis: "evaluations of the force",
    of: |row| row.evaluations.map(|count| count as f64),
};

/// A measure of the error of a run: its names in files and captions, and its value.
struct Accuracy {
    file: &'static str,
    said: &'static str,
    of: fn(&WorkRow) -> Option<Measured>,
}

const ACCURACIES: [Accuracy; 2] = [
    Accuracy { file: "qp", said: "(q, p)", of: WorkRow::qp },
    Accuracy { file: "w", said: "w", of: WorkRow::w },
];

/// Runs of several methods, to be shown with one curve for each method.
pub(crate) struct Runs<'a> {
    /// The name before the titles, if there is one.
    pub(crate) name: Option<&'a str>,
    /// The end of time.
    pub(crate) end: f64,
    /// The names of the methods.
    pub(crate) methods: &'a [&'static str],
    /// The runs.
    pub(crate) found: &'a [WorkRow],
    /// Makes a curve from a method and its costs and errors.
    pub(crate) curve: fn(&str, Vec<(f64, Measured)>) -> Curve,
}

/// A chart with the name of its files and its caption.
pub(crate) type Shown = (String, String, LineChart);

impl Runs<'_> {
    /// The charts of the errors of (q, p) and of w against a cost.
    pub(crate) fn against(&self, cost: &Cost) -> [Shown; 2] {
        ACCURACIES.map(|Accuracy { file, said, of }| {
            let (title, what) = match self.name {
                Some(name) => (format!("{name}: error of {said}"), format!("error of {said}")),
                None => (format!("Error of {said}"), format!("Error of {said}")),
            };
            let y = Axis::log(format!("{what} at t = {}", self.end));
            let curve = |method: &&str| {
                let rows = self.found.iter().filter(|row| row.method == *method);
                let points = rows.filter_map(|row| Some(((cost.of)(row)?, of(row)?)));
                (self.curve)(method, points.collect())
            };
            let curves = self.methods.iter().map(curve).collect();
            let caption = format!("Error of {said} against {}.", cost.said);
            let chart = LineChart::new(title, Axis::log(cost.axis), y, curves);
            (format!("{}-{file}", cost.file), caption, chart)
        })
    }
}

/// A curve of errors. Errors that are not resolved are shown as upper bounds.
pub(crate) fn with_bounds(method: &str, points: Vec<(f64, Measured)>) -> Curve {
    of_errors(method, Style::LineMarkers, points.into_iter())
}

/// A curve of errors, whether or not they are resolved.
pub(crate) fn as_measured(method: &str, points: Vec<(f64, Measured)>) -> Curve {
    marked(method, points.into_iter().map(|(cost, error)| (cost, error.error)).collect())
}
