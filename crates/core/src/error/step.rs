//! Steps that cannot be taken.

use crate::numbers::{Scalar, first_not_finite};
use crate::quantity::Quantity;
use thiserror::Error;

/// The reason why a step failed. The state is unchanged.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StepFailure {
    /// The step gives a number that is not finite.
    #[error("{} becomes {value:?}: {}", quantity.of(*dof), remedy(*value))]
    NonFinite {
        /// The vector.
        quantity: Quantity,
        /// The degree of freedom, from 0.
        dof: usize,
        /// The value it would have.
        value: f64,
    },
    /// H, a velocity or a force has no finite value at the state from which the step begins.
    #[error(
        "{} = {value:?} where the step begins: check the parameters and the masses, or begin where \
         H, its derivatives and D have values",
        quantity.of(*dof)
    )]
    Undefined {
        /// H, ∂H/∂q, ∂H/∂p or D
        quantity: Quantity,
        /// The degree of freedom, from 0.
        dof: usize,
        /// The value it has.
        value: f64,
    },
    /// The fixed-point iteration does not contract.
    #[error(
        "the fixed-point iteration of degree of freedom {} does not contract (updates change by \
         the factor {} after {iterations} iterations): take a smaller step, or a method that is \
         solved by Newton's iteration",
        dof + 1,
        factor(*ratio)
    )]
    NotContracting {
        /// The degree of freedom, from 0.
        dof: usize,
        /// Evaluations of the equation, over all attempts.
        iterations: u32,
        /// The last update over the one before.
        ratio: f64,
    },
    /// Newton's method finds no solution on the branch that starts at h = 0 within its limit of
    /// iterations.
    #[error(
        "Newton's iteration of degree of freedom {} stalls (last update {update:e} after \
         {iterations} iterations): {}",
        dof + 1,
        stalled(*update)
    )]
    NewtonStalled {
        /// The degree of freedom, from 0.
        dof: usize,
        /// Evaluations of the equation, over all attempts.
        iterations: u32,
        /// The last update.
        update: f64,
    },
    /// The branch of solutions that starts at h = 0 ends at a fold or forks before the whole step,
    /// where the equation has several solutions.
    #[error(
        "the equation of degree of freedom {} has several solutions at {share:.6} of the step, and \
         none is seen to continue from h = 0 to its end: take a smaller step",
        dof + 1
    )]
    SeveralSolutions {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The share of the step at which several solutions are found.
        share: f64,
    },
    /// The linear equation of the step has no solution.
    #[error(
        "the equation of degree of freedom {} is singular{}: take another step",
        dof + 1,
        of_slope(*slope)
    )]
    Singular {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The slope, where the equation is solved by itself; none where a matrix is singular.
        slope: Option<f64>,
    },
    /// The matrices of the equations exceed the memory allowed.
    #[error(
        "the equations of the step have {unknowns} unknowns, and their matrices would take \
         {bytes:.1e} bytes: take a step so short that fixed-point iteration contracts, or an \
         explicit method"
    )]
    TooLarge {
        /// The unknowns of one system of equations.
        unknowns: usize,
        /// The memory that all of their matrices would take.
        bytes: f64,
    },
    /// No small change of (q, p) restores K.
    #[error(
        "the projection fails: K is off by {excess:e} after the step, and no change of q and p of \
         the size of its error makes up for it: take a smaller step, or a larger tolerance where \
         the method chooses its steps, or a method of collocation"
    )]
    ProjectionFailed {
        /// The change of K over the step.
        excess: f64,
    },
    /// δ is not finite: its denominator vanishes.
    #[error(
        "δ of degree of freedom {} has a pole (its denominator is {denominator:e}): take another \
         step size; if none helps, as at p = 0, take another initial state",
        dof + 1
    )]
    Pole {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The denominator: p for δ(q), V' + D for δ(p).
        denominator: f64,
    },
    /// The error control shortens the steps to roundings of t, or below the least step allowed.
    #[error(
        "the step shrinks to {h:e}, a rounding of t or below the least step allowed: allow a \
         larger error, or end before a singularity, a jump of a force, or a point where H or D has \
         no value"
    )]
    Vanishes {
        /// The step.
        h: f64,
    },
    /// Events follow each other within one step without end.
    #[error(
        "events follow each other without end within one step ({count} so far, the last is event \
         {} of the list), as those of a ball that bounces to rest, or of a wall whose action does \
         not turn the motion back: end before, or stop at the event",
        event + 1
    )]
    EventsAccumulate {
        /// The number of events before the step is given up.
        count: u64,
        /// The event that happens again, from 0.
        event: usize,
    },
    /// The action at an event leaves a state that is not finite.
    #[error(
        "event {} of the list leaves {} = {value:?}, which is not finite: check its action",
        event + 1,
        quantity.of(*dof)
    )]
    LeftByEvent {
        /// The event, from 0.
        event: usize,
        /// The vector.
        quantity: Quantity,
        /// The degree of freedom, from 0.
        dof: usize,
        /// The value it has.
        value: f64,
    },
    /// The motion is too fast or too stiff for the step, or passes kinks of the forces within it
    /// without end.
    #[error(
        "{parts} parts of the step do not reach its end: the motion is too fast or too stiff for \
         it (take a smaller step), or meets kinks of the force without end, as where it comes to \
         rest on one (take a force that is smooth there)"
    )]
    PartsAccumulate {
        /// The number of parts, those included that were taken again.
        parts: u32,
    },
    /// The ∂V/∂q_j that a separable system gives differs from that in its gradient, so that no step
    /// keeps K.
    #[error(
        "partial() gives ∂V/∂q{} = {partial:e} and gradient() gives {slope:e}: \
         `validate::separable` compares the two, and `Formulas` derives both from H",
        dof + 1
    )]
    NotPartial {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The derivative that `partial` gives.
        partial: f64,
        /// The derivative that `gradient` gives.
        slope: f64,
    },
    /// The gradient that a system gives is not that of its energy, so that no step keeps K.
    #[error(
        "the gradient is not that of H: along (q, p) it gives a change of {integral:e}, and H \
         changes by {rise:e}; `validate::system` finds the entry that is wrong, and `Formulas` \
         derives all of them from H"
    )]
    NotGradient {
        /// The integral of ∇H·(q, p) over a short line.
        integral: f64,
        /// The change of H along it.
        rise: f64,
    },
    /// A quadrature does not resolve H along the step, so that K would change.
    #[error(
        "{nodes} nodes do not resolve H along the step (K would move by {roundings:.0} roundings): \
         take a smaller step, or a method without a quadrature if H has a kink there"
    )]
    Unresolved {
        /// The nodes of the quadrature.
        nodes: usize,
        /// The change of K, in rounding errors of its terms.
        roundings: f64,
    },
    /// H or the force of a drive is singular between the ends of the step: on the edge along which
    /// a coordinate moves, or on the straight line from q to where the step leads. A mean of ∂H/∂q
    /// exists across a pole, and would keep K.
    #[error(
        "H, D or a force is singular between the ends of the step, in which q{} goes from {from:?} \
         to {to:?}: no step crosses a singularity, take a smaller one, or end before the motion \
         itself meets it",
        dof + 1
    )]
    AcrossSingularity {
        /// The degree of freedom that moves, from 0. If several move, it is one whose move meets
        /// the singularity.
        dof: usize,
        /// Its coordinate before the step.
        from: f64,
        /// Its coordinate after the step.
        to: f64,
    },
    /// The mean of ∂V/∂q along an edge is not resolved by quadrature: there may be a singularity on
    /// it.
    #[error(
        "the mean of ∂V/∂q{} between {from:?} and {to:?} is not resolved by quadrature: take a \
         smaller step, or give the divided difference in closed form",
        dof + 1
    )]
    EdgeUnresolved {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The start of the edge.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// The divided differences along the edges of a step do not add up to the change of H.
    #[error(
        "the divided differences along the step do not add up to the increment of H (K would move \
         by {roundings:.0} roundings): the quadrature misses a feature of H, or they are not those \
         of the energy; take a smaller step, or give divided differences in closed form"
    )]
    BalanceLost {
        /// The change of K, in rounding errors of its terms.
        roundings: f64,
    },
    /// The step is too long for the flow of the linearised system to be computed.
    #[error(
        "h times the rates of the linearised system is near or above {limit:e}: take a smaller step"
    )]
    TooLong {
        /// The limit.
        limit: f64,
    },
    /// No point near the end of an explicit step keeps K.
    #[error(
        "no relaxation root: K is off by {excess:e} after the explicit step, and no step near it \
         keeps K: take another step size (a smaller one if K grows), or an implicit method"
    )]
    NoRelaxationRoot {
        /// The change of K over the explicit step.
        excess: f64,
    },
    /// No momentum gives the velocity of a coordinate after an impact.
    #[error(
        "no momentum p{} was found at which q{} has the velocity {velocity:e} after the impact: H \
         may bound this velocity, or it may not depend on p{}",
        .dof + 1, .dof + 1, .dof + 1
    )]
    NoRebound {
        /// The degree of freedom.
        dof: usize,
        /// The velocity.
        velocity: f64,
    },
}

