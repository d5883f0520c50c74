//! A system whose potential and friction are expressions, compiled when it is made.
//!
//! ```text
//! q_j' = p_j/m_j        p_j' = -∂V/∂q_j - D_j        w_j' = D_j p_j/m_j
//! H = Σ p_j²/(2 m_j) + V(q)        D_j(q, p) as given, or D = R(q, p) v with v_j = p_j/m_j
//! ```
//!
//! Expressions are made of numbers, the names of parameters, q1, q2, .. and p1, p2, .., + - * / ^, parentheses, pi and the
//! functions sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs. `-q1^2` is -(q1²), `2^3^2` is 512. A power is a product
//! where the exponent is a whole number, with a root where it is half of one, and e^(b ln a) otherwise: then a must be positive.
//! N is the number of masses, else of the D_j, else the largest index in V.
//!
//! Nothing is claimed by sampling. ∂V/∂q_j and the second derivatives come from the expressions, with what V does not couple left
//! out, so that each costs O(1) where the coupling is local. The mean of ∂V/∂q_j along an edge comes from slope arithmetic, exact
//! to a few roundings for every V and every edge; an edge across a singularity of V is seen by intervals
//! ([`Separable::is_singular_along`]). D is passive where its form shows it: D_j p_j ≥ 0 by the signs of parameters, even powers, abs, sqrt and exp; or D = R v with R constant and positive semidefinite.
//!
//! What V and the γ_j(q) of D_j = γ_j p_j are made of decides how they are evaluated: sums of polynomials, each in one linear form
//! of one or two coordinates, by Horner's rule, eight degrees of freedom side by side; anything else by straight-line programs.
//!
//! Parameters and masses may be any finite and any positive numbers. Invariant: K = H + Σ w_j. References come from
//! [`afterbay_core::taylor::trajectory`], from kink to kink.

mod abilities;
mod description;
mod failure;
mod passive;
mod period;
mod polynomial;
mod ridges;
mod shape;
mod structure;

pub use crate::expression::parse::Problem;
pub use description::{Description, DissipationText};
pub use failure::{CustomError, Place};
pub use structure::Structure;

use crate::expression::graph::{Input, Node};
use crate::expression::program::Point;
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, Interval, Line, Mask, Quantity,
    Scalar, Separable, System, validate,
};
use shape::{Edge, Part, Potential, Resistance, Shape};
use std::sync::Arc;

/// A system made of expressions, its parameters in a scalar. Clones and other scalars share its programs.
#[derive(Clone, Debug)]
pub struct Custom<T> {
    shape: Arc<Shape>,
    parameters: Vec<T>,
    masses: Vec<T>,
    /// Are all of them 1?
    unit_mass: bool,
    /// 1/m_j
    inverse_masses: Vec<T>,
    /// The frames of all programs and the numbers of all polynomials, one after the other.
    frames: Vec<T>,
    /// γ_j of D_j = γ_j p_j, and γ_j m_j of D_j = γ_j m_j v_j; nothing where D is not so simple.
    rates: Vec<[T; 2]>,
    damping: DissipationForm,
}

impl Custom<f64> {
    /// Reads and compiles a description.
    ///
    /// # Errors
    /// [`CustomError`]: which expression, where in it, and what is wrong.
    pub fn new(description: &Description) -> Result<Self, CustomError> {
        let shape = Shape::new(description.read()?)?;
        let parameters = description.parameters.iter().map(|x| x.1).collect();
        Self::bind(Arc::new(shape), parameters).checked()
    }
}

