//! A method and its system with both types erased, for the time loop.
//!
//! The time loop is then compiled once for each storage of states, instead of once for each method
//! and system. A step costs one more call through a table of functions, which is negligible beside
//! the calls to a system whose type is erased.

use afterbay_core::{Abilities, Effort, InputError, Method, State, StepFailure, System, Vector};
use std::sync::Arc;

/// Takes steps with states stored in `V`. It owns the workspace of the method.
pub(super) trait Stepper<V: Vector>: Send + Sync {
    fn step(&mut self, h: V::Scalar, state: &mut State<V>) -> Result<Effort, StepFailure>;

    /// A stepper for another run.
    fn copied(&self) -> Box<dyn Stepper<V>>;
}

struct Stepping<M, S: ?Sized, W> {
    method: Arc<M>,
    system: Arc<S>,
    workspace: W,
}

impl<V, M, S> Stepper<V> for Stepping<M, S, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized + 'static,
    M: Method<V, S> + Send + Sync + 'static,
    M::Workspace: Clone + Send + Sync + 'static,
{
    fn step(&mut self, h: V::Scalar, state: &mut State<V>) -> Result<Effort, StepFailure> {
        self.method.step(&self.system, h, state, &mut self.workspace)
    }

    fn copied(&self) -> Box<dyn Stepper<V>> {
        let Self { method, system, workspace } = self;
        let (method, system) = (Arc::clone(method), Arc::clone(system));
        Box::new(Self { method, system, workspace: workspace.clone() })
    }
}

impl<V: Vector> Clone for Box<dyn Stepper<V>> {
    fn clone(&self) -> Self {
        (**self).copied()
    }
}

/// A method for one system. The system that its functions receive must be that one.
///
/// It does not pass on [`Method::refuses_singularities`]: such methods examine the edges of a step,
/// and the time loop then also examines the straight line to its end.
pub(super) struct ErasedMethod<V: Vector> {
    /// It is copied and never takes a step.
    first: Box<dyn Stepper<V>>,
    memoryless: bool,
    sums_reservoir: bool,
}

impl<V: Vector> ErasedMethod<V> {
    /// Erases the types of a method and of a system.
    ///
    /// # Errors
    /// Those of [`Method::workspace`].
    pub(super) fn new<M, S>(method: M, system: Arc<S>) -> Result<Self, InputError>
    where
        V: 'static,
        S: System<V::Scalar> + ?Sized + 'static,
        M: Method<V, S> + Send + Sync + 'static,
        M::Workspace: Clone + Send + Sync + 'static,
    {
        let workspace = method.workspace(&system)?;
        let (memoryless, sums_reservoir) = (method.is_memoryless(), method.sums_reservoir());
        let first = Box::new(Stepping { method: Arc::new(method), system, workspace });
        Ok(Self { first, memoryless, sums_reservoir })
    }
}

impl<V: Vector> Method<V, dyn Abilities<V::Scalar>> for ErasedMethod<V> {
    type Workspace = Box<dyn Stepper<V>>;

    fn workspace(&self, _: &dyn Abilities<V::Scalar>) -> Result<Self::Workspace, InputError> {
        Ok(self.first.clone())
    }

    #[inline(always)]
    fn step(
        &self,
        _: &dyn Abilities<V::Scalar>,
        h: V::Scalar,
        state: &mut State<V>,
        stepper: &mut Self::Workspace,
    ) -> Result<Effort, StepFailure> {
        stepper.step(h, state)
    }

    fn is_memoryless(&self) -> bool {
        self.memoryless
    }

    fn sums_reservoir(&self) -> bool {
        self.sums_reservoir
    }
}
