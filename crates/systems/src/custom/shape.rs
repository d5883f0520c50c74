//! The part of a described system that does not depend on parameters: its programs and its
//! structure.

use super::breaks::{Breaks, of_time_and_state};
use super::description::Reading;
use super::failure::{CustomError, Place};
use super::members::{Members, along};
use super::passive;
use super::polynomial::Polynomial;
use super::programs::{Builder, Part, closed, crowded};
use super::ridges::{Links, Wanted};
use super::second_derivatives::SecondDerivatives;
use super::structure::Structure;
use afterbay_core::Block;
use afterbay_expression::{Graph, Input, Kinds, Node, Program, Ridge};
use std::ops::Range;

/// The divided difference of V along q_j and its derivative by the end of the edge.
#[derive(Debug)]
pub(super) enum DividedDifference {
    /// V is a polynomial along q_j.
    Polynomial(Polynomial),
    /// A program from slope arithmetic.
    Program(Part),
}

/// The evaluation of V and its derivatives.
#[derive(Debug)]
pub(super) enum Potential {
    /// V is a sum of ridge polynomials: all that depend on a coordinate in `along`, each one once
    /// in `once`.
    Ridges { along: Links, once: Links },
    /// Any other V: programs for V, ∇V, each ∂V/∂q_j with q_j moved to the end of an edge, each
    /// divided difference, and the part of V that depends on q_j if it may be singular.
    Programs {
        value: Part,
        gradient: Vec<Part>,
        partials: Vec<Part>,
        edges: Vec<DividedDifference>,
        singular: Vec<Option<Part>>,
    },
}

/// The evaluation of D.
#[derive(Debug)]
pub(super) enum DissipationKernel {
    /// D_j = γ_j p_j, with γ_j made of parameters.
    Constant(Vec<Node>),
    /// D_j = γ_j p_j, γ_j(q) a sum of ridge polynomials.
    Linear(Links),
    /// Any other D: D_j with its derivatives by q_j and p_j, and D as a function of (q, p, v).
    General { local_dissipations: Vec<Part>, forces: Vec<Part> },
}

#[derive(Debug)]
pub(super) struct Shape {
    pub(super) dof: usize,
    /// Whether the last coordinate is the time.
    pub(super) has_clock: bool,
    pub(super) graph: Graph,
    pub(super) parameters: Vec<String>,
    pub(super) places: Vec<(Place, Node, Range<usize>)>,
    pub(super) masses: Vec<Node>,
    /// The nodes that depend on parameters alone, in order of evaluation.
    pub(super) closed: Vec<Node>,
    /// The frames of all programs and the numbers of all polynomials.
    pub(super) frames: Vec<Node>,
    pub(super) potential: Potential,
    /// Whether V or D may be singular, by their form.
    pub(super) may_be_singular: bool,
    /// The parts of D that can be singular and depend on coordinates alone.
    pub(super) singular_dissipations: Vec<Part>,
    pub(super) dissipation_kernel: DissipationKernel,
    /// D_j as functions of (q, p, v), empty if D = 0.
    pub(super) dissipations: Vec<Node>,
    /// The entries of R by row and column, if D = R v and they depend on parameters alone.
    pub(super) matrix: Option<Vec<(usize, usize, Node)>>,
    /// V, and D_j as functions of (q, p, v).
    pub(super) fields: Vec<Node>,
    /// The second derivatives, except those by two momenta, and their blocks, rows and columns.
    pub(super) curvature: Vec<Part>,
    pub(super) entries: Vec<(Block, usize, usize)>,
    /// The functions at whose zeros ∂V/∂q_j or D_j may not be analytic.
    /// First those that depend on the time alone, if it is a coordinate, then the others.
    pub(super) kinks: [Vec<Part>; 2],
    /// The instants that the first of these give.
    pub(super) breaks: Option<Breaks>,
    pub(super) structure: Structure,
    /// The laws of its members, if it is a chain or a ring of equal ones.
    pub(super) members: Option<Box<Members>>,
}

