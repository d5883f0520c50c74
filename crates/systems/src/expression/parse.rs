//! From text to the graph.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = factor (("*" | "/") factor)*
//! factor  = ("-" | "+") factor | power
//! power   = atom ("^" factor)?                  -q1^2 is -(q1²), 2^3^2 is 512, 2^-3 is allowed
//! atom    = number | name | function "(" sum ")" | "(" sum ")"
//! ```
//!
//! Text and nesting are bounded, so that time and stack are.

use super::function;
use super::graph::{Graph, Input, Node};
use std::ops::Range;
use thiserror::Error;
use winnow::Parser as _;
use winnow::combinator::opt;
use winnow::error::EmptyError;
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{any, one_of, take_while};

/// The longest expression, in bytes.
pub(crate) const LONGEST: usize = 1 << 16;
/// The deepest nesting of parentheses, signs and powers.
pub(crate) const DEEPEST: usize = 256;
/// The most degrees of freedom.
pub(crate) const MOST_DEGREES: usize = 100_000;

/// What is wrong with an expression.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Problem {
    /// Something else should stand here.
    #[error("{found} where {expected} should be")]
    Unexpected {
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A name nobody gave.
    #[error("{name} is not known{}", nearest.as_ref().map(|x| format!(": do you mean {x}?")).unwrap_or_default())]
    Unknown {
        /// The name.
        name: String,
        /// The one most like it, if any is.
        nearest: Option<String>,
    },
    /// A number that `f64` has no room for.
    #[error("{text} is too large or too small for a number")]
    Number {
        /// As it was written.
        text: String,
    },
    /// q or p with an index that none has.
    #[error(
        "{name} is no coordinate or momentum: they are counted from 1, without leading zeros, up to {}",
        MOST_DEGREES
    )]
    Index {
        /// As it was written.
        name: String,
    },
    /// A degree of freedom beyond the last.
    #[error("{name} is beyond the last of {dof} degrees of freedom")]
    BeyondLast {
        /// As it was written.
        name: String,
        /// N
        dof: usize,
    },
    /// A coordinate or momentum where there is no place for it.
    #[error("{name} has no place here: {rule}")]
    NoPlace {
        /// As it was written.
        name: String,
        /// What may stand here.
        rule: &'static str,
    },
    /// Too long a text.
    #[error("{bytes} bytes are more than {LONGEST}")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// Parentheses, signs or powers in one another.
    #[error("nested deeper than {DEEPEST}")]
    TooDeep,
}

/// What names mean.
pub(crate) struct Names<'a> {
    pub(crate) parameters: &'a [String],
    /// N, if it is known.
    pub(crate) dof: Option<usize>,
    /// Whether q and p may stand in the expression, and the rule where one may not.
    pub(crate) coordinates: Result<(), &'static str>,
    pub(crate) momenta: Result<(), &'static str>,
}

/// An expression read.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub(crate) node: Node,
    /// Where each operation stands in the text, what it is made of first.
    pub(crate) places: Vec<(Node, Range<usize>)>,
    /// Which parameters it mentions.
    pub(crate) used: Vec<bool>,
    /// One more than the largest index of a coordinate or momentum.
    pub(crate) dof: usize,
}

type Text<'s> = LocatingSlice<&'s str>;
type Failure = (Range<usize>, Problem);

/// Reads an expression into the graph.
pub(crate) fn parse(graph: &mut Graph, names: &Names<'_>, text: &str) -> Result<Parsed, Failure> {
    if text.len() > LONGEST {
        return Err((0..text.len(), Problem::TooLong { bytes: text.len() }));
    }
    let (used, node) = (vec![false; names.parameters.len()], graph.number(0.0));
    let parsed = Parsed { node, places: Vec::new(), used, dof: 0 };
    let mut reader = Reader { graph, names, text: LocatingSlice::new(text), depth: 0, parsed };
    let node = reader.sum()?;
    reader.space();
    if !reader.text.is_empty() {
        return Err(reader.unexpected("an operator or the end"));
    }
    Ok(Parsed { node, ..reader.parsed })
}

