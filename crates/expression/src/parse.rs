//! Parsing: from text to nodes of a graph.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = factor (("*" | "/") factor)*
//! factor  = ("-" | "+") factor | power
//! power   = atom ("^" factor)?                  -q1^2 is -(q1²), 2^3^2 is 512, 2^-3 is allowed
//! atom    = number | name | function "(" sum ")" | "(" sum ")" | entry | series | extreme
//! extreme = ("min" | "max" | "mod") "(" sum "," sum ")"
//! entry   = ("q" | "p" | "v") "[" index "]"     q[i+1], counted from 1
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
mod names;
mod problem;

use crate::function::{self, FUNCTIONS_WITH_JUMPS};
use crate::graph::{Graph, Kinds, Node};
pub use names::{Definition, Names, is_name, is_reserved};
use names::{in_name, only};
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
/// The largest size of an index, so that sums and products of indices do not overflow.
const MOST_INDEX: i64 = 1 << 31;
/// The largest index of a coordinate or momentum.
pub const MOST_DEGREES: usize = 100_000;

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
    let (whole, text) = (text, LocatingSlice::new(text));
    let mut reader =
        Reader { graph, names, whole, text, depth: 0, parsed, variables: Vec::new(), written: 0 };
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
    let names = Names {
        count,
        index,
        coordinates: rule,
        momenta: rule,
        velocities: rule,
        ..Names::of(&known)
    };
    let node = parse(&mut graph, &names, text)?.node;
    let values = graph.evaluate(&graph.all(&[node]), &values, &|_| 0.0);
    Ok(values.get(&node).copied().unwrap_or(f64::NAN))
}

/// Whether a symbol or word may begin a factor after a sign.
fn may_be_factor(found: &str) -> bool {
    found == "(" || found.starts_with(in_name)
}

struct Reader<'a, 's> {
    graph: &'a mut Graph,
    names: &'a Names<'a>,
    whole: &'s str,
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
            Err(_) => {
                return ParseError { span: start..start, problem: Problem::Ends { expected } };
            }
        };
        let problem = match self.word_before() {
            Some(left) if expected.contains("operator") && may_be_factor(&found) => {
                Problem::NoSign { left, right: found }
            }
            _ => Problem::Unexpected { found, expected },
        };
        ParseError { span: start..start + length, problem }
    }

    /// The name or number before this place, or the parenthesis that is closed there.
    fn word_before(&self) -> Option<String> {
        let before = self.whole.get(..self.text.current_token_start())?.trim_end();
        if before.ends_with(')') {
            return Some(")".to_owned());
        }
        let word = before.rsplit(|c: char| !in_name(c) && c != '.').next()?;
        (!word.is_empty() && word.len() <= 64).then(|| word.to_owned())
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
        if let Some(letter @ ('q' | 'p' | 'v')) = only(name)
            && self.symbol(&['[']).is_some()
        {
            return self.entry(letter, start);
        }
        // A parameter with one of these names takes precedence over the function, as in scenes
        // written before the function existed.
        match name {
            _ if self.names.is_defined(name) => {}
            "sum" => return self.series(start),
            "min" | "max" => return self.extreme(name, start),
            "mod" => return self.remainder(start),
            _ => {
                if let Some(&(name, _)) = FUNCTIONS_WITH_JUMPS.iter().find(|x| x.0 == name) {
                    return self.jumping(name, start);
                }
            }
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

    /// `"(" sum "," sum ")"`, after `min` or `max`.
    fn extreme(&mut self, name: &str, start: usize) -> Result<Node, ParseError> {
        self.expect(&['('], "a parenthesis, as in max(0, q1 - 1)")?;
        let [a, b] = self.two()?;
        let node = if name == "max" { self.graph.max(a, b) } else { self.graph.min(a, b) };
        Ok(self.operation(start, node))
    }

    /// `"(" sum "," sum ")"`, after `mod`.
    fn remainder(&mut self, start: usize) -> Result<Node, ParseError> {
        self.expect(&['('], "a parenthesis, as in mod(t, 2)")?;
        let [a, b] = self.two()?;
        for x in [a, b] {
            self.may_jump("mod", x, start)?;
        }
        let node = self.graph.remainder(a, b);
        Ok(self.operation(start, node))
    }

    /// `"(" sum ")"`, after `sign` or `floor`.
    fn jumping(&mut self, name: &'static str, start: usize) -> Result<Node, ParseError> {
        self.expect(&['('], "the parenthesis of a function")?;
        let x = self.sum()?;
        self.close()?;
        self.may_jump(name, x, start)?;
        match self.graph.call_with_jumps(name, x) {
            Some(node) => Ok(self.operation(start, node)),
            None => Err(self.unexpected("a function")),
        }
    }

    /// Refuses a function with jumps of anything but parameters and, where it is allowed, the time.
    fn may_jump(&self, name: &'static str, x: Node, start: usize) -> Result<(), ParseError> {
        let state = Kinds::ALL.without(Kinds::END);
        let rule = if self.graph.depends(x, state) {
            Err("it jumps, and its argument may depend on t and parameters only")
        } else if self.graph.depends(x, Kinds::END) {
            self.names.jumps
        } else {
            Ok(())
        };
        rule.map_err(|rule| ParseError {
            span: start..self.text.previous_token_end(),
            problem: Problem::Jumps { name, rule },
        })
    }

    /// `sum "," sum ")"`
    fn two(&mut self) -> Result<[Node; 2], ParseError> {
        let a = self.sum()?;
        self.expect(&[','], "an operator or a comma")?;
        let b = self.sum()?;
        self.close()?;
        Ok([a, b])
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
}
