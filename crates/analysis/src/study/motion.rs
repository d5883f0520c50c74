//! The ranges of the coordinates and momenta along a run, and along its settled part.

use super::metric::{FADED, Metric, OF_MAGNITUDE};
use super::ranges::Ranges;
use afterbay_core::StateRef;

/// The least unit of a motion's own, as a share of its unit beside the whole run. A choice: units
/// are then at least some thousand roundings of the run.
const LEAST_OWN: f64 = 1e-9;

/// The ranges of a run, of all of it and since it has settled.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    run: Ranges,
    settled: Ranges,
}

impl Motion {
    /// A run that has not begun, of `dof` degrees of freedom.
    pub(super) fn new(dof: usize) -> Self {
        Self { run: Ranges::nothing(dof), settled: Ranges::nothing(dof) }
    }

    /// Adds a state.
    pub(super) fn see(&mut self, state: StateRef<'_, f64>) {
        self.run.see(state);
        self.settled.see(state);
    }

    /// Adds the states of some ranges.
    pub(super) fn join(&mut self, path: &Ranges) {
        self.run.join(path);
        self.settled.join(path);
    }

    /// The transient ends here.
    pub(super) fn settle(&mut self) {
        self.settled.clear();
    }

    /// All of the run.
    pub(super) fn run(&self) -> &Ranges {
        &self.run
    }

    /// The run since it has settled.
    pub(super) fn settled(&self) -> &Ranges {
        &self.settled
    }

    /// Whether the motion that has settled is rest beside another, of which it is a small share. A
    /// coordinate that moves by roundings rests as well, and its momentum with it. (While a run
    /// seeks its section, `ensemble/standstill.rs` asks for the latter alone.)
    pub(super) fn is_rest_beside(&self, whole: &Ranges) -> bool {
        self.is_share_of(FADED, whole)
    }

    /// Whether the motion that has settled is at most some thousand roundings of another.
    pub(super) fn is_rounding_beside(&self, whole: &Ranges) -> bool {
        self.is_share_of(OF_MAGNITUDE, whole)
    }

    fn is_share_of(&self, share: f64, whole: &Ranges) -> bool {
        let (settled, dof) = (&self.settled, whole.len() / 2);
        let faded = |j: usize| settled.extent(j) <= share * whole.extent(j);
        let rounds = |j: usize| settled.extent(j) <= OF_MAGNITUDE * settled.magnitude(j);
        (0..dof).all(|j| rounds(j) || (faded(j) && faded(dof + j)))
    }

    /// The distance of states in units of the motion that has settled, however small it is beside
    /// the transient.
    pub(super) fn own_metric(&self, periods: &[Option<f64>]) -> Metric {
        self.metric(periods).of_motion(&self.settled, LEAST_OWN)
    }

    /// The distance of states of the motion that has settled. `periods` are those of the
    /// coordinates.
    pub(super) fn metric(&self, periods: &[Option<f64>]) -> Metric {
        Metric::of(periods, &self.settled, &self.run)
    }
}
