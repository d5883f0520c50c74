//! Systems with any H(q, p), described by expressions.
//!
//! ```text
//! q_j' = ∂H/∂p_j        p_j' = -∂H/∂q_j - D_j        w_j' = D_j ∂H/∂p_j        D_j(q, p, v)
//! ```
//!
//! Expressions are those of [`super`], and v_j is the velocity ∂H/∂p_j. Derivatives and divided
//! differences along each coordinate and each momentum come from the expression of H, and are exact
//! to a few roundings. All expressions are interpreted as straight-line programs. Singularities of
//! H on the way of a step are found if their places depend on coordinates alone.

mod phase_plane;
mod shape;

use super::description::GeneralDescription;
use super::failure::CustomError;
use super::programs::{Part, run_at};
use super::{checks, passive, period};
use afterbay_core::singularity::{between, enclosed};
use afterbay_core::{
    Abilities, Block, Coupling, Curvature, DissipationForm, Interval, PhasePlane, Scalar,
    SecondDerivatives, System,
};
use afterbay_expression::{Input, Node, Point};
use shape::Shape;
use std::sync::Arc;

/// A system with any H(q, p), with its parameters in a scalar. Clones and the same system in other
/// scalars share its programs.
#[derive(Clone, Debug)]
pub struct CustomGeneral<T> {
    shape: Arc<Shape>,
    parameters: Vec<T>,
    /// The frames of all programs, in one array.
    frames: Vec<T>,
    dissipation_form: DissipationForm,
}

impl CustomGeneral<f64> {
    /// Compiles a description.
    ///
    /// # Errors
    /// [`CustomError`], with the expression and the place in it.
    pub fn new(description: &GeneralDescription) -> Result<Self, CustomError> {
        let shape = Shape::new(description.read()?)?;
        let parameters = description.parameters.iter().map(|x| x.1).collect();
        Self::bind(Arc::new(shape), parameters).checked()
    }

    /// The period of each coordinate, as for [`super::Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        let shape = &self.shape;
        period::periods(&shape.graph, &shape.fields, shape.dof, &self.parameters)
    }
}

impl<T: Scalar> CustomGeneral<T> {
    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> CustomGeneral<U> {
        self.lift(|_, x| f(x))
    }

    /// The system in another scalar, with parameters that may depend on their names. Values are not
    /// checked as by [`CustomGeneral::with`].
    pub fn lift<U: Scalar>(&self, f: impl Fn(&str, T) -> U) -> CustomGeneral<U> {
        let parameters = self.parameters().map(|(name, x)| f(name, x)).collect();
        CustomGeneral::bind(Arc::clone(&self.shape), parameters)
    }

    /// The system with another value of a parameter. Nothing is compiled again.
    ///
    /// # Errors
    /// [`CustomError::NoParameter`], [`CustomError::Value`], and [`CustomError::NotFinite`] if
    /// constant parts of expressions become invalid.
    pub fn with(&self, name: &str, value: T) -> Result<Self, CustomError> {
        let parameters = checks::replaced(&self.shape.parameters, &self.parameters, name, value)?;
        Self::bind(Arc::clone(&self.shape), parameters).checked()
    }

    /// The names and values of the parameters.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, T)> {
        self.shape.parameters.iter().map(String::as_str).zip(self.parameters.iter().copied())
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
        let sign = |node: Node| passive::sign(at(&node));
        let signs = passive::signs(&shape.graph, &shape.dissipations, &sign);
        let dissipation_form = if passive::zero(&signs) {
            DissipationForm::NONE
        } else {
            DissipationForm {
                passive: passive::passive(&signs, shape.dof, shape.matrix.as_deref(), at),
                coupled: shape.coupled_dissipation,
                ..DissipationForm::GENERAL
            }
        };
        let frames = shape.frames.iter().map(at).collect();
        Self { parameters, frames, dissipation_form, shape }
    }

    /// Checks that the parts that depend on the parameters alone are finite.
    fn checked(self) -> Result<Self, CustomError> {
        let shape = &self.shape;
        checks::closed_are_finite(&shape.graph, &shape.places, &shape.closed, &self.parameters)?;
        Ok(self)
    }

    fn frame(&self, part: &Part) -> &[T] {
        &self.frames[part.frame.clone()]
    }

    #[inline(never)]
    fn run<const K: usize>(&self, part: &Part, point: &Point<'_, T>) -> [T; K] {
        part.program.results(self.frame(part), point)
    }
}

impl<T: Scalar> System<T> for CustomGeneral<T> {
    #[inline]
    fn dof(&self) -> usize {
        self.shape.dof
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let [energy] = self.run(&self.shape.energy, &Point::new(q, p, &[]));
        energy
    }

    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let n = self.shape.dof;
        for part in &self.shape.gradient {
            part.program.run(self.frame(part), &Point::new(q, p, &[]), |k, x| {
                match (k as usize).checked_sub(n) {
                    Some(j) => hp[j] = x,
                    None => hq[k as usize] = x,
                }
            });
        }
    }

    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        if self.shape.forces.is_empty() {
            d.fill(T::zero());
        }
        for part in &self.shape.forces {
            let point = Point::new(q, p, v);
            part.program.run(self.frame(part), &point, |j, x| d[j as usize] = x);
        }
    }

    fn has_batches(&self) -> bool {
        true
    }

    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        let (n, point) = (self.shape.dof, |i| Point::new(q[i], p[i], &[]));
        run_at(&self.shape.gradient, &self.frames, q.len(), point, |i, k, x| {
            match (k as usize).checked_sub(n) {
                Some(j) => hp[i][j] = x,
                None => hq[i][k as usize] = x,
            }
        });
    }

    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        if self.shape.forces.is_empty() {
            d.iter_mut().for_each(|d| d.fill(T::zero()));
        }
        let point = |i| Point::new(q[i], p[i], v[i]);
        run_at(&self.shape.forces, &self.frames, q.len(), point, |i, j, x| d[i][j as usize] = x);
    }

    fn dissipation_form(&self) -> DissipationForm {
        self.dissipation_form
    }

    fn finds_dissipation_form(&self) -> bool {
        true
    }

    fn coupling(&self) -> Coupling {
        self.shape.coupling.clone()
    }

    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        for part in &self.shape.kinks {
            part.program.run(self.frame(part), &Point::new(q, p, &[]), |_, x| put(x));
        }
    }

    fn may_be_singular(&self) -> bool {
        !self.shape.singular.is_empty()
    }

    #[cold]
    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        self.shape.singular.iter().any(|part| {
            let frame = self.frame(part);
            (0..T::LANES).any(|lane| {
                let input = |input, share| match input {
                    Input::Coordinate(i) => {
                        let [from, to] = [from, to].map(|q| enclosed(q[i as usize], lane));
                        between(from, to, share)
                    }
                    _ => Interval::WHOLE,
                };
                part.program.is_singular([0.0, 1.0], &|k| enclosed(frame[k], lane), &input)
            })
        })
    }
}

impl<T: Scalar> Curvature<T> for CustomGeneral<T> {
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        for part in &self.shape.curvature {
            part.program.run(self.frame(part), &Point::new(q, p, &[]), |index, x| {
                let (block, i, j) = self.shape.entries[index as usize];
                put(block, i, j, x);
            });
        }
    }

    fn is_linear(&self) -> bool {
        self.shape.linear
    }
}

impl<T: Scalar> Abilities<T> for CustomGeneral<T> {
    fn phase_planes(self: Arc<Self>) -> Option<Arc<dyn PhasePlane<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }
}
