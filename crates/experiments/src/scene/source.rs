//! The text of a scene: its TOML values, their check against the schema, and their places.

use super::problem::{SceneError, SceneProblem};
use super::{depth, literal};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// The deepest nesting of tables and arrays.
const DEEPEST: usize = 64;

/// A text with its tables.
pub(super) struct Source<'a> {
    text: &'a str,
    root: Spanned<DeTable<'a>>,
}

type Key<'a> = Spanned<std::borrow::Cow<'a, str>>;

impl<'a> Source<'a> {
    pub(super) fn parse(text: &'a str) -> Result<Self, SceneError> {
        if let Some(span) = depth::beyond(text, DEEPEST) {
            return Err(SceneError { problem: SceneProblem::TooDeep { limit: DEEPEST }, span });
        }
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { text, root }),
            Err(error) => Err(SceneError {
                problem: SceneProblem::Syntax(error.message().to_owned()),
                span: error.span().unwrap_or(0..0),
            }),
        }
    }

    /// Checks the keys and the kind of each value against the schema.
    pub(super) fn check(&self, schema: &Value) -> Result<(), SceneError> {
        Schema { root: schema, at: schema }.table(self.root.get_ref(), self.root.span())
    }

    /// Deserializes the tables.
    pub(super) fn read<D: DeserializeOwned>(&self) -> Result<D, SceneError> {
        toml::from_str(self.text).map_err(|error| SceneError {
            problem: SceneProblem::Syntax(error.message().to_owned()),
            span: error.span().unwrap_or(0..0),
        })
    }

    /// The place of the entry at a path such as `study.stability.methods.2`, or of the part of the
    /// path that exists.
    pub(super) fn span(&self, path: &str) -> Range<usize> {
        let (key, value) = self.walk(path.split('.'));
        key.start..value.end.max(key.end)
    }

    /// The place of the entry at a path whose keys may contain dots.
    pub(super) fn span_of(&self, keys: &[&str]) -> Range<usize> {
        let (key, value) = self.walk(keys.iter().copied());
        key.start..value.end.max(key.end)
    }

    /// The place of a part of the expression at a path.
    pub(super) fn span_within(&self, path: &str, part: &Range<usize>) -> Range<usize> {
        let span = self.walk(path.split('.')).1;
        match self.text.get(span.clone()).and_then(|written| literal::part_of(written, part)) {
            Some(part) => span.start + part.start..span.start + part.end,
            None => span,
        }
    }

    /// The places of the key and of the value. A table is represented by its header; an entry of a
    /// list has no key.
    fn walk<'p>(&self, path: impl Iterator<Item = &'p str>) -> (Range<usize>, Range<usize>) {
        let (mut table, mut list) = (Some(self.root.get_ref()), None);
        let mut spans = (0..0, 0..0);
        for step in path {
            let found = match (table, list) {
                (Some(table), _) => table
                    .iter()
                    .find(|(key, _)| key.get_ref() == step)
                    .map(|(key, value)| (key.span(), value)),
                (None, Some(list)) => {
                    let list: &DeArray<'_> = list;
                    step.parse()
                        .ok()
                        .and_then(|i: usize| list.get(i))
                        .map(|value| (value.span(), value))
                }
                (None, None) => None,
            };
            let Some((key, value)) = found else { break };
            (table, list) = (None, None);
            spans = (key.clone(), value.span());
            match value.get_ref() {
                DeValue::Table(inner) => (table, spans.1) = (Some(inner), key),
                DeValue::Array(inner) => list = Some(inner),
                _ => {}
            }
        }
        spans
    }
}

/// A part of the schema, and the whole that it refers to.
#[derive(Clone, Copy)]
struct Schema<'s> {
    root: &'s Value,
    at: &'s Value,
}

impl<'s> Schema<'s> {
    /// The schema at a place, with references followed.
    fn of(self, at: &'s Value) -> Self {
        let referred =
            at["$ref"].as_str().and_then(|path| self.root.pointer(path.trim_start_matches('#')));
        Self { root: self.root, at: referred.unwrap_or(at) }
    }

    /// The forms a value may have.
    fn forms(self) -> Vec<Self> {
        match self.at["anyOf"].as_array().or(self.at["oneOf"].as_array()) {
            Some(forms) => forms.iter().flat_map(|form| self.of(form).forms()).collect(),
            None => vec![self],
        }
    }

    /// Whether values of the kind have this form.
    fn is(self, kind: &str) -> bool {
        match &self.at["type"] {
            Value::String(one) => one == kind,
            Value::Array(several) => several.iter().any(|one| one == kind),
            _ => false,
        }
    }

    /// The names of the tables of the whole that have a key.
    fn tables(self, key: &str) -> Vec<String> {
        let properties = |form: Self| form.at["properties"].as_object().into_iter().flatten();
        let inner = |at: &'s Value| self.of(at).forms().into_iter().flat_map(properties);
        let (mut tables, mut inner_tables) = (Vec::new(), Vec::new());
        for (name, at) in properties(Self { root: self.root, at: self.root }) {
            for (entry, at) in inner(at) {
                if entry == key {
                    tables.push(format!("[{name}]"));
                }
                if inner(at).any(|(entry, _)| entry == key) {
                    inner_tables.push(format!("[{name}.{entry}]"));
                }
            }
        }
        tables.append(&mut inner_tables);
        tables
    }

