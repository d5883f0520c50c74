//! Curves over two axes.

use kuva::render::render::TextAnchor;

use super::axis::{Axis, MOST_TICKS, Scale, Span, extent};
use super::curve::{CANVAS, Curve, Style};
use super::dots::dots;
use super::drawing::Drawing;
use super::frame::{self, Frame};
use super::legend::{Legend, ROW};
use super::look::{self, GREY, Look};
use super::thin::thin;

/// The most points drawn for one curve, and for all curves of a chart.
const POINTS: (usize, usize) = (1500, 15_000);
/// The least share of the plot's width or height that a guide below its curve extends over. Where
/// there is less room, the guide is above.
const LEAST_GUIDE: f64 = 0.4;

/// Curves over two axes, each linear or logarithmic.
///
/// A point that an axis cannot show (not finite, or not positive on a logarithmic axis) is left
/// out: the line joins its neighbours, and a note below the chart gives the number of missing
/// points. A curve of more than 1500 points is thinned to that many, keeping the lowest and the
/// highest point of each stretch. A single curve has no legend. Where all points have at most eight
/// places on a logarithmic horizontal axis, as errors at some steps have, its ticks are there.
#[derive(Debug, Clone)]
pub struct LineChart {
    /// A short title above the plot.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves, drawn in this order.
    pub curves: Vec<Curve>,
    /// Slopes of guide lines, drawn if both axes are logarithmic. Each lies just below the lowest
    /// of the curves with the nearest slope at the coarse end, or above it where the plot ends.
    pub guides: Vec<f64>,
}

impl LineChart {
    /// A chart without guides.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x, y, curves, guides: Vec::new() }
    }

    /// The chart as a drawing.
    pub fn draw(&self) -> Drawing {
        let on_plot = |points: fn(&Curve) -> &Vec<Point>| -> Vec<Vec<Point>> {
            self.curves.iter().map(|curve| place(&self.x, &self.y, points(curve))).collect()
        };
        let (placed, bounds) = (on_plot(|curve| &curve.points), on_plot(|curve| &curve.bounds));
        let xs = || placed.iter().chain(&bounds).flatten().map(|p| p.0);
        let mut x_span = self.x.span(xs());
        if self.x.scale == Scale::Log {
            x_span = x_span.with_ticks_at(few(xs()));
        }
        let y_span = self.y.span(placed.iter().chain(&bounds).flatten().map(|p| p.1));
        let guides = self.guide_lines(&placed, &y_span);

        let legend = Legend::of(&self.curves);
        let notes = self.notes(&placed, &bounds);
        let size = (CANVAS.0 - legend.right, CANVAS.1);
        let below = legend.below + notes.len() as f64 * ROW;
        let room = (legend.right + legend.overhang, below);
        let mut frame = Frame::new(&self.title, (&self.x, x_span), (&self.y, y_span), size, room);
        frame.axes(true);
        for (_, from, to) in &guides {
            draw_guide(&mut frame, *from, *to);
        }
        let looks = Look::of_labels(self.curves.iter().map(|curve| curve.label.as_str()));
        self.draw_curves(&mut frame, &looks, &placed, &bounds);
        // Guide labels are drawn last, with a white rim, so that no curve crosses them.
        for (slope, from, to) in &guides {
            label_guide(&mut frame, *slope, *from, *to);
        }
        let (left, top, ..) = frame.plot();
        legend.entries((left, top), &self.curves, &looks).for_each(|entry| frame.add(entry));
        for (row, note) in notes.into_iter().enumerate() {
            let at = (CANVAS.0 - 12.0, CANVAS.1 + legend.below + (0.4 + row as f64) * ROW);
            frame.add(frame::note(note, at, TextAnchor::End));
        }
        frame.drawing()
    }

    fn draw_curves(
        &self,
        frame: &mut Frame,
        looks: &[Look],
        placed: &[Vec<Point>],
        bounds: &[Vec<Point>],
    ) {
        let most = most_points(self.curves.len());
        for ((curve, points), &look) in self.curves.iter().zip(placed).zip(looks) {
            if curve.style == Style::Dots {
                draw_curve(frame, look, curve.style, points);
            } else {
                draw_curve(frame, look, curve.style, &thin(points, most));
            }
        }
        for (bounds, look) in bounds.iter().zip(looks).filter(|(bounds, _)| !bounds.is_empty()) {
            let pixels: Vec<_> = thin(bounds, most).into_iter().map(|p| frame.pixel(p)).collect();
            frame.add(look.upper_bounds(&pixels, 4.0));
        }
    }

    /// The notes below the chart: on points that are not shown, and on upper bounds.
    fn notes(&self, placed: &[Vec<Point>], bounds: &[Vec<Point>]) -> Vec<String> {
        let all: usize = self.curves.iter().map(|curve| curve.points.len()).sum();
        let missing = all - placed.iter().map(Vec::len).sum::<usize>();
        let mut notes = Vec::new();
        if missing > 0 {
            let why = if [self.x.scale, self.y.scale].contains(&Scale::Log) {
                "zero, negative, not finite or beyond 1e300"
            } else {
                "not finite or beyond 1e300"
            };
            notes.push(format!("{missing} of {all} points are not shown: {why}"));
        }
        if bounds.iter().any(|bounds| !bounds.is_empty()) {
            notes.push(
                "hollow with an arrow: an upper bound, set by the doubt of the reference".into(),
            );
        }
        notes
    }

    /// The guides as slopes and end points, in coordinates along the axes.
    fn guide_lines(&self, placed: &[Vec<Point>], y: &Span) -> Vec<(f64, Point, Point)> {
        if self.x.scale == Scale::Linear || self.y.scale == Scale::Linear {
            return Vec::new();
        }
        let guide = |&slope: &f64| {
            let ends: Vec<_> =
                placed.iter().filter_map(|points| coarse_half(points, slope)).collect();
            let off = |(a, b): &(Point, Point)| ((b.1 - a.1) / (b.0 - a.0) - slope).abs();
            let nearest = ends.iter().map(off).min_by(f64::total_cmp)?;
            // The lowest of the curves with about this slope, so that the guide crosses none of
            // them.
            let alike = ends.iter().filter(|ends| off(ends) <= nearest + 0.2).map(|ends| ends.0);
            let height = |p: &Point| p.1 - slope * p.0;
            let coarse = alike.min_by(|a, b| height(a).total_cmp(&height(b)))?;
            let (first, last) = extent(placed.iter().flatten().map(|p| p.0))?;
            // The guide ends at the coarse end and where it leaves the plot.
            let clipped = |base: f64| {
                let (mut from, mut to) =
                    if slope > 0.0 { (first, coarse.0) } else { (coarse.0, last) };
                if slope != 0.0 {
                    let (a, b) = ((y.lo - base) / slope, (y.hi - base) / slope);
                    (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
                }
                (base, from, to)
            };
            let off = 0.07 * (y.hi - y.lo);
            let below = clipped(height(&coarse) - off);
            let run = below.2 - below.1;
            let short = run < LEAST_GUIDE * (last - first)
                && run * slope.abs() < LEAST_GUIDE * (y.hi - y.lo);
            let (base, from, to) = if short { clipped(height(&coarse) + off) } else { below };
            (to > from).then_some((slope, (from, base + slope * from), (to, base + slope * to)))
        };
        self.guides.iter().filter_map(guide).collect()
    }
}

