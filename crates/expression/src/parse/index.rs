//! Entries `q[i+1]` and sums `sum(i, 1, n, ..)`.

use super::names::{in_name, is_name, is_reserved};
use super::{DEEPEST, MOST_DEGREES, MOST_INDEX, MOST_WRITTEN_OUT, ParseError, Problem, Reader};
use crate::graph::Node;
use winnow::Parser as _;
use winnow::error::EmptyError;
use winnow::stream::Location;
use winnow::token::{take, take_while};

/// The bytes that a term counts for at least.
const SHORTEST_TERM: usize = 16;

impl Reader<'_, '_> {
    /// The value of a variable of a sum around this place.
    pub(super) fn index_variable(&self, name: &str) -> Option<i64> {
        self.variables.iter().rev().find(|(known, _)| known == name).map(|x| x.1)
    }

    /// N
    pub(super) fn count(&mut self) -> Result<usize, Problem> {
        self.parsed.counted = true;
        self.names.count.ok_or(Problem::NoCount)
    }

    fn failed(&self, start: usize, problem: Problem) -> ParseError {
        ParseError { span: start..self.text.previous_token_end(), problem }
    }

    pub(super) fn expect(
        &mut self,
        symbol: &'static [char],
        expected: &'static str,
    ) -> Result<(), ParseError> {
        match self.symbol(symbol) {
            Some(_) => Ok(()),
            None => Err(self.unexpected(expected)),
        }
    }

    /// `index "]"`, after `q[`, `p[` or `v[`.
    pub(super) fn entry(&mut self, name: char, start: usize) -> Result<Node, ParseError> {
        let index = self.index_sum()?;
        self.expect(&[']'], "an operator or a closing bracket")?;
        let limit = self.names.dof.or(self.names.count.filter(|_| self.parsed.counted));
        let most = limit.unwrap_or(MOST_DEGREES);
        match usize::try_from(index).ok().filter(|&index| (1..=most).contains(&index)) {
            Some(index) => self
                .input(name, index, || format!("{name}[{index}]"))
                .map_err(|problem| self.failed(start, problem)),
            None => Err(self.failed(start, Problem::NoEntry { name, index, dof: limit })),
        }
    }

    /// `"(" name "," index "," index "," sum ")"`, after `sum`.
    pub(super) fn series(&mut self, start: usize) -> Result<Node, ParseError> {
        self.expect(&['('], "a parenthesis, as in sum(i, 1, n, q[i]^2)")?;
        let begin = self.start();
        let variable: Result<&str, EmptyError> =
            take_while(1.., in_name).parse_next(&mut self.text);
        let Ok(variable) = variable else {
            return Err(self.unexpected("the name of an index, as in sum(i, 1, n, q[i]^2)"));
        };
        let means = variable == "n" || is_reserved(variable) || self.names.is_defined(variable);
        if means || !is_name(variable) {
            return Err(self.failed(begin, Problem::NoIndex { name: variable.to_owned() }));
        }
        self.expect(&[','], "a comma")?;
        let first = self.index_sum()?;
        self.expect(&[','], "an operator or a comma")?;
        let last = self.index_sum()?;
        self.expect(&[','], "an operator or a comma")?;
        let body = self.text;
        let mut sum = self.graph.number(0.0);
        if first > last {
            self.skip();
        }
        for value in first..=last {
            self.text = body;
            let begin = self.text.current_token_start();
            self.variables.push((variable.to_owned(), value));
            let term = self.sum();
            self.variables.pop();
            let term = term?;
            self.written += (self.text.current_token_start() - begin).max(SHORTEST_TERM);
            if self.written > MOST_WRITTEN_OUT {
                return Err(self.failed(start, Problem::TooManyTerms));
            }
            sum = if value == first { term } else { self.graph.sum(sum, term) };
        }
        self.close()?;
        Ok(self.operation(start, sum))
    }

    /// Passes over a term that no value of the variable needs.
    fn skip(&mut self) {
        let mut open = 1_usize;
        let end = self.text.chars().take_while(|&c| {
            match c {
                '(' => open += 1,
                ')' => open -= 1,
                _ => {}
            }
            open > 0
        });
        let bytes = end.map(char::len_utf8).sum::<usize>();
        let _: Result<&str, EmptyError> = take(bytes).parse_next(&mut self.text);
    }

    fn index_sum(&mut self) -> Result<i64, ParseError> {
        let start = self.start();
        let mut sum = self.index_product()?;
        while let Some(sign) = self.symbol(&['+', '-']) {
            let term = self.index_product()?;
            sum = self.bounded(start, if sign == '+' { sum + term } else { sum - term })?;
        }
        Ok(sum)
    }

    fn index_product(&mut self) -> Result<i64, ParseError> {
        let start = self.start();
        let mut product = self.index_atom()?;
        while self.symbol(&['*']).is_some() {
            let factor = self.index_atom()?;
            product = self.bounded(start, product * factor)?;
        }
        Ok(product)
    }

    fn bounded(&self, start: usize, index: i64) -> Result<i64, ParseError> {
        if index.abs() < MOST_INDEX {
            Ok(index)
        } else {
            Err(self.failed(start, Problem::LargeIndex))
        }
    }

    fn index_atom(&mut self) -> Result<i64, ParseError> {
        let start = self.start();
        if self.depth > DEEPEST {
            return Err(self.failed(start, Problem::TooDeep));
        }
        self.depth += 1;
        let index = if self.symbol(&['-']).is_some() {
            self.index_atom().map(|index| -index)
        } else if self.symbol(&['(']).is_some() {
            let index = self.index_sum();
            index.and_then(|index| self.close().map(|()| index))
        } else {
            self.index_word(start)
        };
        self.depth -= 1;
        index
    }

    /// A whole number, a variable, `n`, or `wrap(index)`.
    fn index_word(&mut self, start: usize) -> Result<i64, ParseError> {
        let word: Result<&str, EmptyError> = take_while(1.., in_name).parse_next(&mut self.text);
        let Ok(word) = word else {
            return Err(self.unexpected("a whole number or the name of an index"));
        };
        if word.bytes().all(|c| c.is_ascii_digit()) {
            let index = word.parse::<i64>().ok().filter(|&index| index < MOST_INDEX);
            return index.ok_or_else(|| self.failed(start, Problem::LargeIndex));
        }
        if let Some(value) = self.index_variable(word) {
            return Ok(value);
        }
        match (word, self.names.index) {
            ("i", Some(index)) => Ok(index as i64),
            ("n", _) => {
                self.count().map(|n| n as i64).map_err(|problem| self.failed(start, problem))
            }
            ("wrap", _) => {
                let count = self.count().map_err(|problem| self.failed(start, problem))?;
                self.expect(&['('], "the parenthesis of wrap")?;
                let index = self.index_sum()?;
                self.close()?;
                Ok((index - 1).rem_euclid(count.max(1) as i64) + 1)
            }
            _ => Err(self.failed(start, self.unknown(word))),
        }
    }
}
