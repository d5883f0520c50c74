//! The numbers of a scene that are given by expressions.

use super::document::{Entries, EntriesTable, Expression};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use afterbay_core::{InputError, Quantity};
use afterbay_expression::{ParseError, Problem, evaluate};
use std::collections::BTreeMap;

/// The parameters of a system by name, as numbers.
pub(super) type Parameters = Vec<(String, f64)>;

/// Evaluates the parameters, each after those that it mentions. `count` is the value of n.
pub(super) fn parameters(
    source: &Source<'_>,
    given: &BTreeMap<String, Expression>,
    count: Option<usize>,
) -> Result<Parameters, SceneError> {
    let path = |name: &str| format!("system.parameters.{name}");
    let (mut known, mut texts) = (Parameters::new(), BTreeMap::new());
    for (name, value) in given {
        match value {
            Expression::Number(value) => known.push((name.clone(), *value)),
            Expression::Text(text) => drop(texts.insert(name, text)),
        }
    }
    while let Some((&first, _)) = texts.first_key_value() {
        // Parameters, each of which mentions the next.
        let mut chain = vec![first];
        while let Some(&name) = chain.last() {
            match evaluate(texts[name], &known, count, None) {
                Ok(value) => {
                    known.push((name.clone(), finite(source, &path(name), value)?));
                    texts.remove(name);
                    chain.pop();
                }
                Err(error) => match mentioned(&error, &texts) {
                    None => return Err(located(source, &path(name), error)),
                    Some(other) if chain.contains(&other) => {
                        let (name, span) = (first.clone(), source.span(&path(first)));
                        return Err(SceneError { problem: SceneProblem::Circle { name }, span });
                    }
                    Some(other) => chain.push(other),
                },
            }
        }
    }
    Ok(known)
}

/// The parameter that an expression mentions and that has no value yet.
fn mentioned<'a>(error: &ParseError, texts: &BTreeMap<&'a String, &String>) -> Option<&'a String> {
    let Problem::Unknown { name, .. } = &error.problem else { return None };
    texts.get_key_value(name).map(|(&name, _)| name)
}

/// Evaluates the entries of q or p for `dof` degrees of freedom.
pub(super) fn entries(
    source: &Source<'_>,
    path: &str,
    quantity: Quantity,
    given: &Entries,
    (known, dof): (&Parameters, usize),
    set_by: &str,
) -> Result<Vec<f64>, SceneError> {
    if let Some(found) = given.count().filter(|&found| found != dof) {
        let error = InputError::Length { quantity, expected: dof, found };
        let problem = SceneProblem::Length { error, set_by: set_by.to_owned() };
        return Err(SceneError { problem, span: source.span(path) });
    }
    let number = |path: &str, value: &Expression, i: usize| match value {
        Expression::Number(value) => Ok(*value),
        Expression::Text(text) => evaluate(text, known, Some(dof), Some(i))
            .map_err(|error| located(source, path, error))
            .and_then(|value| finite(source, path, value)),
    };
    let by_rule =
        |path: &str, rule: &Expression| (1..=dof).map(|i| number(path, rule, i)).collect();
    match given {
        Entries::List(list) => list
            .iter()
            .enumerate()
            .map(|(j, value)| number(&format!("{path}.{j}"), value, j + 1))
            .collect(),
        Entries::Table(EntriesTable { value: Some(value), .. }) => {
            by_rule(&format!("{path}.value"), value)
        }
        Entries::Table(_) => {
            let problem = SceneProblem::Missing { key: "value".into() };
            Err(SceneError { problem, span: source.span(path) })
        }
        Entries::Rule(rule) => by_rule(path, rule),
    }
}

fn finite(source: &Source<'_>, path: &str, value: f64) -> Result<f64, SceneError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(SceneError { problem: SceneProblem::NotFinite { value }, span: source.span(path) })
}

fn located(source: &Source<'_>, path: &str, error: ParseError) -> SceneError {
    let span = source.span_within(path, &error.span);
    SceneError { problem: SceneProblem::Expression(error.problem), span }
}
