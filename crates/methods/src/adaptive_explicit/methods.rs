//! The traits of a method, from its tableau.

/// Implements [`afterbay_core::Adaptive`] and its binding for a method with this tableau.
macro_rules! adaptive_explicit {
    ($method:ty, $tableau:ty) => {
        impl crate::registry::binding::AdaptiveBinding for $method {
            fn bind(
                &self,
                target: &crate::registry::binding::Target<'_, f64>,
            ) -> crate::registry::binding::Bound<f64> {
                let system = target.curvature()?;
                match target.system.dof() {
                    1 => target.chosen::<afterbay_core::Single<f64>, _, _>(*self, system),
                    2 => target.chosen::<[f64; 2], _, _>(*self, system),
                    _ => target.chosen::<Vec<f64>, _, _>(*self, system),
                }
            }
        }

        impl<V, S> afterbay_core::Adaptive<V, S> for $method
        where
            V: afterbay_core::Vector,
            S: afterbay_core::Curvature<V::Scalar> + ?Sized,
        {
            type Workspace = crate::adaptive_explicit::Workspace<V>;

            fn workspace(
                &self,
                system: &S,
                tolerance: &afterbay_core::Tolerance,
                span: f64,
            ) -> Result<Self::Workspace, afterbay_core::InputError> {
                Ok(Self::Workspace::new::<$tableau, S>(system, tolerance, span))
            }

            #[inline]
            fn attempt(
                &self,
                system: &S,
                h: V::Scalar,
                state: &afterbay_core::State<V>,
                workspace: &mut Self::Workspace,
            ) -> Result<afterbay_core::Attempt, afterbay_core::StepFailure> {
                workspace.attempt::<$tableau, S>(system, h, state)
            }

            #[inline]
            fn end<'a>(&self, workspace: &'a Self::Workspace) -> &'a [V::Scalar] {
                workspace.end()
            }

            #[inline]
            fn accept(&self, state: &mut afterbay_core::State<V>, workspace: &mut Self::Workspace) {
                workspace.accept(state);
            }

            fn between(
                &self,
                system: &S,
                h: V::Scalar,
                before: &afterbay_core::State<V>,
                workspace: &mut Self::Workspace,
                to: &mut afterbay_core::State<V>,
            ) -> Result<afterbay_core::Effort, afterbay_core::StepFailure> {
                workspace.between::<$tableau, S>(system, h, before, to)
            }
        }
    };
}
pub(crate) use adaptive_explicit;
