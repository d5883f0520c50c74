//! The orders that local errors show, and the rows of their table.

use super::super::VARIABLES;
use super::{LocalErrors, Statistic};
use crate::statistics::{Fit, fit};
use serde::Serialize;

/// The least ratio of a statistic to that of its roundings at which it is used. A choice.
const ABOVE: f64 = 10.0;

/// A row of `local_orders.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct OrderRow {
    /// Name of the method.
    pub method: &'static str,
    /// q, p or w.
    pub variable: &'static str,
    /// max, median or rms.
    pub statistic: &'static str,
    /// The slope; none if fewer than two steps are ten times above rounding.
    pub order: Option<f64>,
    /// Lower end of its 95 % confidence interval.
    pub ci_low: Option<f64>,
    /// Upper end.
    pub ci_high: Option<f64>,
    /// The number of steps used, which are at least ten times above rounding.
    pub points: usize,
    /// The order printed in the paper.
    pub printed: Option<f64>,
    /// Time of the worst grid point at the largest step.
    pub worst_t: f64,
    /// Its distance to the nearest pole: |p/m| for δ(q), |V' + D| for δ(p).
    pub pole_distance: Option<f64>,
    /// The number of failed steps over the grid and all step sizes.
    pub failed: usize,
}

impl OrderRow {
    /// The row of a method, a variable and a statistic.
    pub fn find<'a>(
        rows: &'a [Self],
        method: &str,
        variable: &str,
        statistic: Statistic,
    ) -> Option<&'a Self> {
        let mut rows = rows.iter().filter(|row| row.method == method && row.variable == variable);
        rows.find(|row| row.statistic == statistic.name())
    }
}

impl LocalErrors {
    /// Whether a statistic is at least ten times that of its roundings.
    pub fn is_seen(&self, variable: usize, statistic: Statistic) -> bool {
        let [size, floor] = [&self.variables, &self.floors].map(|of| of[variable].get(statistic));
        size > 0.0 && size >= ABOVE * floor
    }
}

/// Fits log statistic against log h for one method and variable, over the steps at least ten times
/// above rounding.
pub fn order(errors: &[&LocalErrors], variable: usize, statistic: Statistic) -> Option<Fit> {
    let seen = errors.iter().filter(|errors| errors.is_seen(variable, statistic));
    let point =
        |errors: &&LocalErrors| (errors.h.ln(), errors.variables[variable].get(statistic).ln());
    fit(&seen.map(point).collect::<Vec<_>>())
}

/// The rows of the table, in the order in which the methods were run. `printed` returns the order
/// printed in the paper.
pub fn rows(
    errors: &[LocalErrors],
    printed: impl Fn(&str, &str, Statistic) -> Option<f64>,
) -> Vec<OrderRow> {
    let mut rows = Vec::new();
    for group in errors.chunk_by(|a, b| a.method.name == b.method.name) {
        let Some(widest) = group.iter().max_by(|a, b| a.h.total_cmp(&b.h)) else { continue };
        let group: Vec<_> = group.iter().collect();
        for (variable, name) in VARIABLES.into_iter().enumerate() {
            for statistic in Statistic::ALL {
                let fit = order(&group, variable, statistic);
                let margin = fit.and_then(|fit| fit.margin);
                let slope = fit.map(|fit| fit.slope);
                let (worst_t, pole_distance) = widest.worst[variable];
                rows.push(OrderRow {
                    method: widest.method.name,
                    variable: name,
                    statistic: statistic.name(),
                    order: slope,
                    ci_low: slope.zip(margin).map(|(slope, margin)| slope - margin),
                    ci_high: slope.zip(margin).map(|(slope, margin)| slope + margin),
                    points: group
                        .iter()
                        .filter(|errors| errors.is_seen(variable, statistic))
                        .count(),
                    printed: printed(widest.method.name, name, statistic),
                    worst_t,
                    pole_distance,
                    failed: group.iter().map(|errors| errors.failed).sum(),
                });
            }
        }
    }
    rows
}
