//! Bifurcations of cycles along a branch.
//!
//! ```text
//! fold                dλ/ds and Π (μ_i - 1) change their signs
//! branching           one of the two changes its sign, and the other does not
//! period doubling     Π (μ_i + 1) changes its sign
//! Neimark-Sacker      Π_{i<j} (μ_i μ_j - 1) changes its sign, by a complex pair
//! ```
//!
//! The products are over the nontrivial multipliers μ_i. They keep their signs where two
//! multipliers pass at once, as those of equal parts do: more multipliers then pass the unit circle
//! than these events explain, and |μ_i| - 1 of each of them changes its sign.
//!
//! At a branching the continuation may go on along the branch that crosses: where a symmetry is
//! lost, dλ/ds changes its sign there, and the mirror image of the cycles before follows. Source:
//! Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory (2004), section 10.3.

use super::Cycle;
use super::multipliers::{Complex, product};
use serde::{Deserialize, Serialize};

/// The imaginary part above which a multiplier is one of a complex pair.
const COMPLEX: f64 = 1e-6;
/// The distance from the unit circle of a pair that a Neimark-Sacker bifurcation has.
const ON_CIRCLE: f64 = 1e-3;

/// The distance from the unit circle from which a multiplier is inside or outside of it. A choice:
/// the multipliers of parts without friction stay on the circle to their roundings.
const OFF_CIRCLE: f64 = 1e-6;
/// The imaginary part up to which a multiplier on the circle is 1 or -1. A choice: roundings part
/// two equal multipliers by their square root.
const REAL: f64 = 1e-3;

/// A bifurcation of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// The branch turns back in the parameter: a multiplier goes through +1.
    Fold,
    /// Another branch crosses, as where a symmetry is lost: a multiplier goes through +1 where the
    /// branch does not turn, or the branch turns where none does.
    Branching,
    /// A multiplier goes through -1: a cycle of twice the period branches off.
    PeriodDoubling,
    /// A complex pair of multipliers goes through the unit circle: a torus branches off.
    NeimarkSacker,
}

/// The functions whose changes of sign are bifurcations, in the order of [`EVENTS`].
pub(super) type Tests = [f64; 4];

/// The events in the order in which they are looked for.
pub(super) const EVENTS: [Event; 4] =
    [Event::Fold, Event::Branching, Event::PeriodDoubling, Event::NeimarkSacker];

/// The test functions of a cycle, with dλ/ds.
pub(super) fn tests(cycle: &Cycle, slope: f64) -> Tests {
    let all = cycle.nontrivial();
    let off = |x: f64| all.iter().fold([1.0, 0.0], |all, [re, im]| product(all, [re + x, *im]))[0];
    let mut pairs = [1.0, 0.0];
    for (i, &a) in all.iter().enumerate() {
        for &b in &all[i + 1..] {
            let [re, im] = product(a, b);
            pairs = product(pairs, [re - 1.0, im]);
        }
    }
    [slope, off(-1.0), off(1.0), pairs[0]]
}

/// The bifurcations between two cycles, with the indices of the test functions that find them.
/// At a fold both dλ/ds and Π (μ_i - 1) change their signs; it is reported once.
pub(super) fn between(before: &Tests, after: &Tests) -> Vec<(usize, Event)> {
    let changes = |i: usize| before[i] * after[i] < 0.0;
    let (turns, passes) = (changes(0), changes(1));
    let named = |i: usize| match EVENTS[i] {
        Event::Fold if !passes => (i, Event::Branching),
        event => (i, event),
    };
    let found = (0..EVENTS.len()).filter(|&i| changes(i) && !(turns && i == 1));
    found.map(named).collect()
}

/// The number of multipliers that pass the unit circle at the bifurcation that a test function
/// finds.
pub(super) fn multipliers((index, event): (usize, Event)) -> usize {
    match event {
        // The branch turns, and an even number of multipliers passes, most often none.
        Event::Branching if index == 0 => 0,
        Event::Fold | Event::Branching | Event::PeriodDoubling => 1,
        Event::NeimarkSacker => 2,
    }
}

/// |μ| - 1 of the nontrivial multipliers, the largest first.
pub(super) fn beyond_circle(cycle: &Cycle) -> Vec<f64> {
    cycle.nontrivial().iter().map(|[re, im]| re.hypot(*im) - 1.0).collect()
}

