//! Very many points, as dots of equal size.

use kuva::render::render::Primitive;
use std::collections::BTreeSet;

use super::look::{self, Look};

/// Up to this number, points are circles.
const FEW: usize = 400;
/// The radius of such a circle in pixels.
const RADIUS: f64 = 1.6;
/// The number of points from which dots are as small as a pixel. Fewer have sides of 1.5 pixels.
const MANY: usize = 20_000;

/// Dots at `points`, in pixels. Points in the same pixel are one dot, and dots above each other one
/// bar, so that a million points make a chart no larger than its pixels.
pub(super) fn dots(look: Look, points: &[(f64, f64)]) -> Primitive {
    if points.len() <= FEW {
        let circle = |&(x, y): &(f64, f64)| {
            let (r, d) = (RADIUS, 2.0 * RADIUS);
            format!("M{:.1} {y:.1}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", x - r)
        };
        return look::area(points.iter().map(circle).collect(), look.colour());
    }
    let side = if points.len() < MANY { 1.5 } else { 1.0 };
    let cell = |&(x, y): &(f64, f64)| ((x / side).floor() as i64, (y / side).floor() as i64);
    let cells: BTreeSet<(i64, i64)> = points.iter().map(cell).collect();
    let mut path = String::new();
    let mut cells = cells.into_iter().peekable();
    while let Some((x, y)) = cells.next() {
        let mut end = y;
        while cells.next_if_eq(&(x, end + 1)).is_some() {
            end += 1;
        }
        let (left, top, height) = (x as f64 * side, y as f64 * side, (end + 1 - y) as f64 * side);
        path.push_str(&format!("M{left} {top}h{side}v{height}h-{side}z"));
    }
    look::area(path, look.colour())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_of_one_pixel_are_one() {
        let look = Look::of_labels(["a"])[0];
        let many: Vec<_> = (0..30_000).map(|i| (10.0 + 0.00001 * f64::from(i), 7.5)).collect();
        let Primitive::Path(path) = dots(look, &many) else { panic!("a path") };
        assert_eq!(path.d, "M10 7h1v1h-1z");
        let bar: Vec<_> = (0..1000).map(|i| (3.2, 0.15 * f64::from(i))).collect();
        let Primitive::Path(path) = dots(look, &bar) else { panic!("a path") };
        assert_eq!(path.d, "M3 0h1.5v150h-1.5z");
    }
}
