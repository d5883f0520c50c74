//! Failures are values that say where, what and how much.

use crate::{Block, Mask, Scalar};
use thiserror::Error;

/// What a number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// q
    Coordinate,
    /// p
    Momentum,
    /// w
    Reservoir,
    /// -∂H/∂q or D
    Force,
    /// H
    Energy,
    /// ∂H/∂q
    Slope,
    /// ∂H/∂p
    Velocity,
    /// ∂V/∂q
    Partial,
    /// The mean of ∂V/∂q along an edge.
    Increment,
    /// m
    Mass,
    /// D
    Dissipation,
    /// ∂D_j/∂p_j
    Friction,
    /// D_j ∂H/∂p_j, what the reservoir gains.
    Loss,
    /// Σ D_j ∂H/∂p_j
    TotalLoss,
}

impl Quantity {
    /// Its name with the degree of freedom, counted from 1, where it belongs to one.
    fn of(self, dof: usize) -> String {
        match self {
            Self::Energy | Self::TotalLoss => self.to_string(),
            _ => format!("{self}{}", dof + 1),
        }
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Coordinate => "q",
            Self::Momentum => "p",
            Self::Reservoir => "w",
            Self::Force => "force",
            Self::Energy => "H",
            Self::Slope => "∂H/∂q",
            Self::Velocity => "∂H/∂p",
            Self::Partial => "∂V/∂q",
            Self::Increment => "the mean of ∂V/∂q",
            Self::Mass => "m",
            Self::Dissipation => "D",
            Self::Friction => "∂D/∂p of ",
            Self::Loss => "w'",
            Self::TotalLoss => "Σ w'",
        })
    }
}

/// Why nothing was computed: what was asked for cannot be done.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InputError {
    /// A step size that is zero, negative or not finite.
    #[error("the step h = {h:?} must be positive and finite")]
    Step {
        /// The step asked for.
        h: f64,
    },
    /// An end of time that is zero, negative or not finite.
    #[error("the end of time {end:?} must be positive and finite")]
    End {
        /// The end asked for.
        end: f64,
    },
    /// The end is not reached by whole steps.
    #[error("the end {end:?} is no multiple of the step h = {h:?}: take h = {nearest:?}")]
    NotAMultiple {
        /// The end asked for.
        end: f64,
        /// The step asked for.
        h: f64,
        /// The nearest step that divides the end.
        nearest: f64,
    },
    /// A step that vanishes beside the time it is added to.
    #[error("time stalls: t + h = t at t = {t:?} with h = {h:?}: take a larger step or an earlier end")]
    TimeStalled {
        /// The time.
        t: f64,
        /// The step asked for.
        h: f64,
    },
    /// A tolerance that is not a positive number, or one that roundings alone exceed.
    #[error("the tolerance {name} = {value:?} must be finite and at least {least:e}")]
    Tolerance {
        /// Which of them.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The least there may be.
        least: f64,
    },
    /// A study that needs the solution beyond its end: it leaves the numbers, or lies on a kink from there
    /// on.
    #[error("the solution cannot be followed beyond t = {t:?}: end before")]
    SolutionEnds {
        /// The time it was followed to.
        t: f64,
    },
    /// More steps than anyone can wait for.
    #[error("{steps:e} steps are more than {limit:e}: take larger steps or an earlier end")]
    Budget {
        /// The steps asked for.
        steps: f64,
        /// The most there may be.
        limit: f64,
    },
    /// A vector of the wrong length.
    #[error("{quantity} has {found} entries and the number of degrees of freedom is {expected}")]
    Length {
        /// Which vector.
        quantity: Quantity,
        /// The number of degrees of freedom.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// A state that is not finite to begin with, or a system that is not at a state that is.
    #[error("{} = {value:?} is not finite", quantity.of(*dof))]
    NotFinite {
        /// Which vector.
        quantity: Quantity,
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The value given.
        value: f64,
    },
    /// A parameter outside its range.
    #[error("parameter {name} = {value:?} must be {range}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A mass that is zero, negative or not finite.
    #[error("m{} = {value:?} must be positive and finite", dof + 1)]
    Mass {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The mass given.
        value: f64,
    },
    /// A system that contradicts itself, see [`crate::check`].
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", quantity.of(*dof))]
    Contradiction {
        /// What is contradicted.
        quantity: Quantity,
        /// Which degree of freedom, from 0; for a sum, the one that contributes most to what is wrong.
        dof: usize,
        /// The value given, or the bound claimed.
        given: f64,
        /// The value found.
        found: f64,
        /// What should hold and does not.
        rule: &'static str,
    },
    /// The same of a derivative of one degree of freedom by another.
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", block.of(*row, *column))]
    ContradictionBetween {
        /// Which derivative.
        block: Block,
        /// The degree of freedom differentiated, from 0.
        row: usize,
        /// The degree of freedom it is differentiated by, from 0.
        column: usize,
        /// The value given.
        given: f64,
        /// The value found.
        found: f64,
        /// What should hold and does not.
        rule: &'static str,
    },
    /// A method that does not apply to this system.
    #[error("{method} does not apply: {why}")]
    Unsupported {
        /// The method.
        method: &'static str,
        /// What it needs and the system does not have.
        why: &'static str,
    },
}

