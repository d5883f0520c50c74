//! The map of a method: the attractor of every cell.

use super::{Known, TOO_MANY, UNSETTLED, UNSTABLE};
use crate::statistics::fit;
use crate::study::outcome::Ending;
use crate::words::by_name;
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};

/// The map of a method and a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BasinMap {
    /// The method.
    #[serde(with = "by_name")]
    pub row: &'static Row,
    /// The step.
    pub h: f64,
    /// The attractors. Attractor number n has the index n - 1.
    pub attractors: Vec<Known>,
    /// The cells, row by row from the least value of the second axis.
    pub cells: Vec<Cell>,
}

/// The outcome of one initial state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// The index of the attractor.
    pub attractor: Option<usize>,
    /// Returns until it was known.
    pub periods: u64,
    /// The outcome of the run.
    pub ending: Ending,
}

impl BasinMap {
    /// Numbers the attractors as those of a reference that they are like, the nearest pairs first;
    /// new ones follow.
    pub fn renumber(&mut self, reference: &Self) {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (n, exact) in reference.attractors.iter().enumerate() {
            let own = self.attractors.iter().enumerate();
            pairs.extend(own.map(|(k, own)| (exact.distance(own), n, k)));
        }
        pairs.retain(|pair| pair.0 <= Known::ALIKE);
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut order: Vec<Option<usize>> = vec![None; self.attractors.len()];
        for (_, n, k) in pairs {
            if order[k].is_none() && !order.contains(&Some(n)) {
                order[k] = Some(n);
            }
        }
        let mut next = reference.attractors.len();
        let order: Vec<usize> = order
            .into_iter()
            .map(|known| {
                known.unwrap_or_else(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect();
        for cell in &mut self.cells {
            cell.attractor = cell.attractor.map(|k| order[k]);
        }
        let mut numbered: Vec<_> = reference.attractors.iter().cloned().map(Some).collect();
        numbered.resize(next, None);
        for (known, n) in self.attractors.drain(..).zip(order) {
            numbered[n] = Some(known);
        }
        self.attractors = numbered.into_iter().flatten().collect();
    }

    /// The share of the cells that reach each attractor.
    pub fn shares(&self) -> Vec<f64> {
        let share = |k| {
            let cells = self.cells.iter().filter(|cell| cell.attractor == Some(k)).count();
            cells as f64 / self.cells.len().max(1) as f64
        };
        (0..self.attractors.len()).map(share).collect()
    }

    /// The uncertainty exponent α of the boundary (Grebogi and others 1983): the share of cells
    /// with a cell of another attractor beside them at a distance ε grows like ε^α, and the
    /// dimension of the boundary is 2 - α. A run that fails counts as one that leaves for an
    /// attractor of its own; other cells without an attractor, and those beside them, are
    /// left out. None if the shares do not grow, as with too few cells.
    pub fn uncertainty(&self, width: usize) -> Option<f64> {
        let lines = self.lines(width);
        let shortest = lines.iter().map(|line| line.count).min()?;
        let distances: Vec<usize> =
            DISTANCES.into_iter().filter(|&apart| 4 * apart < shortest).collect();
        let margin = *distances.last()?;
        let beside = |i: usize, apart: usize| {
            lines.iter().flat_map(move |line| [i - apart * line.stride, i + apart * line.stride])
        };
        // The cells are the same at all distances, so that the shares count one boundary.
        let known = |&i: &usize| {
            let inside = lines.iter().all(|line| line.is_inside(i, margin));
            let settled = |&apart: &usize| beside(i, apart).all(|i| self.is_settled(i));
            inside && self.is_settled(i) && distances.iter().all(settled)
        };
        let compared: Vec<usize> = (0..self.cells.len()).filter(known).collect();
        let share = |&apart: &usize| {
            let differs = |i: &&usize| beside(**i, apart).any(|other| self.differ(**i, other));
            compared.iter().filter(differs).count() as f64 / compared.len().max(1) as f64
        };
        let points: Vec<(f64, f64)> = distances
            .iter()
            .map(|apart| (*apart as f64, share(apart)))
            .filter(|point| point.1 > 0.0)
            .map(|(apart, share)| (apart.ln(), share.ln()))
            .collect();
        fit(&points).map(|fit| fit.slope).filter(|&slope| slope > 0.0)
    }

    /// Whether there is a boundary: cells of two attractors side by side.
    pub fn has_boundary(&self, width: usize) -> bool {
        let is_boundary =
            |i, next| self.is_settled(i) && self.is_settled(next) && self.differ(i, next);
        (0..self.cells.len()).any(|i| {
            let beside = ((i + 1) % width != 0).then_some(i + 1);
            let above = Some(i + width).filter(|&above| above < self.cells.len());
            beside.into_iter().chain(above).any(|next| is_boundary(i, next))
        })
    }

    /// The directions of the grid that have enough cells for three distances, or else for two.
    fn lines(&self, width: usize) -> Vec<Line> {
        let along = Line { stride: 1, count: width };
        let across = Line { stride: width, count: self.cells.len() / width.max(1) };
        let longest = along.count.max(across.count);
        let least = if longest > 4 * DISTANCES[2] { 4 * DISTANCES[2] } else { 4 * DISTANCES[1] };
        [along, across].into_iter().filter(|line| line.count > least).collect()
    }

    /// Whether a cell has an attractor, or its run fails.
    fn is_settled(&self, i: usize) -> bool {
        ![UNSETTLED, TOO_MANY, UNSTABLE].contains(&self.cells[i].ending.outcome)
    }

    fn differ(&self, i: usize, other: usize) -> bool {
        self.cells[i].attractor != self.cells[other].attractor
    }
}

/// The distances, in cells, at which others are compared.
const DISTANCES: [usize; 4] = [1, 2, 4, 8];

/// A direction of a grid.
struct Line {
    /// From one cell to the next.
    stride: usize,
    /// The number of cells.
    count: usize,
}

impl Line {
    /// Whether a cell is at least `margin` from both ends.
    fn is_inside(&self, i: usize, margin: usize) -> bool {
        (margin..self.count - margin).contains(&(i / self.stride % self.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::REFERENCE;

    /// A map of two basins.
    fn map(width: usize, height: usize, is_first: impl Fn(usize, usize) -> bool) -> BasinMap {
        let cell = |i: usize| Cell {
            attractor: Some(usize::from(is_first(i % width, i / width))),
            periods: 1,
            ending: Ending::completed(),
        };
        let cells = (0..width * height).map(cell).collect();
        BasinMap { row: &REFERENCE, h: 0.1, attractors: Vec::new(), cells }
    }

    /// A smooth boundary has the dimension 1 in whatever direction it lies.
    #[test]
    fn a_smooth_boundary_has_the_exponent_1() {
        for (width, height) in [(100, 100), (40, 60), (1000, 9), (40, 3)] {
            for (map, what) in [
                (map(width, height, |i, _| 2 * i < width), "across"),
                (map(width, height, |_, j| 2 * j < height), "along"),
                (map(width, height, |i, j| i + j < (width + height) / 2), "oblique"),
            ] {
                assert!(map.has_boundary(width), "{what}");
                if what == "along" && height < 10 {
                    assert_eq!(map.uncertainty(width), None);
                    continue;
                }
                let found = map.uncertainty(width).expect("an exponent");
                // The strips about an oblique boundary are cut off at the corners.
                let most = if what == "oblique" { 0.1 } else { 1e-12 };
                assert!((found - 1.0).abs() < most, "{what}, {width} x {height}: {found}");
            }
        }
        let one = map(20, 20, |_, _| true);
        assert!(!one.has_boundary(20) && one.uncertainty(20).is_none());
    }
}
