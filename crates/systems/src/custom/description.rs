//! The description of a system and how it is parsed.

use super::failure::{CustomError, Place};
use afterbay_expression::{
    Definition, Graph, Input, Kinds, MOST_DEGREES, Names, Node, ParseError, Parsed, Problem,
    is_name, is_reserved, parse,
};
use std::ops::Range;

/// A system as texts of expressions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// V(q)
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

/// The texts of D. A p_j in them is m_j v_j, where a discrete gradient passes its own velocity v_j.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DissipationText {
    /// D = 0
    #[default]
    None,
    /// D_j(q, p), one for each degree of freedom.
    Forces(Vec<String>),
    /// D = R(q, p) v with v_j = p_j/m_j: the rows of R.
    Matrix(Vec<Vec<String>>),
}

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
}

impl Description {
    /// N, if a list gives it.
    fn listed(&self) -> Option<usize> {
        let rows = match &self.dissipation {
            DissipationText::None => 0,
            DissipationText::Forces(rows) => rows.len(),
            DissipationText::Matrix(rows) => rows.len(),
        };
        [self.masses.len(), rows].into_iter().find(|&n| n > 0)
    }

    pub(super) fn read(&self) -> Result<Reading, CustomError> {
        let names = self.names()?;
        let mut reader = Reader {
            graph: Graph::default(),
            used: vec![false; names.len()],
            names,
            definitions: Vec::new(),
            defined: vec![false; self.definitions.len()],
            places: Vec::new(),
            count: self.listed().or(self.dof),
        };
        reader.define(&self.definitions)?;
        let declared = self.listed();
        if let Some(count) = declared.filter(|&n| n > MOST_DEGREES) {
            return Err(CustomError::TooLarge {
                what: "degrees of freedom",
                count,
                limit: MOST_DEGREES,
            });
        }
        let no_momenta = Err("a potential is made of coordinates and parameters");
        let rules = Rules { dof: declared, coordinates: Ok(()), momenta: no_momenta };
        let (potential, found) = reader.read(Place::Potential, &self.potential, rules)?;
        let dof = match (declared, self.dof) {
            (None, Some(dof)) if found.counted => dof,
            _ => declared.unwrap_or(found.dof),
        };
        if found.dof > dof {
            let problem = Problem::BeyondLast { name: format!("q{}", found.dof), dof };
            let span = 0..self.potential.len();
            return Err(CustomError::Expression { place: Place::Potential, span, problem });
        }
        let all = Rules { dof: Some(dof), coordinates: Ok(()), momenta: Ok(()) };
        let count = |list, found| {
            if found == dof {
                Ok(())
            } else {
                Err(CustomError::Count { list, expected: dof, found })
            }
        };
        if dof == 0 {
            return Err(CustomError::Empty);
        }
        let mut masses = Vec::with_capacity(dof);
        if self.masses.is_empty() {
            masses.resize(dof, reader.graph.number(1.0));
        } else {
            count("list of masses", self.masses.len())?;
            let rule = Err("a mass is made of numbers and parameters");
            for (j, text) in self.masses.iter().enumerate() {
                let rules = Rules { dof: Some(dof), coordinates: rule, momenta: rule };
                masses.push(reader.read(Place::Mass(j), text, rules)?.0);
            }
        }
        let (mut forces, mut dissipations) = (Vec::new(), Vec::new());
        match &self.dissipation {
            DissipationText::None => {}
            DissipationText::Forces(texts) => {
                count("dissipation", texts.len())?;
                for (j, text) in texts.iter().enumerate() {
                    let force = reader.read(Place::Dissipation(j), text, all)?.0;
                    forces.push(force);
                    dissipations.push(reader.graph.substitute(
                        force,
                        Kinds::MOMENTA,
                        |graph, input| match input {
                            Input::Momentum(k) => {
                                let v = graph.input(Input::Velocity(k));
                                graph.product(masses[k as usize], v)
                            }
                            _ => graph.input(input),
                        },
                    ));
                }
            }
            DissipationText::Matrix(rows) => {
                count("friction matrix", rows.len())?;
                for (i, row) in rows.iter().enumerate() {
                    count("row of the friction matrix", row.len())?;
                    let mut dissipation = reader.graph.number(0.0);
                    for (k, text) in row.iter().enumerate() {
                        let r = reader.read(Place::Friction(i, k), text, all)?.0;
                        let v = reader.graph.input(Input::Velocity(k as u32));
                        let part = reader.graph.product(r, v);
                        dissipation = reader.graph.sum(dissipation, part);
                    }
                    dissipations.push(dissipation);
                    forces.push(reader.graph.substitute(
                        dissipation,
                        Kinds::VELOCITIES,
                        |graph, input| match input {
                            Input::Velocity(k) => {
                                let p = graph.input(Input::Momentum(k));
                                graph.quotient(p, masses[k as usize])
                            }
                            _ => graph.input(input),
                        },
                    ));
                }
            }
        }
        if let Some(unused) = reader.used.iter().position(|used| !used) {
            return Err(CustomError::Unused { name: reader.names[unused].clone() });
        }
        if let Some(unused) = reader.defined.iter().position(|used| !used) {
            return Err(CustomError::Unused { name: reader.definitions[unused].name.clone() });
        }
        let Reader { graph, names: parameters, places, .. } = reader;
        Ok(Reading { graph, parameters, potential, masses, forces, dissipations, places })
    }

    /// The names of the parameters, if they and those of the definitions are allowed.
    fn names(&self) -> Result<Vec<String>, CustomError> {
        let mut names: Vec<String> = Vec::new();
        let values = self.parameters.iter().map(|(name, value)| (name, *value));
        for (name, value) in values.chain(self.definitions.iter().map(|(name, _)| (name, 0.0))) {
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
        names.truncate(self.parameters.len());
        Ok(names)
    }
}

/// What an expression may mention.
#[derive(Clone, Copy)]
struct Rules {
    /// The largest index of a coordinate or momentum, if it is known.
    dof: Option<usize>,
    coordinates: Result<(), &'static str>,
    momenta: Result<(), &'static str>,
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
    /// Parses the definitions, each after those that it mentions.
    fn define(&mut self, texts: &[(String, String)]) -> Result<(), CustomError> {
        let rule = Err("a parameter is made of numbers and other parameters");
        let rules = Rules { dof: None, coordinates: rule, momenta: rule };
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
