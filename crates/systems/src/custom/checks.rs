//! Checks of described systems.

use super::failure::{CustomError, Place};
use afterbay_core::{InputError, Mask, Quantity, Scalar, System};
use afterbay_expression::{Graph, Input, Node};
use std::collections::HashMap;
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
    first_not_finite(graph, places, &values)
}

/// Checks that all operations, and H, its gradient and D, are finite at (q, p). Where an operation
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
    let values = graph.evaluate(&graph.all(&operations), parameters, &|input| match input {
        Input::Coordinate(j) => q[j as usize],
        Input::Momentum(j) => p[j as usize],
        Input::Velocity(j) => hp[j as usize],
        Input::End => q[n - 1],
        Input::OwnCoordinate | Input::OwnMomentum => T::zero(),
    });
    first_not_finite(graph, places, &values)?;
    system.dissipation(q, p, &hp, &mut d);
    finite(Quantity::Energy, &[system.energy(q, p)])?;
    finite(Quantity::Slope, &hq)?;
    finite(Quantity::Velocity, &hp)?;
    finite(Quantity::Dissipation, &d)
}

/// Checks that the operations whose values are known are finite, and so are all parts of them, such
/// as the cube in x^-3. The error is that of the first that is not.
pub(super) fn first_not_finite<T: Scalar>(
    graph: &Graph,
    places: &Places,
    values: &HashMap<Node, T>,
) -> Result<(), CustomError> {
    let infinite =
        |node: &Node| values.get(node).filter(|x| !x.is_finite().all()).map(|x| x.to_f64());
    let error = |(place, _, span): &(Place, Node, Range<usize>), value| {
        Err(CustomError::NotFinite { place: *place, span: span.clone(), value })
    };
    for at in places {
        if let Some(value) = infinite(&at.1) {
            return error(at, value);
        }
    }
    if values.keys().all(|node| infinite(node).is_none()) {
        return Ok(());
    }
    for at in places {
        if let Some(value) = graph.all(&[at.1]).iter().find_map(infinite) {
            return error(at, value);
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