    fn table(self, table: &DeTable<'_>, span: Range<usize>) -> Result<(), SceneError> {
        let at = |key: &Key<'_>, problem| SceneError { problem, span: key.span() };
        if let Some(properties) = self.at["properties"].as_object() {
            // The first problem in the text is reported.
            let mut entries: Vec<_> = table.iter().collect();
            entries.sort_by_key(|(key, _)| key.span().start);
            for (key, value) in entries {
                let Some(inner) = properties.get(&**key.get_ref()) else {
                    let name = key.get_ref().to_string();
                    let (known, tables) =
                        (properties.keys().cloned().collect(), self.tables(&name));
                    return Err(at(key, SceneProblem::UnknownKey { key: name, known, tables }));
                };
                check_value(&self.of(inner).forms(), value)?;
            }
        } else if self.at["additionalProperties"].is_object() {
            let forms = self.of(&self.at["additionalProperties"]).forms();
            table.values().try_for_each(|value| check_value(&forms, value))?;
        }
        let required =
            self.at["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
        match required
            .into_iter()
            .find(|&key| !table.iter().any(|(given, _)| given.get_ref() == key))
        {
            Some(key) => {
                Err(SceneError { problem: SceneProblem::Missing { key: key.into() }, span })
            }
            None => Ok(()),
        }
    }
}

/// Checks a value that has one of the forms. The forms of the entries of a list are found once for
/// all of them: a list may have 100,000 entries.
fn check_value(forms: &[Schema<'_>], value: &Spanned<DeValue<'_>>) -> Result<(), SceneError> {
    let refuse = |problem| Err(SceneError { problem, span: value.span() });
    let expects = |kind: &str| forms.iter().copied().find(|form| form.is(kind));
    let found = match value.get_ref() {
        DeValue::Float(number) => match expects("number") {
            Some(_) if is_number(number.as_str()) => return Ok(()),
            Some(_) => return refuse(SceneProblem::Number { text: number.as_str().into() }),
            None => "a number with a fraction",
        },
        DeValue::Integer(number) => match (expects("number"), expects("integer")) {
            (None, None) => "a number",
            (None, Some(_)) if number.as_str().starts_with('-') => "negative",
            _ => match i64::from_str_radix(number.as_str(), number.radix()) {
                Ok(_) => return Ok(()),
                Err(_) => {
                    let text = number.as_str().into();
                    return refuse(SceneProblem::LargeWhole { text });
                }
            },
        },
        DeValue::String(text) => match expects("string") {
            Some(_) => return word(forms, text, value.span()),
            None if text.trim().parse::<f64>().is_ok() => {
                return refuse(SceneProblem::Quoted { text: text.to_string() });
            }
            None => "text",
        },
        DeValue::Array(entries) => match expects("array") {
            Some(form) => {
                let inner = form.of(&form.at["items"]).forms();
                return entries.iter().try_for_each(|entry| check_value(&inner, entry));
            }
            None => "a list",
        },
        DeValue::Table(table) => match expects("object") {
            Some(form) => return form.table(table, value.span()),
            None => "a table",
        },
        DeValue::Boolean(_) if expects("boolean").is_some() => return Ok(()),
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
    };
    refuse(SceneProblem::Kind { found, expected: expected(forms) })
}

/// The kinds that values of these forms have, in words.
fn expected(forms: &[Schema<'_>]) -> String {
    let names = [
        ("number", "a number"),
        ("integer", "a whole number that is not negative"),
        ("string", "text"),
        ("array", "a list"),
        ("object", "a table"),
        ("boolean", "true or false"),
    ];
    let is_expected = |(kind, _): &&(&str, _)| forms.iter().any(|form| form.is(kind));
    names.iter().filter(is_expected).map(|x| x.1).collect::<Vec<_>>().join(" or ")
}

/// Checks that a text is one of the words that its forms list. A form without a list accepts every
/// text.
fn word(forms: &[Schema<'_>], text: &str, span: Range<usize>) -> Result<(), SceneError> {
    let mut known = Vec::new();
    for form in forms.iter().filter(|form| form.is("string")) {
        let listed = form.at["enum"].as_array().into_iter().flatten();
        let before = known.len();
        known
            .extend(listed.chain([&form.at["const"]]).filter_map(Value::as_str).map(str::to_owned));
        if known.len() == before {
            return Ok(());
        }
    }
    if known.iter().any(|word| word == text) {
        return Ok(());
    }
    Err(SceneError {
        problem: SceneProblem::Unknown { what: "choice", name: text.into(), known },
        span,
    })
}

/// Whether the number is finite in `f64`, and is 0 only if it is written as 0.
fn is_number(text: &str) -> bool {
    let value: f64 = text.parse().unwrap_or(f64::NAN);
    let mantissa = text.split(['e', 'E']).next().unwrap_or(text);
    let zero = !mantissa.contains(|c: char| ('1'..='9').contains(&c));
    value.is_finite() && (value != 0.0 || zero)
}
