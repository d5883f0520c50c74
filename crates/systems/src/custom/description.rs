//! The description of a system and how it is parsed.

use super::failure::{CustomError, Place};
use afterbay_expression::{
    Graph, Input, Kinds, MOST_DEGREES, Names, Node, ParseError, is_name, is_reserved, parse,
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
    fn dof(&self) -> Option<usize> {
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
            places: Vec::new(),
        };
        let declared = self.dof();
        if let Some(count) = declared.filter(|&n| n > MOST_DEGREES) {
            return Err(CustomError::TooLarge {
                what: "degrees of freedom",
                count,
                limit: MOST_DEGREES,
            });
        }
        let no_momenta = Err("a potential is made of coordinates and parameters");
        let (potential, largest) =
            reader.read(Place::Potential, &self.potential, declared, Ok(()), no_momenta)?;
        let dof = declared.unwrap_or(largest);
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
                masses.push(reader.read(Place::Mass(j), text, Some(dof), rule, rule)?.0);
            }
        }
        let (mut forces, mut dissipations) = (Vec::new(), Vec::new());
        match &self.dissipation {
            DissipationText::None => {}
            DissipationText::Forces(texts) => {
                count("dissipation", texts.len())?;
                for (j, text) in texts.iter().enumerate() {
                    let force =
                        reader.read(Place::Dissipation(j), text, Some(dof), Ok(()), Ok(()))?.0;
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
                        let r =
                            reader.read(Place::Friction(i, k), text, Some(dof), Ok(()), Ok(()))?.0;
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
        let Reader { graph, names: parameters, places, .. } = reader;
        Ok(Reading { graph, parameters, potential, masses, forces, dissipations, places })
    }

    fn names(&self) -> Result<Vec<String>, CustomError> {
        let mut names: Vec<String> = Vec::new();
        for (name, value) in &self.parameters {
            let why = match name {
                _ if !is_name(name) => {
                    "a name is made of letters, digits and underscores, the first no digit"
                }
                _ if is_reserved(name) => "the name means something else",
                _ if names.contains(name) => "the name is taken",
                _ if !value.is_finite() => {
                    return Err(CustomError::Value { name: name.clone(), value: *value });
                }
                _ => {
                    names.push(name.clone());
                    continue;
                }
            };
            return Err(CustomError::Name { name: name.clone(), why });
        }
        Ok(names)
    }
}

struct Reader {
    graph: Graph,
    names: Vec<String>,
    used: Vec<bool>,
    places: Vec<(Place, Node, Range<usize>)>,
}

impl Reader {
    /// The expression, and the largest index of a coordinate or momentum in it, counted from 1.
    fn read(
        &mut self,
        place: Place,
        text: &str,
        dof: Option<usize>,
        coordinates: Result<(), &'static str>,
        momenta: Result<(), &'static str>,
    ) -> Result<(Node, usize), CustomError> {
        let names = Names { parameters: &self.names, dof, coordinates, momenta };
        let parsed =
            parse(&mut self.graph, &names, text).map_err(|ParseError { span, problem }| {
                CustomError::Expression { place, span, problem }
            })?;
        self.used.iter_mut().zip(&parsed.used).for_each(|(used, &also)| *used |= also);
        self.places.extend(parsed.places.into_iter().map(|(node, span)| (place, node, span)));
        Ok((parsed.node, parsed.dof))
    }
}