/// Why a step could not be taken. The state is as it was before the step.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StepFailure {
    /// The step would give a number that is not finite.
    #[error("{quantity}{} becomes {value:?}: take a smaller step, or a method that is stable here", dof + 1)]
    NonFinite {
        /// Which vector.
        quantity: Quantity,
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The value it would have.
        value: f64,
    },
    /// The simple iteration moves away from the solution.
    #[error(
        "the fixed-point iteration of degree of freedom {} does not contract (updates change by the factor \
         {} after {iterations} iterations): take a smaller step or Newton's method",
        dof + 1,
        factor(*ratio)
    )]
    NotContracting {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// Iterations done.
        iterations: u32,
        /// The last update over the one before.
        ratio: f64,
    },
    /// Newton's iteration finds no solution that continues from h → 0, within the iterations it has.
    #[error(
        "Newton's iteration of degree of freedom {} stalls (last update {update:e} after {iterations} iterations): \
         it finds no solution that continues from h = 0, take a smaller step",
        dof + 1
    )]
    NewtonStalled {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// Iterations done.
        iterations: u32,
        /// The last update.
        update: f64,
    },
    /// The solution that continues from h → 0 is lost where the equation is seen to have several: the branch it is on meets
    /// another and ends, or forks.
    #[error(
        "the equation of degree of freedom {} has several solutions at {share:.6} of the step, and none is seen to continue \
         from h = 0 to its end: take a smaller step",
        dof + 1
    )]
    SeveralSolutions {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The share of the step at which they are seen.
        share: f64,
    },
    /// The linear equation of the step has no solution.
    #[error("the equation of degree of freedom {} is singular (its slope is {slope:e}): take another step", dof + 1)]
    Singular {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The slope.
        slope: f64,
    },
    /// The equations of the step do not fit in the memory allowed.
    #[error(
        "the equations of the step have {unknowns} unknowns, and their matrices would take {bytes:.1e} bytes: take a step \
         so short that simple iteration contracts, or an explicit method"
    )]
    TooLarge {
        /// The unknowns of one system of equations.
        unknowns: usize,
        /// What all of their matrices would take.
        bytes: f64,
    },
    /// No small change of (q, p) brings H to what K asks for.
    #[error(
        "the projection fails: K is off by {excess:e} after the step, and no change of q and p within the error allowed \
         makes up for it: take a smaller step, allow a larger error, or take a method of collocation"
    )]
    ProjectionFailed {
        /// What the step adds to K.
        excess: f64,
    },
    /// δ is not finite: its denominator vanishes.
    #[error("δ of degree of freedom {} has a pole (its denominator is {denominator:e}): step around it", dof + 1)]
    Pole {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The denominator: p for δ(q), V' + D for δ(p).
        denominator: f64,
    },
    /// Steps accurate enough become so short that t + h = t.
    #[error("the step shrinks to {h:e}, and t + h = t: allow a larger error, or end before")]
    Vanishes {
        /// The step.
        h: f64,
    },
    /// A quadrature does not resolve H along the step, and K would be lost.
    #[error(
        "{nodes} nodes do not resolve H along the step (K would move by {roundings:.0} roundings): take a smaller step"
    )]
    Unresolved {
        /// The nodes of the quadrature.
        nodes: usize,
        /// How far K would move, in roundings of what it is made of.
        roundings: f64,
    },
    /// H is singular between the ends of the step: on the edge along which a coordinate moves, or on
    /// the straight line from q to where the step leads. A mean of ∂H/∂q exists across a pole, and
    /// would keep K.
    #[error(
        "H is singular between the ends of the step, in which q{} goes from {from:?} to {to:?}: no step crosses a singularity, \
         take a smaller one, or end before the motion itself meets it",
        dof + 1
    )]
    AcrossSingularity {
        /// The degree of freedom that moves, or moves furthest, from 0.
        dof: usize,
        /// Its coordinate before the step.
        from: f64,
        /// Its coordinate after the step.
        to: f64,
    },
    /// The mean of ∂V/∂q along an edge is not resolved by quadrature: there may be a singularity on it.
    #[error(
        "the mean of ∂V/∂q{} between {from:?} and {to:?} is not resolved by quadrature: take a smaller step, or give the edge in \
         closed form",
        dof + 1
    )]
    EdgeUnresolved {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// Where the edge starts.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// The means along the edges of a step do not add up to what H changes by.
    #[error(
        "the means along the edges of the step do not add up to the increment of H (K would move by {roundings:.0} roundings): \
         H changes between the points they are taken from, or is another function; take a smaller step, or give the edges in \
         closed form"
    )]
    BalanceLost {
        /// How far K would move, in roundings of what it is made of.
        roundings: f64,
    },
    /// The step is too long for the flow of the linearised system to be followed.
    #[error(
        "h times the rates of the linearised system is more than {limit:e}, or about that: take a smaller step"
    )]
    TooLong {
        /// The limit.
        limit: f64,
    },
    /// No point near the end of an explicit step keeps K.
    #[error(
        "no relaxation root: K is off by {excess:e} after the explicit step, and no step near it keeps K: take another \
         step size (a smaller one if K grows), or an implicit method"
    )]
    NoRelaxationRoot {
        /// What the explicit step adds to K.
        excess: f64,
    },
}

