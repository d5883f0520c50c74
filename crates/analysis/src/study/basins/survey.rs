//! The search for the attractors and their basins.

use super::found::{Ended, Found, SEEN, Shown};
use super::known::{Known, Nearby};
use super::map::{BasinMap, Cell};
use super::path::Path;
use super::{Basins, MOST_ATTRACTORS, TOO_MANY, UNSETTLED, UNSTABLE};
use crate::study::ensemble::{Ensemble, GROUP, Watch};
use crate::study::metric::Metric;
use crate::study::outcome::{COMPLETED, Ending};
use crate::study::ranges::Ranges;
use crate::study::section::point;
use afterbay_core::{InputError, StateRef};
use std::ops::ControlFlow;

/// The most new attractors that are looked for between two comparisons of all runs.
const NEW_AT_ONCE: usize = 8;
/// The runs that are followed at once where those before have shown nothing new. It bounds the
/// states that are stored.
const TOGETHER: usize = 4 * GROUP;
/// The number of times that a run which has shown an attractor without a period is followed for as
/// many returns again, since that may have been a long transient.
const CONFIRMED: usize = 2;

/// A search: the attractors found so far, and the cells whose outcome is known.
pub(super) struct Survey<'a> {
    pub(super) basins: &'a Basins,
    pub(super) ensemble: Ensemble<'a>,
    /// The distance of states.
    pub(super) metric: Metric,
    pub(super) attractors: Vec<Known>,
    cells: Vec<Option<Cell>>,
}

impl<'a> Survey<'a> {
    /// A search that has not begun.
    ///
    /// # Errors
    /// Invalid input, such as a method that does not apply.
    pub(super) fn new(basins: &'a Basins, ensemble: Ensemble<'a>) -> Result<Self, InputError> {
        let metric = basins.metric(&ensemble)?;
        let size = basins.axes.iter().map(|axis| axis.values.len()).product();
        Ok(Self { basins, ensemble, metric, attractors: Vec::new(), cells: vec![None; size] })
    }

    /// The map, whose runs have the step h.
    pub(super) fn map(mut self, h: f64) -> Result<BasinMap, InputError> {
        for i in self.basins.samples() {
            self.discover(&[i])?;
        }
        loop {
            let open: Vec<usize> = self.open(0..self.cells.len());
            if open.is_empty() {
                break;
            }
            self.compare(&open)?;
            if self.is_full() {
                self.give_up();
                break;
            }
            // The runs that reach none of the attractors show new ones.
            let left = self.open(open);
            let (stride, before) = (left.len().div_ceil(NEW_AT_ONCE).max(1), self.attractors.len());
            for &i in left.iter().step_by(stride) {
                self.discover(&[i])?;
            }
            if self.attractors.len() > before {
                continue;
            }
            // Another comparison would give the same result. Each run is followed by itself.
            for group in left.chunks(TOGETHER) {
                if !self.is_full() {
                    self.discover(group)?;
                }
            }
        }
        let Self { ensemble, attractors, cells, .. } = self;
        let cells = cells.into_iter().flatten().collect();
        Ok(BasinMap { row: ensemble.row, h, attractors, cells })
    }

    /// The cells among `cells` whose outcome is not known.
    fn open(&self, cells: impl IntoIterator<Item = usize>) -> Vec<usize> {
        cells.into_iter().filter(|&i| self.cells[i].is_none()).collect()
    }

    /// Whether the number of attractors has reached its limit.
    fn is_full(&self) -> bool {
        self.attractors.len() >= MOST_ATTRACTORS
    }

    /// Leaves the open cells, whose runs reach none of the attractors.
    fn give_up(&mut self) {
        let ending = Ending { outcome: TOO_MANY, failure: None };
        let cell = Cell { attractor: None, periods: self.basins.longest, ending };
        for open in self.cells.iter_mut().filter(|cell| cell.is_none()) {
            *open = Some(cell.clone());
        }
    }

