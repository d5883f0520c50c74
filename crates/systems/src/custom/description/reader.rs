//! The reader of expressions. It checks the names that each may mention, and records those that it
//! mentions.

use super::super::failure::{CustomError, Place};
use super::DissipationText;
use afterbay_expression::{
    Definition, Graph, Input, MOST_DEGREES, Names, Node, ParseError, Parsed, Problem, is_name,
    is_reserved, parse,
};
use std::ops::Range;

/// The reason for which a circular definition is refused.
const CIRCLE: &str = "it is defined by itself, or by others that are defined by it";

/// Checks the length of a list.
pub(super) fn counted(
    list: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), CustomError> {
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
        let why = match name.as_str() {
            _ if !is_name(name) => {
                "a name is made of letters (a to z, A to Z), digits and underscores, the first no \
                 digit"
            }
            _ if is_reserved(name) => "the name means something else",
            "i" => "i is the number of the degree of freedom",
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

/// Checks that no name of a system is `n`, the number of its degrees of freedom. The chains of the
/// catalogue have a parameter of this name and value, and pass it on to a drive and to events.
pub(super) fn check_count(
    parameters: &[(String, f64)],
    definitions: &[(String, String)],
) -> Result<(), CustomError> {
    let mut names = parameters.iter().map(|x| &x.0).chain(definitions.iter().map(|x| &x.0));
    match names.find(|name| *name == "n") {
        Some(name) => Err(CustomError::Name {
            name: name.clone(),
            why: "n is the number of degrees of freedom",
        }),
        None => Ok(()),
    }
}

/// The inputs that an expression may contain.
#[derive(Clone, Copy)]
pub(super) struct Rules {
    /// The largest index of a coordinate or momentum, if it is known.
    pub(super) dof: Option<usize>,
    pub(super) coordinates: Result<(), &'static str>,
    pub(super) momenta: Result<(), &'static str>,
    pub(super) velocities: Result<(), &'static str>,
    pub(super) time: Result<(), &'static str>,
    /// Whether it may jump in time.
    pub(super) jumps: bool,
}

impl Rules {
    pub(super) const ALL: Self = Self {
        dof: None,
        coordinates: Ok(()),
        momenta: Ok(()),
        velocities: Ok(()),
        time: Ok(()),
        jumps: false,
    };

    /// Numbers and parameters, by this rule.
    pub(super) fn only_parameters(rule: Result<(), &'static str>) -> Self {
        Self {
            dof: None,
            coordinates: rule,
            momenta: rule,
            velocities: rule,
            time: rule,
            jumps: false,
        }
    }
}

pub(super) struct Reader {
    pub(super) graph: Graph,
    pub(super) names: Vec<String>,
    pub(super) used: Vec<bool>,
    pub(super) definitions: Vec<Definition>,
    /// Whether each of the definitions is used.
    pub(super) defined: Vec<bool>,
    pub(super) places: Vec<(Place, Node, Range<usize>)>,
    /// The value of `n`.
    pub(super) count: Option<usize>,
}

impl Reader {
    /// A reader that knows the parameters and the definitions, and the value of `n`.
    pub(super) fn new(
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
    pub(super) fn energy(
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
    pub(super) fn dissipation(
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
    pub(super) fn finish(self) -> Result<Self, CustomError> {
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
        let mut waiting = vec![true; texts.len()];
        for first in 0..texts.len() {
            // Definitions, each of which mentions the next.
            let mut chain: Vec<usize> = waiting[first].then_some(first).into_iter().collect();
            while let Some(&k) = chain.last() {
                let (name, text) = &texts[k];
                match self.parse(Place::Definition(k), text, rules) {
                    Ok(parsed) => {
                        self.add(name, parsed);
                        waiting[k] = false;
                        chain.pop();
                    }
                    Err(error) => match mentioned(&error, texts) {
                        None => return Err(error),
                        Some(other) if chain.contains(&other) => {
                            let name = texts[first].0.clone();
                            return Err(CustomError::Name { name, why: CIRCLE });
                        }
                        Some(other) => chain.push(other),
                    },
                }
            }
        }
        Ok(())
    }

    /// Adds a definition, and notes those that it uses.
    fn add(&mut self, name: &str, parsed: Parsed) {
        self.defined.iter_mut().zip(&parsed.defined).for_each(|(used, &also)| *used |= also);
        let Parsed { node, used, counted, .. } = parsed;
        self.definitions.push(Definition { name: name.to_owned(), node, used, counted });
    }

    /// Parses an expression of the system and notes what it uses.
    pub(super) fn read(
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
        let names = if rules.jumps { Names { jumps: Ok(()), ..names } } else { names };
        parse(&mut self.graph, &names, text).map_err(|ParseError { span, problem }| {
            CustomError::Expression { place, span, problem }
        })
    }
}

/// The definition that an expression mentions and that has not been read.
fn mentioned(error: &CustomError, texts: &[(String, String)]) -> Option<usize> {
    let CustomError::Expression { problem: Problem::Unknown { name, .. }, .. } = error else {
        return None;
    };
    texts.iter().position(|known| known.0 == *name)
}

/// The inputs that an expression contains.
pub(super) struct Found {
    /// The largest index of a coordinate or momentum, counted from 1; 0 if there is none.
    pub(super) dof: usize,
    /// Whether it depends on the number of degrees of freedom.
    pub(super) counted: bool,
}
