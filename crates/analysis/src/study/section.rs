//! Sections: the states at which a run is observed, so that its motion becomes a map.

use super::side::Side;
use crate::Model;
use crate::Variable;
use crate::digits::significant;
use afterbay_core::{Grid, InputError, StateRef};
use afterbay_methods::registry::{REFERENCE, Row};
use serde::{Deserialize, Serialize};

/// The states at which a run is observed.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// Once in every interval of time.
    Stroboscopic {
        /// The interval [default: the period of the drive]. Under a drive it is a multiple of its
        /// period ([`is_multiple`]), since the clock of the drive starts at 0 in each interval.
        interval: Option<f64>,
    },
    /// The crossing of a value by a coordinate or a momentum.
    Crossing(Crossing),
}

/// A crossing of a value by a coordinate or a momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Q or P.
    pub variable: Variable,
    /// The degree of freedom, counted from 0.
    pub dof: usize,
    /// The value.
    pub value: f64,
    /// The direction of the crossing.
    pub direction: Direction,
}

/// The direction of a crossing.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// From below.
    #[default]
    Rising,
    /// From above.
    Falling,
    /// From either side.
    Both,
}

impl Direction {
    /// The direction of the event that locates the crossing.
    pub fn of_core(self) -> afterbay_core::Direction {
        match self {
            Self::Rising => afterbay_core::Direction::Rising,
            Self::Falling => afterbay_core::Direction::Falling,
            Self::Both => afterbay_core::Direction::Both,
        }
    }
}

/// The reason why states cannot be taken once in a period.
const UNTIMED: &str = "no period of the forces is known: give an interval";
/// The least number of steps of the reference in an interval: the error of DOP853 is then some
/// 1e-10 of a smooth motion.
pub const LEAST_STEPS: f64 = 32.0;
/// The most steps between two crossings. A run that takes more does not return.
pub(crate) const MOST_STEPS_BETWEEN: u64 = 1_000_000;

impl Section {
    /// The steps between two states of the section. A stroboscopic interval is divided into whole
    /// steps of nearly h; a crossing takes steps of h, at most a million of them.
    ///
    /// # Errors
    /// Those of [`Grid::of`], [`InputError::Unsupported`] without an interval, and
    /// [`InputError::Parameter`] if the drive does not repeat after it.
    pub fn grid(&self, model: &Model, h: f64) -> Result<Grid<f64>, InputError> {
        match self.interval(model) {
            Some(interval) => {
                Grid::<f64>::of(h, 1)?;
                let repeats = |period| is_multiple(interval, period);
                if !model.motors().is_empty() && !model.drive_period().is_some_and(repeats) {
                    let range = "a multiple of the period of the drive";
                    return Err(InputError::Parameter { name: "interval", value: interval, range });
                }
                let steps = (interval / h).round().max(1.0);
                Grid::of(interval / steps, steps as u64)
            }
            None if matches!(self, Self::Crossing(_)) => Grid::of(h, MOST_STEPS_BETWEEN),
            None => Err(InputError::Unsupported { method: "a stroboscopic section", why: UNTIMED }),
        }
    }

    /// [`Section::grid`] of a method. The reference takes at least [`LEAST_STEPS`] steps in an
    /// interval, which a parameter of the drive may shorten.
    ///
    /// # Errors
    /// Those of [`Section::grid`].
    pub(super) fn grid_of(
        &self,
        row: &Row,
        model: &Model,
        h: f64,
    ) -> Result<Grid<f64>, InputError> {
        let shortest = self.interval(model).filter(|_| row.name == REFERENCE.name);
        self.grid(model, shortest.map_or(h, |all| h.min(all / LEAST_STEPS)))
    }

    /// The interval of a stroboscopic section.
    pub fn interval(&self, model: &Model) -> Option<f64> {
        match self {
            Self::Stroboscopic { interval } => interval.or_else(|| model.drive_period()),
            Self::Crossing(_) => None,
        }
    }

