//! Several charts of one figure: curves that would hide one another, and maps of several methods.

use kuva::render::render::{Primitive, TextAnchor};

use super::axis::{Axis, extent};
use super::drawing::Drawing;
use super::frame::Frame;
use super::heat::HeatMap;
use super::legend::Legend;
use super::line::{CANVAS, Curve, draw_curve, most_points, place};
use super::look::Look;
use super::thin::thin;

/// The size of a panel in pixels. Two of them are as wide as a chart, three as a report.
const PANEL: (f64, f64) = (380.0, 300.0);
/// The height of the title above the panels, in pixels.
const TITLE: f64 = 34.0;

/// Curves in small charts side by side, which have the same axes and one legend.
#[derive(Debug, Clone)]
pub struct Panels {
    /// A short title above all panels.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The title and the curves of each panel. The curves of all have the labels of the first.
    pub panels: Vec<(String, Vec<Curve>)>,
}

impl Panels {
    /// The panels as one drawing.
    pub fn draw(&self) -> Drawing {
        let placed: Vec<Vec<Vec<_>>> = self
            .panels
            .iter()
            .map(|(_, curves)| {
                curves.iter().map(|curve| place(&self.x, &self.y, &curve.points)).collect()
            })
            .collect();
        let all = || placed.iter().flatten().flatten();
        let most = most_points(placed.iter().map(Vec::len).sum());
        let panel = |((title, curves), placed): (&(String, Vec<Curve>), &Vec<Vec<_>>)| {
            let spans = (self.x.span(all().map(|p| p.0)), self.y.span(all().map(|p| p.1)));
            let axes = ((&self.x, spans.0), (&self.y, spans.1));
            let mut frame = Frame::new(title, axes.0, axes.1, PANEL, (0.0, 0.0));
            frame.axes(true);
            let looks = Look::of_labels(curves.iter().map(|curve| curve.label.as_str()));
            for ((curve, points), look) in curves.iter().zip(placed).zip(looks) {
                draw_curve(&mut frame, look, curve.style, &thin(points, most));
            }
            frame.drawing()
        };
        let panels: Vec<_> = self.panels.iter().zip(&placed).map(panel).collect();
        // Neither more than three in a row nor one alone in the last row of four.
        let columns = if panels.len() == 4 { 2 } else { 3 };
        let mut drawing = Drawing::grid(&self.title, panels, columns, TITLE);
        drawing.elements.push(heading(&self.title, drawing.size.0));
        let first = self.panels.first().map_or(&[][..], |(_, curves)| curves);
        let looks = Look::of_labels(first.iter().map(|curve| curve.label.as_str()));
        let (legend, below) = (Legend::below(first), drawing.size.1);
        let at = format!("translate(0,{})", below - CANVAS.1);
        let group = Primitive::GroupStart { transform: Some(at), title: None, extra_attrs: None };
        drawing.elements.push(group);
        drawing.elements.extend(legend.entries((60.0, 0.0), first, &looks));
        drawing.elements.push(Primitive::GroupEnd);
        drawing.size.1 += legend.below;
        drawing
    }
}

/// Maps side by side.
#[derive(Debug, Clone)]
pub struct Maps {
    /// A short title above all maps.
    pub title: String,
    /// The maps, of equal size.
    pub maps: Vec<HeatMap>,
}

impl Maps {
    /// The maps as one drawing.
    pub fn draw(&self) -> Drawing {
        let maps = self.maps.iter().map(HeatMap::draw).collect();
        let mut drawing = Drawing::grid(&self.title, maps, 2, TITLE);
        drawing.elements.push(heading(&self.title, drawing.size.0));
        drawing
    }
}

fn heading(title: &str, width: f64) -> Primitive {
    Primitive::Text {
        x: 0.5 * width,
        y: 0.7 * TITLE,
        content: title.into(),
        size: 16,
        anchor: TextAnchor::Middle,
        rotate: None,
        bold: false,
        color: None,
    }
}

/// Whether any two curves coincide to the eye: they are nowhere further apart than a 250th of the
/// extent of all. Points are compared in their order.
pub fn coincide(curves: &[Curve]) -> bool {
    let size = |part: fn(&(f64, f64)) -> f64| {
        let (lo, hi) = extent(curves.iter().flat_map(|curve| &curve.points).map(part))?;
        Some((hi - lo) / 250.0)
    };
    let (Some(x), Some(y)) = (size(|p| p.0), size(|p| p.1)) else { return false };
    let near = |a: &Curve, b: &Curve| {
        let mut pairs = a.points.iter().zip(&b.points);
        pairs.all(|(a, b)| (a.0 - b.0).abs() <= x && (a.1 - b.1).abs() <= y)
    };
    curves.iter().enumerate().any(|(i, a)| curves.iter().skip(i + 1).any(|b| near(a, b)))
}
