//! Systems described by expressions: [`Custom`] is separable, [`CustomGeneral`] has any H(q, p).
//!
//! ```text
//! q_j' = p_j/m_j        p_j' = -∂V/∂q_j - D_j        w_j' = D_j p_j/m_j
//! H = Σ p_j²/(2 m_j) + V(q)        D_j(q, p), or D = R(q, p) v with v_j = p_j/m_j
//! ```
//!
//! Expressions are made of numbers, the names of parameters, q1, q2, .. and p1, p2, .., in D also
//! the velocities v1, v2, .., + - * / ^, parentheses, pi, the [`FUNCTIONS`], min and max. In V and
//! D of a separable system t is the time; the system is then [`Described::Clocked`].
//! `-q1^2` is -(q1²), `2^3^2` is 512. A power is a product if the exponent is a whole number, with
//! a square root if it is half of one, and e^(b ln a) otherwise, where a must be positive. `q[i+1]`
//! is an entry, `sum(i, 1, n-1, ..)` a sum over whole numbers, `wrap(i+1)` a periodic index; i in
//! the expression of a degree of freedom is its number. N is the number of masses, else of the D_j,
//! else the one given where `n` is used, else the largest index in V.
//!
//! All derivatives come from the expressions. Terms of V without q_j are left out of ∂V/∂q_j and
//! the second derivatives, so that each costs O(1) if the coupling is local. Divided differences of
//! V come from slope arithmetic and are exact to a few roundings for every V and every edge.
//! Singularities of V on an edge are found by interval arithmetic. D counts as passive if its form
//! shows it: D_j p_j ≥ 0 by the signs of parameters, even powers, abs, sqrt and exp, or D = R v
//! with R constant and positive semidefinite.
//!
//! The form of V and of the γ_j(q) in D_j = γ_j p_j decides how they are evaluated. Sums of
//! polynomials, each in one linear form of one or two coordinates, are evaluated by Horner's rule,
//! eight degrees of freedom in SIMD lanes. All other expressions are interpreted as straight-line
//! programs.
//!
//! Parameters are finite numbers, masses positive ones. Invariant: K = H + Σ w_j. References come
//! from [`afterbay_core::taylor::trajectory`], from kink to kink.

mod abilities;
mod breaks;
mod checks;
mod described;
mod description;
mod drive;
mod failure;
mod fields;
mod function;
mod general;
mod harmonics;
mod members;
mod passive;
mod period;
mod polynomial;
mod programs;
mod ridges;
mod second_derivatives;
mod shape;
mod structure;
mod wave;

pub use afterbay_expression::{FUNCTIONS, FUNCTIONS_OF_TWO, FUNCTIONS_WITH_JUMPS, Problem};
pub use described::Described;
pub use description::{
    Description, DissipationText, DriveDescription, FunctionDescription, GeneralDescription,
};
pub use drive::CustomDrive;
pub use failure::{CustomError, Place};
pub use function::CustomFunction;
pub use general::CustomGeneral;
pub use period::whole_multiples;
pub use structure::Structure;

use afterbay_core::{DissipationForm, Scalar, validate};
use afterbay_expression::{Node, Point};
use shape::{DissipationKernel, Shape};
use std::sync::Arc;

/// A system described by expressions, with its parameters in a scalar. Clones and the same system
/// in other scalars share its programs.
#[derive(Clone, Debug)]
pub struct Custom<T> {
    shape: Arc<Shape>,
    parameters: Vec<T>,
    masses: Vec<T>,
    /// Whether all masses are 1.
    unit_mass: bool,
    /// 1/m_j
    inverse_masses: Vec<T>,
    /// The frames of all programs and the numbers of all polynomials, in one array.
    frames: Vec<T>,
    /// [γ_j, γ_j m_j] if D_j = γ_j p_j with constant γ_j; else empty.
    rates: Vec<[T; 2]>,
    dissipation_form: DissipationForm,
}

/// The point (q, t): t is read as the end of an edge.
fn time_point<T: Scalar>(q: &[T], t: T) -> Point<'_, T> {
    Point { end: t, ..Point::new(q, &[], &[]) }
}

