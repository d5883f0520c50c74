//! The description of a function of (q, p, t) and how it is parsed.

use super::super::failure::{CustomError, Place};
use super::reader::{Reader, Rules};
use afterbay_expression::{Graph, Node};

/// A function of (q, p, t), as the text of an expression in q1, .., p1, .., t and parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FunctionDescription {
    /// The expression.
    pub text: String,
    /// The names and values of parameters. They need not be used.
    pub parameters: Vec<(String, f64)>,
    /// Names of expressions in the parameters and in each other.
    pub definitions: Vec<(String, String)>,
}

impl FunctionDescription {
    pub(crate) fn read(&self, dof: usize) -> Result<(Graph, Node), CustomError> {
        let mut reader = Reader::new(&self.parameters, &self.definitions, Some(dof))?;
        let rule = Err("an event is a function of coordinates, momenta, t and parameters");
        let rules = Rules { dof: Some(dof), velocities: rule, ..Rules::ALL };
        let node = reader.read(Place::Function, &self.text, rules)?.0;
        Ok((reader.graph, node))
    }
}
