//! The side of zero on which a function of the state is.

use super::{Direction, EVENT_ROUNDINGS, Event};

/// The side of zero on which a function is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// The sign of the function, or the sign that it has once it leaves zero; 0 if this sign is not
    /// known.
    pub(super) sign: f64,
    /// If it is at zero, the size of a value that is a rounding of zero.
    pub(super) at_zero: Option<f64>,
    /// Whether an event changed the state there, or it is at a wall.
    pub(super) turned: bool,
    /// Why its event follows at this time.
    pub(super) due: Due,
}

/// Why an event follows another one at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Due {
    No,
    /// Its function reaches zero at the same time, to rounding.
    AtZero,
    /// The other event moved its function away from zero, or over it.
    Moved,
}

impl Side {
    /// The side of a value.
    pub(super) fn of(value: f64) -> Self {
        let (sign, at_zero) = if value == 0.0 { (0.0, Some(0.0)) } else { (value.signum(), None) };
        Self { sign, at_zero, turned: false, due: Due::No }
    }

    /// Records that the event of another function moved this one between two values. Its own event
    /// is due if it was before, or if the function crosses zero in its direction.
    pub(super) fn moved(&mut self, event: &Event<'_>, [was, is]: [f64; 2], was_due: bool) {
        let noise = EVENT_ROUNDINGS * f64::EPSILON * is.abs();
        let has_left = was.abs() > self.at_zero.map_or(noise, |at_zero| at_zero.max(noise));
        let jumped = has_left && !event.is_wall && event.direction.crosses(was, is);
        *self = Self { due: if was_due || jumped { Due::Moved } else { Due::No }, ..Self::of(is) };
    }

    /// Whether a function on this side may reach zero in a step, with its values before and after
    /// it.
    pub(super) fn may_reach_zero(self, direction: Direction, [before, after]: [f64; 2]) -> bool {
        match self.at_zero {
            Some(noise) => after.abs() > noise,
            None => {
                let is_beyond = before * self.sign <= 0.0 && direction.crosses(self.sign, before);
                is_beyond || direction.crosses(before, after)
            }
        }
    }

    /// Records an event at a zero with this value: the function is then beyond zero, or back on its
    /// side if the event `turned` it there.
    pub(super) fn happen(&mut self, value: f64, scale: f64, turned: bool) {
        let noise = match self.at_zero {
            // It has not left zero since the last event. Its value must not count as a new
            // rounding: the noise would grow from event to event, until a wall is passed.
            Some(noise) if value.abs() <= noise => noise,
            _ => EVENT_ROUNDINGS * value.abs(),
        };
        let noise = noise.max(EVENT_ROUNDINGS * f64::EPSILON * scale);
        let sign = if turned { self.sign } else { -self.sign };
        *self = Self { sign, at_zero: Some(noise), turned, due: Due::No };
    }

    /// Records the value at the end of a step without another event.
    pub(super) fn leave(&mut self, value: f64) {
        match self.at_zero {
            // A rounding on the wrong side of zero is not yet a side.
            Some(noise) if value * self.sign <= 0.0 && value.abs() <= noise => self.turned = false,
            _ if value == 0.0 => {}
            _ => *self = Self::of(value),
        }
    }
}
