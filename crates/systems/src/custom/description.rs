//! The description of a system and how it is parsed.

mod drive;
mod function;

pub use drive::DriveDescription;
pub use function::FunctionDescription;

use super::failure::{CustomError, Place};
use afterbay_expression::{
    Definition, Graph, Input, Kinds, MOST_DEGREES, Names, Node, ParseError, Parsed, Problem,
    is_name, is_reserved, parse,
};
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
    /// As in a [`Description`].
    pub parameters: Vec<(String, f64)>,
    /// As in a [`Description`].
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

/// Checks the length of a list.
fn counted(list: &'static str, expected: usize, found: usize) -> Result<(), CustomError> {
    if found == expected { Ok(()) } else { Err(CustomError::Count { list, expected, found }) }
}

/// The names of the parameters, if they and those of the definitions are allowed.
fn names(
    parameters: &[(String, f64)],
    definitions: &[(String, String)],
) -> Result<Vec<String>, CustomError> {
    let mut names: Vec<String> = Vec::new();
    let values = parameters.iter().map(|(name, value)| (name, *value));
    for (name, value) in values.chain(definitions.iter().map(|(name, _)| (name, 0.0))) {
        let why = match name {
            _ if !is_name(name) => {
                "a name is made of letters, digits and underscores, the first no digit"
            }
            _ if is_reserved(name) => "the name means something else",
            _ if names.contains(name) => "the name is taken",
            _ if !value.is_finite() => {
                return Err(CustomError::Value { name: name.clone(), value });
            }
            _ => {
                names.push(name.clone());
                continue;
            }
        };
        return Err(CustomError::Name { name: name.clone(), why });
    }
    names.truncate(parameters.len());
    Ok(names)
}

/// What an expression may mention.
#[derive(Clone, Copy)]
struct Rules {
    /// The largest index of a coordinate or momentum, if it is known.
    dof: Option<usize>,
    coordinates: Result<(), &'static str>,
    momenta: Result<(), &'static str>,
    velocities: Result<(), &'static str>,
    time: Result<(), &'static str>,
}

impl Rules {
    const ALL: Self =
        Self { dof: None, coordinates: Ok(()), momenta: Ok(()), velocities: Ok(()), time: Ok(()) };

    /// Numbers and parameters, by this rule.
    fn only_parameters(rule: Result<(), &'static str>) -> Self {
        Self { dof: None, coordinates: rule, momenta: rule, velocities: rule, time: rule }
    }
}

struct Reader {
    graph: Graph,
    names: Vec<String>,
    used: Vec<bool>,
    definitions: Vec<Definition>,
    /// Whether each of the definitions is used.
    defined: Vec<bool>,
    places: Vec<(Place, Node, Range<usize>)>,
    /// The value of `n`.
    count: Option<usize>,
}

impl Reader {
    /// A reader that knows the parameters and the definitions, and the value of `n`.
    fn new(
        parameters: &[(String, f64)],
        definitions: &[(String, String)],
        count: Option<usize>,
    ) -> Result<Self, CustomError> {
        let names = names(parameters, definitions)?;
        let mut reader = Self {
            graph: Graph::default(),
            used: vec![false; names.len()],
            names,
            definitions: Vec::new(),
            defined: vec![false; definitions.len()],
            places: Vec::new(),
            count,
        };
        reader.define(definitions)?;
        Ok(reader)
    }

    /// Reads V or H and determines N: the number that is declared, else the one given where `n` is
    /// used, else the largest index in the expression.
    fn energy(
        &mut self,
        place: Place,
        text: &str,
        rules: Rules,
        [declared, given]: [Option<usize>; 2],
    ) -> Result<(Node, usize), CustomError> {
        if let Some(count) = declared.filter(|&n| n > MOST_DEGREES) {
            let what = "degrees of freedom";
            return Err(CustomError::TooLarge { what, count, limit: MOST_DEGREES });
        }
        let (node, found) = self.read(place, text, Rules { dof: declared, ..rules })?;
        let dof = declared.or(given.filter(|_| found.counted)).unwrap_or(found.dof);
        if found.dof > dof {
            let problem = Problem::BeyondLast { name: format!("q{}", found.dof), dof };
            return Err(CustomError::Expression { place, span: 0..text.len(), problem });
        }
        if dof == 0 { Err(CustomError::Empty) } else { Ok((node, dof)) }
    }

