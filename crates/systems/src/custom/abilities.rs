//! The abilities of a custom system.

use super::Custom;
use super::shape::Shape;
use afterbay_core::{
    Abilities, EndMembers, InputError, Members, Scalar, SecondDerivatives, Separable, Uniform,
    f64x8,
};
use std::any::Any;
use std::sync::Arc;

impl<T: Scalar> Abilities<T> for Custom<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }

    fn is_uniform(&self) -> bool {
        self.shape.members.is_some()
    }

    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        let uniform = self.is_uniform().then_some(self as Arc<dyn Any + Send + Sync>)?;
        Some(uniform.downcast::<Custom<f64>>().ok()? as Arc<dyn Members>)
    }
}

impl Uniform for Custom<f64> {
    type Lanes = Custom<f64x8>;

    fn lanes(&self) -> Result<Custom<f64x8>, InputError> {
        let why = "its expressions are not those of a long chain or ring of equal members";
        match &self.shape.members {
            Some(members) => Ok(self.member(&members.inner)),
            None => Err(InputError::Unsupported { method: "increment", why }),
        }
    }

    fn ends(&self) -> Option<EndMembers> {
        let ends = self.shape.members.as_ref()?.ends.as_ref()?;
        Some(
            ends.each_ref().map(|end| Arc::new(self.member::<f64>(end)) as Arc<dyn Separable<f64>>),
        )
    }
}

impl Custom<f64> {
    /// A member with the parameters of this system.
    fn member<T: Scalar>(&self, law: &Arc<Shape>) -> Custom<T> {
        Custom::bind(Arc::clone(law), self.parameters.iter().map(|&x| T::from_f64(x)).collect())
    }
}
