//! Chains and rings of equal members, as the form of the expressions shows them.
//!
//! The law of a member consists of its mass, the summands of V with its coordinate, and its D_j.
//! Laws are compared with the coordinates q_{j-1}, q_j and q_{j+1} renamed to q1, q2 and q3. The
//! ends of a chain have laws of their own: a free end has one neighbour, a fixed one its wall.

use super::description::Reading;
use super::failure::CustomError;
use super::shape::Shape;
use afterbay_core::Coupling;
use afterbay_expression::{Graph, Input, Kinds, Node};
use std::sync::Arc;

/// The least number of members. With fewer, eight at a time are not faster than one at a time.
/// Measured by the bench `custom`.
const FEWEST: usize = 16;

/// The laws of a chain or a ring of equal members, each as that of the middle of three.
#[derive(Debug)]
pub(super) struct Members {
    /// The law of every member, except the ends of a chain.
    pub(super) inner: Arc<Shape>,
    /// The laws of the first and of the last member of a chain; none for a ring.
    pub(super) ends: Option<[Arc<Shape>; 2]>,
}

impl Members {
    /// The laws, if the system is a chain or a ring whose members have the same one.
    ///
    /// # Errors
    /// [`CustomError::TooLarge`]
    pub(super) fn new(reading: &mut Reading) -> Result<Option<Box<Self>>, CustomError> {
        let n = reading.masses.len();
        if n < FEWEST {
            return Ok(None);
        }
        let summands = reading.graph.summands(reading.potential);
        let along = along(&reading.graph, n, &summands);
        let laws = Laws { reading, along };
        let Some(ring) = laws.is_ring() else { return Ok(None) };
        let mut graph = Graph::default();
        let inner = laws.comparable(&mut graph, 1);
        let equal = if ring { 0..n } else { 1..n - 1 };
        if equal.into_iter().any(|j| laws.comparable(&mut graph, j) != inner) {
            return Ok(None);
        }
        let inner = laws.shape(1)?;
        let ends = if ring { None } else { Some([laws.shape(0)?, laws.shape(n - 1)?]) };
        Ok(Some(Box::new(Self { inner, ends })))
    }

    /// The pattern of neighbours.
    pub(super) fn coupling(&self) -> Coupling {
        if self.ends.is_some() { Coupling::Chain } else { Coupling::Ring }
    }
}

/// The members of a system.
struct Laws<'a> {
    reading: &'a Reading,
    /// The summands of V that depend on q_j, for every j.
    along: Vec<Vec<Node>>,
}

/// The law of a member.
#[derive(PartialEq)]
struct Law {
    summands: Vec<Node>,
    mass: Node,
    /// D_j of (q, p), and of (q, p, v); none if D = 0.
    dissipation: Option<[Node; 2]>,
}

impl Laws<'_> {
    fn of(&self, j: usize) -> Law {
        let Reading { masses, forces, dissipations, .. } = self.reading;
        let dissipation = forces.get(j).zip(dissipations.get(j)).map(|(&of_p, &of_v)| [of_p, of_v]);
        Law { summands: self.along[j].clone(), mass: masses[j], dissipation }
    }

    /// Whether the first member depends on the last or the last on the first. None if a member
    /// depends on one that is no neighbour.
    fn is_ring(&self) -> Option<bool> {
        let n = self.along.len();
        let mut ring = false;
        for j in 0..n {
            let Law { summands, dissipation, .. } = self.of(j);
            for &node in summands.iter().chain(dissipation.iter().flatten()) {
                for input in self.reading.graph.inputs(node, Kinds::ALL) {
                    let (Input::Coordinate(i) | Input::Momentum(i) | Input::Velocity(i)) = input
                    else {
                        return None;
                    };
                    match j.abs_diff(i as usize) {
                        0 | 1 => {}
                        apart if apart + 1 == n => ring = true,
                        _ => return None,
                    }
                }
            }
        }
        Some(ring)
    }

    /// The law of member j in another graph, with q_{j-1}, q_j and q_{j+1} renamed to q1, q2, q3.
    fn renamed(&self, j: usize, graph: &mut Graph) -> Law {
        let n = self.along.len();
        let place = |i: u32| ((i as usize + n + 1 - j) % n) as u32;
        let rename = |input| match input {
            Input::Coordinate(i) => Input::Coordinate(place(i)),
            Input::Momentum(i) => Input::Momentum(place(i)),
            Input::Velocity(i) => Input::Velocity(place(i)),
            _ => input,
        };
        let mut copy = |node| self.reading.graph.copy(node, graph, rename);
        let Law { summands, mass, dissipation } = self.of(j);
        Law {
            summands: summands.into_iter().map(&mut copy).collect(),
            mass: copy(mass),
            dissipation: dissipation.map(|forces| forces.map(&mut copy)),
        }
    }

    /// The renamed law, with its summands in an order that is the same for equal laws.
    fn comparable(&self, graph: &mut Graph, j: usize) -> Law {
        let mut law = self.renamed(j, graph);
        law.summands.sort_unstable();
        law
    }

    /// Member j as the middle of three, of which the other two have no friction.
    fn shape(&self, j: usize) -> Result<Arc<Shape>, CustomError> {
        let mut graph = Graph::default();
        let Law { summands, mass, dissipation } = self.renamed(j, &mut graph);
        let zero = graph.number(0.0);
        let potential = summands.into_iter().fold(zero, |sum, summand| graph.sum(sum, summand));
        let beside_zero = |force| vec![zero, force, zero];
        let [forces, dissipations] =
            dissipation.map_or([Vec::new(), Vec::new()], |forces| forces.map(beside_zero));
        let reading = Reading {
            graph,
            parameters: self.reading.parameters.clone(),
            potential,
            masses: vec![mass; 3],
            forces,
            dissipations,
            places: Vec::new(),
            has_clock: false,
        };
        Shape::new(reading).map(Arc::new)
    }
}

/// The summands that depend on each coordinate.
pub(super) fn along(graph: &Graph, dof: usize, summands: &[Node]) -> Vec<Vec<Node>> {
    let mut along = vec![Vec::new(); dof];
    for &summand in summands {
        for input in graph.inputs(summand, Kinds::COORDINATES) {
            if let Input::Coordinate(j) = input {
                along[j as usize].push(summand);
            }
        }
    }
    along
}