impl<T: Scalar> Custom<T> {
    /// The same system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> Custom<U> {
        self.lift(|_, x| f(x))
    }

    /// The same, each parameter lifted by its name and value. What [`Custom::with`] would refuse is not looked for.
    pub fn lift<U: Scalar>(&self, f: impl Fn(&str, T) -> U) -> Custom<U> {
        Custom::bind(Arc::clone(&self.shape), self.parameters().map(|(name, x)| f(name, x)).collect())
    }

    /// The same system with another value of a parameter. Nothing is compiled.
    ///
    /// # Errors
    /// [`CustomError::NoParameter`], [`CustomError::Value`], and what the value makes of the masses and the constant parts of
    /// expressions.
    pub fn with(&self, name: &str, value: T) -> Result<Self, CustomError> {
        let Some(index) = self.shape.parameters.iter().position(|parameter| parameter == name) else {
            return Err(CustomError::NoParameter { name: name.to_owned() });
        };
        if !value.is_finite().all() {
            return Err(CustomError::Value { name: name.to_owned(), value: value.to_f64() });
        }
        let mut parameters = self.parameters.clone();
        parameters[index] = value;
        Self::bind(Arc::clone(&self.shape), parameters).checked()
    }

    /// Names and values.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, T)> {
        self.shape.parameters.iter().map(String::as_str).zip(self.parameters.iter().copied())
    }

    /// What follows from the form of V and D alone.
    pub fn structure(&self) -> &Structure {
        &self.shape.structure
    }

    /// Have all expressions, and the fields made of them, finite values at (q, p)?
    ///
    /// # Errors
    /// [`CustomError::NotFinite`] with the first operation that has none, or [`CustomError::Input`].
    pub fn check_at(&self, q: &[T], p: &[T]) -> Result<(), CustomError> {
        let (shape, n) = (&self.shape, self.shape.dof);
        for (quantity, part) in [(Quantity::Coordinate, q), (Quantity::Momentum, p)] {
            if part.len() != n {
                return Err(InputError::Length { quantity, expected: n, found: part.len() }.into());
            }
            finite(quantity, part)?;
        }
        let operations: Vec<Node> = shape.places.iter().map(|x| x.1).collect();
        let values =
            shape.graph.evaluate(&shape.graph.all(&operations), &self.parameters, |input| match input {
                Input::Coordinate(j) => q[j as usize],
                Input::Momentum(j) => p[j as usize],
                Input::Velocity(j) => p[j as usize] * self.inverse_masses[j as usize],
                Input::End => T::zero(),
            });
        for (place, node, span) in &shape.places {
            if let Some(value) = values.get(node).filter(|x| !x.is_finite().all()) {
                return Err(CustomError::NotFinite {
                    place: *place,
                    span: span.clone(),
                    value: value.to_f64(),
                });
            }
        }
        let [mut hq, mut hp, mut d] = [0; 3].map(|_| vec![T::zero(); n]);
        self.gradient(q, p, &mut hq, &mut hp);
        self.dissipation(q, p, &hp, &mut d);
        finite(Quantity::Energy, &[self.energy(q, p)])?;
        finite(Quantity::Slope, &hq)?;
        finite(Quantity::Velocity, &hp)?;
        finite(Quantity::Dissipation, &d)
    }

    /// Computes what depends on the parameters alone.
    fn bind(shape: Arc<Shape>, parameters: Vec<T>) -> Self {
        let closed = shape.graph.evaluate(&shape.closed, &parameters, |_| T::zero());
        let at = |node: &Node| closed.get(node).copied().unwrap_or(T::zero());
        let masses: Vec<T> = shape.masses.iter().map(at).collect();
        let rates = match &shape.resistance {
            Resistance::Constant(rates) => {
                rates.iter().zip(&masses).map(|(rate, &m)| [at(rate), at(rate) * m]).collect()
            }
            Resistance::Linear(_) | Resistance::General { .. } => Vec::new(),
        };
        let structure = &shape.structure;
        let zero = passive::zero(&shape, at);
        let damping = if zero {
            DissipationForm::NONE
        } else {
            DissipationForm {
                zero,
                passive: passive::passive(&shape, at),
                linear: structure.linear_dissipation,
                coupled: structure.coupled_dissipation,
            }
        };
        let frames = shape.frames.iter().map(at).collect();
        let inverse_masses = masses.iter().map(|m| m.recip()).collect();
        let unit_mass = masses.iter().all(|&m| m == T::one());
        Self { parameters, inverse_masses, frames, rates, damping, masses, unit_mass, shape }
    }

    /// The masses are masses, and what depends on the parameters alone is finite.
    fn checked(self) -> Result<Self, CustomError> {
        let (graph, shape) = (&self.shape.graph, &self.shape);
        let closed = graph.evaluate(&shape.closed, &self.parameters, |_| T::zero());
        for (place, node, span) in &shape.places {
            if let Some(value) = closed.get(node).filter(|x| !x.is_finite().all()) {
                return Err(CustomError::NotFinite {
                    place: *place,
                    span: span.clone(),
                    value: value.to_f64(),
                });
            }
        }
        validate::masses(&self)?;
        Ok(self)
    }

    fn frame(&self, part: &Part) -> &[T] {
        &self.frames[part.frame.clone()]
    }

    /// Writes what the programs give.
    #[inline(never)]
    fn fill(&self, parts: &[Part], point: &Point<'_, T>, to: &mut [T]) {
        for part in parts {
            part.program.run(self.frame(part), point, |j, x| to[j as usize] = x);
        }
    }

    /// Has the part of V no value somewhere between q and q with q_j moved to `to`?
    #[cold]
    fn is_singular(&self, part: &Part, q: &[T], j: usize, to: T) -> bool {
        // What is rounded to f64 may be a unit in the last place away.
        let enclosed = |x: T, lane: usize| {
            let x = x.lane(lane);
            if T::EPSILON < f64::EPSILON / 4.0 {
                Interval::new(x.next_down(), x.next_up())
            } else {
                Interval::from_f64(x)
            }
        };
        let frame = self.frame(part);
        (0..T::LANES).any(|lane| {
            part.program.is_singular(
                |k| enclosed(frame[k], lane),
                |input| match input {
                    Input::Coordinate(i) => enclosed(q[i as usize], lane),
                    Input::Momentum(_) | Input::Velocity(_) | Input::End => Interval::WHOLE,
                },
                [q[j].lane(lane), to.lane(lane)],
            )
        })
    }

    #[inline(never)]
    fn run<const K: usize>(&self, part: &Part, q: &[T], p: &[T], end: T) -> [T; K] {
        part.program.results(self.frame(part), &Point { q, p, v: &[], end })
    }
}

