//! Maps of cells over two parameters.

use std::collections::BTreeMap;

use kuva::plot::colormap::ColorMap;
use kuva::render::color::Color;
use kuva::render::render::TextAnchor;

use super::axis::{Axis, extent};
use super::drawing::Drawing;
use super::frame::{Frame, text, width};
use super::look;

/// The canvas above the key, and the height of the key, in pixels. Both kinds of cells share them,
/// so that the axes of two maps side by side are level.
const CANVAS: (f64, f64) = (560.0, 440.0);
const ROW: f64 = 22.0;
const KEY: f64 = 3.3 * ROW;
/// The number of shades of a continuous map.
const SHADES: usize = 65;
/// The colour of cells without a finite value.
const BLANK: &str = "#d4d4d4";

/// The contents of the cells of a [`HeatMap`]: one entry for each cell, row by row from the lowest
/// `y` up, each row from the lowest `x`.
#[derive(Debug, Clone)]
pub enum Cells {
    /// Numbers around 0, shown by a colour bar from blue (negative) over white to red. Cells that
    /// are not finite are grey.
    Values {
        /// The name of the quantity, for instance `log₁₀ of the spectral radius`.
        label: String,
        /// The bar covers [-span, span]. Values beyond it take the colour of the end. Maps with
        /// equal spans can be compared.
        span: f64,
        /// The numbers.
        values: Vec<f64>,
    },
    /// One of several verdicts for each cell, as an index into `names`.
    Verdicts {
        /// The verdicts, at most ten, in the order of the legend; colours follow this order.
        names: Vec<String>,
        /// The verdict of each cell.
        verdicts: Vec<usize>,
    },
}

/// A map of cells over two parameters. Two maps of the same grid have level axes side by side.
#[derive(Debug, Clone)]
pub struct HeatMap {
    /// A short title above the plot.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The centres of the columns, ascending.
    pub xs: Vec<f64>,
    /// The centres of the rows, ascending.
    pub ys: Vec<f64>,
    /// The contents of the cells.
    pub cells: Cells,
}

impl HeatMap {
    /// The map as a drawing.
    ///
    /// # Panics
    ///
    /// If the number of entries is not that of the cells, or if an axis cannot show a centre (for
    /// instance zero on a logarithmic axis).
    pub fn draw(&self) -> Drawing {
        let columns = edges(&self.x, &self.xs);
        let rows = edges(&self.y, &self.ys);
        let entries = match &self.cells {
            Cells::Values { values, .. } => values.len(),
            Cells::Verdicts { verdicts, .. } => verdicts.len(),
        };
        assert_eq!(entries, self.xs.len() * self.ys.len(), "one entry for each cell");
        let span = |axis: &Axis, edges: &[f64]| {
            let (lo, hi) = extent(edges.iter().copied()).unwrap_or((0.0, 1.0));
            axis.exactly(lo, hi)
        };
        let spans = ((&self.x, span(&self.x, &columns)), (&self.y, span(&self.y, &rows)));
        let key = match &self.cells {
            Cells::Values { .. } => KEY,
            Cells::Verdicts { names, .. } => {
                KEY.max(names.len().div_ceil(key_columns(names)) as f64 * ROW)
            }
        };
        let mut frame = Frame::new(&self.title, spans.0, spans.1, CANVAS, (0.0, key));
        let areas = self.areas(&frame, &columns, &rows);
        frame.group(
            r#"shape-rendering="crispEdges""#,
            areas.into_iter().map(|(shade, d)| look::area(d, self.colour(shade))),
        );
        frame.axes(false);
        match &self.cells {
            Cells::Values { label, span, values } => colour_bar(&mut frame, label, *span, values),
            Cells::Verdicts { names, .. } => legend(&mut frame, names),
        }
        frame.drawing()
    }

