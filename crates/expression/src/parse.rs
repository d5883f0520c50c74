//! Parsing: from text to nodes of a graph.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = factor (("*" | "/") factor)*
//! factor  = ("-" | "+") factor | power
//! power   = atom ("^" factor)?                  -q1^2 is -(q1²), 2^3^2 is 512, 2^-3 is allowed
//! atom    = number | name | function "(" sum ")" | "(" sum ")" | entry | series
//! entry   = ("q" | "p") "[" index "]"           q[i+1], counted from 1
//! series  = "sum" "(" name "," index "," index "," sum ")"
//! ```
//!
//! An index is made of whole numbers, index variables, `n`, `+ - *`, parentheses and
//! `wrap(index)`, which brings it into 1..n. A series is written out when it is parsed: the text of
//! its term is read once for each value of its variable (`index.rs`).
//!
//! Bounds on the length and on the nesting of a text bound the time and the stack that parsing
//! takes.

mod index;
mod problem;

use crate::function::{self, FUNCTIONS};
use crate::graph::{Graph, Input, Node};
pub use problem::{ParseError, Problem};
use std::ops::Range;
use winnow::Parser as _;
use winnow::combinator::opt;
use winnow::error::EmptyError;
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{any, one_of, take_while};

/// The longest expression, in bytes.
const LONGEST: usize = 1 << 16;
/// The deepest nesting of parentheses, signs and powers.
const DEEPEST: usize = 256;
/// The most bytes read while the terms of sums are written out.
const MOST_WRITTEN_OUT: usize = 1 << 23;
/// The largest index of a coordinate or momentum.
pub const MOST_DEGREES: usize = 100_000;

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
}

impl<'a> Names<'a> {
    /// The parameters, and all coordinates and momenta.
    pub fn of(parameters: &'a [String]) -> Self {
        Self {
            parameters,
            definitions: &[],
            dof: None,
            count: None,
            index: None,
            coordinates: Ok(()),
            momenta: Ok(()),
        }
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

/// A parsed expression.
#[derive(Debug)]
pub struct Parsed {
    /// Its node in the graph.
    pub node: Node,
    /// The bytes each operation takes in the text, operands first.
    pub places: Vec<(Node, Range<usize>)>,
    /// Whether it mentions each of the parameters.
    pub used: Vec<bool>,
    /// The largest index of a coordinate or momentum, counted from 1; 0 if there is none.
    pub dof: usize,
    /// Whether it depends on the number of degrees of freedom.
    pub counted: bool,
    /// Whether it mentions each of the definitions.
    pub defined: Vec<bool>,
}

type Text<'s> = LocatingSlice<&'s str>;

/// Parses an expression and adds its nodes to the graph.
///
/// # Errors
/// [`ParseError`]
pub fn parse(graph: &mut Graph, names: &Names<'_>, text: &str) -> Result<Parsed, ParseError> {
    if text.len() > LONGEST {
        return Err(ParseError {
            span: 0..text.len(),
            problem: Problem::TooLong { bytes: text.len() },
        });
    }
    let (used, node) = (vec![false; names.parameters.len()], graph.number(0.0));
    let defined = vec![false; names.definitions.len()];
    let parsed = Parsed { node, places: Vec::new(), used, dof: 0, counted: false, defined };
    let text = LocatingSlice::new(text);
    let mut reader =
        Reader { graph, names, text, depth: 0, parsed, variables: Vec::new(), written: 0 };
    let node = reader.sum()?;
    reader.space();
    if !reader.text.is_empty() {
        return Err(reader.unexpected("an operator or the end"));
    }
    Ok(Parsed { node, ..reader.parsed })
}

/// The value of an expression in parameters. `count` is the value of `n`, `index` that of `i`.
///
/// # Errors
/// [`ParseError`]; coordinates and momenta have no place in it.
pub fn evaluate(
    text: &str,
    parameters: &[(String, f64)],
    count: Option<usize>,
    index: Option<usize>,
) -> Result<f64, ParseError> {
    let mut graph = Graph::default();
    let (known, values): (Vec<_>, Vec<_>) = parameters.iter().cloned().unzip();
    let rule = Err("this is made of numbers and parameters");
    let (coordinates, momenta) = (rule, rule);
    let names = Names { count, index, coordinates, momenta, ..Names::of(&known) };
    let node = parse(&mut graph, &names, text)?.node;
    let values = graph.evaluate(&graph.all(&[node]), &values, |_| 0.0);
    Ok(values.get(&node).copied().unwrap_or(f64::NAN))
}

/// Whether the text is a name: letters, digits and underscores, no digit first.
pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && text.chars().all(in_name)
}

/// Whether the name is a constant, a function, a coordinate or a momentum.
pub fn is_reserved(name: &str) -> bool {
    name == "pi" || function::names().any(|known| known == name) || index(name).is_some()
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
    /// The index variables of the sums around this place, innermost last.
    variables: Vec<(String, i64)>,
    /// The bytes read in terms of sums.
    written: usize,
}

impl Reader<'_, '_> {
    fn space(&mut self) {
        let _: Result<&str, EmptyError> =
            take_while(0.., |c: char| c.is_ascii_whitespace()).parse_next(&mut self.text);
    }

    /// The next character, if it is one of these.
    fn symbol(&mut self, symbols: &'static [char]) -> Option<char> {
        self.space();
        let next: Result<Option<char>, EmptyError> =
            opt(one_of(symbols)).parse_next(&mut self.text);
        next.ok().flatten()
    }

    /// The start of the next token.
    fn start(&mut self) -> usize {
        self.space();
        self.text.current_token_start()
    }

