//! The studies. Each runs methods on a problem with any number of degrees of freedom and returns
//! the rows of one table.
//!
//! Errors are computed in parallel over (method, step) and collected by index, so that a table is
//! the same to the bit for any number of threads. Times are measured one run after another.

pub mod attractor;
pub mod basins;
pub mod bifurcation;
pub mod cell;
pub mod cost;
pub mod decay;
pub mod dynamics;
pub mod energy;
mod ensemble;
pub mod events;
pub mod global_order;
pub mod growing;
pub mod kept;
pub mod limit_cycle;
pub mod local_order;
pub mod long_run;
pub mod lyapunov;
pub mod metric;
mod motion;
pub mod outcome;
mod passivity;
pub mod pick;
pub mod poincare;
mod ranges;
mod reference;
pub mod resonance;
mod returns;
pub mod section;
mod side;
pub mod size;
pub mod stability;
pub mod tangent;
pub mod trajectory;
mod watch;
pub mod work_precision;
mod zero;

pub use reference::MOST_DEGREES_IN_QUAD;

use crate::progress::Progress;
use crate::{Model, Solution};
use afterbay_core::{InputError, IntegrateError, Mask, Scalar, State, StateRef, with_motors};
use afterbay_methods::registry::{self, Row};
use serde::Serialize;

/// The names of the three variables, in the order the studies keep. With N > 1 degrees of freedom
/// the error of each is the largest of its N.
pub const VARIABLES: [&str; 3] = ["q", "p", "w"];

/// The name of the column of s_t, the energy pumped by V(q, t).
pub(crate) const PUMPED: &str = "st";

/// A system, its initial state and the end of time.
#[derive(Clone, Debug, Serialize)]
pub struct Problem {
    /// The system.
    #[serde(rename = "system")]
    pub model: Model,
    /// q at t = 0 in the units of the system, one entry for each degree of freedom but the motors.
    pub q: Vec<f64>,
    /// p at t = 0, likewise.
    pub p: Vec<f64>,
    /// The end of time, in the unit of time of the system.
    pub end: f64,
}

impl Problem {
    /// The initial state. Nothing has been supplied or pumped.
    ///
    /// # Errors
    /// [`InputError::Length`] where q or p does not fit the system, [`InputError::NotFinite`], and
    /// [`InputError::Parameter`] for a number of degrees of freedom out of range.
    pub fn start<T: Scalar>(&self) -> Result<State<Vec<T>>, InputError> {
        let lift = |part: &[f64]| part.iter().map(|&x| T::from_f64(x)).collect();
        let state = State::new(lift(&self.q), lift(&self.p))?;
        state.check(self.model.checked_degrees()?)?;
        Ok(with_motors(&state, self.model.motors().count()))
    }

    /// Whether the forces may jump or have kinks ([`afterbay_core::System::kinks`]).
    ///
    /// # Errors
    /// Those of [`Problem::start`], and parameters with which there is no system.
    pub fn has_kinks(&self) -> Result<bool, InputError> {
        let (system, start) = (self.model.system::<f64>()?, self.start::<f64>()?);
        let mut any = false;
        system.kinks(&start.q, &start.p, &mut |_| any = true);
        Ok(any)
    }

    /// The reference at the times `i h`, i = 0..=count, with its doubt at each. Up to
    /// [`MOST_DEGREES_IN_QUAD`] degrees of freedom it comes from Taylor series in 106 bits,
    /// rounded; with more from series in 53 bits. Where series end at a kink or take too many
    /// strides, it is the exact flow of a linear system of few degrees of freedom, else one of the
    /// two runs that agree best.
    ///
    /// # Errors
    /// Invalid input, a solution that ceases to be finite, and [`IntegrateError::Interrupted`]
    /// where `progress` asks to stop.
    pub fn solution(
        &self,
        h: f64,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Solution<f64>, IntegrateError> {
        reference::reference(self, h, count, progress)
    }
}

/// The row of a method that a study runs by itself.
fn method(name: &'static str) -> Result<&'static Row, InputError> {
    registry::find(name)
        .ok_or(InputError::Unsupported { method: name, why: "it is not registered" })
}

/// The largest differences over the degrees of freedom, of q, p and w; NaN if one of them is.
fn distance<T: Scalar>(found: StateRef<'_, T>, exact: StateRef<'_, T>) -> [T; 3] {
    [(found.q, exact.q), (found.p, exact.p), (found.w, exact.w)].map(|(found, exact)| {
        let differences = found.iter().zip(exact).map(|(&found, &exact)| (found - exact).abs());
        differences.fold(T::zero(), |most, x| {
            let keeps = x.le(most).or(most.le(most).not());
            T::select(keeps, most, x)
        })
    })
}

/// The names of N columns: `name1` to `nameN`.
fn numbered(name: &str, dof: usize) -> impl Iterator<Item = String> {
    (1..=dof).map(move |j| format!("{name}{j}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_that_is_nan_is_not_hidden_by_the_others() {
        let exact = State::new(vec![0.0; 3], vec![0.0; 3]).unwrap();
        for place in 0..3 {
            let mut found = exact.clone();
            found.p = vec![1.0, 2.0, 3.0];
            found.q[place] = f64::NAN;
            let [q, p, w] = distance(found.state_ref(), exact.state_ref());
            assert!(q.is_nan(), "entry {place}: {q}");
            assert_eq!([p, w], [3.0, 0.0]);
        }
    }
}