    /// The path around the cells of each shade. Neighbours of the same shade in a row form one
    /// rectangle.
    fn areas(&self, frame: &Frame, columns: &[f64], rows: &[f64]) -> BTreeMap<usize, String> {
        let shades = self.shades();
        let width = self.xs.len().max(1);
        let mut areas = BTreeMap::<usize, String>::new();
        for (row, y) in shades.chunks(width).zip(rows.windows(2)) {
            let mut start = 0;
            for run in row.chunk_by(|a, b| a == b) {
                let end = start + run.len();
                let (left, bottom) = frame.pixel((columns[start], y[0]));
                let (right, top) = frame.pixel((columns[end], y[1]));
                let d = areas.entry(run[0]).or_default();
                d.push_str(&rectangle(left, top, right, bottom));
                start = end;
            }
        }
        areas
    }

    /// The shade of each cell; `SHADES` marks a value that is not finite.
    fn shades(&self) -> Vec<usize> {
        match &self.cells {
            Cells::Verdicts { verdicts, .. } => verdicts.clone(),
            Cells::Values { values, span, .. } => {
                let part = |v: f64| (0.5 + 0.5 * v / span).clamp(0.0, 1.0);
                let shade = |&v: &f64| {
                    if v.is_finite() {
                        (part(v) * (SHADES - 1) as f64).round() as usize
                    } else {
                        SHADES
                    }
                };
                values.iter().map(shade).collect()
            }
        }
    }

    fn colour(&self, shade: usize) -> Color {
        match &self.cells {
            Cells::Verdicts { .. } => look::category(shade),
            Cells::Values { .. } if shade == SHADES => BLANK.into(),
            Cells::Values { .. } => shade_colour(shade),
        }
    }
}

fn shade_colour(shade: usize) -> Color {
    ColorMap::RedBlue.map(1.0 - shade as f64 / (SHADES - 1) as f64).as_str().into()
}

/// The borders of cells around `middles`, in coordinates along the axis: halfway between
/// neighbours.
fn edges(axis: &Axis, middles: &[f64]) -> Vec<f64> {
    let at: Vec<f64> = middles.iter().filter_map(|v| axis.place(*v)).collect();
    assert_eq!(at.len(), middles.len(), "each middle has a place on the axis");
    let inner = at.windows(2).map(|w| 0.5 * (w[0] + w[1]));
    let (first, last) = match at[..] {
        [] => return Vec::new(),
        [only] => (only - 0.5, only + 0.5),
        [a, b, ..] => (1.5 * a - 0.5 * b, 1.5 * at[at.len() - 1] - 0.5 * at[at.len() - 2]),
    };
    std::iter::once(first).chain(inner).chain([last]).collect()
}