/// Is it a name: letters, digits and underscores, no digit first?
pub(crate) fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && text.chars().all(in_name)
}

/// Does the name mean something already?
pub(crate) fn is_reserved(name: &str) -> bool {
    name == "pi" || function::NAMES.contains(&name) || index(name).is_some()
}

fn in_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// The digits of q12 or p12.
fn index(name: &str) -> Option<&str> {
    let digits = name.strip_prefix(['q', 'p'])?;
    (!digits.is_empty() && digits.bytes().all(|c| c.is_ascii_digit())).then_some(digits)
}

struct Reader<'a, 's> {
    graph: &'a mut Graph,
    names: &'a Names<'a>,
    text: Text<'s>,
    depth: usize,
    parsed: Parsed,
}

impl Reader<'_, '_> {
    fn space(&mut self) {
        let _: Result<&str, EmptyError> =
            take_while(0.., |c: char| c.is_ascii_whitespace()).parse_next(&mut self.text);
    }

    /// The next character, if it is one of these.
    fn symbol(&mut self, symbols: &'static [char]) -> Option<char> {
        self.space();
        let next: Result<Option<char>, EmptyError> = opt(one_of(symbols)).parse_next(&mut self.text);
        next.ok().flatten()
    }

    /// The start of what comes next.
    fn start(&mut self) -> usize {
        self.space();
        self.text.current_token_start()
    }

    fn unexpected(&mut self, expected: &'static str) -> Failure {
        let start = self.start();
        let mut rest = self.text;
        let next: Result<char, EmptyError> = any.parse_next(&mut rest);
        let (found, length) = match next {
            Ok(c) if in_name(c) => {
                let word: String = self.text.chars().take_while(|&c| in_name(c)).take(64).collect();
                let length = word.len();
                (word, length)
            }
            Ok(c) => (c.to_string(), c.len_utf8()),
            Err(_) => ("the end".to_owned(), 0),
        };
        (start..start + length, Problem::Unexpected { found, expected })
    }

    /// The operation between `start` and here.
    fn operation(&mut self, start: usize, node: Node) -> Node {
        self.parsed.places.push((node, start..self.text.previous_token_end()));
        node
    }

