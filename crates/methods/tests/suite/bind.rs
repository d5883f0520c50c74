//! Systems bound to the rows of the registry, each with the abilities that a test requires.

use afterbay_core::{
    Abilities, Coupling, Curvature, DissipationForm, InputError, Linear, Members, Misprinted,
    OrderRaising, PhasePlane, Scalar, SecondDerivatives, Separable, System, Uniform,
};
use afterbay_methods::registry::{self, Number, Row, Run};
use std::marker::PhantomData;
use std::sync::Arc;

/// A system with its type erased, so that a method is compiled once for all systems of a test.
pub(crate) type Curved<T> = dyn SecondDerivatives<T>;

/// A system that offers some of its abilities.
struct Able<S, A>(Arc<S>, PhantomData<fn() -> A>);

struct General;
struct Plain;
struct Raising;
struct Closed;
struct Equal;

fn bound<T: Number, S, A>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    Able<S, A>: Abilities<T>,
{
    registry::bind(row, Arc::new(Able(Arc::new(system), PhantomData)) as Arc<dyn Abilities<T>>)
}

/// Binds a system with any H, phase planes and second derivatives.
pub(crate) fn general<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Curvature<T> + PhasePlane<T> + 'static,
{
    bound::<T, S, General>(row, system)
}

/// Binds a system with separable H.
pub(crate) fn separable<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Separable<T> + Curvature<T> + 'static,
{
    bound::<T, S, Plain>(row, system)
}

/// Binds a system with separable H and known δ.
pub(crate) fn nonlinear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: OrderRaising<T> + Curvature<T> + 'static,
{
    bound::<T, S, Raising>(row, system)
}

/// Binds a linear system with printed δ: the closed forms.
pub(crate) fn linear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Number,
    S: Misprinted<T> + Curvature<T> + 'static,
{
    bound::<T, S, Closed>(row, system)
}

/// Binds a system of equal members, eight at a time.
pub(crate) fn uniform<S>(row: &Row, system: S) -> Result<Run<f64>, InputError>
where
    S: Uniform + Curvature<f64> + 'static,
    S::Lanes: 'static,
{
    bound::<f64, S, Equal>(row, system)
}

impl<T: Scalar, S: System<T>, A> System<T> for Able<S, A> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.0.dissipation(q, p, v, d);
    }
    fn dissipation_form(&self) -> DissipationForm {
        System::<T>::dissipation_form(&*self.0)
    }
    fn unit_mass(&self) -> bool {
        System::<T>::unit_mass(&*self.0)
    }
    fn coupling(&self) -> Coupling {
        System::<T>::coupling(&*self.0)
    }
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.0.kinks(q, p, put);
    }
    fn may_be_singular(&self) -> bool {
        System::<T>::may_be_singular(&*self.0)
    }
    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        self.0.is_singular_between(from, to)
    }
}

impl<T: Scalar, S: Curvature<T> + PhasePlane<T> + 'static> Abilities<T> for Able<S, General> {
    fn phase_planes(self: Arc<Self>) -> Option<Arc<dyn PhasePlane<T>>> {
        Some(self.0.clone())
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self.0.clone())
    }
}

impl<T: Scalar, S: Separable<T> + Curvature<T> + 'static> Abilities<T> for Able<S, Plain> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self.0.clone())
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self.0.clone())
    }
}

impl<T: Scalar, S: OrderRaising<T> + Curvature<T> + 'static> Abilities<T> for Able<S, Raising> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self.0.clone())
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self.0.clone())
    }
    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        Some(self.0.clone())
    }
}

impl<T: Scalar, S: Misprinted<T> + Curvature<T> + 'static> Abilities<T> for Able<S, Closed> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self.0.clone())
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self.0.clone())
    }
    fn linear(self: Arc<Self>) -> Option<Arc<dyn Linear<T>>> {
        Some(self.0.clone())
    }
    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        Some(self.0.clone())
    }
    fn misprinted(self: Arc<Self>) -> Option<Arc<dyn Misprinted<T>>> {
        Some(self.0.clone())
    }
}

impl<S: Uniform + Curvature<f64> + 'static> Abilities<f64> for Able<S, Equal>
where
    S::Lanes: 'static,
{
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<f64>>> {
        Some(self.0.clone())
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<f64>>> {
        Some(self.0.clone())
    }
    fn is_uniform(&self) -> bool {
        true
    }
    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        Some(self.0.clone())
    }
}

struct Bent;

/// Binds a system with any H and second derivatives.
pub(crate) fn curved<S: Curvature<f64> + 'static>(
    row: &Row,
    system: S,
) -> Result<Run<f64>, InputError> {
    bound::<f64, S, Bent>(row, system)
}

impl<T: Scalar, S: Curvature<T> + 'static> Abilities<T> for Able<S, Bent> {
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self.0.clone())
    }
}
