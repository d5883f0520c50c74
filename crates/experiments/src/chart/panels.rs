//! Several charts of one figure: curves that would hide one another, and maps of several methods.

use kuva::render::render::{Primitive, TextAnchor};

use super::axis::{Axis, extent};
use super::curve::{CANVAS, Curve};
use super::drawing::Drawing;
use super::frame::{Frame, note};
use super::heat::HeatMap;
use super::legend::{Legend, ROW};
use super::line::{Point, draw_curve, most_points, place};
use super::look::Look;
use super::thin::thin;

/// The size of a panel in pixels. Two of them are as wide as a chart, three as a report.
const PANEL: (f64, f64) = (380.0, 300.0);
/// The height of the title above the panels, in pixels.
const TITLE: f64 = 34.0;

/// The largest ratio of the extents of two panels that share a vertical axis.
const ALIKE: f64 = 100.0;

/// Curves in small charts side by side, which have one legend and the same axes. Each has its own
/// vertical axis where the curves of one would be a flat line beside another's, and its own
/// horizontal axis, if that is allowed, where they would be an upright line.
#[derive(Debug, Clone)]
pub struct Panels {
    /// A short title above all panels.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// Whether the panels may have horizontal axes of their own.
    pub own_x: bool,
    /// The vertical axis.
    pub y: Axis,
    /// The title and the curves of each panel. The curves of all have the labels of the first.
    pub panels: Vec<(String, Vec<Curve>)>,
}

