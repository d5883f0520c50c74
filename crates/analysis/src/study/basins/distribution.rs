//! Whether the points of a run still move, by their distributions over its halves.

/// The least change of the extent from one half of the points to the other that shows that a run
/// has not settled. A choice: chaos shows less, since its halves are of 2000 points.
const CHANGE: f64 = 0.05;
/// The least move of the mean between these halves that shows it, as a share of their range.
const MOVE: f64 = 0.5;

/// Whether a run changes from the first half of its points to the second: an entry shrinks or
/// grows, in range and in standard deviation, or its mean moves. Entries whose range is smaller
/// than `least` of their units do not count.
pub(super) fn still_moves(
    [first, second]: &[Vec<Distribution>; 2],
    units: &[f64],
    least: f64,
) -> bool {
    first.iter().zip(second).zip(units).any(|((first, second), unit)| {
        let range = first.range().max(second.range());
        let (by_range, by_deviation) =
            ((second.range() / first.range()).ln(), (second.deviation() / first.deviation()).ln());
        let both = by_range.min(by_deviation) > CHANGE || by_range.max(by_deviation) < -CHANGE;
        range > least * unit && (both || (second.mean - first.mean).abs() > MOVE * range)
    })
}

/// The range, the mean and the standard deviation of one coordinate or momentum over points.
pub(super) struct Distribution {
    count: f64,
    mean: f64,
    /// The sum of the squared distances from the mean.
    square: f64,
    least: f64,
    most: f64,
}

impl Default for Distribution {
    fn default() -> Self {
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { count: 0.0, mean: 0.0, square: 0.0, least, most }
    }
}

impl Distribution {
    pub(super) fn add(&mut self, x: f64) {
        self.count += 1.0;
        let off = x - self.mean;
        self.mean += off / self.count;
        self.square += off * (x - self.mean);
        (self.least, self.most) = (self.least.min(x), self.most.max(x));
    }

    pub(super) fn range(&self) -> f64 {
        self.most - self.least
    }

    fn deviation(&self) -> f64 {
        (self.square / self.count).sqrt()
    }
}