impl Shape {
    pub(super) fn new(mut reading: Reading) -> Result<Self, CustomError> {
        let members = if reading.has_clock { None } else { Members::new(&mut reading)? };
        let Reading { graph, potential, masses, forces, dissipations, has_clock, .. } = reading;
        let dof = masses.len();
        let mut builder = Builder::new(graph);
        let coordinate = |j: usize| Input::Coordinate(j as u32);
        let every: Vec<Input> = (0..dof).map(coordinate).collect();
        let slopes = builder.graph.gradient(potential, Kinds::COORDINATES, &every);

        let (second, local_dissipations) = second_derivatives(&mut builder, &slopes, &forces)?;
        let kinks = builder.graph.kinks(&[&slopes[..], &forces].concat());
        let structure = Structure::new(
            &builder.graph,
            potential,
            &slopes,
            &forces,
            second.nodes.iter().copied(),
            kinks.is_empty(),
        );
        let members = members.filter(|members| members.coupling() == structure.coupling);
        let clock = has_clock.then(|| coordinate(dof - 1));
        let breaks = clock.map(|clock| Breaks::new(&mut builder, &kinks, clock)).transpose()?;
        let [of_time, of_state] = match clock {
            Some(clock) => of_time_and_state(&builder.graph, &kinks, clock),
            None => [Vec::new(), kinks],
        };
        let kinks = [builder.many(&of_time)?, builder.many(&of_state)?];
        let dissipation_kernel =
            builder.dissipation_kernel(&structure, &local_dissipations, &dissipations)?;
        let matrix = passive::matrix(&mut builder.graph, &dissipations);
        let fields = std::iter::once(potential).chain(dissipations.iter().copied()).collect();
        let potential = builder.potential(potential, &slopes)?;
        let curvature = builder.many(&second.nodes)?;
        let singular_dissipations = builder.singular(&dissipations)?;

        let Builder { graph, frames, .. } = builder;
        let evaluated = frames.iter().chain(&masses).chain(dissipation_kernel.constants()).copied();
        let evaluated = evaluated.chain(matrix.iter().flatten().map(|x| x.2)).collect();
        let closed = closed(&graph, evaluated, &dissipations, &reading.places);
        Ok(Self {
            dof,
            has_clock,
            graph,
            parameters: reading.parameters,
            places: reading.places,
            masses,
            closed,
            frames,
            may_be_singular: potential.may_be_singular() || !singular_dissipations.is_empty(),
            potential,
            singular_dissipations,
            dissipation_kernel,
            dissipations,
            matrix,
            fields,
            curvature,
            entries: second.entries,
            kinks,
            breaks,
            structure,
            members,
        })
    }
}

impl Potential {
    /// Whether V may be singular, by its form.
    fn may_be_singular(&self) -> bool {
        match self {
            Self::Programs { singular, .. } => singular.iter().any(Option::is_some),
            Self::Ridges { .. } => false,
        }
    }
}

impl DissipationKernel {
    /// γ_j, if they are made of parameters.
    fn constants(&self) -> &[Node] {
        match self {
            Self::Constant(gammas) => gammas,
            Self::Linear(_) | Self::General { .. } => &[],
        }
    }
}

/// The second derivatives, and each D_j with its derivatives by q_j and p_j.
fn second_derivatives(
    builder: &mut Builder,
    slopes: &[Node],
    forces: &[Node],
) -> Result<(SecondDerivatives, Vec<[Node; 3]>), CustomError> {
    let mut second = SecondDerivatives::default();
    for (i, &slope) in slopes.iter().enumerate() {
        second.add_row(builder, (Block::Hqq, i), slope)?;
    }
    let mut local_dissipations = Vec::new();
    for (i, &force) in forces.iter().enumerate() {
        let by_q = second.add_row(builder, (Block::Dq, i), force)?;
        let by_p = second.add_row(builder, (Block::Dp, i), force)?;
        local_dissipations.push([force, by_q, by_p]);
    }
    Ok((second, local_dissipations))
}

impl Builder {
    fn moving(&mut self, j: usize, results: &[Node]) -> Result<Part, CustomError> {
        let program = Program::new(&self.graph, results).map_err(crowded)?.moving(j as u32);
        let part = self.part(program);
        self.fits(0)?;
        Ok(part)
    }

