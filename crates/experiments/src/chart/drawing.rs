//! A finished chart: SVG text, or the pixels of a PNG file.

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::{PathData, Primitive, Scene};

/// Pixels of a PNG file for one pixel of the chart.
const SCALE: f32 = 2.0;
/// The width in pixels beyond which a chart is marked as wide, for the style sheet of the report.
const WIDE: f64 = 800.0;

/// A chart with all its elements placed.
#[derive(Debug, Clone)]
pub struct Drawing {
    pub(super) title: String,
    pub(super) size: (f64, f64),
    pub(super) elements: Vec<Primitive>,
    pub(super) font: Option<String>,
}

impl Drawing {
    /// The chart as SVG text, with a view box so that it can be shown at any width.
    pub fn svg(&self) -> String {
        let svg = SvgBackend::new().render_scene(&self.scene(self.elements.clone()));
        let (w, h) = self.size;
        let title = maud::html! { (self.title) }.into_string();
        let class = if w > WIDE { r#" class="wide""# } else { "" };
        svg.replacen(
            "<svg ",
            &format!(r#"<svg viewBox="0 0 {w} {h}" role="img" aria-label="{title}"{class} "#),
            1,
        )
    }

    /// The chart as a PNG file, with two pixels for each pixel of the chart.
    ///
    /// # Errors
    /// A message if the picture cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let elements = self.elements.iter().map(with_dashes_drawn).collect();
        PngBackend::new().with_scale(SCALE).render_scene(&self.scene(elements))
    }

    /// Drawings of equal size in rows of `columns`, below `top` pixels.
    pub(super) fn grid(title: &str, drawings: Vec<Self>, columns: usize, top: f64) -> Self {
        let (w, h) = drawings.first().map_or((0.0, 0.0), |first| first.size);
        let font = drawings.first().and_then(|first| first.font.clone());
        let columns = columns.min(drawings.len()).max(1);
        let rows = drawings.len().div_ceil(columns);
        let mut elements = Vec::new();
        for (nth, drawing) in drawings.into_iter().enumerate() {
            let (x, y) = ((nth % columns) as f64 * w, top + (nth / columns) as f64 * h);
            let transform = Some(format!("translate({x},{y})"));
            elements.push(Primitive::GroupStart { transform, title: None, extra_attrs: None });
            elements.extend(drawing.elements);
            elements.push(Primitive::GroupEnd);
        }
        let size = (columns as f64 * w, top + rows as f64 * h);
        Self { title: title.into(), size, elements, font }
    }

    fn scene(&self, elements: Vec<Primitive>) -> Scene {
        let mut scene = Scene::new(self.size.0, self.size.1);
        scene.font_family.clone_from(&self.font);
        scene.text_color = Some("#1a1a1a".into());
        scene.elements = elements;
        scene
    }
}

/// The element with each dash as a line of its own. The rasteriser begins its dashes anew at every
/// point of a curve, which leaves a curve of many points solid.
fn with_dashes_drawn(element: &Primitive) -> Primitive {
    let Primitive::Path(path) = element else { return element.clone() };
    let Some(pattern) = &path.stroke_dasharray else { return element.clone() };
    let pattern: Vec<f64> = pattern.split(' ').filter_map(|part| part.parse().ok()).collect();
    let d = dashes(&points(&path.d), &pattern);
    Primitive::Path(Box::new(PathData { d, stroke_dasharray: None, ..(**path).clone() }))
}

/// The points of path data that has only absolute lines.
fn points(d: &str) -> Vec<(f64, f64)> {
    let point = |pair: &str| {
        let (x, y) = pair.split_once(' ')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    };
    d.split(['M', 'L']).filter_map(point).collect()
}

/// Path data of the dashes along a line through `points`.
fn dashes(points: &[(f64, f64)], pattern: &[f64]) -> String {
    let mut d = String::new();
    let Some(&longest) = pattern.iter().max_by(|a, b| a.total_cmp(b)) else { return d };
    if longest.is_nan() || longest <= 0.0 {
        return d;
    }
    let mut lengths = pattern.iter().copied().cycle();
    let (mut left, mut drawn) = (lengths.next().unwrap_or(longest), true);
    for (nth, pair) in points.windows(2).enumerate() {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        let at = |along: f64| {
            let share = if length > 0.0 { along / length } else { 0.0 };
            format!("{:.2} {:.2}", x0 + share * (x1 - x0), y0 + share * (y1 - y0))
        };
        if nth == 0 {
            d.push_str(&format!("M{}", at(0.0)));
        }
        let mut along = 0.0;
        while along + left < length {
            along += left;
            d.push_str(&format!("{}{}", if drawn { 'L' } else { 'M' }, at(along)));
            drawn = !drawn;
            left = lengths.next().unwrap_or(longest);
        }
        left -= length - along;
        if drawn {
            d.push_str(&format!("L{}", at(length)));
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_on_across_the_points_of_a_curve() {
        let line = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (10.0, 0.0)];
        let drawn = "M0.00 0.00L1.00 0.00L2.00 0.00L3.00 0.00M5.00 0.00L8.00 0.00M10.00 0.00";
        assert!(drawn.starts_with(&dashes(&line, &[3.0, 2.0])));
        assert_eq!(dashes(&line, &[]), "");
        assert_eq!(points("M0.5 1L2 -3.5"), [(0.5, 1.0), (2.0, -3.5)]);
    }
}