    /// D_j as written: functions of (q, p, v), and of t if `time` allows it.
    fn dissipation(
        &mut self,
        text: &DissipationText,
        dof: usize,
        time: Result<(), &'static str>,
    ) -> Result<Vec<Node>, CustomError> {
        let all = Rules { dof: Some(dof), time, ..Rules::ALL };
        match text {
            DissipationText::None => Ok(Vec::new()),
            DissipationText::Forces(texts) => {
                counted("dissipation", dof, texts.len())?;
                let texts = texts.iter().enumerate();
                texts.map(|(j, text)| Ok(self.read(Place::Dissipation(j), text, all)?.0)).collect()
            }
            DissipationText::Matrix(rows) => {
                counted("friction matrix", dof, rows.len())?;
                let mut dissipations = Vec::with_capacity(dof);
                for (i, row) in rows.iter().enumerate() {
                    counted("row of the friction matrix", dof, row.len())?;
                    let mut dissipation = self.graph.number(0.0);
                    for (k, text) in row.iter().enumerate() {
                        let r = self.read(Place::Friction(i, k), text, all)?.0;
                        let v = self.graph.input(Input::Velocity(k as u32));
                        let part = self.graph.product(r, v);
                        dissipation = self.graph.sum(dissipation, part);
                    }
                    dissipations.push(dissipation);
                }
                Ok(dissipations)
            }
        }
    }

    /// Checks that every parameter and definition is used.
    fn finish(self) -> Result<Self, CustomError> {
        let unused = self.used.iter().position(|used| !used);
        let undefined = self.defined.iter().position(|used| !used);
        let name = unused.map(|k| &self.names[k]);
        match name.or(undefined.map(|k| &self.definitions[k].name)) {
            Some(name) => Err(CustomError::Unused { name: name.clone() }),
            None => Ok(self),
        }
    }

    /// Parses the definitions, each after those that it mentions.
    fn define(&mut self, texts: &[(String, String)]) -> Result<(), CustomError> {
        let rule = Err("a parameter is made of numbers and other parameters");
        let rules = Rules::only_parameters(rule);
        let mut waiting: Vec<usize> = (0..texts.len()).collect();
        while !waiting.is_empty() {
            let before = waiting.len();
            let mut later = Vec::new();
            for k in waiting {
                let (name, text) = &texts[k];
                match self.parse(Place::Definition(k), text, rules) {
                    Ok(parsed) => {
                        for (used, also) in self.defined.iter_mut().zip(&parsed.defined) {
                            *used |= also;
                        }
                        let Parsed { node, used, counted, .. } = parsed;
                        self.definitions.push(Definition {
                            name: name.clone(),
                            node,
                            used,
                            counted,
                        });
                    }
                    Err(CustomError::Expression {
                        problem: Problem::Unknown { name, .. }, ..
                    }) if texts.iter().any(|known| known.0 == name) => {
                        later.push(k);
                    }
                    Err(error) => return Err(error),
                }
            }
            if later.len() == before {
                let name = texts[later[0]].0.clone();
                let why = "it is defined by itself, or by others that are defined by it";
                return Err(CustomError::Name { name, why });
            }
            waiting = later;
        }
        Ok(())
    }

    /// Parses an expression of the system and notes what it uses.
    fn read(
        &mut self,
        place: Place,
        text: &str,
        rules: Rules,
    ) -> Result<(Node, Found), CustomError> {
        let parsed = self.parse(place, text, rules)?;
        self.used.iter_mut().zip(&parsed.used).for_each(|(used, &also)| *used |= also);
        self.defined.iter_mut().zip(&parsed.defined).for_each(|(used, &also)| *used |= also);
        self.places.extend(parsed.places.into_iter().map(|(node, span)| (place, node, span)));
        Ok((parsed.node, Found { dof: parsed.dof, counted: parsed.counted }))
    }

    fn parse(&mut self, place: Place, text: &str, rules: Rules) -> Result<Parsed, CustomError> {
        let names = Names {
            definitions: &self.definitions,
            dof: rules.dof,
            count: self.count,
            index: place.degree().map(|j| j + 1),
            coordinates: rules.coordinates,
            momenta: rules.momenta,
            velocities: rules.velocities,
            time: rules.time,
            ..Names::of(&self.names)
        };
        parse(&mut self.graph, &names, text).map_err(|ParseError { span, problem }| {
            CustomError::Expression { place, span, problem }
        })
    }
}

/// What an expression mentions.
struct Found {
    /// The largest index of a coordinate or momentum, counted from 1; 0 if there is none.
    dof: usize,
    /// Whether it depends on the number of degrees of freedom.
    counted: bool,
}
