//! The abilities of a driven system: those of the system, with the same drive.

use super::{Drive, Driven};
use crate::numbers::Scalar;
use crate::system::abilities::{Abilities, SecondDerivatives};
use crate::system::separable::Separable;
use std::sync::Arc;

impl<T: Scalar> Abilities<T> for Driven<dyn Abilities<T>, dyn Drive<T>> {
    fn driven(&self) -> Option<&Self> {
        Some(self)
    }

    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        let system = self.system.clone().separable()?;
        Some(Arc::new(self.with(system)))
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        let system = self.system.clone().second_derivatives()?;
        Some(Arc::new(self.with(system)))
    }
}

impl<S: ?Sized, D: ?Sized> Driven<S, D> {
    /// Another view of the same system, with the same drive.
    fn with<R: ?Sized>(&self, system: Arc<R>) -> Driven<R, D> {
        let (drive, motors) = (Arc::clone(&self.drive), self.motors.clone());
        Driven { system, drive, dof: self.dof, motors }
    }
}