/// A factor in words: one of many digits says no more than how large it is.
fn factor(x: f64) -> String {
    if x.abs() < 1e4 { format!("{x:.3}") } else { format!("{x:.2e}") }
}

impl StepFailure {
    /// The first entry that is not finite among the parts of a state that was about to be taken.
    #[cold]
    pub fn non_finite<T: Scalar>(parts: &[(Quantity, &[T])]) -> Self {
        for &(quantity, part) in parts {
            if let Some(dof) = part.iter().position(|x| !x.is_finite().all()) {
                return Self::NonFinite { quantity, dof, value: part[dof].to_f64() };
            }
        }
        Self::NonFinite { quantity: Quantity::Force, dof: 0, value: f64::NAN }
    }
}

/// A run that ended before its time. The state is that of the last good step.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("step {step} (from t = {t:?}): {failure}")]
pub struct RunError {
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time it started from.
    pub t: f64,
    /// Why.
    #[source]
    pub failure: StepFailure,
}

/// Why [`crate::integrate`] did not reach the end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IntegrateError {
    /// Nothing was computed.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A step failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// It was asked to stop.
    #[error("interrupted")]
    Interrupted,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_short() {
        let says = |ratio| StepFailure::NotContracting { dof: 0, iterations: 3, ratio }.to_string();
        for (ratio, factor) in [(1.5, " 1.500 "), (1.25e300, " 1.25e300 "), (f64::NAN, " NaN ")] {
            assert!(says(ratio).contains(factor), "{}", says(ratio));
        }
    }
}
