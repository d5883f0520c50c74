//! The distance in which the states of basins are compared.

use super::Basins;
use crate::progress::Unseen;
use crate::study::ensemble::{Ensemble, Watch};
use crate::study::metric::Metric;
use crate::study::ranges::Ranges;
use afterbay_core::{InputError, StateRef};
use std::ops::ControlFlow;

/// The returns of each half of the runs that show how far motions go.
const RETURNS: u64 = 32;
/// The most by which a motion that stays where it is has a larger extent in the second half.
const GROWTH: f64 = 1.5;

impl Basins {
    /// The distance of states. The unit of an entry is the extent of the grid along it, or that of
    /// the motion if it is larger: the median of some runs that are spread over the grid. Runs that
    /// grow do not count.
    pub(super) fn metric(&self, ensemble: &Ensemble<'_>) -> Result<Metric, InputError> {
        let model = &self.problem.model;
        let (dof, periods) = (model.degrees(), model.periods());
        let watch =
            |i: usize| Ok((self.member(i)?, Halves([(); 2].map(|()| Ranges::nothing(dof)))));
        let members = self.samples().into_iter().map(watch);
        let members = members.collect::<Result<Vec<_>, InputError>>()?;
        let unseen = Unseen(ensemble.progress);
        let ended = Ensemble { progress: &unseen, ..*ensemble }.follow(members)?.into_iter();
        let completed = ended.filter(|(_, ending)| ending.is_completed());
        let moves: Vec<Vec<f64>> =
            completed.filter_map(|(halves, _)| halves.extents(&periods)).collect();
        let unit = |j: usize| {
            let mut each: Vec<f64> = moves.iter().map(|units| units[j]).collect();
            each.sort_by(f64::total_cmp);
            each.get(each.len() / 2).copied().unwrap_or(0.0).max(self.extent(j))
        };
        let mut units: Vec<f64> = (0..2 * dof).map(unit).collect();
        // An entry that does not move takes the largest unit of its kind.
        let largest = |units: &[f64]| units.iter().copied().fold(0.0, f64::max);
        let all = largest(&units);
        for kind in units.chunks_mut(dof) {
            let other = [largest(kind), all, 1.0].into_iter().find(|&unit| unit > 0.0);
            kind.iter_mut()
                .filter(|unit| **unit == 0.0)
                .for_each(|unit| *unit = other.unwrap_or(1.0));
        }
        Ok(Metric::with_units(&periods, units))
    }

    /// The extent of the grid along entry j of (q, p).
    fn extent(&self, j: usize) -> f64 {
        let along = self.axes.iter().filter(|axis| self.entry(axis) == j);
        let extent = |values: &[f64]| Some(values.last()? - values.first()?);
        along.filter_map(|axis| extent(&axis.values)).fold(0.0, f64::max)
    }
}

/// The ranges of the halves of a run.
struct Halves([Ranges; 2]);

impl Halves {
    /// The extents of the run, 0 for entries that do not move; none if an entry moves much further
    /// in the second half.
    fn extents(self, periods: &[Option<f64>]) -> Option<Vec<f64>> {
        let Self([first, second]) = self;
        let mut all = first.clone();
        all.join(&second);
        let extents = Metric::of(periods, &all, &all).moving_units();
        let stays = |j: usize| extents[j] == 0.0 || second.extent(j) <= GROWTH * first.extent(j);
        (0..extents.len()).all(stays).then_some(extents)
    }
}

impl Watch for Halves {
    fn see(&mut self, n: u64, _: StateRef<'_, f64>, path: &Ranges) -> ControlFlow<()> {
        self.0[usize::from(n > RETURNS)].join(path);
        if n >= 2 * RETURNS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
