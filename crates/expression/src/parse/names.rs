//! The names in an expression: what they may be, and what each stands for.

use super::problem::jumps_elsewhere;
use super::{MOST_DEGREES, Problem, Reader};
use crate::function::{self, FUNCTIONS, FUNCTIONS_OF_TWO, FUNCTIONS_WITH_JUMPS};
use crate::graph::{Input, Node};

/// The most parameters that a message names.
const MOST_NAMED: usize = 12;

/// The names that an expression may mention.
#[derive(Clone, Copy)]
pub struct Names<'a> {
    /// The parameters, in the order of their values.
    pub parameters: &'a [String],
    /// Names of other expressions, each with its node.
    pub definitions: &'a [Definition],
    /// The largest index a coordinate or momentum may have, if there is a limit.
    pub dof: Option<usize>,
    /// The value of `n`, the number of degrees of freedom, if it is known.
    pub count: Option<usize>,
    /// The value of `i`, the number of this degree of freedom, for one of a list of expressions.
    pub index: Option<usize>,
    /// Whether coordinates are allowed; if not, the rule that a message quotes.
    pub coordinates: Result<(), &'static str>,
    /// Whether momenta are allowed; if not, the rule that a message quotes.
    pub momenta: Result<(), &'static str>,
    /// Whether velocities are allowed; if not, the rule that a message quotes.
    pub velocities: Result<(), &'static str>,
    /// Whether the time `t` is allowed, which is [`Input::End`]; if not, the rule that a message
    /// quotes.
    pub time: Result<(), &'static str>,
    /// Whether functions with jumps may be called with arguments that depend on the time; if not,
    /// the rule that a message quotes.
    pub jumps: Result<(), &'static str>,
}

impl<'a> Names<'a> {
    /// The parameters, and all coordinates, momenta and velocities.
    pub fn of(parameters: &'a [String]) -> Self {
        Self {
            parameters,
            definitions: &[],
            dof: None,
            count: None,
            index: None,
            coordinates: Ok(()),
            momenta: Ok(()),
            velocities: Ok(()),
            time: Err("it is the time"),
            jumps: Err("it jumps, and only a force of a drive may jump, and only in time"),
        }
    }
}

impl Names<'_> {
    /// Whether a parameter or a definition has this name.
    pub(super) fn is_defined(&self, name: &str) -> bool {
        self.parameters.iter().any(|known| known == name)
            || self.definitions.iter().any(|known| known.name == name)
    }
}

/// A named expression that others may mention.
#[derive(Clone, Debug)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// Its node in the graph.
    pub node: Node,
    /// Whether it mentions each of the parameters.
    pub used: Vec<bool>,
    /// Whether it depends on the number of degrees of freedom.
    pub counted: bool,
}

/// Whether the text is a name: letters, digits and underscores, no digit first.
pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && text.chars().all(in_name)
}

/// Whether the name is a constant, the time, a function, a coordinate or a momentum.
pub fn is_reserved(name: &str) -> bool {
    name == "pi"
        || name == "t"
        || function::names().any(|known| known == name)
        || index(name).is_some()
}

pub(super) fn in_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// The digits of q12 or p12. Parameters cannot have such names.
fn index(name: &str) -> Option<&str> {
    digits(name, &['q', 'p'])
}

/// The digits behind one of these letters.
fn digits<'n>(name: &'n str, letters: &[char]) -> Option<&'n str> {
    let digits = name.strip_prefix(letters)?;
    (!digits.is_empty() && digits.bytes().all(|c| c.is_ascii_digit())).then_some(digits)
}

/// The character of a text that has only one.
pub(super) fn only(text: &str) -> Option<char> {
    let mut characters = text.chars();
    characters.next().filter(|_| characters.next().is_none())
}

impl Reader<'_, '_> {
    /// The constant, parameter, index or input of a name.
    pub(super) fn variable(&mut self, name: &str) -> Result<Node, Problem> {
        if let Some(value) = self.index_variable(name) {
            return Ok(self.graph.number(value as f64));
        }
        if name == "pi" {
            return Ok(self.graph.pi());
        }
        if let Some(digits) = index(name) {
            return self.state(name, digits);
        }
        match self.names.parameters.iter().position(|parameter| parameter == name) {
            Some(_) if self.is_velocity(name) => Err(Problem::Ambiguous { name: name.to_owned() }),
            Some(index) => {
                self.parsed.used[index] = true;
                Ok(self.graph.parameter(index as u32))
            }
            None => self.defined(name),
        }
    }

    /// Whether the name is that of a velocity here.
    fn is_velocity(&self, name: &str) -> bool {
        let index = digits(name, &['v']).filter(|digits| !digits.starts_with('0'));
        let index = index.and_then(|digits| digits.parse::<usize>().ok());
        self.names.velocities.is_ok()
            && index.is_some_and(|index| self.names.dof.is_none_or(|dof| index <= dof))
    }

