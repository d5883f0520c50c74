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
        let (mut pairs, mut coupled_dissipation) = (Vec::new(), false);
        for (fields, momenta) in [(slopes, false), (forces, true)] {
            for (j, &field) in fields.iter().enumerate() {
                for input in graph.inputs(field, Kinds::ALL) {
                    if let Input::Coordinate(i) | Input::Momentum(i) = input {
                        pairs.push((i as usize, j));
                        coupled_dissipation |=
                            momenta && matches!(input, Input::Momentum(_)) && i as usize != j;
                    }
                }
            }
        }
        let fits = |coupling: &Coupling| pairs.iter().all(|&(i, j)| coupling.joins(n, i, j));
        let coupling =
            [Coupling::Chain, Coupling::Ring].into_iter().find(fits).unwrap_or(Coupling::Dense);
        Self {
            degree,
            degrees: slopes.iter().enumerate().map(along).collect(),
            linear: smooth && second.into_iter().all(|node| graph.closed(node)),
            coupling,
            linear_dissipation,
            coupled_dissipation,
        }
    }
}

/// Whether the node is homogeneous of degree 1.
pub(super) fn linear(graph: &Graph, node: Node, kinds: Kinds) -> bool {
    graph.is_zero(node) || graph.degrees(node, kinds).is_some_and(|degrees| degrees.are(1))
}