pub(super) type Point = (f64, f64);

/// Points nearer to each other than this, in pixels, look like one.
const INVISIBLE: f64 = 0.05;

/// The end of a curve at which errors that fall with `slope` are largest, and the point halfway
/// along. Points beyond may lie on a floor of roundings.
fn coarse_half(points: &[Point], slope: f64) -> Option<(Point, Point)> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| if slope > 0.0 { b.0.total_cmp(&a.0) } else { a.0.total_cmp(&b.0) });
    let (coarse, middle) = (*points.first()?, *points.get(points.len() / 2)?);
    (coarse.0 != middle.0).then_some((coarse, middle))
}

fn draw_guide(frame: &mut Frame, from: Point, to: Point) {
    let ends = [frame.pixel(from), frame.pixel(to)];
    frame.add(look::stroke(&ends, GREY.into(), 1.0, Some("4 3")));
}

/// Labels a guide below its line, a quarter of the way up.
fn label_guide(frame: &mut Frame, slope: f64, from: Point, to: Point) {
    let (from, to) = (frame.pixel(from), frame.pixel(to));
    let (low, high) = if slope > 0.0 { (from, to) } else { (to, from) };
    let at = (low.0 + 0.25 * (high.0 - low.0), low.1 + 0.25 * (high.1 - low.1) + 7.0);
    let label = format!("slope {}", slope.to_string().replace('-', "−"));
    let label = if slope > 0.0 {
        frame::note(label, (at.0 + 8.0, at.1), TextAnchor::Start)
    } else {
        frame::note(label, (at.0 - 8.0, at.1), TextAnchor::End)
    };
    let rim = r##"stroke="#ffffff" stroke-width="3" paint-order="stroke""##;
    frame.group(rim, [label]);
}

/// The different coordinates, as many as an axis may have ticks and one more.
fn few(coordinates: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for x in coordinates {
        if found.len() <= MOST_TICKS && found.iter().all(|other| (x - other).abs() > 1e-9) {
            found.push(x);
        }
    }
    found
}

/// The coordinates along the axes of the points that both can show.
pub(super) fn place(x: &Axis, y: &Axis, points: &[Point]) -> Vec<Point> {
    points.iter().filter_map(|&(px, py)| Some((x.place(px)?, y.place(py)?))).collect()
}

