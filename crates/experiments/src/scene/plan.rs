//! The checked plans of the runs and studies of a scene. Their methods are registered and apply to
//! the system, their steps divide the time they cover, and no plan exceeds the budget.

use afterbay_analysis::study::basins::Basins;
use afterbay_analysis::study::bifurcation::Bifurcation;
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::events::{Action, EventPlan};
use afterbay_analysis::study::limit_cycle::LimitCycle;
use afterbay_analysis::study::local_order::LocalOrder;
use afterbay_analysis::study::lyapunov::Lyapunov;
use afterbay_analysis::study::poincare::Poincare;
use afterbay_analysis::study::resonance::Resonance;
use afterbay_analysis::{Observable, Spacing, Variable};
use afterbay_methods::registry::Row;

/// The plan of trajectories.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// The methods that take a step.
    pub methods: Vec<&'static Row>,
    /// The methods that choose their steps.
    pub adaptive: Vec<&'static Row>,
    /// The number of steps between two states that are kept.
    pub every: u64,
    /// The tolerance of the methods that choose their steps.
    pub tolerance: Option<f64>,
    /// The spacing in time of the states that are kept, instead of `every`.
    pub sample: Option<f64>,
    /// The events.
    pub events: Vec<EventPlan>,
}

impl RunPlan {
    /// The names of all methods, those that take a step first.
    pub fn names(&self) -> Vec<&'static str> {
        self.methods.iter().chain(&self.adaptive).map(|row| row.name).collect()
    }

    /// The names of the events with this kind of action.
    pub fn events_that(&self, is_one: impl Fn(Action) -> bool) -> Vec<&str> {
        let those = self.events.iter().filter(|event| is_one(event.action));
        those.map(|event| event.name.as_str()).collect()
    }
}

/// The plan of a figure of trajectories.
#[derive(Clone, Debug)]
pub struct FigurePlan {
    /// The name of its files.
    pub name: String,
    /// The title, if it is given.
    pub title: Option<String>,
    /// The methods whose runs are shown.
    pub methods: Vec<&'static str>,
    /// The states that are shown.
    pub shown: Shown,
}

/// The contents of a figure.
#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    /// Curves of quantities.
    Curves {
        /// The quantity of the horizontal axis.
        x: Observable,
        /// The quantities of the vertical axis.
        y: Vec<Observable>,
        /// Whether the vertical axis is logarithmic and shows absolute values.
        log: bool,
    },
    /// A variable over the degree of freedom and time.
    Map(Variable),
}

/// The studies a scene declares.
#[derive(Clone, Debug, Default)]
pub struct Studies {
    /// Local errors and orders.
    pub local_order: Option<LocalOrderPlan>,
    /// Global errors and orders.
    pub global_order: Option<StepsPlan>,
    /// The energy balance.
    pub energy: Option<EnergyPlan>,
    /// Work against precision.
    pub work_precision: Option<WorkPrecisionPlan>,
    /// Stability.
    pub stability: Option<StabilityPlan>,
    /// Growth of the deviation of K.
    pub long_run: Option<LongRunPlan>,
    /// Points of a section.
    pub poincare: Option<DynamicsPlan<Poincare>>,
    /// Points of a section against a parameter.
    pub bifurcation: Option<DynamicsPlan<Bifurcation>>,
    /// Amplitude and energy per period against the frequency of a drive.
    pub resonance: Option<DynamicsPlan<Resonance>>,
    /// The attractors of a grid of initial states.
    pub basins: Option<DynamicsPlan<Basins>>,
    /// Lyapunov exponents.
    pub lyapunov: Option<DynamicsPlan<Lyapunov>>,
    /// A limit cycle, or a branch of them.
    pub limit_cycle: Option<DynamicsPlan<LimitCycle>>,
}

impl Studies {
    /// Whether no study is declared.
    pub fn is_empty(&self) -> bool {
        self.all_methods().is_empty()
    }

    /// The methods of each study, one study after another.
    pub(super) fn methods(&self) -> impl Iterator<Item = &&'static Row> {
        self.all_methods().into_iter().flatten()
    }

    /// The lists of methods of the studies that are declared, one or two for each.
    fn all_methods(&self) -> Vec<&[&'static Row]> {
        let Self {
            local_order,
            global_order,
            energy,
            work_precision,
            stability,
            long_run,
            poincare,
            bifurcation,
            resonance,
            basins,
            lyapunov,
            limit_cycle,
        } = self;
        let work = work_precision.as_ref();
        let lists = [
            local_order.as_ref().map(|plan| &plan.methods),
            global_order.as_ref().map(|plan| &plan.methods),
            energy.as_ref().map(|plan| &plan.methods),
            work.map(|plan| &plan.methods),
            work.map(|plan| &plan.adaptive),
            stability.as_ref().map(|plan| &plan.methods),
            long_run.as_ref().map(|plan| &plan.methods),
            poincare.as_ref().map(|plan| &plan.methods),
            bifurcation.as_ref().map(|plan| &plan.methods),
            resonance.as_ref().map(|plan| &plan.methods),
            basins.as_ref().map(|plan| &plan.methods),
            lyapunov.as_ref().map(|plan| &plan.methods),
            limit_cycle.as_ref().map(|plan| &plan.methods),
        ];
        lists.into_iter().flatten().map(Vec::as_slice).collect()
    }
}

/// The plan of local errors and orders.
#[derive(Clone, Debug)]
pub struct LocalOrderPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The base grid and the steps.
    pub study: LocalOrder,
}

/// The plan of a study of methods at several steps.
#[derive(Clone, Debug)]
pub struct StepsPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
}

/// The plan of work against precision.
#[derive(Clone, Debug)]
pub struct WorkPrecisionPlan {
    /// The methods that take a step.
    pub methods: Vec<&'static Row>,
    /// The methods that choose their steps; none without tolerances.
    pub adaptive: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
    /// The tolerances of methods that choose their steps.
    pub tolerances: Vec<f64>,
}

/// The plan of the energy balance.
#[derive(Clone, Debug)]
pub struct EnergyPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// The number of steps between two rows that are kept.
    pub every: u64,
}

/// The plan of a stability map.
#[derive(Clone, Debug)]
pub struct StabilityPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, ascending.
    pub steps: Vec<f64>,
    /// The spacing of the steps. A list counts as logarithmic.
    pub step_spacing: Spacing,
    /// The parameter that is varied.
    pub parameter: String,
    /// Its values, ascending.
    pub values: Vec<f64>,
    /// The spacing of the values.
    pub spacing: Spacing,
    /// The time span of a run.
    pub end: f64,
}

/// The plan of a long run.
#[derive(Clone, Debug)]
pub struct LongRunPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// The number of steps.
    pub count: u64,
    /// Whether methods also run with compensated roundings.
    pub compensated: bool,
}
