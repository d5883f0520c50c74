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
        let points: Vec<(f64, f64)> = [1, 2, 4, 8]
            .into_iter()
            .filter(|&apart| 4 * apart < width)
            .map(|apart| (apart as f64, self.uncertain(width, apart)))
            .filter(|point| point.1 > 0.0)
            .map(|(apart, share)| (apart.ln(), share.ln()))
            .collect();
        fit(&points).map(|fit| fit.slope).filter(|&slope| slope > 0.0)
    }

    /// Whether there is a boundary: cells of two attractors side by side.
    pub fn has_boundary(&self, width: usize) -> bool {
        self.uncertain(width, 1) > 0.0
    }

    /// The share of cells with a cell of another attractor at a distance of `apart` cells.
    fn uncertain(&self, width: usize, apart: usize) -> f64 {
        let left_out = [UNSETTLED, TOO_MANY, UNSTABLE];
        let settled = |i: usize| !left_out.contains(&self.cells[i].ending.outcome);
        let beside = |i: usize| [i - apart, i + apart];
        let inner = |i: &usize| (apart..width.saturating_sub(apart)).contains(&(i % width));
        let known = |i: &usize| settled(*i) && beside(*i).into_iter().all(settled);
        let at = |i: usize| self.cells[i].attractor;
        let differs = |&i: &usize| beside(i).into_iter().any(|other| at(other) != at(i));
        let all: Vec<usize> = (0..self.cells.len()).filter(inner).filter(known).collect();
        all.iter().copied().filter(differs).count() as f64 / all.len().max(1) as f64
    }
}
