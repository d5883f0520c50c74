//! The table of the system, and its expressions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A built-in system by name, or a custom one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SystemTable {
    /// One of `afterbay list systems`, or "custom".
    pub name: String,
    /// The values of its parameters: numbers, or expressions in other parameters such as
    /// "sqrt(k/m)". A parameter given as an expression follows those that it mentions.
    #[serde(default)]
    pub parameters: BTreeMap<String, Expression>,
    /// Custom: V(q, t), an expression in q1, q2, .., t and the parameters. H = Σ p_j²/(2 m_j) + V.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub potential: Option<Expression>,
    /// Custom, instead of `potential` and `mass`: H(q, p), an expression in q1, q2, .., p1, p2, ..
    /// and the parameters. Methods for a separable H refuse it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hamiltonian: Option<Expression>,
    /// Custom: the dissipative forces D_j(q, p, v), one for each degree of freedom, or one rule for
    /// all of them, in which i is the number of the degree of freedom: "c*p[i]". The velocities v1,
    /// v2, .. are ∂H/∂p_j.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dissipation: Option<PerDegree>,
    /// Custom, instead of `dissipation`: the rows of R(q, p) in D = R v with v_j = ∂H/∂p_j. Where R
    /// is constant and positive semidefinite the system is passive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Vec<Vec<Expression>>>,
    /// Custom: the masses, one for each degree of freedom, or one rule for all of them. All are 1
    /// if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<PerDegree>,
}

impl SystemTable {
    /// The expressions of a custom system, each with its name.
    pub fn expressions(&self) -> Vec<(String, String)> {
        let mut all = Vec::new();
        let numbered =
            |name: &str, given: Option<&PerDegree>| given.map_or(Vec::new(), |all| all.named(name));
        all.extend(self.potential.iter().map(|text| ("V".into(), text.text())));
        all.extend(self.hamiltonian.iter().map(|text| ("H".into(), text.text())));
        all.extend(numbered("D", self.dissipation.as_ref()));
        for (i, row) in self.friction.iter().flatten().enumerate() {
            let row = row.iter().enumerate();
            all.extend(row.map(|(j, text)| (format!("R{}{}", i + 1, j + 1), text.text())));
        }
        all.extend(numbered("m", self.mass.as_ref()));
        all
    }
}

/// An expression such as "c*p1", or a number.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// An expression.
    Text(String),
}

impl Expression {
    /// The expression as text.
    pub fn text(&self) -> String {
        match self {
            Self::Number(value) => format!("{value:?}"),
            Self::Text(text) => text.clone(),
        }
    }
}

/// Expressions, one for each degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PerDegree {
    /// One after another.
    List(Vec<Expression>),
    /// One rule for all, in which i is the number of the degree of freedom.
    Rule(Expression),
}

impl PerDegree {
    /// The expressions, each with its name: that of all and its number.
    pub(crate) fn named(&self, name: &str) -> Vec<(String, String)> {
        match self {
            Self::Rule(rule) => vec![(format!("{name}_i"), rule.text())],
            Self::List(list) => {
                let list = list.iter().enumerate();
                list.map(|(j, text)| (format!("{name}{}", j + 1), text.text())).collect()
            }
        }
    }
}