/// A horizontal colour bar below the plot.
fn colour_bar(frame: &mut Frame, label: &str, span: f64, values: &[f64]) {
    let (left, _, right, _) = frame.plot();
    // Room for the widest of the end labels.
    let (left, right) = (left + 12.0, right - 12.0);
    let (top, height) = (CANVAS.1 + 1.15 * ROW, 0.6 * ROW);
    frame.add(text(label, (0.5 * (left + right), CANVAS.1 + 0.6 * ROW), TextAnchor::Middle));
    let blank = values.iter().any(|v| !v.is_finite());
    let bar_right = if blank { right - width("not finite") - 34.0 } else { right };
    let step = (bar_right - left) / SHADES as f64;
    let bar = (0..SHADES).map(|k| {
        let x = left + k as f64 * step;
        look::area(rectangle(x, top, x + step, top + height), shade_colour(k))
    });
    frame.group(r#"shape-rendering="crispEdges""#, bar);
    for (v, tick) in Axis::linear("").exactly(-span, span).ticks() {
        let tick = match v {
            _ if v >= span && values.iter().any(|&value| value > span) => format!("≥ {tick}"),
            _ if v <= -span && values.iter().any(|&value| value < -span) => format!("≤ {tick}"),
            _ => tick,
        };
        let x = left + (0.5 + 0.5 * v / span) * (bar_right - left);
        let foot = [(x, top + height), (x, top + height + 4.0)];
        frame.add(look::stroke(&foot, "#000000".into(), 1.0, None));
        frame.add(text(tick, (x, top + height + 13.0), TextAnchor::Middle));
    }
    if blank {
        swatch(frame, "not finite", BLANK.into(), (bar_right + 14.0, top + 0.5 * height));
    }
}

fn key_columns(names: &[String]) -> usize {
    let column = names.iter().map(|n| width(n)).fold(0.0, f64::max) + 34.0;
    (((CANVAS.0 - 80.0) / column) as usize).clamp(1, names.len().max(1))
}

/// The verdicts in columns below the plot.
fn legend(frame: &mut Frame, names: &[String]) {
    let (left, _, right, _) = frame.plot();
    let columns = key_columns(names);
    let rows = names.len().div_ceil(columns).max(1);
    for (nth, name) in names.iter().enumerate() {
        let x = left + (nth / rows) as f64 * (right - left) / columns as f64;
        let y = CANVAS.1 + ((nth % rows) as f64 + 0.6) * ROW;
        swatch(frame, name, look::category(nth), (x, y));
    }
}

fn swatch(frame: &mut Frame, name: &str, colour: Color, (x, y): (f64, f64)) {
    frame.add(look::area(rectangle(x, y - 7.0, x + 14.0, y + 7.0), colour));
    frame.add(text(name, (x + 20.0, y), TextAnchor::Start));
}

/// Path data of a rectangle. Corners are rounded to half a pixel, a whole one of a PNG picture,
/// before the sides are measured, so that neighbours meet without a seam.
fn rectangle(left: f64, top: f64, right: f64, bottom: f64) -> String {
    let [left, top, right, bottom] = [left, top, right, bottom].map(|v| (2.0 * v).round() / 2.0);
    let (w, h) = (right - left, bottom - top);
    format!("M{left:.1} {top:.1}h{w:.1}v{h:.1}h{:.1}z", -w)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(cells: Cells) -> HeatMap {
        let (x, y) = (Axis::log("h [s]"), Axis::linear("c [1/s]"));
        HeatMap { title: "map".into(), x, y, xs: vec![0.01, 0.1, 1.0], ys: vec![1.0, 2.0], cells }
    }

    #[test]
    fn edges_lie_half_way_in_the_scale_of_the_axis() {
        assert_eq!(edges(&Axis::log("h"), &[0.01, 0.1, 1.0]), [-2.5, -1.5, -0.5, 0.5]);
        assert_eq!(edges(&Axis::linear("c"), &[1.0, 2.0, 4.0]), [0.5, 1.5, 3.0, 5.0]);
        assert_eq!(edges(&Axis::linear("c"), &[3.0]), [2.5, 3.5]);
    }

    #[test]
    fn equal_neighbours_are_one_rectangle() {
        let verdicts = vec![0, 0, 1, 1, 1, 1];
        let svg = map(Cells::Verdicts { names: vec!["good".into(), "bad".into()], verdicts })
            .draw()
            .svg();
        let cells = &svg[svg.find("crispEdges").unwrap()..svg.find("</g>").unwrap()];
        assert_eq!(cells.matches('z').count(), 3);
        assert!(svg.contains("good") && svg.contains("bad"));
    }

    #[test]
    fn a_value_that_is_not_finite_is_shown_as_such() {
        let with =
            |values| map(Cells::Values { label: "log₁₀ ρ".into(), span: 1.0, values }).draw().svg();
        assert!(with(vec![0.0, 1.0, 2.0, 3.0, f64::NAN, 5.0]).contains("not finite"));
        assert!(!with(vec![1.5; 6]).contains("not finite"));
    }

    #[test]
    fn values_beyond_the_span_have_the_colour_of_its_end() {
        let values = Cells::Values {
            label: "ρ".into(),
            span: 1.0,
            values: vec![-1.0, -7.0, 0.0, 0.5, 1.0, f64::MAX],
        };
        assert_eq!(map(values).shades(), [0, 0, 32, 48, 64, 64]);
    }
}
