//! The description of a system and how it is parsed.

mod drive;
mod function;
mod reader;

pub use drive::DriveDescription;
pub use function::FunctionDescription;

use super::failure::{CustomError, Place};
use afterbay_expression::{Graph, Input, Kinds, Node};
use reader::{Reader, Rules, check_count, counted};
use std::ops::Range;

/// A separable system as texts of expressions. V and D may depend on the time t.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// V(q, t)
    pub potential: String,
    /// D
    pub dissipation: DissipationText,
    /// The masses m_j > 0, made of numbers and parameters. If empty, all are 1.
    pub masses: Vec<String>,
    /// The names and values of parameters. Each must be used.
    pub parameters: Vec<(String, f64)>,
    /// Names of expressions in the parameters and in each other, such as ω₀ = √(k/m). Each must be
    /// used.
    pub definitions: Vec<(String, String)>,
    /// N, where `n` is used and neither masses nor dissipation give it.
    pub dof: Option<usize>,
}

/// A system with any H(q, p), as texts of expressions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeneralDescription {
    /// H(q, p)
    pub hamiltonian: String,
    /// D
    pub dissipation: DissipationText,
    /// The names and values of parameters. Each must be used.
    pub parameters: Vec<(String, f64)>,
    /// Names of expressions; see [`Description::definitions`].
    pub definitions: Vec<(String, String)>,
    /// N, where `n` is used and the dissipation does not give it.
    pub dof: Option<usize>,
}

/// The texts of D. A discrete gradient passes its own mean velocity: v_j = ∂H/∂p_j in them is that
/// velocity, and so is p_j/m_j in the forces of a separable system.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DissipationText {
    /// D = 0
    #[default]
    None,
    /// D_j(q, p, v), one for each degree of freedom.
    Forces(Vec<String>),
    /// D = R(q, p) v: the rows of R.
    Matrix(Vec<Vec<String>>),
}

impl DissipationText {
    /// N, if D gives it.
    fn dof(&self) -> Option<usize> {
        match self {
            Self::None => None,
            Self::Forces(rows) => Some(rows.len()),
            Self::Matrix(rows) => Some(rows.len()),
        }
        .filter(|&n| n > 0)
    }
}

/// The rule for t where H is given as a whole.
const NO_TIME: &str = "H(q, p) does not depend on t: give `potential` and `mass` in its place, or \
                       add the term + p2 to H, which makes q2 the time";

/// A parsed description.
pub(super) struct Reading {
    pub(super) graph: Graph,
    pub(super) parameters: Vec<String>,
    pub(super) potential: Node,
    pub(super) masses: Vec<Node>,
    /// D_j of (q, p), and of (q, p, v).
    pub(super) forces: Vec<Node>,
    pub(super) dissipations: Vec<Node>,
    /// The expression and the bytes of each operation, operands first.
    pub(super) places: Vec<(Place, Node, Range<usize>)>,
    /// Whether the last coordinate is the time.
    pub(super) has_clock: bool,
}

impl Reading {
    /// Makes the time a coordinate behind the others, where V or D depends on it. It has mass 1,
    /// and D is 0 there. In `places` the time stays the end of an edge.
    fn with_clock(mut self) -> Self {
        let timed = |graph: &Graph, x: Node| graph.depends(x, Kinds::END);
        let graph = &mut self.graph;
        if ![&[self.potential], &self.forces[..]].concat().iter().any(|&x| timed(graph, x)) {
            return self;
        }
        let clock = Input::Coordinate(self.masses.len() as u32);
        let texts = self.forces.iter_mut().chain(&mut self.dissipations);
        for node in std::iter::once(&mut self.potential).chain(texts) {
            *node = graph.substitute(*node, Kinds::END, |graph, input| match input {
                Input::End => graph.input(clock),
                input => graph.input(input),
            });
        }
        self.masses.push(graph.number(1.0));
        if !self.forces.is_empty() {
            self.forces.push(graph.number(0.0));
            self.dissipations.push(graph.number(0.0));
        }
        Self { has_clock: true, ..self }
    }
}