impl Panels {
    /// The panels as one drawing.
    pub fn draw(&self) -> Drawing {
        let placed: Vec<Vec<Vec<Point>>> = self
            .panels
            .iter()
            .map(|(_, curves)| {
                curves.iter().map(|curve| place(&self.x, &self.y, &curve.points)).collect()
            })
            .collect();
        let all = || placed.iter().flatten().flatten();
        let own_scales = extents_differ(&placed, |p| p.1);
        let own_x = self.own_x && extents_differ(&placed, |p| p.0);
        let most = most_points(placed.iter().map(Vec::len).sum());
        let panel = |((title, curves), placed): (&(String, Vec<Curve>), &Vec<Vec<Point>>)| {
            let y_span = if own_scales {
                self.y.span(placed.iter().flatten().map(|p| p.1))
            } else {
                self.y.span(all().map(|p| p.1))
            };
            let x_span = if own_x {
                self.x.span(placed.iter().flatten().map(|p| p.0))
            } else {
                self.x.span(all().map(|p| p.0))
            };
            let axes = ((&self.x, x_span), (&self.y, y_span));
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
        let differ = match (own_x, own_scales) {
            (true, true) => Some("the scales differ"),
            (true, false) => Some("the horizontal scales differ"),
            (false, true) => Some("the vertical scales differ"),
            (false, false) => None,
        };
        if let Some(differ) = differ {
            let at = (drawing.size.0 - 24.0, CANVAS.1 + 0.4 * ROW);
            drawing.elements.push(note(differ, at, TextAnchor::End));
        }
        drawing.elements.push(Primitive::GroupEnd);
        drawing.size.1 += legend.below;
        drawing
    }
}

/// Whether the curves of one panel extend over far more of an axis than those of another.
fn extents_differ(panels: &[Vec<Vec<Point>>], along: fn(&Point) -> f64) -> bool {
    uneven(panels.iter().map(|curves| extent(curves.iter().flatten().map(along))))
}

/// Whether a curve would be flat in a plot that shows all of another.
pub(crate) fn dwarf(curves: &[Curve]) -> bool {
    uneven(curves.iter().map(|curve| extent(curve.points.iter().map(|p| p.1))))
}

fn uneven(extents: impl Iterator<Item = Option<(f64, f64)>>) -> bool {
    extent(extents.flatten().map(|(lo, hi)| hi - lo))
        .is_some_and(|(least, largest)| largest > ALIKE * least && least > 0.0)
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
/// extent of all. Points are compared in their order. Curves that are all the same line, such as
/// quantities that are 0, need not be told apart.
pub fn coincide(curves: &[Curve]) -> bool {
    let size = |part: fn(&(f64, f64)) -> f64| {
        let (lo, hi) = extent(curves.iter().flat_map(|curve| &curve.points).map(part))?;
        Some((hi - lo) / 250.0)
    };
    let (Some(x), Some(y)) = (size(|p| p.0), size(|p| p.1)) else { return false };
    if y <= 0.0 {
        return false;
    }
    let near = |a: &Curve, b: &Curve| {
        let mut pairs = a.points.iter().zip(&b.points);
        pairs.all(|(a, b)| (a.0 - b.0).abs() <= x && (a.1 - b.1).abs() <= y)
    };
    curves.iter().enumerate().any(|(i, a)| curves.iter().skip(i + 1).any(|b| near(a, b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Style;

    fn curve(label: &str, shift: f64) -> Curve {
        let points = (0..100).map(|i| (f64::from(i), (f64::from(i) * 0.1).sin() + shift)).collect();
        Curve { label: label.into(), points, bounds: Vec::new(), style: Style::Line }
    }

    #[test]
    fn curves_coincide_where_none_is_seen_beside_the_other() {
        let with = |shift| coincide(&[curve("a", 0.0), curve("b", 1.0), curve("c", shift)]);
        assert!(with(0.001) && with(1.001));
        assert!(!with(0.1) && !with(-3.0));
        assert!(!coincide(&[curve("a", 0.0)]) && !coincide(&[]));
        let flat = Curve { points: vec![(0.0, 2.0), (1.0, 2.0)], ..curve("flat", 0.0) };
        assert!(!coincide(&[flat.clone(), flat]));
    }

    #[test]
    fn panels_share_axes_and_one_legend() {
        let panel = |title: &str, shift| {
            (title.to_owned(), vec![curve("H", shift), curve("K", shift + 1.0)])
        };
        let panels = Panels {
            title: "Energy".into(),
            x: Axis::linear("t"),
            own_x: false,
            y: Axis::linear("energy"),
            panels: vec![panel("rk4", 0.0), panel("moddg", 50.0), panel("leapfrog", 0.0)],
        };
        let svg = panels.draw().svg();
        assert_eq!(svg.matches(">K</text>").count(), 1, "the legend");
        assert_eq!(svg.matches(">20</text>").count(), svg.matches(">40</text>").count());
        assert!(svg.matches(">40</text>").count() >= 3, "each panel reaches to 50");
        assert!(["Energy", "rk4", "moddg", "leapfrog"].iter().all(|text| svg.contains(text)));
    }

    #[test]
    fn a_panel_that_diverges_leaves_the_others_readable() {
        let mut burst = curve("H", 0.0);
        burst.points.iter_mut().for_each(|p| p.1 = 1e80 * p.0);
        let panels = Panels {
            title: "Energy".into(),
            x: Axis::linear("t"),
            own_x: false,
            y: Axis::linear("energy"),
            panels: vec![("rk4".into(), vec![burst]), ("moddg".into(), vec![curve("H", 0.0)])],
        };
        let svg = panels.draw().svg();
        assert!(svg.contains("the vertical scales differ"));
        assert!(svg.contains(">0.5</text>"), "the panel of moddg reaches from -1 to 1");
    }

    #[test]
    fn a_panel_may_have_its_own_horizontal_axis() {
        let mut burst = curve("path", 0.0);
        burst.points.iter_mut().for_each(|p| p.0 *= -1e17);
        let panels = Panels {
            title: "Phase plane".into(),
            x: Axis::linear("q1"),
            own_x: true,
            y: Axis::linear("p1"),
            panels: vec![("rk4".into(), vec![burst]), ("moddg".into(), vec![curve("path", 0.0)])],
        };
        let svg = panels.draw().svg();
        assert!(svg.contains(">60</text>"), "the panel of moddg reaches to 99");
        assert!(svg.contains("the horizontal scales differ"));
        let shared = Panels { own_x: false, ..panels };
        assert!(!shared.draw().svg().contains(">60</text>"));
    }
}
