//! Statistics of the local errors over the grid.

use crate::statistics::median;
use serde::{Deserialize, Serialize};

/// A statistic of all |T_i|.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The maximum.
    Max,
    /// The median.
    Median,
    /// The root mean square.
    Rms,
}

impl Statistic {
    /// All statistics, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Max, Self::Median, Self::Rms];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Max => "max",
            Self::Median => "median",
            Self::Rms => "rms",
        }
    }
}

/// Statistics of |T| of one variable over the grid.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Summary {
    max: f64,
    median: f64,
    rms: f64,
    /// The grid point of the maximum.
    pub(super) worst: usize,
}

impl Summary {
    /// The statistics of values at grid points.
    pub(super) fn of(points: impl Iterator<Item = (usize, f64)>) -> Self {
        let (mut sizes, mut worst, mut max, mut squares) = (Vec::new(), 0, 0.0, 0.0);
        for (i, size) in points {
            if size > max {
                (worst, max) = (i, size);
            }
            squares += size * size;
            sizes.push(size);
        }
        let rms = (squares / sizes.len().max(1) as f64).sqrt();
        Self { max, median: median(&mut sizes), rms, worst }
    }

    /// The value of a statistic.
    pub fn get(&self, statistic: Statistic) -> f64 {
        match statistic {
            Statistic::Max => self.max,
            Statistic::Median => self.median,
            Statistic::Rms => self.rms,
        }
    }
}
