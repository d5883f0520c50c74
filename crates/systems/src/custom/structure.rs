//! Properties of a system that the form of its expressions shows.

use afterbay_core::Coupling;
use afterbay_expression::{Graph, Input, Kinds, Node};

/// Properties that follow from the form of V and D.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structure {
    /// The degree of V, if it is a polynomial.
    pub degree: Option<u32>,
    /// The degree of V in each coordinate, if it is a polynomial in it.
    pub degrees: Vec<Option<u32>>,
    /// H is quadratic and D linear, apart from constant forces: all second derivatives are
    /// constant.
    pub linear: bool,
    /// The pattern of degrees of freedom that act on each other.
    pub coupling: Coupling,
    /// D is linear in p with D(q, 0) = 0.
    pub linear_dissipation: bool,
    /// A D_j depends on another momentum than p_j.
    pub coupled_dissipation: bool,
}

impl Structure {
    pub(super) fn new(
        graph: &Graph,
        potential: Node,
        slopes: &[Node],
        forces: &[Node],
        second: impl IntoIterator<Item = Node>,
        smooth: bool,
    ) -> Self {
        let n = slopes.len();
        let degree = graph.degrees(potential, Kinds::COORDINATES).map(|degrees| degrees.most);
        let along = |(j, &slope): (usize, &Node)| {
            let degrees = graph.degrees_by(slope, Input::Coordinate(j as u32))?;
            Some(if graph.is_zero(slope) { 0 } else { degrees.most.saturating_add(1) })
        };
        let linear_dissipation = forces.iter().all(|&x| linear(graph, x, Kinds::MOMENTA));
        let coupled_dissipation = forces.iter().enumerate().any(|(j, &force)| {
            let mut momenta = graph.inputs(force, Kinds::MOMENTA).into_iter();
            momenta.any(|input| input != Input::Momentum(j as u32))
        });
        let fields = slopes.iter().copied().enumerate().chain(forces.iter().copied().enumerate());
        Self {
            degree,
            degrees: slopes.iter().enumerate().map(along).collect(),
            linear: smooth && second.into_iter().all(|node| graph.closed(node)),
            coupling: coupling(graph, n, fields),
            linear_dissipation,
            coupled_dissipation,
        }
    }
}

/// The pattern of degrees of freedom that act on each other, given functions each of which acts on
/// a degree of freedom.
pub(super) fn coupling(
    graph: &Graph,
    n: usize,
    fields: impl Iterator<Item = (usize, Node)>,
) -> Coupling {
    let mut pairs = Vec::new();
    for (j, field) in fields {
        for input in graph.inputs(field, Kinds::ALL) {
            if let Input::Coordinate(i) | Input::Momentum(i) | Input::Velocity(i) = input {
                pairs.push((i as usize, j));
            }
        }
    }
    let fits = |coupling: &Coupling| pairs.iter().all(|&(i, j)| coupling.joins(n, i, j));
    [Coupling::Chain, Coupling::Ring].into_iter().find(fits).unwrap_or(Coupling::Dense)
}

/// Whether the node is homogeneous of degree 1.
pub(super) fn linear(graph: &Graph, node: Node, kinds: Kinds) -> bool {
    graph.is_zero(node) || graph.degrees(node, kinds).is_some_and(|degrees| degrees.are(1))
}
