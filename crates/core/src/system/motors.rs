//! States with motors, the degrees of freedom that [`crate::Clocked`] and [`crate::Driven`] add,
//! and the energies that are read from them.

use super::state::State;
use super::state_ref::StateRef;
use crate::numbers::Scalar;

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

/// The state of a system with motors from that of the system alone: the motors stand at the time of
/// the state and have supplied nothing.
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
pub fn accounts<T: Scalar>(state: StateRef<'_, T>, motors: &Motors) -> Accounts<T> {
    let dof = state.w.len() - motors.count();
    let pumped = motors.has_clock.then(|| -state.p[dof]);
    let first_driven = dof + usize::from(motors.has_clock);
    let mut w = state.w[..dof].to_vec();
    if motors.driven.is_empty() {
        return Accounts { w, s: Vec::new(), pumped };
    }
    let mut s = vec![T::zero(); dof];
    for (k, &j) in motors.driven.iter().enumerate() {
        w[j] += state.p[first_driven + k];
        s[j] = T::zero() - state.w[first_driven + k];
    }
    Accounts { w, s, pumped }
}