/// The ranks, in the order of size, of the multipliers that pass the unit circle between two
/// cycles.
pub(super) fn passing(before: &Cycle, after: &Cycle) -> Vec<usize> {
    // Multipliers below the roundings of the largest are not known.
    if [before, after].iter().any(|of| of.lost_below.is_some_and(|bound| bound >= 1.0)) {
        return Vec::new();
    }
    let [before, after] = [before, after].map(beyond_circle);
    let passes = |(a, b): (&f64, &f64)| a.abs().min(b.abs()) > OFF_CIRCLE && a * b < 0.0;
    let pairs = before.iter().zip(&after).enumerate();
    pairs.filter(|(_, pair)| passes(*pair)).map(|(rank, _)| rank).collect()
}

/// The bifurcation at which the multiplier of a rank is on the unit circle; none if it is not.
/// `turns` tells whether the branch turns back.
pub(super) fn of_rank(cycle: &Cycle, rank: usize, turns: bool) -> Option<Event> {
    let [re, im] = cycle.nontrivial()[rank];
    if (re.hypot(im) - 1.0).abs() > ON_CIRCLE {
        return None;
    }
    Some(match (im.abs() > REAL, re > 0.0) {
        (true, _) => Event::NeimarkSacker,
        (false, false) => Event::PeriodDoubling,
        (false, true) if turns => Event::Fold,
        (false, true) => Event::Branching,
    })
}

/// Whether a cycle at which a test function is 0 has that bifurcation. The product of two real
/// multipliers may be 1 without one.
pub(super) fn is_real(event: Event, cycle: &Cycle) -> bool {
    let on_circle =
        |[re, im]: &Complex| im.abs() > COMPLEX && (re.hypot(*im) - 1.0).abs() < ON_CIRCLE;
    event != Event::NeimarkSacker || cycle.nontrivial().iter().any(on_circle)
}

#[cfg(test)]
mod tests_of_events {
    use super::*;

    fn cycle(multipliers: &[Complex]) -> Cycle {
        Cycle {
            value: Some(1.0),
            h: 0.1,
            period: 1.0,
            multiple: Some(1),
            start: [vec![0.0], vec![0.0]],
            amplitude: vec![1.0],
            multipliers: multipliers.to_vec(),
            lost_below: None,
        }
    }

    fn found(before: (&[Complex], f64), after: (&[Complex], f64)) -> Vec<Event> {
        let [before, after] = [before, after].map(|(all, slope)| tests(&cycle(all), slope));
        between(&before, &after).into_iter().map(|(_, event)| event).collect()
    }

    #[test]
    fn each_bifurcation_is_named() {
        let real = |a: f64, b: f64| [[a, 0.0], [b, 0.0]];
        let pair = |r: f64| [[r * 0.6, r * 0.8], [r * 0.6, -r * 0.8]];
        let still = real(0.5, 0.3);
        assert_eq!(found((&still, 1.0), (&real(0.9, 0.1), 1.0)), []);
        assert_eq!(found((&still, 1.0), (&real(1.1, 0.1), -1.0)), [Event::Fold]);
        assert_eq!(found((&still, 1.0), (&real(1.1, 0.1), 1.0)), [Event::Branching]);
        // It turns onto the other branch, on which the multiplier is below 1 again.
        assert_eq!(found((&still, 1.0), (&real(0.9, 0.1), -1.0)), [Event::Branching]);
        assert_eq!(found((&still, 1.0), (&real(-1.1, 0.1), 1.0)), [Event::PeriodDoubling]);
        assert_eq!(found((&pair(0.9), 1.0), (&pair(1.1), 1.0)), [Event::NeimarkSacker]);
        assert!(is_real(Event::NeimarkSacker, &cycle(&pair(1.0))));
        let twice = [real(0.9, 0.9), real(1.1, 1.1)];
        // Their product passes 1, which is no bifurcation of its own.
        assert_eq!(found((&twice[0], 1.0), (&twice[1], 1.0)), [Event::NeimarkSacker]);
        assert!(!is_real(Event::NeimarkSacker, &cycle(&real(1.0, 1.0))));
        assert_eq!(passing(&cycle(&twice[0]), &cycle(&twice[1])), [0, 1]);
        assert!(passing(&cycle(&pair(1.0 - 1e-9)), &cycle(&pair(1.0 + 1e-9))).is_empty());
        for (at, turns, event) in [
            (real(1.0, 1.0), false, Some(Event::Branching)),
            (real(1.0, 1.0), true, Some(Event::Fold)),
            (real(-1.0, -1.0), false, Some(Event::PeriodDoubling)),
            (pair(1.0), false, Some(Event::NeimarkSacker)),
            (pair(0.9), false, None),
        ] {
            assert_eq!(of_rank(&cycle(&at), 1, turns), event);
        }
    }
}
