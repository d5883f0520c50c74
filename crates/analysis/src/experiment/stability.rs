//! Where methods fail.

use crate::progress::Progress;
use crate::scene::{Scene, StabilityPlan};
use crate::sheet::{ReportError, Sheet};

pub(super) fn sheet(
    _scene: &Scene,
    _plan: &StabilityPlan,
    _progress: &dyn Progress,
) -> Result<Sheet, ReportError> {
    Ok(Sheet::new("Stability where methods fail"))
}
