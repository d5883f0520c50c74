//! Statements put to the test. A statement consists of the numbers it rests on and of a rule that
//! turns them into a verdict and a sentence.
//!
//! The rule is a function pointer, so that it depends on the readings alone and a sentence cannot
//! state anything its numbers do not show. `tests/suite/paper/claims.rs` alters the readings of
//! every finding and checks that the verdict and the sentence change.

use crate::report::Verdict;
pub(crate) use afterbay_analysis::digits::significant;
pub use afterbay_analysis::digits::{in_full, in_short};
use serde::Serialize;

/// The verdict and the sentence derived from readings.
pub type Said = (Verdict, String);

/// A number or word on which a finding rests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The subject that has the quantity: a method, a variable or the paper.
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
    /// No value, because the run did not get far enough.
    Nothing,
}

impl Found {
    /// The number; NaN if it is none.
    fn number(&self) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Word(_) | Self::Nothing => f64::NAN,
        }
    }
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
    /// Appends a reading and returns all of them.
    pub fn and(mut self, of: &str, what: &str, found: impl Into<Found>) -> Self {
        self.add(of, what, found);
        self
    }

    /// Appends a reading.
    pub(crate) fn add(&mut self, of: &str, what: &str, found: impl Into<Found>) {
        self.0.push(Reading { of: of.into(), what: what.into(), found: found.into() });
    }

    fn find(&self, of: &str, what: &str) -> Option<&Found> {
        self.0.iter().find(|one| one.what == what && one.of == of).map(|one| &one.found)
    }

    /// The number `what` of the subject `of`. It is NaN if missing, so that no comparison with it
    /// holds.
    pub fn number(&self, of: &str, what: &str) -> f64 {
        self.find(of, what).map_or(f64::NAN, Found::number)
    }

    /// The word `what` of the subject `of`; empty if missing.
    pub(crate) fn word(&self, of: &str, what: &str) -> &str {
        match self.find(of, what) {
            Some(Found::Word(word)) => word,
            _ => "",
        }
    }

    /// The number `what` of the subject `of`, if there is one.
    pub(crate) fn known(&self, of: &str, what: &str) -> Option<f64> {
        Some(self.number(of, what)).filter(|number| !number.is_nan())
    }

    /// The subjects that have the quantity `what`, in order.
    pub(crate) fn of_all(&self, what: &str) -> Vec<&str> {
        self.0.iter().filter(|one| one.what == what).map(|one| one.of.as_str()).collect()
    }

    /// The numbers of the quantity `what` with their subjects; NaN where one is missing.
    pub(crate) fn numbers(&self, what: &str) -> Vec<(&str, f64)> {
        let all = self.0.iter().filter(|one| one.what == what);
        all.map(|one| (one.of.as_str(), one.found.number())).collect()
    }

    /// A sentence with a part about each subject that has the quantity `what`.
    pub(crate) fn each(&self, what: &str, say: impl Fn(&str) -> String) -> String {
        format!("{}.", self.of_all(what).into_iter().map(say).collect::<Vec<_>>().join("; "))
    }
}

/// A statement with its verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// The topic: a figure or a claim of the paper, or a question about a scene.
    pub topic: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The sentence, with numbers.
    pub statement: String,
    /// The readings from which the verdict and the statement follow.
    pub readings: Readings,
    #[serde(skip)]
    say: fn(&Readings) -> Said,
}

impl Finding {
    /// Applies the rule `say` to readings.
    pub fn new(topic: impl Into<String>, readings: Readings, say: fn(&Readings) -> Said) -> Self {
        let (verdict, statement) = say(&readings);
        Self { topic: topic.into(), verdict, statement, readings, say }
    }

    /// Applies the rule to other readings, and returns the verdict and the sentence.
    pub fn again(&self, readings: &Readings) -> Said {
        (self.say)(readings)
    }
}

/// [`Verdict::Holds`] or [`Verdict::Fails`].
pub(crate) fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Holds } else { Verdict::Fails }
}

/// [`Verdict::Note`] if nothing went wrong, else [`Verdict::Fails`].
pub(crate) fn note(is_right: bool) -> Verdict {
    if is_right { Verdict::Note } else { Verdict::Fails }
}

/// A count of things for a sentence, as `1 step` or `2 steps`.
pub fn counted(count: impl std::fmt::Display, thing: &str) -> String {
    let count = count.to_string();
    format!("{count} {thing}{}", if count == "1" { "" } else { "s" })
}

/// A number for a sentence, with two significant digits.
pub(crate) fn sci(number: f64) -> String {
    if number.is_nan() { "not known".into() } else { format!("{number:.1e}") }
}

/// A deviation of K for a sentence, with one significant digit.
pub(crate) fn deviation(drift: f64) -> String {
    if drift.is_finite() {
        format!("{drift:.0e}")
    } else {
        "an unknown amount (H overflows, or has no value there)".into()
    }
}

/// A number for a sentence, with the given number of decimals; with two significant digits if these
/// decimals do not tell it from zero, or if it is too large for them.
pub(crate) fn fixed(number: f64, decimals: usize) -> String {
    let is_small = number != 0.0 && number.abs() < 0.5 * 0.1_f64.powi(decimals as i32);
    if number.is_nan() || is_small || number.abs() >= LARGEST_FIXED {
        return sci(number);
    }
    format!("{number:.decimals$}")
}

/// The numbers from which on decimals are left out.
const LARGEST_FIXED: f64 = 1e9;

/// Items joined for a sentence: "a, b and c".
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
            let unknown = known.again(&Readings::default().and("a", "x", found));
            assert_eq!(unknown, (Verdict::Fails, "x is not known".to_owned()));
        }
        assert_eq!(known.again(&Readings::default()).0, Verdict::Fails);
    }

    #[test]
    fn lists_read_as_sentences() {
        let all = |names: &[&str]| list(names.iter().map(ToString::to_string));
        assert_eq!(all(&[]), "none");
        assert_eq!(all(&["a"]), "a");
        assert_eq!(all(&["a", "b", "c"]), "a, b and c");
    }
}
