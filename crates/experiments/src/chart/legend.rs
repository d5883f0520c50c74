//! Legends of curves.

use kuva::render::render::{Primitive, TextAnchor};

use super::curve::{CANVAS, Curve, Style};
use super::frame::{TEXT, text, width};
use super::look::{self, Look};

/// The widest legend beside the plot, in pixels.
const BESIDE: f64 = 250.0;
/// The length in pixels of the sample of a curve, with the gap to its label.
const SAMPLE: f64 = 46.0;
/// The height of an entry in pixels.
pub(super) const ROW: f64 = 21.0;

/// The place of the legend and the room it takes, in pixels.
pub(super) struct Legend {
    /// The width beside the plot.
    pub(super) right: f64,
    /// The height below the plot.
    pub(super) below: f64,
    /// The excess of the widest entry over the width of the canvas.
    pub(super) overhang: f64,
    columns: usize,
    column: f64,
}

impl Legend {
    /// The legend of a chart: beside the plot where it fits, else below.
    pub(super) fn of(curves: &[Curve]) -> Self {
        let column = column(curves);
        if curves.len() > 1 && column <= BESIDE && (curves.len() as f64) * ROW < CANVAS.1 - 60.0 {
            return Self { right: column, below: 0.0, overhang: 0.0, columns: 1, column };
        }
        Self::below(curves)
    }

    /// The legend below a chart. A single curve has none.
    pub(super) fn below(curves: &[Curve]) -> Self {
        let column = column(curves);
        if curves.len() < 2 {
            return Self { right: 0.0, below: 0.0, overhang: 0.0, columns: 1, column };
        }
        let columns = (((CANVAS.0 - 60.0) / column) as usize).clamp(1, curves.len());
        let below = curves.len().div_ceil(columns) as f64 * ROW + 16.0;
        let overhang = (column + 60.0 - CANVAS.0).max(0.0);
        Self { right: 0.0, below, overhang, columns, column }
    }

    /// The entries: beside a plot whose left and upper edges are given, or below the canvas.
    pub(super) fn entries<'a>(
        &'a self,
        (left, top): (f64, f64),
        curves: &'a [Curve],
        looks: &'a [Look],
    ) -> impl Iterator<Item = Primitive> + 'a {
        let beside = self.right > 0.0;
        let origin = if beside {
            (CANVAS.0 - self.right, top + 0.5 * ROW)
        } else {
            (left, CANVAS.1 + f64::from(TEXT))
        };
        let shown = if beside || self.below > 0.0 { curves.len() } else { 0 };
        let rows = curves.len().div_ceil(self.columns).max(1);
        curves.iter().zip(looks).take(shown).enumerate().flat_map(move |(nth, (curve, look))| {
            let x = origin.0 + (nth / rows) as f64 * self.column;
            let y = origin.1 + (nth % rows) as f64 * ROW;
            let middle = [(x + 0.5 * (SAMPLE - 8.0), y)];
            let line = look.line(&[(x, y), (x + SAMPLE - 8.0, y)], 1.9);
            let sample = match curve.style {
                Style::Line => vec![line],
                Style::LineMarkers => vec![line, look.markers(&middle, 4.0)],
                Style::Dots => vec![look.disc(middle[0], 4.0)],
                Style::Ring => vec![look::rings(&middle, 7.0)],
            };
            sample.into_iter().chain([text(&curve.label, (x + SAMPLE, y), TextAnchor::Start)])
        })
    }
}

/// The width of an entry in pixels.
fn column(curves: &[Curve]) -> f64 {
    SAMPLE + curves.iter().map(|curve| width(&curve.label)).fold(0.0, f64::max) + 14.0
}
