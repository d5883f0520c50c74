//! Checks of described systems.

use super::failure::{CustomError, Place};
use afterbay_core::{InputError, Mask, Quantity, Scalar, System};
use afterbay_expression::{Graph, Input, Node};
use std::ops::Range;

/// The expression and the bytes of each operation, operands first.
type Places = [(Place, Node, Range<usize>)];

/// The parameters with another value for one of them.
pub(super) fn replaced<T: Scalar>(
    names: &[String],
    parameters: &[T],
    name: &str,
    value: T,
) -> Result<Vec<T>, CustomError> {
    let Some(index) = names.iter().position(|parameter| parameter == name) else {
        return Err(CustomError::NoParameter { name: name.to_owned() });
    };
    if !value.is_finite().all() {
        return Err(CustomError::Value { name: name.to_owned(), value: value.to_f64() });
    }
    let mut parameters = parameters.to_vec();
    parameters[index] = value;
    Ok(parameters)
}

/// Checks that the operations that depend on the parameters alone are finite.
pub(super) fn closed_are_finite<T: Scalar>(
    graph: &Graph,
    places: &Places,
    closed: &[Node],
    parameters: &[T],
) -> Result<(), CustomError> {
    let values = graph.evaluate(closed, parameters, &|_| T::zero());
    first_not_finite(places, |node| values.get(node).copied())
}

/// Checks that all operations and their parts, and H, its gradient and D, are finite at (q, p). Where an operation
/// mentions the time, that is the last coordinate.
pub(super) fn finite_at<T: Scalar, S: System<T>>(
    system: &S,
    graph: &Graph,
    places: &Places,
    parameters: &[T],
    [q, p]: [&[T]; 2],
) -> Result<(), CustomError> {
    let n = system.dof();
    for (quantity, part) in [(Quantity::Coordinate, q), (Quantity::Momentum, p)] {
        if part.len() != n {
            return Err(InputError::Length { quantity, expected: n, found: part.len() }.into());
        }
        finite(quantity, part)?;
    }
    let [mut hq, mut hp, mut d] = [0; 3].map(|_| vec![T::zero(); n]);
    system.gradient(q, p, &mut hq, &mut hp);
    let operations: Vec<Node> = places.iter().map(|x| x.1).collect();
    let parts = graph.all(&operations);
    let values = graph.evaluate(&parts, parameters, &|input| match input {
        Input::Coordinate(j) => q[j as usize],
        Input::Momentum(j) => p[j as usize],
        Input::Velocity(j) => hp[j as usize],
        Input::End => q[n - 1],
        Input::OwnCoordinate | Input::OwnMomentum => T::zero(),
    });
    first_not_finite(places, |node| values.get(node).copied())?;
    let mut known = parts.iter().filter_map(|&part| Some((part, *values.get(&part)?)));
    if let Some((part, value)) = known.find(|(_, x)| !x.is_finite().all()) {
        return Err(inner_not_finite(graph, places, part, value));
    }
    system.dissipation(q, p, &hp, &mut d);
    finite(Quantity::Energy, &[system.energy(q, p)])?;
    finite(Quantity::Slope, &hq)?;
    finite(Quantity::Velocity, &hp)?;
    finite(Quantity::Dissipation, &d)
}

/// The error of a part that is not finite inside of an operation that is, as the cube in x^-3.
fn inner_not_finite<T: Scalar>(
    graph: &Graph,
    places: &Places,
    part: Node,
    value: T,
) -> CustomError {
    let value = value.to_f64();
    match places.iter().find(|(_, node, _)| graph.all(&[*node]).contains(&part)) {
        Some((place, _, span)) => {
            CustomError::NotFinite { place: *place, span: span.clone(), value }
        }
        None => InputError::NotFinite { quantity: Quantity::Energy, dof: 0, value }.into(),
    }
}

/// The first operation whose value is known and not finite is an error.
pub(super) fn first_not_finite<T: Scalar>(
    places: &Places,
    value: impl Fn(&Node) -> Option<T>,
) -> Result<(), CustomError> {
    for (place, node, span) in places {
        if let Some(value) = value(node).filter(|x| !x.is_finite().all()) {
            let (place, span, value) = (*place, span.clone(), value.to_f64());
            return Err(CustomError::NotFinite { place, span, value });
        }
    }
    Ok(())
}

fn finite<T: Scalar>(quantity: Quantity, part: &[T]) -> Result<(), CustomError> {
    match part.iter().enumerate().find(|(_, x)| !x.is_finite().all()) {
        Some((dof, x)) => Err(InputError::NotFinite { quantity, dof, value: x.to_f64() }.into()),
        None => Ok(()),
    }
}
