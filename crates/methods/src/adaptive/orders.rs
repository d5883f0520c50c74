//! Methods with step size control that have several orders, one of which suits the tolerance.

/// Implements [`afterbay_core::Adaptive`] and its binding for a method, given its engine, the name
/// of each order with the number of stages of its engine, and the least factor by which a step
/// grows. The function `Order::new` of the method chooses the order.
macro_rules! adaptive_of_orders {
    ($method:ty, $engine:ident, { $($order:ident: $stages:literal),+ }, $growth:expr) => {
        /// The engine of the order chosen.
        #[derive(Clone, Debug)]
        pub struct Workspace<V: afterbay_core::Vector>(Order<V>);

        #[derive(Clone, Debug)]
        enum Order<V: afterbay_core::Vector> {
            $($order(Box<$engine<V, $stages>>)),+
        }

        impl crate::registry::binding::AdaptiveBinding for $method {
            fn bind(
                &self,
                target: &crate::registry::binding::Target<'_, f64>,
            ) -> crate::registry::binding::Bound<f64> {
                let system = target.curvature()?;
                match target.system.dof() {
                    1 => target.chosen::<afterbay_core::Single<f64>, _, _>(*self, system),
                    _ => target.chosen::<Vec<f64>, _, _>(*self, system),
                }
            }
        }

        impl<V, S> afterbay_core::Adaptive<V, S> for $method
        where
            V: afterbay_core::Vector,
            S: afterbay_core::Curvature<V::Scalar> + ?Sized,
        {
            type Workspace = Workspace<V>;

            const LEAST_GROWTH: f64 = $growth;

            fn workspace(
                &self,
                system: &S,
                tolerance: &afterbay_core::Tolerance,
                span: f64,
            ) -> Result<Workspace<V>, afterbay_core::InputError> {
                Ok(Workspace(Order::new(system, tolerance, span)?))
            }

            #[inline]
            fn attempt(
                &self,
                system: &S,
                h: V::Scalar,
                state: &afterbay_core::State<V>,
                workspace: &mut Workspace<V>,
            ) -> Result<afterbay_core::Attempt, afterbay_core::StepFailure> {
                match &mut workspace.0 {
                    $(Order::$order(engine) => engine.attempt(system, h, state)),+
                }
            }

            #[inline]
            fn end<'a>(&self, workspace: &'a Workspace<V>) -> &'a [V::Scalar] {
                match &workspace.0 {
                    $(Order::$order(engine) => engine.end_of_attempt()),+
                }
            }

            #[inline]
            fn accept(&self, state: &mut afterbay_core::State<V>, workspace: &mut Workspace<V>) {
                match &mut workspace.0 {
                    $(Order::$order(engine) => engine.accept(state)),+
                }
            }

            fn between(
                &self,
                system: &S,
                h: V::Scalar,
                before: &afterbay_core::State<V>,
                workspace: &mut Workspace<V>,
                to: &mut afterbay_core::State<V>,
            ) -> Result<afterbay_core::Effort, afterbay_core::StepFailure> {
                match &mut workspace.0 {
                    $(Order::$order(engine) => engine.between(system, h, before, to)),+
                }
            }
        }
    };
}
pub(crate) use adaptive_of_orders;
