//! Colours, dashes and markers: after Okabe and Ito, told apart without colour as well.

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive};

/// Colours of curves; the yellow of the set is left out, too pale for a line on white.
const CURVES: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000", "#56b4e9"];

/// Dashes, one longer than the colours so that a colour that comes again has another dash.
const DASHES: [&str; 8] = ["", "9 3", "2.5 2.5", "10 3 2 3", "5 3", "12 3 2 3 2 3", "6 2 2 2", "1.5 4"];

/// Colours of the categories of a map.
const CATEGORIES: [&str; 9] =
    ["#56b4e9", "#f0e442", "#d55e00", "#000000", "#cc79a7", "#999999", "#009e73", "#0072b2", "#e69f00"];

/// The grey of guides, notes and cells without a value.
pub(super) const GREY: &str = "#6b6b6b";

/// How the curve at one place in the list looks.
#[derive(Clone, Copy)]
pub(super) struct Look {
    nth: usize,
}

impl Look {
    pub(super) fn nth(nth: usize) -> Self {
        Self { nth }
    }

    fn colour(self) -> Color {
        CURVES[self.nth % CURVES.len()].into()
    }

    /// A line through `points`, in pixels.
    pub(super) fn line(self, points: &[(f64, f64)], width: f64) -> Primitive {
        let dash = DASHES[self.nth % DASHES.len()];
        stroke(points, self.colour(), width, (!dash.is_empty()).then_some(dash))
    }

    /// Markers at `points`, in pixels, all in one path; every second look is hollow.
    pub(super) fn markers(self, points: &[(f64, f64)], radius: f64) -> Primitive {
        let d = points.iter().map(|at| self.outline(*at, radius)).collect();
        let fill = if self.nth.is_multiple_of(2) { self.colour() } else { "#ffffff".into() };
        path(d, Some(fill), self.colour(), 1.5, None)
    }

    /// The outline of one marker, as SVG path data.
    fn outline(self, (x, y): (f64, f64), r: f64) -> String {
        let corners = |radii: &[f64], turn: f64| {
            let point = |k: usize| {
                let angle = (turn + k as f64 / radii.len() as f64) * std::f64::consts::TAU;
                (x + radii[k] * angle.sin(), y - radii[k] * angle.cos())
            };
            format!("{}Z", trace((0..radii.len()).map(point)))
        };
        match self.nth % 6 {
            0 => format!("M{:.1} {y:.1}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", x - r, d = 2.0 * r),
            1 => corners(&[1.25 * r; 4], 0.125),
            2 => corners(&[1.35 * r; 3], 0.0),
            3 => corners(&[1.35 * r; 4], 0.0),
            4 => corners(&[1.35 * r; 3], 0.5),
            _ => corners(&[1.5 * r, 0.65 * r].repeat(5), 0.0),
        }
    }
}

/// The colour of the category at one place in the list.
pub(super) fn category(nth: usize) -> Color {
    CATEGORIES[nth % CATEGORIES.len()].into()
}

/// A line through `points`, in pixels.
pub(super) fn stroke(points: &[(f64, f64)], colour: Color, width: f64, dash: Option<&str>) -> Primitive {
    path(trace(points.iter().copied()), None, colour, width, dash)
}

/// An area without a border.
pub(super) fn area(d: String, fill: Color) -> Primitive {
    path(d, Some(fill), Color::None, 0.0, None)
}

fn path(d: String, fill: Option<Color>, stroke: Color, width: f64, dash: Option<&str>) -> Primitive {
    let stroke_dasharray = dash.map(Into::into);
    Primitive::Path(Box::new(PathData {
        d,
        fill,
        stroke,
        stroke_width: width,
        opacity: None,
        stroke_dasharray,
    }))
}

/// Path data through `points` to a tenth of a pixel.
fn trace(points: impl Iterator<Item = (f64, f64)>) -> String {
    points.enumerate().map(|(i, (x, y))| format!("{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' })).collect()
}