/// A parsed description of a system with any H(q, p).
pub(super) struct GeneralReading {
    pub(super) graph: Graph,
    pub(super) parameters: Vec<String>,
    pub(super) hamiltonian: Node,
    pub(super) dof: usize,
    /// D_j of (q, p, v), empty if D = 0.
    pub(super) dissipations: Vec<Node>,
    /// The expression and the bytes of each operation, operands first.
    pub(super) places: Vec<(Place, Node, Range<usize>)>,
}

impl Description {
    pub(super) fn read(&self) -> Result<Reading, CustomError> {
        check_count(&self.parameters, &self.definitions)?;
        let declared = Some(self.masses.len()).filter(|&n| n > 0).or(self.dissipation.dof());
        let mut reader = Reader::new(&self.parameters, &self.definitions, declared.or(self.dof))?;
        let no_momenta = Err("a potential is made of coordinates, t and parameters");
        let rules = Rules { momenta: no_momenta, velocities: no_momenta, ..Rules::ALL };
        let (potential, dof) =
            reader.energy(Place::Potential, &self.potential, rules, [declared, self.dof])?;
        let masses = if self.masses.is_empty() {
            vec![reader.graph.number(1.0); dof]
        } else {
            counted("list of masses", dof, self.masses.len())?;
            let rule = Err("a mass is made of numbers and parameters");
            let rules = Rules { dof: Some(dof), ..Rules::only_parameters(rule) };
            let read =
                |(j, text): (usize, &String)| Ok(reader.read(Place::Mass(j), text, rules)?.0);
            self.masses.iter().enumerate().map(read).collect::<Result<_, CustomError>>()?
        };
        let written = reader.dissipation(&self.dissipation, dof, Ok(()))?;
        let forces: Vec<Node> = written
            .iter()
            .map(|&force| {
                reader.graph.substitute(force, Kinds::VELOCITIES, |graph, input| match input {
                    Input::Velocity(k) => {
                        let p = graph.input(Input::Momentum(k));
                        graph.quotient(p, masses[k as usize])
                    }
                    _ => graph.input(input),
                })
            })
            .collect();
        let dissipations = match &self.dissipation {
            DissipationText::Forces(_) => written
                .iter()
                .map(|&force| {
                    reader.graph.substitute(force, Kinds::MOMENTA, |graph, input| match input {
                        Input::Momentum(k) => {
                            let v = graph.input(Input::Velocity(k));
                            graph.product(masses[k as usize], v)
                        }
                        _ => graph.input(input),
                    })
                })
                .collect(),
            DissipationText::None | DissipationText::Matrix(_) => written,
        };
        let Reader { graph, names: parameters, places, .. } = reader.finish()?;
        let has_clock = false;
        let reading = Reading {
            graph,
            parameters,
            potential,
            masses,
            forces,
            dissipations,
            places,
            has_clock,
        };
        Ok(reading.with_clock())
    }
}

impl GeneralDescription {
    pub(super) fn read(&self) -> Result<GeneralReading, CustomError> {
        check_count(&self.parameters, &self.definitions)?;
        let declared = self.dissipation.dof();
        let mut reader = Reader::new(&self.parameters, &self.definitions, declared.or(self.dof))?;
        let rule = Err("H is made of coordinates, momenta and parameters");
        let no_time = Err(NO_TIME);
        let rules = Rules { velocities: rule, time: no_time, ..Rules::ALL };
        let (hamiltonian, dof) =
            reader.energy(Place::Hamiltonian, &self.hamiltonian, rules, [declared, self.dof])?;
        let dissipations = reader.dissipation(&self.dissipation, dof, no_time)?;
        let Reader { graph, names: parameters, places, .. } = reader.finish()?;
        Ok(GeneralReading { graph, parameters, hamiltonian, dof, dissipations, places })
    }
}
