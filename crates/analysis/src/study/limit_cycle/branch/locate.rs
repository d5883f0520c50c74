//! The bifurcations of a branch, located between two of its cycles.

use super::Walk;
use super::place::{Place, dot};
use crate::study::limit_cycle::Event;
use crate::study::limit_cycle::event::{self, is_real};
use afterbay_core::solver::zero_within;

/// The value of a test function that counts as 0, as a share of the larger of its values at the
/// ends of the step.
const LOCATED: f64 = 1e-10;
/// Bifurcations of one kind nearer to each other than this share of the step are one, at which
/// several multipliers pass. A choice: the product of three factors is below [`LOCATED`] within a
/// thousandth of the step.
const ALIKE: f64 = 1e-2;

impl Walk<'_> {
    /// The bifurcations between the present place and the next, in their order along the branch.
    pub(super) fn located(&self, next: &Place) -> Vec<(Event, Place)> {
        if self.fresh {
            return Vec::new();
        }
        let mut explained = 0;
        let mut found = Vec::new();
        for (index, event) in event::between(&self.at.tests, &next.tests) {
            let place = self.locate(next.clone(), |place| place.tests[index]);
            if is_real(event, &place.cycle) {
                explained += event::multipliers((index, event));
                found.push((event, place));
            }
        }
        let passing = event::passing(&self.at.cycle, &next.cycle);
        if passing.len() > explained {
            passing.into_iter().for_each(|rank| self.add_passing(rank, next, &mut found));
        }
        found.sort_by(|(_, a), (_, b)| self.distance(&a.x).total_cmp(&self.distance(&b.x)));
        found
    }

    /// Adds the bifurcation at which the multiplier of a rank passes the unit circle, or puts it in
    /// place of one that is known less well: a product of several factors that vanish at once is 0
    /// to its roundings from afar, and a fold of two equal parts was taken for a branching, since
    /// the product keeps its sign.
    fn add_passing(&self, rank: usize, next: &Place, found: &mut Vec<(Event, Place)>) {
        let place = self.locate(next.clone(), |place| event::beyond_circle(&place.cycle)[rank]);
        let turns = self.at.tests[0] * next.tests[0] < 0.0;
        let Some(event) = event::of_rank(&place.cycle, rank, turns) else { return };
        let near = ALIKE * self.distance(&next.x).abs();
        let same = |event| if event == Event::Fold { Event::Branching } else { event };
        let known = found.iter_mut().find(|(other, there)| {
            let apart = self.distance(&there.x) - self.distance(&place.x);
            same(*other) == same(event) && apart.abs() <= near
        });
        match known {
            Some(known) => *known = (event, place),
            None => found.push((event, place)),
        }
    }

    /// The distance of unknowns from the present place, along the branch.
    fn distance(&self, x: &[f64]) -> f64 {
        let Place { x: from, along, .. } = &self.at;
        let off =
            x.iter().zip(from).zip(&self.shooting.scales).map(|((b, a), scale)| (b - a) / scale);
        dot(&off.collect::<Vec<_>>(), along)
    }

    /// The cycle between the present place and the next at which a test function is 0.
    ///
    /// Guesses lie between the nearest known cycles. From a guess that is further off, Newton's
    /// method may find a cycle of the branch that crosses at the zero.
    fn locate(&self, next: Place, test: impl Fn(&Place) -> f64) -> Place {
        let far = self.distance(&next.x);
        let ends = (test(&self.at), test(&next));
        let rounding = LOCATED * ends.0.abs().max(ends.1.abs());
        let mut known = vec![(0.0, self.at.x.clone()), (1.0, next.x.clone())];
        let within = |share: f64| {
            let above = known.partition_point(|(at, _)| *at < share);
            let [(low, a), (high, b)] = [&known[above - 1], &known[above]];
            let part = (share - low) / (high - low);
            let guess = a.iter().zip(b).map(|(a, b)| a + part * (b - a)).collect();
            let (place, _) = self.solve(guess, self.at_distance(share * far)).ok()?;
            known.insert(above, (share, place.x.clone()));
            let value = test(&place);
            Some((if value.abs() <= rounding { 0.0 } else { value }, place))
        };
        zero_within(ends, next, within).1
    }
}