    fn unexpected(&mut self, expected: &'static str) -> ParseError {
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
        ParseError { span: start..start + length, problem: Problem::Unexpected { found, expected } }
    }

    /// Records that the operation takes the text from `start` to the current position.
    fn operation(&mut self, start: usize, node: Node) -> Node {
        self.parsed.places.push((node, start..self.text.previous_token_end()));
        node
    }

    fn sum(&mut self) -> Result<Node, ParseError> {
        let start = self.start();
        let mut sum = self.product()?;
        while let Some(sign) = self.symbol(&['+', '-']) {
            let term = self.product()?;
            sum = if sign == '+' {
                self.graph.sum(sum, term)
            } else {
                self.graph.difference(sum, term)
            };
            self.operation(start, sum);
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<Node, ParseError> {
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

    fn factor(&mut self) -> Result<Node, ParseError> {
        let start = self.start();
        if self.depth > DEEPEST {
            return Err(ParseError { span: start..start, problem: Problem::TooDeep });
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

    fn power(&mut self) -> Result<Node, ParseError> {
        let start = self.start();
        let base = self.atom()?;
        if self.symbol(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.factor()?;
        let power = self.graph.power(base, exponent);
        Ok(self.operation(start, power))
    }

    fn atom(&mut self) -> Result<Node, ParseError> {
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
        let Ok(name) = name else {
            return Err(self.unexpected("a number, a name or a parenthesis"));
        };
        let span = start..self.text.previous_token_end();
        if matches!(name, "q" | "p") && self.symbol(&['[']).is_some() {
            return self.entry(name, start);
        }
        if name == "sum" && !self.names.parameters.iter().any(|known| known == name) {
            return self.series(start);
        }
        if !function::names().any(|known| known == name) {
            return self.variable(name).map_err(|problem| ParseError { span, problem });
        }
        if self.symbol(&['(']).is_none() {
            return Err(self.unexpected("the parenthesis of a function"));
        }
        let argument = self.sum()?;
        self.close()?;
        match self.graph.call(name, argument) {
            Some(node) => Ok(self.operation(start, node)),
            None => Err(ParseError { span, problem: self.unknown(name) }),
        }
    }

    fn close(&mut self) -> Result<(), ParseError> {
        match self.symbol(&[')']) {
            Some(_) => Ok(()),
            None => Err(self.unexpected("an operator or a closing parenthesis")),
        }
    }

    /// A decimal number with an optional point and an optional exponent, if one stands here.
    fn number(&mut self) -> Result<Option<Node>, ParseError> {
        let start = self.start();
        let digits = |least: usize| {
            take_while::<_, Text<'_>, EmptyError>(least.., |c: char| c.is_ascii_digit())
        };
        let mantissa = winnow::combinator::alt((
            (digits(1), opt(('.', digits(0)))).void(),
            ('.', digits(1)).void(),
        ));
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
            _ => {
                let problem = Problem::Number { text: text.chars().take(64).collect() };
                Err(ParseError { span, problem })
            }
        }
    }

    fn variable(&mut self, name: &str) -> Result<Node, Problem> {
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
            Some(index) => {
                self.parsed.used[index] = true;
                Ok(self.graph.parameter(index as u32))
            }
            None => self.defined(name),
        }
    }

    /// The value of another expression, of `i` or of `n`.
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
            _ => Err(self.unknown(name)),
        }
    }

    /// q_j or p_j
    fn state(&mut self, name: &str, digits: &str) -> Result<Node, Problem> {
        let short = || name.chars().take(64).collect::<String>();
        let index =
            digits.parse::<usize>().ok().filter(|&j| j <= MOST_DEGREES && !digits.starts_with('0'));
        let Some(index) = index else { return Err(Problem::Index { name: short() }) };
        let of_q = name.starts_with('q');
        if let Some(dof) = self.names.dof.filter(|&dof| index > dof) {
            self.allowed(of_q, short)?;
            return Err(Problem::BeyondLast { name: short(), dof });
        }
        self.input(of_q, index, short)
    }

    fn allowed(&self, of_q: bool, name: impl Fn() -> String) -> Result<(), Problem> {
        let place = if of_q { self.names.coordinates } else { self.names.momenta };
        place.map_err(|rule| Problem::NoPlace { name: name(), rule })
    }

    /// The coordinate or momentum of an index that exists.
    fn input(
        &mut self,
        of_q: bool,
        index: usize,
        name: impl Fn() -> String,
    ) -> Result<Node, Problem> {
        self.allowed(of_q, name)?;
        self.parsed.dof = self.parsed.dof.max(index);
        let j = (index - 1) as u32;
        Ok(self.graph.input(if of_q { Input::Coordinate(j) } else { Input::Momentum(j) }))
    }

    /// The error for an unknown name, with the most similar known name.
    fn unknown(&self, name: &str) -> Problem {
        let parameters = self.names.parameters.iter().map(String::as_str);
        let definitions = self.names.definitions.iter().map(|x| x.name.as_str());
        let functions = FUNCTIONS.iter().map(|x| x.0);
        let known = parameters.chain(definitions).chain(functions).chain(["pi"]);
        let short: String = name.chars().take(64).collect();
        let distances = known.map(|known| (strsim::osa_distance(&short, known), known));
        let nearest = distances.min_by_key(|x| x.0).filter(|&(distance, known)| {
            distance <= (known.len().max(short.len()) / 3).max(1) && distance < short.len()
        });
        Problem::Unknown { name: short, nearest: nearest.map(|x| x.1.to_owned()) }
    }
}