    fn sum(&mut self) -> Result<Node, Failure> {
        let start = self.start();
        let mut sum = self.product()?;
        while let Some(sign) = self.symbol(&['+', '-']) {
            let term = self.product()?;
            sum = if sign == '+' { self.graph.sum(sum, term) } else { self.graph.difference(sum, term) };
            self.operation(start, sum);
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<Node, Failure> {
        let start = self.start();
        let mut product = self.factor()?;
        while let Some(sign) = self.symbol(&['*', '/']) {
            let factor = self.factor()?;
            product = match sign {
                '*' => self.graph.product(product, factor),
                _ => self.graph.quotient(product, factor),
            };
            self.operation(start, product);
        }
        Ok(product)
    }

    fn factor(&mut self) -> Result<Node, Failure> {
        let start = self.start();
        if self.depth > DEEPEST {
            return Err((start..start, Problem::TooDeep));
        }
        self.depth += 1;
        let factor = match self.symbol(&['+', '-']) {
            Some('-') => {
                let factor = self.factor()?;
                self.graph.negative(factor)
            }
            Some(_) => self.factor()?,
            None => self.power()?,
        };
        self.depth -= 1;
        Ok(factor)
    }

    fn power(&mut self) -> Result<Node, Failure> {
        let start = self.start();
        let base = self.atom()?;
        if self.symbol(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.factor()?;
        let power = self.graph.power(base, exponent);
        Ok(self.operation(start, power))
    }

    fn atom(&mut self) -> Result<Node, Failure> {
        let start = self.start();
        if self.symbol(&['(']).is_some() {
            let sum = self.sum()?;
            self.close()?;
            return Ok(sum);
        }
        if let Some(number) = self.number()? {
            return Ok(number);
        }
        let name: Result<&str, EmptyError> = take_while(1.., in_name).parse_next(&mut self.text);
        let Ok(name) = name else { return Err(self.unexpected("a number, a name or a parenthesis")) };
        let span = start..self.text.previous_token_end();
        if !function::NAMES.contains(&name) {
            return self.variable(name).map_err(|problem| (span, problem));
        }
        if self.symbol(&['(']).is_none() {
            return Err(self.unexpected("the parenthesis of a function"));
        }
        let argument = self.sum()?;
        self.close()?;
        match self.graph.call(name, argument) {
            Some(node) => Ok(self.operation(start, node)),
            None => Err((span, self.unknown(name))),
        }
    }

    fn close(&mut self) -> Result<(), Failure> {
        match self.symbol(&[')']) {
            Some(_) => Ok(()),
            None => Err(self.unexpected("an operator or a closing parenthesis")),
        }
    }

    /// Digits with a point among them and an exponent after them, if there are any.
    fn number(&mut self) -> Result<Option<Node>, Failure> {
        let start = self.start();
        let digits =
            |least: usize| take_while::<_, Text<'_>, EmptyError>(least.., |c: char| c.is_ascii_digit());
        let mantissa =
            winnow::combinator::alt(((digits(1), opt(('.', digits(0)))).void(), ('.', digits(1)).void()));
        let exponent = (one_of(['e', 'E']), opt(one_of(['+', '-'])), digits(1));
        let text: Result<Option<&str>, EmptyError> =
            opt((mantissa, opt(exponent)).take()).parse_next(&mut self.text);
        let Ok(Some(text)) = text else { return Ok(None) };
        let span = start..self.text.previous_token_end();
        let lost = |x: f64| {
            let mantissa = text.split(['e', 'E']).next().unwrap_or(text);
            !x.is_finite() || x == 0.0 && mantissa.bytes().any(|c| matches!(c, b'1'..=b'9'))
        };
        match text.parse::<f64>() {
            Ok(x) if !lost(x) => Ok(Some(self.graph.number(x))),
            _ => Err((span, Problem::Number { text: text.chars().take(64).collect() })),
        }
    }

    fn variable(&mut self, name: &str) -> Result<Node, Problem> {
        if name == "pi" {
            return Ok(self.graph.pi());
        }
        if let Some(digits) = index(name) {
            return self.state(name, digits);
        }
        match self.names.parameters.iter().position(|parameter| parameter == name) {
            Some(index) => {
                self.parsed.used[index] = true;
                Ok(self.graph.parameter(index as u32))
            }
            None => Err(self.unknown(name)),
        }
    }

    /// q_j or p_j
    fn state(&mut self, name: &str, digits: &str) -> Result<Node, Problem> {
        let short = || name.chars().take(64).collect::<String>();
        let index = digits.parse::<usize>().ok().filter(|&j| j <= MOST_DEGREES && !digits.starts_with('0'));
        let Some(index) = index else { return Err(Problem::Index { name: short() }) };
        let of_q = name.starts_with('q');
        let place = if of_q { self.names.coordinates } else { self.names.momenta };
        place.map_err(|rule| Problem::NoPlace { name: short(), rule })?;
        if let Some(dof) = self.names.dof.filter(|&dof| index > dof) {
            return Err(Problem::BeyondLast { name: short(), dof });
        }
        self.parsed.dof = self.parsed.dof.max(index);
        let j = (index - 1) as u32;
        Ok(self.graph.input(if of_q { Input::Coordinate(j) } else { Input::Momentum(j) }))
    }

    /// With the known name most like it, if one is.
    fn unknown(&self, name: &str) -> Problem {
        let known = self.names.parameters.iter().map(String::as_str).chain(function::NAMES).chain(["pi"]);
        let short: String = name.chars().take(64).collect();
        let distances = known.map(|known| (strsim::osa_distance(&short, known), known));
        let nearest = distances.min_by_key(|x| x.0).filter(|&(distance, known)| {
            distance <= (known.len().max(short.len()) / 3).max(1) && distance < short.len()
        });
        Problem::Unknown { name: short, nearest: nearest.map(|x| x.1.to_owned()) }
    }
}
