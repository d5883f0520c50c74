//! Whether a motion stands still while its section is sought.

use crate::Model;
use crate::study::ranges::Ranges;
use crate::study::section::MOST_STEPS_BETWEEN;
use afterbay_core::StateRef;

/// The steps over which an autonomous motion that stands still does not move.
const STEPS: u64 = 1 << 14;
/// The largest extent of a coordinate that stands still, relative to its largest magnitude: some
/// roundings.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// The motion since the last return, in parts of equally many steps. Near a rest at q ≠ 0 the
/// roundings of q keep the momentum where it is, and a section that it would cross is never met.
///
/// This ends a search, so that it must be sure: only coordinates that move by roundings stand
/// still, whatever the size of the motion. [`Motion::is_rest_beside`] judges a run that is over:
/// there a motion also rests that has faded to a small share of that of all runs.
///
/// [`Motion::is_rest_beside`]: crate::study::motion::Motion::is_rest_beside
pub(super) struct Standstill {
    /// The steps of a part.
    steps: u64,
    part: Ranges,
}

impl Standstill {
    /// A motion that has not begun. One that is driven may rest for long before it is pushed.
    pub(super) fn new(model: &Model) -> Self {
        let steps = if model.is_autonomous() { STEPS } else { MOST_STEPS_BETWEEN / 2 };
        Self { steps, part: Ranges::nothing(model.degrees()) }
    }

    /// Adds the state that is `missing` steps after the last return. `path` holds the ranges since
    /// then. Returns whether a part has ended in which the coordinates moved by roundings only. The
    /// first part is left out, so that runs that return soon take no time for it.
    pub(super) fn is_seen(
        &mut self,
        missing: u64,
        state: StateRef<'_, f64>,
        path: &Ranges,
    ) -> bool {
        if missing < self.steps {
            return false;
        }
        if missing == self.steps {
            self.part.clear();
        }
        self.part.see(state);
        if missing == self.steps || !missing.is_multiple_of(self.steps) {
            return false;
        }
        let dof = path.len() / 2;
        let still = |j: usize| self.part.extent(j) <= ROUNDINGS * path.magnitude(j);
        let stands = (0..dof).all(still);
        self.part.clear();
        stands
    }
}