impl Custom<f64> {
    /// Compiles a description. [`Described::separable`] takes those that depend on the time, too.
    ///
    /// # Errors
    /// [`CustomError`], with the expression and the place in it, and [`CustomError::NeedsClock`] if
    /// V or D depends on t.
    pub fn new(description: &Description) -> Result<Self, CustomError> {
        let system = Self::compile(description)?;
        if system.shape.has_clock { Err(CustomError::NeedsClock) } else { Ok(system) }
    }

    /// Compiles a description. If V or D depends on t, it is the last coordinate.
    fn compile(description: &Description) -> Result<Self, CustomError> {
        let shape = Shape::new(description.read()?)?;
        let parameters = description.parameters.iter().map(|x| x.1).collect();
        Self::bind(Arc::new(shape), parameters).checked()
    }
}

impl<T: Scalar> Custom<T> {
    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> Custom<U> {
        self.lift(|_, x| f(x))
    }

    /// The system in another scalar, with parameters that may depend on their names. Values are not
    /// checked as by [`Custom::with`].
    pub fn lift<U: Scalar>(&self, f: impl Fn(&str, T) -> U) -> Custom<U> {
        Custom::bind(
            Arc::clone(&self.shape),
            self.parameters().map(|(name, x)| f(name, x)).collect(),
        )
    }

    /// The system with another value of a parameter. Nothing is compiled again.
    ///
    /// # Errors
    /// [`CustomError::NoParameter`], [`CustomError::Value`], and [`CustomError::NotFinite`] or
    /// [`CustomError::Input`] if masses or constant parts of expressions become invalid.
    pub fn with(&self, name: &str, value: T) -> Result<Self, CustomError> {
        let parameters = checks::replaced(&self.shape.parameters, &self.parameters, name, value)?;
        Self::bind(Arc::clone(&self.shape), parameters).checked()
    }

    /// The names and values of the parameters.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, T)> {
        self.shape.parameters.iter().map(String::as_str).zip(self.parameters.iter().copied())
    }

    /// The properties that follow from the form of V and D.
    pub fn structure(&self) -> &Structure {
        &self.shape.structure
    }

    /// Checks that all expressions, and H, its gradient and D, are finite at (q, p).
    ///
    /// # Errors
    /// [`CustomError::NotFinite`] with the first operation that is not, or [`CustomError::Input`].
    pub fn check_at(&self, q: &[T], p: &[T]) -> Result<(), CustomError> {
        let shape = &self.shape;
        checks::finite_at(self, &shape.graph, &shape.places, &self.parameters, [q, p])
    }

    /// Evaluates the parts that depend on the parameters alone.
    fn bind(shape: Arc<Shape>, parameters: Vec<T>) -> Self {
        let closed = shape.graph.evaluate(&shape.closed, &parameters, &|_| T::zero());
        let at = |node: &Node| closed.get(node).copied().unwrap_or(T::zero());
        let masses: Vec<T> = shape.masses.iter().map(at).collect();
        let rates = match &shape.dissipation_kernel {
            DissipationKernel::Constant(rates) => {
                rates.iter().zip(&masses).map(|(rate, &m)| [at(rate), at(rate) * m]).collect()
            }
            DissipationKernel::Linear(_) | DissipationKernel::General { .. } => Vec::new(),
        };
        let structure = &shape.structure;
        let sign = |node: Node| passive::sign(at(&node));
        let signs = passive::signs(&shape.graph, &shape.dissipations, &sign);
        let zero = passive::zero(&signs);
        let dissipation_form = if zero {
            DissipationForm::NONE
        } else {
            DissipationForm {
                zero,
                passive: passive::passive(&signs, shape.dof, shape.matrix.as_deref(), at),
                linear: structure.linear_dissipation,
                coupled: structure.coupled_dissipation,
            }
        };
        let frames = shape.frames.iter().map(at).collect();
        let inverse_masses = masses.iter().map(|m| m.recip()).collect();
        let unit_mass = masses.iter().all(|&m| m == T::one());
        Self {
            parameters,
            inverse_masses,
            frames,
            rates,
            dissipation_form,
            masses,
            unit_mass,
            shape,
        }
    }

    /// Checks that the masses are positive and the parts that depend on the parameters alone are
    /// finite.
    fn checked(self) -> Result<Self, CustomError> {
        let shape = &self.shape;
        checks::closed_are_finite(&shape.graph, &shape.places, &shape.closed, &self.parameters)?;
        validate::masses(&self)?;
        Ok(self)
    }
}
