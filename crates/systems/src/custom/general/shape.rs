//! The part of a system with any H(q, p) that does not depend on parameters: its programs.

use super::super::description::GeneralReading;
use super::super::failure::{CustomError, Place};
use super::super::passive;
use super::super::programs::{Builder, Part, closed, crowded};
use super::super::second_derivatives::SecondDerivatives;
use super::super::structure::coupling;
use afterbay_core::{Block, Coupling};
use afterbay_expression::{Graph, Input, Kinds, Node, Program};
use std::ops::Range;

/// The programs in the plane of one degree of freedom. They read q_j and p_j from
/// [`afterbay_expression::Point::own`].
#[derive(Debug)]
pub(super) struct Plane {
    /// ∂H/∂q_j, ∂H/∂p_j, ∂²H/∂q_j², ∂²H/∂q_j∂p_j, ∂²H/∂p_j²
    pub(super) slopes: Part,
    /// The divided difference along q_j and its derivatives by the end of the edge and by p_j.
    pub(super) along_q: Part,
    /// The divided difference along p_j and its derivatives by the end of the edge and by q_j.
    pub(super) along_p: Part,
    /// D_j and its derivatives by q_j, p_j and v_j, where v_j is read as the end of an edge.
    pub(super) dissipation: Option<Part>,
}

#[derive(Debug)]
pub(super) struct Shape {
    pub(super) dof: usize,
    pub(super) graph: Graph,
    pub(super) parameters: Vec<String>,
    pub(super) places: Vec<(Place, Node, Range<usize>)>,
    /// The nodes that depend on parameters alone, in order of evaluation.
    pub(super) closed: Vec<Node>,
    /// The frames of all programs.
    pub(super) frames: Vec<Node>,
    /// H
    pub(super) energy: Part,
    /// ∂H/∂q_j and, N further on, ∂H/∂p_j.
    pub(super) gradient: Vec<Part>,
    pub(super) planes: Vec<Plane>,
    /// D_j as functions of (q, p, v), and the same compiled; empty if D = 0.
    pub(super) dissipations: Vec<Node>,
    pub(super) forces: Vec<Part>,
    /// R, if D = R v with R made of parameters.
    pub(super) matrix: Option<Vec<(usize, usize, Node)>>,
    /// H, and D_j as functions of (q, p, v).
    pub(super) fields: Vec<Node>,
    /// The second derivatives of H and the derivatives of D along the flow of v = ∂H/∂p, and their
    /// blocks, rows and columns.
    pub(super) curvature: Vec<Part>,
    pub(super) entries: Vec<(Block, usize, usize)>,
    /// The functions at whose zeros ∇H or D may not be analytic.
    pub(super) kinks: Vec<Part>,
    pub(super) coupling: Coupling,
    /// A D_j depends on another velocity than v_j.
    pub(super) coupled_dissipation: bool,
    /// All second derivatives are constant.
    pub(super) linear: bool,
    /// The parts of H and of D that can be singular and depend on coordinates alone.
    pub(super) singular: Vec<Part>,
}

impl Shape {
    pub(super) fn new(reading: GeneralReading) -> Result<Self, CustomError> {
        let GeneralReading { graph, parameters, hamiltonian, dof, dissipations, places } = reading;
        let mut builder = Builder::new(graph);
        let inputs = |of: fn(u32) -> Input| (0..dof as u32).map(of).collect::<Vec<_>>();
        let mut slopes = |kinds, by: &[Input]| builder.graph.gradient(hamiltonian, kinds, by);
        let hq = slopes(Kinds::COORDINATES, &inputs(Input::Coordinate));
        let hp = slopes(Kinds::MOMENTA, &inputs(Input::Momentum));
        let forces = along_flow(&mut builder.graph, &dissipations, &hp);
        let second = second_derivatives(&mut builder, [&hq, &hp, &forces])?;

        let fields = [&hq[..], &hp, &forces];
        let numbered = fields.into_iter().flat_map(|field| field.iter().copied().enumerate());
        let coupling = coupling(&builder.graph, dof, numbered);
        let coupled_dissipation = couples_velocities(&builder.graph, &dissipations);
        let kinks = builder.graph.kinks(&fields.concat());
        let linear = kinks.is_empty() && second.nodes.iter().all(|&x| builder.graph.closed(x));

        let kinks = builder.many(&kinks)?;
        let fields: Vec<Node> =
            std::iter::once(hamiltonian).chain(dissipations.iter().copied()).collect();
        let singular = builder.singular(&fields)?;
        let parts = builder.parts(hamiltonian, dof);
        let planes = (0..dof)
            .map(|j| builder.plane(j, parts[j], [hq[j], hp[j]], dissipations.get(j).copied()))
            .collect::<Result<_, _>>()?;
        let energy = builder.one(&[hamiltonian])?;
        let gradient = builder.many(&[hq, hp].concat())?;
        let forces = builder.many(&dissipations)?;
        let matrix = passive::matrix(&mut builder.graph, &dissipations);
        let curvature = builder.many(&second.nodes)?;

        let Builder { graph, frames, .. } = builder;
        let evaluated = frames.iter().copied().chain(matrix.iter().flatten().map(|x| x.2));
        let closed = closed(&graph, evaluated.collect(), &fields, &places);
        Ok(Self {
            dof,
            graph,
            parameters,
            places,
            closed,
            frames,
            energy,
            gradient,
            planes,
            dissipations,
            forces,
            matrix,
            fields,
            curvature,
            entries: second.entries,
            kinks,
            coupling,
            coupled_dissipation,
            linear,
            singular,
        })
    }
}