    /// The value of another expression, of `i` or `n`, or a velocity.
    fn defined(&mut self, name: &str) -> Result<Node, Problem> {
        if let Some(at) = self.names.definitions.iter().position(|x| x.name == name) {
            let definition = &self.names.definitions[at];
            self.parsed.used.iter_mut().zip(&definition.used).for_each(|(used, &x)| *used |= x);
            self.parsed.defined[at] = true;
            self.parsed.counted |= definition.counted;
            return Ok(definition.node);
        }
        match (name, self.names.index) {
            ("i", Some(index)) => Ok(self.graph.number(index as f64)),
            ("n", _) => self.count().map(|n| self.graph.number(n as f64)),
            ("t", _) => match self.names.time {
                Ok(()) => Ok(self.graph.input(Input::End)),
                Err(rule) => Err(Problem::NoPlace { name: name.to_owned(), rule }),
            },
            _ => match digits(name, &['v']) {
                Some(digits) => self.state(name, digits),
                None => Err(self.unknown(name)),
            },
        }
    }

    /// q_j, p_j or v_j
    fn state(&mut self, name: &str, digits: &str) -> Result<Node, Problem> {
        let short = || name.chars().take(64).collect::<String>();
        let index =
            digits.parse::<usize>().ok().filter(|&j| j <= MOST_DEGREES && !digits.starts_with('0'));
        let (Some(index), Some(letter)) = (index, name.chars().next()) else {
            return Err(Problem::Index { name: short() });
        };
        if let Some(dof) = self.names.dof.filter(|&dof| index > dof) {
            self.allowed(letter, short)?;
            return Err(Problem::BeyondLast { name: short(), dof });
        }
        self.input(letter, index, short)
    }

    /// Whether q, p or v may be mentioned.
    fn allowed(&self, letter: char, name: impl Fn() -> String) -> Result<(), Problem> {
        let place = match letter {
            'q' => self.names.coordinates,
            'p' => self.names.momenta,
            _ => self.names.velocities,
        };
        place.map_err(|rule| Problem::NoPlace { name: name(), rule })
    }

    /// The coordinate, momentum or velocity of an index that exists.
    pub(super) fn input(
        &mut self,
        letter: char,
        index: usize,
        name: impl Fn() -> String,
    ) -> Result<Node, Problem> {
        self.allowed(letter, name)?;
        self.parsed.dof = self.parsed.dof.max(index);
        let j = (index - 1) as u32;
        Ok(self.graph.input(match letter {
            'q' => Input::Coordinate(j),
            'p' => Input::Momentum(j),
            _ => Input::Velocity(j),
        }))
    }

    /// The error for an unknown name, with the most similar known name.
    pub(super) fn unknown(&self, name: &str) -> Problem {
        let parameters = self.names.parameters.iter().map(String::as_str);
        let definitions = self.names.definitions.iter().map(|x| x.name.as_str());
        let functions = FUNCTIONS.iter().chain(&FUNCTIONS_OF_TWO).chain(&FUNCTIONS_WITH_JUMPS);
        let functions = functions.map(|x| x.0).chain(["sum"]);
        let known = parameters.chain(definitions).chain(functions).chain(["pi"]);
        let short: String = name.chars().take(64).collect();
        let distances = known.map(|known| (strsim::osa_distance(&short, known), known));
        let nearest = distances.min_by_key(|x| x.0).filter(|&(distance, known)| {
            let similar = distance <= (known.len().max(short.len()) / 3).max(1);
            similar && distance < short.len() && !jumps_elsewhere(name)
        });
        let nearest = nearest.map(|x| x.1.into());
        Problem::Unknown { name: short, nearest, known: self.known().into() }
    }

    /// The names that may stand here, without functions.
    fn known(&self) -> String {
        let Names { parameters, definitions, dof, coordinates, momenta, velocities, time, .. } =
            *self.names;
        let mut all = Vec::new();
        for (letter, allowed) in [('q', coordinates), ('p', momenta), ('v', velocities)] {
            if allowed.is_ok() {
                all.push(match dof {
                    Some(1) => format!("{letter}1"),
                    Some(2) => format!("{letter}1, {letter}2"),
                    Some(n) => format!("{letter}1 to {letter}{n}"),
                    None => format!("{letter}1, {letter}2, .."),
                });
            }
        }
        if time.is_ok() {
            all.push("t".to_owned());
        }
        let defined = definitions.iter().map(|x| x.name.as_str());
        let variables = self.variables.iter().map(|x| x.0.as_str());
        let named: Vec<_> =
            parameters.iter().map(String::as_str).chain(defined).chain(variables).collect();
        all.extend(named.iter().take(MOST_NAMED).map(|name| name.chars().take(64).collect()));
        if named.len() > MOST_NAMED {
            all.push("..".to_owned());
        }
        all.push("pi".to_owned());
        all.join(", ")
    }
}