fn finite<T: Scalar>(quantity: Quantity, part: &[T]) -> Result<(), CustomError> {
    match part.iter().enumerate().find(|(_, x)| !x.is_finite().all()) {
        Some((dof, x)) => Err(InputError::NotFinite { quantity, dof, value: x.to_f64() }.into()),
        None => Ok(()),
    }
}

impl<T: Scalar> System<T> for Custom<T> {
    #[inline]
    fn dof(&self) -> usize {
        self.shape.dof
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let potential = match &self.shape.potential {
            Potential::Ridges { once, .. } => once.total(&self.frames, q),
            Potential::Programs { value, .. } => {
                let [potential] = self.run(value, q, p, T::zero());
                potential
            }
        };
        let twice =
            p.iter().zip(&self.inverse_masses).fold(T::zero(), |sum, (&p, &m)| (p * p).mul_add(m, sum));
        twice.half() + potential
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.slopes(&self.frames, q, hq),
            Potential::Programs { gradient, .. } => {
                self.fill(gradient, &Point { q, p, v: &[], end: T::zero() }, hq);
            }
        }
        if self.unit_mass {
            hp.copy_from_slice(p);
            return;
        }
        for (j, hp) in hp.iter_mut().enumerate() {
            *hp = p[j] * self.inverse_masses[j];
        }
    }

    #[inline(always)]
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        match &self.shape.resistance {
            Resistance::Constant(rates) if rates.is_empty() => d.fill(T::zero()),
            Resistance::Constant(_) => {
                for (j, d) in d.iter_mut().enumerate() {
                    *d = self.rates[j][1] * v[j];
                }
            }
            Resistance::Linear(rates) => {
                rates.values(&self.frames, q, d);
                for (j, d) in d.iter_mut().enumerate() {
                    *d *= if self.unit_mass { v[j] } else { self.masses[j] * v[j] };
                }
            }
            Resistance::General { forces, .. } => {
                self.fill(forces, &Point { q, p, v, end: T::zero() }, d);
            }
        }
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        self.unit_mass
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        self.damping
    }

    #[inline]
    fn coupling(&self) -> Coupling {
        self.shape.structure.coupling.clone()
    }

    /// x of each |x|, √x and ln x in ∂V/∂q_j and D_j.
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let point = Point { q, p, v: &[], end: T::zero() };
        for part in &self.shape.kinks {
            part.program.run(self.frame(part), &point, |_, x| put(x));
        }
    }
}

impl<T: Scalar> Separable<T> for Custom<T> {
    #[inline]
    fn mass(&self, j: usize) -> T {
        self.masses[j]
    }

    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.slope(&self.frames, q, j, at),
            Potential::Programs { partials, .. } => {
                let [slope] = self.run(&partials[j], q, &[], at);
                slope
            }
        }
    }

    #[inline(always)]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.mean(&self.frames, q, j, to),
            Potential::Programs { edges, .. } => match &edges[j] {
                Edge::Polynomial(polynomial) => polynomial.mean(&self.frames, q, j, to),
                Edge::Program(part) => {
                    let [value, slope] = self.run(part, q, &[], to);
                    Line { value, slope }
                }
            },
        }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn may_be_singular(&self) -> bool {
        self.shape.may_be_singular
    }

    #[inline(always)]
    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        match &self.shape.potential {
            Potential::Programs { singular, .. } => {
                singular[j].as_ref().is_some_and(|part| self.is_singular(part, q, j, to))
            }
            Potential::Ridges { .. } => false,
        }
    }

    #[inline(always)]
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let [value, by_q, by_p] = match &self.shape.resistance {
            Resistance::Constant(_) => match self.rates.get(j) {
                Some(&[rate, _]) => [rate * p[j], T::zero(), rate],
                None => [T::zero(); 3],
            },
            Resistance::Linear(rates) => {
                let Line { value: rate, slope } = rates.value(&self.frames, q, j);
                [rate * p[j], slope * p[j], rate]
            }
            Resistance::General { drags, .. } => self.run(&drags[j], q, p, T::zero()),
        };
        Dissipation { value, by_q, by_p }
    }
}

impl<T: Scalar> Curvature<T> for Custom<T> {
    #[inline]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        self.inverse_masses.iter().enumerate().for_each(|(j, &m)| put(Block::Hpp, j, j, m));
        let point = Point { q, p, v: &[], end: T::zero() };
        for part in &self.shape.curvature {
            part.program.run(self.frame(part), &point, |index, x| {
                let (block, i, j) = self.shape.entries[index as usize];
                put(block, i, j, x);
            });
        }
    }

    fn is_linear(&self) -> bool {
        self.shape.structure.linear
    }
}