/// D along the flow, where v = ∂H/∂p.
fn along_flow(graph: &mut Graph, dissipations: &[Node], hp: &[Node]) -> Vec<Node> {
    let along = |&d: &Node| {
        graph.substitute(d, Kinds::VELOCITIES, |graph, input| match input {
            Input::Velocity(k) => hp[k as usize],
            _ => graph.input(input),
        })
    };
    dissipations.iter().map(along).collect()
}

/// The second derivatives of H and the derivatives of D along the flow.
fn second_derivatives(
    builder: &mut Builder,
    [hq, hp, forces]: [&[Node]; 3],
) -> Result<SecondDerivatives, CustomError> {
    let mut second = SecondDerivatives::default();
    for (fields, blocks) in [
        (hq, &[Block::Hqq, Block::Hqp][..]),
        (hp, &[Block::Hpp]),
        (forces, &[Block::Dq, Block::Dp]),
    ] {
        for (i, &field) in fields.iter().enumerate() {
            for &block in blocks {
                second.add_row(builder, (block, i), field)?;
            }
        }
    }
    Ok(second)
}

/// Whether a D_j depends on another velocity than v_j.
fn couples_velocities(graph: &Graph, dissipations: &[Node]) -> bool {
    dissipations.iter().enumerate().any(|(j, &d)| {
        let mut by = graph.inputs(d, Kinds::VELOCITIES).into_iter();
        by.any(|input| input != Input::Velocity(j as u32))
    })
}

impl Builder {
    /// The terms of H with q_j or p_j, for each j. The others cancel in its differences.
    fn parts(&mut self, hamiltonian: Node, dof: usize) -> Vec<Node> {
        let mut parts = vec![self.graph.number(0.0); dof];
        for summand in self.graph.summands(hamiltonian) {
            let mut degrees: Vec<u32> = self
                .graph
                .inputs(summand, Kinds::ALL)
                .into_iter()
                .filter_map(|input| match input {
                    Input::Coordinate(j) | Input::Momentum(j) => Some(j),
                    _ => None,
                })
                .collect();
            degrees.sort_unstable();
            degrees.dedup();
            for j in degrees {
                parts[j as usize] = self.graph.sum(parts[j as usize], summand);
            }
        }
        parts
    }

    /// The programs in the plane of q_j and p_j.
    fn plane(
        &mut self,
        j: usize,
        part: Node,
        [hq, hp]: [Node; 2],
        dissipation: Option<Node>,
    ) -> Result<Plane, CustomError> {
        const Q: Kinds = Kinds::COORDINATES;
        const P: Kinds = Kinds::MOMENTA;
        let j = j as u32;
        let (q, p, v) = (Input::Coordinate(j), Input::Momentum(j), Input::Velocity(j));
        let [hqq, hqp, hpp] =
            [(hq, Q, q), (hq, P, p), (hp, P, p)].map(|(of, kinds, by)| self.by(of, kinds, by));
        let slopes = self.in_plane(j, &[hq, hp, hqq, hqp, hpp])?;
        let [along_q, along_p] = [(q, P, p), (p, Q, q)].map(|(along, kinds, other)| {
            let mean = self.graph.divided_difference(part, along);
            let by_end = self.by(mean, Kinds::END, Input::End);
            let by_other = self.by(mean, kinds, other);
            self.in_plane(j, &[mean, by_end, by_other])
        });
        let dissipation = dissipation.map(|d| {
            let [by_q, by_p, by_v] =
                [(Q, q), (P, p), (Kinds::VELOCITIES, v)].map(|(kinds, by)| self.by(d, kinds, by));
            self.in_plane(j, &[d, by_q, by_p, by_v])
        });
        Ok(Plane {
            slopes,
            along_q: along_q?,
            along_p: along_p?,
            dissipation: dissipation.transpose()?,
        })
    }

    /// The derivative of a node by one input.
    fn by(&mut self, of: Node, kinds: Kinds, by: Input) -> Node {
        self.graph.gradient(of, kinds, &[by])[0]
    }

    fn in_plane(&mut self, j: u32, results: &[Node]) -> Result<Part, CustomError> {
        let program = Program::new(&self.graph, results).map_err(crowded)?.in_plane(j);
        let part = self.part(program);
        self.fits(0)?;
        Ok(part)
    }
}
