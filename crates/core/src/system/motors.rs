//! States with motors, the degrees of freedom that [`crate::Clocked`] and [`crate::Driven`] add,
//! and the energies that are read from them.

use super::state::State;
use super::state_ref::StateRef;
use crate::error::InputError;
use crate::numbers::Scalar;
use crate::quantity::Quantity;

/// The motors behind the degrees of freedom of a system: its clock, and those of a drive.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Motors {
    /// Whether H or D depends on the time ([`crate::Clocked`]). The clock is the first motor.
    pub has_clock: bool,
    /// The driven degrees of freedom ([`crate::Drive::driven`]), in the order of their motors.
    pub driven: Vec<usize>,
}

impl Motors {
    /// The number of motors.
    pub fn count(&self) -> usize {
        usize::from(self.has_clock) + self.driven.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// The degrees of freedom of the system alone.
    ///
    /// # Errors
    /// [`InputError::Length`] if a state has fewer entries than these motors and the degrees of
    /// freedom that they drive, or p and w differ in length.
    fn degrees<T>(&self, StateRef { p, w, .. }: &StateRef<'_, T>) -> Result<usize, InputError> {
        let least = self.driven.iter().max().map_or(0, |j| j + 1) + self.count();
        let of_p = (Quantity::Momentum, w.len(), p.len());
        let of_w = (Quantity::Reservoir, w.len().max(least), w.len());
        for (quantity, expected, found) in [of_p, of_w] {
            if found != expected {
                return Err(InputError::Length { quantity, expected, found });
            }
        }
        Ok(w.len() - self.count())
    }
}

/// The energies that a system has exchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct Accounts<T> {
    /// The energy w_j dissipated by each degree of freedom.
    pub w: Vec<T>,
    /// The energy s_j supplied to each degree of freedom; empty without a drive.
    pub s: Vec<T>,
    /// The energy s_t pumped by the change of H in time, if there is a clock.
    pub pumped: Option<T>,
}

/// The state of a system with motors from that of the system alone. The coordinates of the motors
/// are the time of the state, and the motors have supplied no energy. Forces and energies that
/// depend on the time read these coordinates. A t that is set afterwards does not change them.
pub fn with_motors<T: Scalar>(state: &State<Vec<T>>, motors: usize) -> State<Vec<T>> {
    let with = |part: &[T], value: T| {
        part.iter().copied().chain(std::iter::repeat_n(value, motors)).collect()
    };
    let zero = T::zero();
    State {
        q: with(&state.q, state.t),
        p: with(&state.p, zero),
        w: with(&state.w, zero),
        t: state.t,
    }
}

/// The energies exchanged up to a state with these motors.
///
/// # Errors
/// [`InputError::Length`] if the state has fewer degrees of freedom than these motors and those
/// that they drive.
pub fn accounts<T: Scalar>(
    state: StateRef<'_, T>,
    motors: &Motors,
) -> Result<Accounts<T>, InputError> {
    let dof = motors.degrees(&state)?;
    let pumped = motors.has_clock.then(|| -state.p[dof]);
    let first_driven = dof + usize::from(motors.has_clock);
    let mut w = state.w[..dof].to_vec();
    if motors.driven.is_empty() {
        return Ok(Accounts { w, s: Vec::new(), pumped });
    }
    let mut s = vec![T::zero(); dof];
    for (k, &j) in motors.driven.iter().enumerate() {
        w[j] += state.p[first_driven + k];
        s[j] = T::zero() - state.w[first_driven + k];
    }
    Ok(Accounts { w, s, pumped })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motors_that_do_not_fit_the_state_are_refused() {
        let state = StateRef { q: &[0.0; 3], p: &[0.5, 2.0, 3.0], w: &[0.25, 0.0, -3.0], t: 0.0 };
        let of = |has_clock, driven: &[usize]| {
            accounts(state, &Motors { has_clock, driven: driven.to_vec() })
        };
        let found = Accounts { w: vec![3.25], s: vec![3.0], pumped: Some(-2.0) };
        assert_eq!(of(true, &[0]), Ok(found));
        for (has_clock, driven, expected) in
            [(false, &[2][..], 4), (true, &[1], 4), (true, &[0, 1, 2], 7)]
        {
            let quantity = Quantity::Reservoir;
            let refused = InputError::Length { quantity, expected, found: 3 };
            assert_eq!(of(has_clock, driven), Err(refused));
        }
        let short = StateRef { p: &[0.5], ..state };
        let refused = InputError::Length { quantity: Quantity::Momentum, expected: 3, found: 1 };
        assert_eq!(accounts(short, &Motors::default()), Err(refused));
    }
}