    /// Compares a run with the attractors, up to return number `longest`.
    fn nearby(&self, longest: u64) -> Nearby<'_> {
        let dof = self.basins.problem.model.degrees();
        Nearby::new(&self.metric, dof, &self.attractors, longest)
    }

    /// The known attractor that the points of a new one show, if they show one.
    fn same(&self, new: &Known) -> Option<usize> {
        // The points are repeated as often as the test of the longest cycle requires.
        let (mut nearby, points) = (self.nearby(u64::MAX), new.points());
        let again = points.iter().cycle().take(points.len().max(2 * SEEN));
        let _ = (1..).zip(again).try_for_each(|(n, point)| nearby.compare(n, point));
        nearby.reached
    }

    /// Compares the runs of open cells with the attractors.
    fn compare(&mut self, open: &[usize]) -> Result<(), InputError> {
        let watch = |&i: &usize| Ok((self.basins.member(i)?, self.nearby(self.basins.longest)));
        let members = open.iter().map(watch).collect::<Result<Vec<_>, InputError>>()?;
        let ended = self.ensemble.follow(members)?.into_iter();
        let ended: Vec<_> =
            ended.map(|(watch, ending)| (watch.reached, watch.returns, ending)).collect();
        for (&i, (attractor, periods, ending)) in open.iter().zip(ended) {
            if attractor.is_some() || !ending.is_completed() {
                self.cells[i] = Some(Cell { attractor, periods, ending });
            }
        }
        Ok(())
    }

    /// Follows the runs of open cells until each reaches an attractor or shows one, and adds that
    /// to the others if it is new.
    fn discover(&mut self, group: &[usize]) -> Result<(), InputError> {
        let open = self.open(group.iter().copied());
        let ended = if self.basins.is_autonomous() {
            self.look::<true>(&open)?
        } else {
            self.look::<false>(&open)?
        };
        for (i, (ended, ending)) in open.into_iter().zip(ended) {
            let full = self.is_full();
            let (ended, ending) =
                if full { (ended, ending) } else { self.confirmed(ended, ending)? };
            self.cells[i] = Some(self.outcome(ended, ending)?);
        }
        Ok(())
    }

    /// The outcome of a run. A new attractor that it shows is added to the others.
    fn outcome(
        &mut self,
        Ended { reached, returns: periods, shown }: Ended,
        ending: Ending,
    ) -> Result<Cell, InputError> {
        if reached.is_some() || !ending.is_completed() {
            return Ok(Cell { attractor: reached, periods, ending });
        }
        let found = match shown {
            Some(Shown::Known(known)) => Some(known),
            Some(Shown::Motion { from, extents }) => self.path(&from, extents)?,
            None => None,
        };
        let (attractor, outcome) = match found {
            None => (None, UNSETTLED),
            Some(found) => match self.same(&found) {
                Some(known) => (Some(known), COMPLETED),
                None if self.repels(found.cycle())? => (None, UNSTABLE),
                None if self.is_full() => (None, TOO_MANY),
                None => {
                    self.attractors.push(found);
                    (Some(self.attractors.len() - 1), COMPLETED)
                }
            },
        };
        Ok(Cell { attractor, periods, ending: Ending { outcome, ..ending } })
    }

    /// Follows runs until each reaches a known attractor or has settled.
    fn look<const STEPS: bool>(&self, open: &[usize]) -> Result<Vec<(Ended, Ending)>, InputError> {
        let nearby = self.nearby(self.basins.longest);
        let watch = |&i: &usize| Ok((self.basins.member(i)?, Found::<STEPS>::new(nearby.clone())));
        let members = open.iter().map(watch).collect::<Result<Vec<_>, InputError>>()?;
        let ended = self.ensemble.follow(members)?.into_iter();
        Ok(ended.map(|(watch, ending)| (watch.ended(), ending)).collect())
    }

    /// Follows a run that shows a new attractor without a period for longer.
    fn confirmed(
        &self,
        mut found: Ended,
        mut ending: Ending,
    ) -> Result<(Ended, Ending), InputError> {
        for _ in 0..CONFIRMED {
            let Ended { reached: None, returns, shown: Some(Shown::Known(known)) } = &found else {
                break;
            };
            if !ending.is_completed() {
                break;
            }
            let last = known.attractor.points().last().filter(|_| known.cycle().is_empty());
            let Some(last) = last.filter(|_| self.same(known).is_none()) else { break };
            let watch = Found::<false>::new(self.nearby(0));
            let mut run = self.basins.member_at(last)?;
            // A failure says when it happens.
            let interval = self.basins.section.interval(&run.model).unwrap_or(0.0);
            run.start.t = *returns as f64 * interval;
            let run = vec![(run, watch)];
            let Some((watch, new)) = self.ensemble.follow(run)?.pop() else { break };
            let ended = watch.ended();
            (found, ending) = (Ended { returns: returns + ended.returns, ..ended }, new);
        }
        Ok((found, ending))
    }

    /// The attractor of a motion without a drive that has settled: its path from a state on it.
    fn path(&self, from: &[f64], extents: Vec<f64>) -> Result<Option<Known>, InputError> {
        let path = Path::new(self.basins, &self.metric, extents);
        let ended = self.ensemble.follow(vec![(self.basins.member_at(from)?, path)])?.pop();
        Ok(ended.filter(|ended| ended.1.is_completed()).and_then(|(path, _)| path.known()))
    }
}

impl<const STEPS: bool> Watch for Found<'_, STEPS> {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, path: &Ranges) -> ControlFlow<()> {
        self.add(n, point(self.periods(), self.dof(), state).concat(), path)
    }

    fn step(&mut self, state: StateRef<'_, f64>) {
        if STEPS {
            let at = point(self.periods(), self.dof(), state).concat();
            self.pass(&at);
        }
    }

    const WANTS_STEPS: bool = STEPS;
}

impl Watch for Path<'_> {
    fn see(&mut self, n: u64, _: StateRef<'_, f64>, _: &Ranges) -> ControlFlow<()> {
        Self::goes_on(n)
    }

    fn step(&mut self, state: StateRef<'_, f64>) {
        let at = point(self.periods(), self.dof(), state).concat();
        self.pass(at);
    }

    const WANTS_STEPS: bool = true;
}

impl Watch for Nearby<'_> {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, _: &Ranges) -> ControlFlow<()> {
        let at = point(self.periods(), self.dof, state).concat();
        self.compare(n, &at)
    }
}
