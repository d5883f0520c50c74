//! A statement put to the test: the numbers it rests on, and the rule and the wordings that make a
//! verdict and a sentence of them.
//!
//! The rule is a function pointer, which sees the readings and nothing else: a sentence cannot
//! state what its numbers do not say. `tests/claims.rs` alters the readings of every finding and
//! sees the verdict and the sentence change.

use crate::report::Verdict;
use serde::Serialize;

/// The verdict and the sentence that follow from readings.
pub type Said = (Verdict, String);

/// One number or word a finding rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The owner of the quantity: a method, a variable or the paper.
    pub of: String,
    /// The quantity.
    pub what: String,
    /// Its value.
    pub found: Found,
}

/// The value of a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Found {
    /// A number.
    Number(f64),
    /// A word, such as an outcome.
    Word(String),
    /// Nothing: the run that would have it did not get there.
    Nothing,
}

impl From<f64> for Found {
    fn from(number: f64) -> Self {
        if number.is_nan() { Self::Nothing } else { Self::Number(number) }
    }
}

impl From<Option<f64>> for Found {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Nothing, Self::from)
    }
}

impl From<usize> for Found {
    fn from(count: usize) -> Self {
        Self::Number(count as f64)
    }
}

impl From<u64> for Found {
    fn from(count: u64) -> Self {
        Self::Number(count as f64)
    }
}

impl From<Option<u64>> for Found {
    fn from(count: Option<u64>) -> Self {
        count.map_or(Self::Nothing, Self::from)
    }
}

impl From<String> for Found {
    fn from(word: String) -> Self {
        Self::Word(word)
    }
}

impl From<&str> for Found {
    fn from(word: &str) -> Self {
        Self::Word(word.into())
    }
}

/// The readings of a finding, in the order they were taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Readings(pub Vec<Reading>);

impl Readings {
    /// With one more.
    pub fn and(mut self, of: &str, what: &str, found: impl Into<Found>) -> Self {
        self.add(of, what, found);
        self
    }

    /// Adds one.
    pub(crate) fn add(&mut self, of: &str, what: &str, found: impl Into<Found>) {
        self.0.push(Reading { of: of.into(), what: what.into(), found: found.into() });
    }

    fn find(&self, of: &str, what: &str) -> Option<&Found> {
        self.0.iter().find(|one| one.of == of && one.what == what).map(|one| &one.found)
    }

    /// A number, NaN where there is none: no rule holds of it.
    pub fn number(&self, of: &str, what: &str) -> f64 {
        match self.find(of, what) {
            Some(Found::Number(number)) => *number,
            _ => f64::NAN,
        }
    }

    /// A word, empty where there is none.
    pub(crate) fn word(&self, of: &str, what: &str) -> &str {
        match self.find(of, what) {
            Some(Found::Word(word)) => word,
            _ => "",
        }
    }

    /// The owners of the readings of one quantity, in order.
    pub(crate) fn of_all(&self, what: &str) -> Vec<&str> {
        self.0.iter().filter(|one| one.what == what).map(|one| one.of.as_str()).collect()
    }

    /// Every number of one quantity, with what it belongs to; NaN where there is none.
    pub(crate) fn numbers(&self, what: &str) -> Vec<(&str, f64)> {
        self.of_all(what).into_iter().map(|of| (of, self.number(of, what))).collect()
    }
}

/// A statement that was put to the test.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// The subject: a figure or a claim of the paper, or a question of ours.
    pub topic: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The sentence, with figures.
    pub statement: String,
    /// The readings the verdict and the statement are made from.
    pub readings: Readings,
    #[serde(skip)]
    say: fn(&Readings) -> Said,
}

impl Finding {
    /// The verdict and the sentence that follow from readings.
    pub fn new(topic: impl Into<String>, readings: Readings, say: fn(&Readings) -> Said) -> Self {
        let (verdict, statement) = say(&readings);
        Self { topic: topic.into(), verdict, statement, readings, say }
    }

    /// The finding other readings would have made.
    pub fn again(&self, readings: Readings) -> Self {
        Self::new(self.topic.clone(), readings, self.say)
    }
}

/// The verdict of a rule.
pub(crate) fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Holds } else { Verdict::Fails }
}

/// A number in a sentence: two significant digits.
pub(crate) fn sci(number: f64) -> String {
    if number.is_nan() { "not known".into() } else { format!("{number:.1e}") }
}

/// A number in a sentence: as many decimals as asked for.
pub(crate) fn fixed(number: f64, decimals: usize) -> String {
    if number.is_nan() { "not known".into() } else { format!("{number:.decimals$}") }
}

/// A list in a sentence.
pub(crate) fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<_> = items.into_iter().collect();
    match items.split_last() {
        None => "none".into(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(r: &Readings) -> Said {
        let x = r.number("a", "x");
        (verdict(x < 1.0), format!("x is {}", sci(x)))
    }

    #[test]
    fn what_is_not_known_holds_nothing() {
        let known = Finding::new("x", Readings::default().and("a", "x", 0.5), small);
        assert_eq!((known.verdict, known.statement.as_str()), (Verdict::Holds, "x is 5.0e-1"));
        for found in [Found::from(None::<f64>), f64::NAN.into(), "much".into()] {
            let unknown = known.again(Readings::default().and("a", "x", found));
            assert_eq!(unknown.verdict, Verdict::Fails);
            assert_eq!(unknown.statement, "x is not known");
        }
        assert_eq!(known.again(Readings::default()).verdict, Verdict::Fails);
    }

    #[test]
    fn lists_read_as_sentences() {
        let all = |names: &[&str]| list(names.iter().map(ToString::to_string));
        assert_eq!(all(&[]), "none");
        assert_eq!(all(&["a"]), "a");
        assert_eq!(all(&["a", "b", "c"]), "a, b and c");
    }
}
