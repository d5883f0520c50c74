//! The bifurcations of a branch, located between two of its cycles.

use super::Walk;
use super::place::{Place, dot};
use crate::study::limit_cycle::Event;
use crate::study::limit_cycle::event::{self, is_real};
use afterbay_core::solver::zero_within;

/// The value of a test function that counts as 0, as a share of the larger of its values at the
/// ends of the step.
const LOCATED: f64 = 1e-10;
/// Bifurcations of one kind nearer to each other than this share of the step in the parameter are
/// one, at which several multipliers pass. A choice.
const ALIKE: f64 = 1e-4;

impl Walk<'_> {
    /// The bifurcations between the present place and the next.
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
        if passing.len() <= explained {
            return found;
        }
        let value = |place: &Place| place.x[place.x.len() - 1];
        let near = ALIKE * (value(next) - value(&self.at)).abs();
        for rank in passing {
            let beyond = |place: &Place| event::beyond_circle(&place.cycle)[rank];
            let place = self.locate(next.clone(), beyond);
            let event = event::of_place(&place.cycle, rank);
            let is_found = |(of, other): &(Event, Place)| {
                *of == event && (value(other) - value(&place)).abs() <= near
            };
            if !found.iter().any(is_found) {
                found.push((event, place));
            }
        }
        found
    }

    /// The cycle between the present place and the next at which a test function is 0.
    ///
    /// Guesses lie between the nearest known cycles. From a guess that is further off, Newton's
    /// method may find a cycle of the branch that crosses at the zero.
    fn locate(&self, next: Place, test: impl Fn(&Place) -> f64) -> Place {
        let scales = &self.shooting.scales;
        let off = next.x.iter().zip(&self.at.x).zip(scales).map(|((b, a), scale)| (b - a) / scale);
        let far = dot(&off.collect::<Vec<_>>(), &self.at.along);
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
