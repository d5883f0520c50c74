//! The share of one of several commands.

use afterbay_analysis::study::cell::Cell;
use std::str::FromStr;

/// One of several commands that share a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, counted from 1.
    pub number: usize,
    /// The number of all.
    pub count: usize,
}

impl Shard {
    /// A command that computes a study alone.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// Its cells: the plan in order of falling cost, dealt out one by one.
    pub fn cells(self, plan: &[Cell]) -> impl Iterator<Item = &Cell> {
        let mut order: Vec<&Cell> = plan.iter().collect();
        order.sort_by(|a, b| b.cost.total_cmp(&a.cost));
        order.into_iter().skip(self.number - 1).step_by(self.count)
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const WRONG: &str = "a shard is K/N with 1 ≤ K ≤ N, such as 3/8";
        let (number, count) = text.split_once('/').ok_or(WRONG)?;
        match (number.parse(), count.parse()) {
            (Ok(number), Ok(count)) if 1 <= number && number <= count => Ok(Self { number, count }),
            _ => Err(WRONG),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn shards_have_each_cell_once(
            costs in prop::collection::vec(0.0..9.0, 0..40),
            count in 1_usize..9,
        ) {
            let cell = |(index, &cost): (usize, &f64)| Cell::new(index.to_string(), cost);
            let plan: Vec<Cell> = costs.iter().enumerate().map(cell).collect();
            let mut found: Vec<&str> = (1..=count)
                .flat_map(|number| Shard { number, count }.cells(&plan).collect::<Vec<_>>())
                .map(|cell| &*cell.key)
                .collect();
            let mut all: Vec<&str> = plan.iter().map(|cell| &*cell.key).collect();
            found.sort_unstable();
            all.sort_unstable();
            prop_assert_eq!(found, all);
        }
    }
}