/// The slope of an equation in brackets; nothing if it is not known.
fn of_slope(slope: Option<f64>) -> String {
    slope.map_or_else(String::new, |slope| format!(" (its slope is {slope:e})"))
}

/// A factor with three decimals, or in scientific notation if it is large.
fn factor(x: f64) -> String {
    if x.abs() < 1e4 { format!("{x:.3}") } else { format!("{x:.2e}") }
}

/// The reason and the advice where Newton's iteration stalls. At the start of a step the derivative
/// of a force may have no value, although the force has one.
fn stalled(update: f64) -> &'static str {
    if update.is_nan() {
        "a force or its derivative has no value on the way, take a smaller step; if none helps, \
         write the force so that its derivative exists, or take a method without this equation, \
         such as adaptive-dop853"
    } else {
        "it finds no solution that continues from h = 0, take a smaller step"
    }
}

/// The advice where a number is not finite.
fn remedy(value: f64) -> &'static str {
    if value.is_nan() {
        "take a smaller step, or a method that is stable here; no step helps where the motion \
         itself grows without bound, or reaches a point where H or D has no value, such as ln(q) \
         or q^m for q < 0"
    } else {
        "take a smaller step, or a method that is stable here; no step helps where the motion \
         itself grows without bound"
    }
}

impl StepFailure {
    /// The failure that names the first entry of `parts` that is not finite.
    #[cold]
    pub fn non_finite<T: Scalar>(parts: &[(Quantity, &[T])]) -> Self {
        for &(quantity, part) in parts {
            if let Some((dof, value)) = first_not_finite(part) {
                return Self::NonFinite { quantity, dof, value };
            }
        }
        Self::NonFinite { quantity: Quantity::Force, dof: 0, value: f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_value_is_said_of_nan_alone() {
        let says =
            |value| StepFailure::NonFinite { quantity: Quantity::Force, dof: 0, value }.to_string();
        assert!(says(f64::NAN).contains("has no value"), "{}", says(f64::NAN));
        assert!(!says(f64::INFINITY).contains("has no value"), "{}", says(f64::INFINITY));
        // A motion with negative damping, say, grows with any step.
        assert!(says(f64::INFINITY).contains("the motion itself grows without bound"));
    }

    #[test]
    fn the_slope_is_said_where_it_is_known() {
        let says = |slope| StepFailure::Singular { dof: 0, slope }.to_string();
        assert!(says(Some(-0.5)).contains("is singular (its slope is -5e-1): "));
        assert!(says(None).contains("is singular: "), "{}", says(None));
    }

    #[test]
    fn one_event_is_not_called_events() {
        let says = StepFailure::EventsAccumulate { count: 1, event: 2 }.to_string();
        assert!(says.contains("(1 so far, the last is event 3 of the list)"), "{says}");
        assert!(!says.contains("1 events"), "{says}");
    }

    #[test]
    fn factors_are_short() {
        let says = |ratio| StepFailure::NotContracting { dof: 0, iterations: 3, ratio }.to_string();
        for (ratio, factor) in [(1.5, " 1.500 "), (1.25e300, " 1.25e300 "), (f64::NAN, " NaN ")] {
            assert!(says(ratio).contains(factor), "{}", says(ratio));
        }
    }
}
