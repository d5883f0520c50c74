//! A system in another unit of time.

use crate::numbers::Scalar;
use crate::system::{Coupling, DissipationForm, System};

/// A system in the time s = t/u. H, D and w are those of the system times u, and q and p stay as
/// they are:
///
/// ```text
/// dq/ds = u ∂H/∂p,   dp/ds = -u (∂H/∂q + D),   d(u w_j)/ds = (u D_j) (u ∂H/∂p_j)
/// ```
///
/// The Taylor coefficients of a motion in 1e-14 s grow like 1e14^k, beyond the largest number; in a
/// unit near its step they do not. With a power of two for u no digit changes. This type serves
/// series alone: it does not state the times at which forces jump.
pub struct InUnits<S> {
    system: S,
    unit: f64,
}

impl<S> InUnits<S> {
    /// The system in the unit u, a positive number of units of its own time.
    pub fn new(system: S, unit: f64) -> Self {
        Self { system, unit }
    }
}

impl<T: Scalar, S: System<T>> System<T> for InUnits<S> {
    fn dof(&self) -> usize {
        self.system.dof()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        T::from_f64(self.unit) * self.system.energy(q, p)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.system.gradient(q, p, hq, hp);
        let unit = T::from_f64(self.unit);
        hq.iter_mut().chain(hp).for_each(|slope| *slope *= unit);
    }
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        let (unit, inverse) = (T::from_f64(self.unit), T::from_f64(self.unit.recip()));
        let v: Vec<T> = v.iter().map(|&v| v * inverse).collect();
        self.system.dissipation(q, p, &v, d);
        d.iter_mut().for_each(|d| *d *= unit);
    }
    fn dissipation_form(&self) -> DissipationForm {
        self.system.dissipation_form()
    }
    fn motors(&self) -> usize {
        self.system.motors()
    }
    fn coupling(&self) -> Coupling {
        self.system.coupling()
    }
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.system.kinks(q, p, put);
    }
}
