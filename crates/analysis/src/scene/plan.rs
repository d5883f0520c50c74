//! The checked form of what a scene asks for. Methods are registered and apply to the system, steps
//! divide the time they cover, and nothing exceeds the budget.

use super::document::Spacing;
use crate::study::local_order::LocalOrder;
use afterbay_methods::registry::Row;

/// Trajectories.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// Every so many steps a state is kept.
    pub every: u64,
    /// What adaptive collocation is to meet.
    pub tolerance: Option<f64>,
}

/// The studies a scene declares.
#[derive(Clone, Debug, Default)]
pub struct Studies {
    /// Local errors and orders.
    pub local_order: Option<LocalOrderPlan>,
    /// Global errors and orders.
    pub global_order: Option<StepsPlan>,
    /// The energy books.
    pub energy: Option<EnergyPlan>,
    /// Work against precision.
    pub work_precision: Option<WorkPrecisionPlan>,
    /// Stability.
    pub stability: Option<StabilityPlan>,
    /// Growth of the deviation of K.
    pub long_run: Option<LongRunPlan>,
}

impl Studies {
    /// Is there none?
    pub fn is_empty(&self) -> bool {
        let Self { local_order, global_order, energy, work_precision, stability, long_run } = self;
        local_order.is_none()
            && global_order.is_none()
            && energy.is_none()
            && work_precision.is_none()
            && stability.is_none()
            && long_run.is_none()
    }
}

/// Local errors and orders.
#[derive(Clone, Debug)]
pub struct LocalOrderPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The base grid and the steps.
    pub study: LocalOrder,
}

/// Methods at steps.
#[derive(Clone, Debug)]
pub struct StepsPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
}

/// Work against precision.
#[derive(Clone, Debug)]
pub struct WorkPrecisionPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
    /// What adaptive collocation is to meet.
    pub tolerances: Vec<f64>,
}

/// The energy books.
#[derive(Clone, Debug)]
pub struct EnergyPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// Every so many steps a row is kept.
    pub every: u64,
}

/// A map of stability.
#[derive(Clone, Debug)]
pub struct StabilityPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, ascending.
    pub steps: Vec<f64>,
    /// How they are spaced; a list counts as spaced by ratios.
    pub step_spacing: Spacing,
    /// The parameter that is varied.
    pub parameter: String,
    /// Its values, ascending.
    pub values: Vec<f64>,
    /// How they are spaced.
    pub spacing: Spacing,
    /// The time of a run.
    pub end: f64,
}

/// Growth of the deviation of K.
#[derive(Clone, Debug)]
pub struct LongRunPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// The number of steps.
    pub count: u64,
    /// Are they also run with roundings that do not add up?
    pub compensated: bool,
}
