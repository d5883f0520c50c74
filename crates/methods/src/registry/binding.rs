//! The binding of the methods of the registry to systems. A method implements [`Binding`], or
//! [`AdaptiveBinding`], in its own file; its row holds it as a [`Form`].

use super::Run;
use super::erased::named;
use super::run::{chosen, fixed};
use super::stepper::ErasedMethod;
use crate::moddg::steps::Equation;
use afterbay_core::{
    Abilities, Adaptive, InputError, Linear, Method, Misprinted, OrderRaising, Quad, Scalar,
    SecondDerivatives, Separable, Single, System, Vector, f64x8,
};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

/// A method bound to a system, or the reason why it is refused.
pub(crate) type Bound<T> = Result<Run<T>, InputError>;

/// Binds a method to eight systems side by side.
pub(crate) type InLanes<M> = fn(&M, &Target<'_, f64x8>) -> Bound<f64x8>;

/// The binding of a fixed-step method to a system.
pub(crate) trait Binding: Debug + Sync + Sized + 'static {
    /// The binding to eight systems side by side, if there is one. Each lane gives the same bits as
    /// a run alone, provided the functions of the scalar do. Methods that are implicit in all
    /// degrees of freedom at once have no lanes, since pivots and the number of iterations depend
    /// on the system. A step that fails in one lane changes no lane.
    const LANES: Option<InLanes<Self>> = None;

    /// Binds to any system, with states stored in `V`.
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar>;

    /// Binds to any system, with the storage that suits its number of degrees of freedom.
    fn bind_stored<T: Scalar>(&self, target: &Target<'_, T>) -> Bound<T> {
        if target.system.dof() == 1 {
            self.bind::<Single<T>>(target)
        } else {
            self.bind::<Vec<T>>(target)
        }
    }

    /// Binds to any system in `f64`.
    fn bind_f64(&self, target: &Target<'_, f64>) -> Bound<f64> {
        self.bind_stored(target)
    }

    /// The equations whose δ the method uses; the δ have poles.
    fn poles(&self) -> &'static [Equation] {
        &[]
    }
}

/// The binding of a method that chooses its steps to a system. Tolerances are those of `f64`.
pub(crate) trait AdaptiveBinding: Any + Debug + Sync {
    /// Binds to any system.
    fn bind(&self, target: &Target<'_, f64>) -> Bound<f64>;
}

/// A [`Binding`] with its type erased: one function for each scalar in which methods run.
pub(super) trait AnyFixed: Any + Debug + Sync {
    fn in_f64(&self, target: &Target<'_, f64>) -> Bound<f64>;
    fn in_quad(&self, target: &Target<'_, Quad>) -> Bound<Quad>;
    fn lanes(&self) -> bool;
    fn in_lanes(&self, target: &Target<'_, f64x8>) -> Bound<f64x8>;
    fn delta_poles(&self) -> &'static [Equation];
}

impl<M: Binding> AnyFixed for M {
    fn in_f64(&self, target: &Target<'_, f64>) -> Bound<f64> {
        self.bind_f64(target)
    }
    fn in_quad(&self, target: &Target<'_, Quad>) -> Bound<Quad> {
        // Also at N = 1: the arithmetic takes so long that another storage gains nothing.
        self.bind::<Vec<Quad>>(target)
    }
    fn lanes(&self) -> bool {
        M::LANES.is_some()
    }
    fn in_lanes(&self, target: &Target<'_, f64x8>) -> Bound<f64x8> {
        match M::LANES {
            // Lanes whose parameters differ may have their breaks at different times.
            Some(bind) if !target.system.has_breaks() => bind(self, target),
            _ => Err(target.no_lanes()),
        }
    }
    fn delta_poles(&self) -> &'static [Equation] {
        self.poles()
    }
}

/// The method of a row.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// It takes a step.
    Fixed(&'static dyn AnyFixed),
    /// It takes a tolerance.
    Adaptive(&'static dyn AdaptiveBinding),
}

impl Form {
    pub(super) fn any(self) -> &'static dyn Any {
        match self {
            Self::Fixed(method) => method,
            Self::Adaptive(method) => method,
        }
    }
}

/// The system that a method is bound to, and the name of the method.
pub(crate) struct Target<'a, T: Scalar> {
    pub(crate) name: &'static str,
    pub(crate) system: &'a Arc<dyn Abilities<T>>,
}

impl<T: Scalar> Target<'_, T> {
    pub(crate) fn refused(&self, why: &'static str) -> InputError {
        InputError::Unsupported { method: self.name, why }
    }

    pub(super) fn no_lanes(&self) -> InputError {
        self.refused("it steps one system at a time")
    }

    pub(crate) fn separable(&self) -> Result<Arc<dyn Separable<T>>, InputError> {
        self.system.clone().separable().ok_or_else(|| self.refused("H is not separable"))
    }

    pub(crate) fn curvature(&self) -> Result<Arc<dyn SecondDerivatives<T>>, InputError> {
        let why = "the system has no second derivatives";
        self.system.clone().second_derivatives().ok_or_else(|| self.refused(why))
    }

    /// The system as a linear one with one degree of freedom, for which implicit steps have a
    /// closed form.
    pub(crate) fn closed(&self) -> Option<Arc<dyn Linear<T>>> {
        if self.system.dof() == 1 { self.system.clone().linear() } else { None }
    }

    pub(crate) fn order_raising(&self) -> Result<Arc<dyn OrderRaising<T>>, InputError> {
        self.separable()?;
        let why = match self.system.motors() {
            0 => "the system has no formula for δ (in Rust, `OrderRaising`)",
            _ => "it takes no drive and no V or D that depends on t",
        };
        self.system.clone().order_raising().ok_or_else(|| self.refused(why))
    }

    pub(crate) fn misprinted(&self) -> Result<Arc<dyn Misprinted<T>>, InputError> {
        self.order_raising()?;
        let why = "the paper prints δ for the damped oscillator only";
        self.system.clone().misprinted().ok_or_else(|| self.refused(why))
    }

    /// Binds a fixed-step method to `system`, one of the views of the target.
    pub(crate) fn fixed<V, S, M>(&self, method: M, system: Arc<S>) -> Bound<T>
    where
        V: Vector<Scalar = T> + 'static,
        S: System<T> + ?Sized + 'static,
        M: Method<V, S> + Send + Sync + 'static,
        M::Workspace: Clone + Send + Sync + 'static,
    {
        let method = ErasedMethod::<V>::new(method, system);
        let method = method.map_err(|error| named(self.name, error))?;
        fixed::<V, dyn Abilities<T>, _>(self.name, method, Arc::clone(self.system))
    }

    /// Binds a method with step size control to `system`, one of the views of the target.
    pub(crate) fn chosen<V, S, M>(&self, method: M, system: Arc<S>) -> Bound<T>
    where
        V: Vector<Scalar = T> + 'static,
        S: System<T> + ?Sized + 'static,
        M: Adaptive<V, S> + Send + Sync + 'static,
    {
        chosen::<V, S, M>(self.name, method, system)
    }
}