    /// The section in words.
    pub fn describe(&self, model: &Model) -> String {
        match self {
            Self::Stroboscopic { .. } => match self.interval(model) {
                Some(interval) => format!("once every {}", significant(interval, 7)),
                None => "once in every period of the drive".into(),
            },
            Self::Crossing(Crossing { variable, dof, value, direction }) => {
                let how = match direction {
                    Direction::Rising => "rises through",
                    Direction::Falling => "falls through",
                    Direction::Both => "crosses",
                };
                let letter = variable.letter();
                format!("wherever {letter}{} {how} {value}", dof + 1)
            }
        }
    }
}

impl Crossing {
    /// The distance of a state from the section, with its sign. It is measured round a coordinate
    /// of the given period.
    pub(super) fn distance(&self, state: StateRef<'_, f64>, period: Option<f64>) -> f64 {
        let part = if self.variable == Variable::P { state.p } else { state.q };
        let off = part[self.dof] - self.value;
        match period {
            Some(period) if self.variable == Variable::Q => nearest(off, period),
            _ => off,
        }
    }

    /// Whether a run crosses between two distances from the section.
    pub(super) fn between(&self, before: f64, after: f64, period: Option<f64>) -> bool {
        // Half a turn away, the distance round a circle changes its sign, too.
        if period.is_some_and(|period| (after - before).abs() > 0.5 * period) {
            return false;
        }
        self.direction.of_core().crosses(before, after)
    }
}

/// Whether an interval is a whole multiple of a period, to nine digits.
pub fn is_multiple(interval: f64, period: f64) -> bool {
    let ratio = interval / period;
    ratio.round() >= 1.0 && (ratio - ratio.round()).abs() <= 1e-9 * ratio
}

/// An angle less whole turns: the value in [-P/2, P/2].
pub(super) fn nearest(x: f64, period: f64) -> f64 {
    x - period * (x / period).round()
}

/// q and p of the degrees of freedom that are not motors. Coordinates with a period lie within half
/// of it from 0.
pub(super) fn point(
    model_periods: &[Option<f64>],
    dof: usize,
    state: StateRef<'_, f64>,
) -> [Vec<f64>; 2] {
    let wrapped =
        |(&q, period): (&f64, &Option<f64>)| period.map_or(q, |period| nearest(q, period));
    let q = state.q[..dof].iter().zip(model_periods).map(wrapped).collect();
    [q, state.p[..dof].to_vec()]
}

/// Puts the motors back to the start of the period.
pub(super) fn rewind<T: Side>(q: &mut [T], t: &mut T, dof: usize) {
    q[dof..].fill(T::zero());
    *t = T::zero();
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_systems::catalog::DUFFING;

    #[test]
    fn a_crossing_has_a_direction_and_a_turn() {
        let crossing =
            |direction| Crossing { variable: Variable::Q, dof: 0, value: 1.0, direction };
        let at = |q: f64, period| {
            let state = StateRef { q: &[q], p: &[0.0], w: &[0.0], t: 0.0 };
            crossing(Direction::Rising).distance(state, period)
        };
        assert_eq!(at(1.5, None), 0.5);
        assert!((at(7.5, Some(6.0)) - 0.5).abs() < 1e-15, "{}", at(7.5, Some(6.0)));
        for (direction, rises, falls) in [
            (Direction::Rising, true, false),
            (Direction::Falling, false, true),
            (Direction::Both, true, true),
        ] {
            let between = |a, b| crossing(direction).between(a, b, Some(6.0));
            assert_eq!([between(-0.1, 0.1), between(0.1, -0.1)], [rises, falls]);
            // A state on the section counts once.
            assert_eq!([between(-0.1, 0.0), between(0.0, 0.1)], [rises, false]);
            // Half a turn away.
            assert!(!between(-2.9, 2.9) && !between(2.9, -2.9));
        }
    }

    #[test]
    fn an_interval_is_told_in_any_unit_and_has_to_be_known() {
        let model = Model::of(&DUFFING, &[1.0, 0.0, 0.0]);
        let of = |interval| Section::Stroboscopic { interval };
        let said = |interval: f64| of(Some(interval)).describe(&model);
        assert_eq!(said(2e-12), "once every 2.000000e-12");
        assert_eq!(said(std::f64::consts::TAU), "once every 6.283185");
        let error = of(None).grid(&model, 0.1).expect_err("no interval").to_string();
        assert!(error.contains("no period of the forces is known"), "{error}");
    }
}