/// The most points drawn for each of a number of curves.
pub(super) fn most_points(curves: usize) -> usize {
    POINTS.0.min(POINTS.1 / curves.max(1))
}

/// Draws a curve through `points`, in coordinates along the axes.
pub(super) fn draw_curve(frame: &mut Frame, look: Look, style: Style, points: &[Point]) {
    let pixels: Vec<_> = points.iter().map(|&at| frame.pixel(at)).collect();
    if style == Style::Dots {
        return frame.add(dots(look, &pixels));
    }
    if style == Style::Ring {
        return frame.add(look::rings(&pixels, 9.0));
    }
    if pixels.len() > 1 {
        let width = if pixels.len() > 400 { 1.3 } else { 1.9 };
        frame.group(r#"stroke-linejoin="round""#, [look.line(&pixels, width)]);
    }
    let Some(first) = pixels.first() else { return };
    let is_there = |at: &Point| (at.0 - first.0).hypot(at.1 - first.1) < INVISIBLE;
    if pixels.iter().all(is_there) {
        frame.add(look.markers(&[*first], 4.0));
    } else if style != Style::Line {
        let marked: Vec<_> =
            pixels.iter().copied().step_by(pixels.len().div_ceil(40).max(1)).collect();
        frame.add(look.markers(&marked, 4.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> LineChart {
        let curve = |label: &str| Curve {
            label: label.into(),
            points: points.clone(),
            bounds: Vec::new(),
            style: Style::Line,
        };
        LineChart {
            title: "energy".into(),
            x: Axis::linear("t [s]"),
            y: Axis::log("|K − K₀| [J]"),
            curves: vec![curve("a < b"), curve("c")],
            guides: vec![],
        }
    }

    #[test]
    fn zeros_on_a_log_axis_are_left_out_and_counted() {
        let svg = chart(vec![(0.0, 0.0), (1.0, 1e-14), (2.0, f64::NAN), (3.0, 1e-12)]).draw().svg();
        assert!(svg.contains("4 of 8 points are not shown"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(svg.contains("a &lt; b"));
    }

    #[test]
    fn a_long_curve_makes_a_small_chart() {
        let wave = |i: u32| (f64::from(i) * 0.01, 1e-12 * (2.0 + (f64::from(i) * 0.3).sin()));
        assert!(chart((0..20_001).map(wave).collect()).draw().svg().len() < 100_000);
    }

    #[test]
    fn an_empty_chart_still_has_axes() {
        assert!(chart(vec![]).draw().svg().contains("t [s]"));
    }

    #[test]
    fn upper_bounds_are_drawn_apart() {
        let mut chart = chart(vec![(0.0, 1e-3), (1.0, 1e-4)]);
        let without = chart.draw().svg();
        chart.curves[0].bounds = vec![(2.0, 1e-9)];
        let with = chart.draw().svg();
        assert!(!without.contains("hollow with an arrow") && with.contains("hollow with an arrow"));
        assert!(with.matches("<path").count() > without.matches("<path").count());
    }

    #[test]
    fn a_guide_keeps_its_slope() {
        let points = vec![(-4.0, -5.9), (-3.0, -6.0), (-2.0, -6.0), (-1.5, -5.0), (-1.0, -4.0)];
        let mut chart = chart(points.iter().map(|p| (10f64.powf(p.0), 10f64.powf(p.1))).collect());
        chart.x = Axis::log("h");
        chart.guides = vec![2.0, 4.0];
        let y = chart.y.span(points.iter().map(|p| p.1));
        let lines = chart.guide_lines(&[points], &y);
        assert_eq!(lines.len(), 2);
        for (slope, a, b) in lines {
            assert!(((b.1 - a.1) / (b.0 - a.0) - slope).abs() < 1e-9);
            assert!(a.1 >= y.lo - 1e-9 && b.1 <= y.hi + 1e-9);
            assert!(b.0 == -1.0 && b.1 < -4.0 && b.1 > -4.3, "just below the coarse end: {b:?}");
        }
        assert!(chart.draw().svg().contains("slope 4"));
    }

    #[test]
    fn a_guide_without_room_below_is_above() {
        let low: Vec<Point> = (0..=6).map(|i| (0.5 * f64::from(i), -15.0)).collect();
        let high: Vec<Point> = low.iter().map(|p| (p.0, -6.0 + p.0)).collect();
        let mut chart = chart(vec![]);
        (chart.x, chart.guides) = (Axis::log("t"), vec![0.5]);
        let (_, from, to) =
            chart.guide_lines(&[low, high], &chart.y.span([-15.0, -3.0].into_iter()))[0];
        assert!(to.1 > -15.0 && to.0 - from.0 > 1.2, "{from:?} {to:?}");
    }
}