    /// The fastest evaluation that the form of V allows.
    fn potential(&mut self, potential: Node, slopes: &[Node]) -> Result<Potential, CustomError> {
        if let Some(ridges) = self.graph.ridges(potential) {
            let [mut along, mut once] = [0; 2].map(|_| vec![Vec::new(); slopes.len()]);
            for ridge in &ridges {
                let coordinates = ridge.base.form.weights().map(|(j, _)| j as usize);
                once[coordinates.clone().next().unwrap_or(0)].push(ridge);
                coordinates.for_each(|j| along[j].push(ridge));
            }
            let links = [self.links(&along, Wanted::Slopes)?, self.links(&once, Wanted::Values)?];
            if let [Some(along), Some(once)] = links {
                return Ok(Potential::Ridges { along, once });
            }
        }
        let summands = self.graph.summands(potential);
        let (edges, singular) = self.edges(slopes.len(), &summands)?;
        let partials = slopes.iter().enumerate().map(|(j, &slope)| self.moving(j, &[slope]));
        let partials = partials.collect::<Result<_, _>>()?;
        let gradient = self.many(slopes)?;
        let value = self.one(&[potential])?;
        Ok(Potential::Programs { value, gradient, partials, edges, singular })
    }

    /// γ_j, if each is a sum of ridge polynomials of q_j and another coordinate.
    fn rates(&mut self, local_dissipations: &[[Node; 3]]) -> Result<Option<Links>, CustomError> {
        let rates =
            local_dissipations.iter().map(|x| self.graph.ridges(x[2])).collect::<Option<Vec<_>>>();
        let Some(rates) = rates else { return Ok(None) };
        let along: Vec<Vec<&Ridge>> = rates.iter().map(|ridges| ridges.iter().collect()).collect();
        self.links(&along, Wanted::Values)
    }

    fn links(
        &mut self,
        along: &[Vec<&Ridge>],
        wanted: Wanted,
    ) -> Result<Option<Links>, CustomError> {
        let before = self.frames.len();
        let links = Links::new(&mut self.graph, &mut self.frames, along, wanted);
        if links.is_none() {
            self.frames.truncate(before);
        }
        self.instructions += self.frames.len() - before;
        self.fits(0)?;
        Ok(links)
    }

    fn dissipation_kernel(
        &mut self,
        structure: &Structure,
        local_dissipations: &[[Node; 3]],
        dissipations: &[Node],
    ) -> Result<DissipationKernel, CustomError> {
        let constant = local_dissipations.iter().all(|x| self.graph.closed(x[2]));
        if structure.linear_dissipation && !structure.coupled_dissipation && constant {
            return Ok(DissipationKernel::Constant(
                local_dissipations.iter().map(|x| x[2]).collect(),
            ));
        }
        if structure.linear_dissipation
            && !structure.coupled_dissipation
            && let Some(links) = self.rates(local_dissipations)?
        {
            return Ok(DissipationKernel::Linear(links));
        }
        let local_dissipations =
            local_dissipations.iter().map(|results| self.one(results)).collect::<Result<_, _>>()?;
        Ok(DissipationKernel::General { local_dissipations, forces: self.many(dissipations)? })
    }

    /// The divided difference along each coordinate, of the part of V that depends on it.
    fn edges(&mut self, dof: usize, summands: &[Node]) -> Result<DividedDifferences, CustomError> {
        let (mut edges, mut singular) = (Vec::with_capacity(dof), Vec::with_capacity(dof));
        for (j, summands) in (0..).zip(along(&self.graph, dof, summands)) {
            let zero = self.graph.number(0.0);
            let part = summands.into_iter().fold(zero, |sum, summand| self.graph.sum(sum, summand));
            edges.push(self.divided_difference(part, j)?);
            let doubtful = self.graph.may_be_singular(part);
            singular.push(if doubtful { Some(self.moving(j as usize, &[part])?) } else { None });
        }
        Ok((edges, singular))
    }

    fn divided_difference(&mut self, part: Node, j: u32) -> Result<DividedDifference, CustomError> {
        if let Some(monomials) = self.graph.monomials(part)
            && let Some(edge) = Polynomial::new(&mut self.graph, &mut self.frames, &monomials, j)
        {
            return Ok(DividedDifference::Polynomial(edge));
        }
        let mean = self.graph.divided_difference(part, Input::Coordinate(j));
        let slope = self.graph.gradient(mean, Kinds::END, &[Input::End]);
        let results: Vec<Node> = std::iter::once(mean).chain(slope).collect();
        Ok(DividedDifference::Program(self.one(&results)?))
    }
}

/// Divided differences along each coordinate, and programs for the parts that may be singular.
type DividedDifferences = (Vec<DividedDifference>, Vec<Option<Part>>);
