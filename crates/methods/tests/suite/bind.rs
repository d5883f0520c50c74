//! Systems bound to the rows of the registry, each with the abilities that a test requires.

use afterbay_core::{
    Abilities, Coupling, Curvature, DissipationForm, Grid, InputError, Linear, Members, Misprinted,
    OrderRaising, PhasePlane, Scalar, SecondDerivatives, Separable, State, System,
};
use afterbay_methods::registry::{self, Number, Row, Run};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A system with its type erased, so that a method is compiled once for all systems of a test.
pub(crate) type Curved<T> = dyn SecondDerivatives<T>;

/// A system with separable H, with its type erased.
pub(crate) type AnySeparable<T> = dyn Separable<T>;

/// A chain or a ring of equal members, with its type erased.
pub(crate) type AnyMembers = dyn Members;

/// A system that offers some of its abilities.
pub(crate) struct Able<T: Scalar> {
    system: Arc<dyn System<T>>,
    curvature: Option<Arc<Curved<T>>>,
    pub(crate) separable: Option<Arc<dyn Separable<T>>>,
    pub(crate) planes: Option<Arc<dyn PhasePlane<T>>>,
    pub(crate) linear: Option<Arc<dyn Linear<T>>>,
    pub(crate) raising: Option<Arc<dyn OrderRaising<T>>>,
    pub(crate) misprinted: Option<Arc<dyn Misprinted<T>>>,
    pub(crate) members: Option<Arc<dyn Members>>,
}

impl<T: Number> Able<T> {
    pub(crate) fn new(system: Arc<Curved<T>>) -> Self {
        Self { curvature: Some(system.clone()), ..Self::plain(system) }
    }

    /// Without any ability.
    fn plain(system: Arc<dyn System<T>>) -> Self {
        let (curvature, separable, planes, linear) = (None, None, None, None);
        let (raising, misprinted, members) = (None, None, None);
        Self { system, curvature, separable, planes, linear, raising, misprinted, members }
    }

    pub(crate) fn bind(self, row: &Row) -> Result<Run<T>, InputError> {
        registry::bind(row, Arc::new(self) as Arc<dyn Abilities<T>>)
    }
}

/// The state after a run.
pub(crate) fn after<T: Number>(
    run: &Run<T>,
    grid: Grid<T>,
    start: &State<Vec<T>>,
) -> State<Vec<T>> {
    let mut state = start.clone();
    run.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(())).unwrap();
    state
}

/// Binds a system with any H and second derivatives.
pub(crate) fn curved<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Curvature<T> + 'static,
{
    erased(row, Arc::new(system))
}

/// Binds a system with any H and second derivatives whose type is erased already.
pub(crate) fn erased<T: Number>(row: &Row, system: Arc<Curved<T>>) -> Result<Run<T>, InputError> {
    Able::new(system).bind(row)
}

/// Binds a system with separable H and without second derivatives.
pub(crate) fn by_force<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Separable<T> + 'static,
{
    let system = Arc::new(system);
    Able { separable: Some(system.clone()), ..Able::plain(system) }.bind(row)
}

/// Binds a system with separable H.
pub(crate) fn separable<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Separable<T> + Curvature<T> + 'static,
{
    let system = Arc::new(system);
    Able { separable: Some(system.clone()), ..Able::new(system) }.bind(row)
}

/// Binds a system with separable H and known δ.
pub(crate) fn nonlinear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: OrderRaising<T> + Curvature<T> + 'static,
{
    let system = Arc::new(system);
    let separable: Arc<dyn Separable<T>> = system.clone();
    Able { separable: Some(separable), raising: Some(system.clone()), ..Able::new(system) }
        .bind(row)
}

/// Binds a linear system with printed δ: the closed forms.
pub(crate) fn linear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Misprinted<T> + Curvature<T> + 'static,
{
    let system = Arc::new(system);
    let misprinted: Arc<dyn Misprinted<T>> = system.clone();
    Able {
        separable: Some(misprinted.clone()),
        linear: Some(misprinted.clone()),
        raising: Some(misprinted.clone()),
        misprinted: Some(misprinted),
        ..Able::new(system)
    }
    .bind(row)
}

impl<T: Scalar> System<T> for Able<T> {
    fn dof(&self) -> usize {
        self.system.dof()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        self.system.energy(q, p)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.system.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.system.dissipation(q, p, v, d);
    }
    fn dissipation_form(&self) -> DissipationForm {
        self.system.dissipation_form()
    }
    fn unit_mass(&self) -> bool {
        self.system.unit_mass()
    }
    fn coupling(&self) -> Coupling {
        self.system.coupling()
    }
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.system.kinks(q, p, put);
    }
    fn may_be_singular(&self) -> bool {
        self.system.may_be_singular()
    }
    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        self.system.is_singular_between(from, to)
    }
}

impl<T: Scalar> Abilities<T> for Able<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        self.separable.clone()
    }
    fn phase_planes(self: Arc<Self>) -> Option<Arc<dyn PhasePlane<T>>> {
        self.planes.clone()
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<Curved<T>>> {
        self.curvature.clone()
    }
    fn linear(self: Arc<Self>) -> Option<Arc<dyn Linear<T>>> {
        self.linear.clone()
    }
    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        self.raising.clone()
    }
    fn misprinted(self: Arc<Self>) -> Option<Arc<dyn Misprinted<T>>> {
        self.misprinted.clone()
    }
    fn is_uniform(&self) -> bool {
        self.members.is_some()
    }
    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        self.members.clone()
    }
}
