//! Functions of (q, p, t) described by expressions, such as those of events.

use super::description::FunctionDescription;
use super::failure::CustomError;
use super::programs::{Builder, Part};
use afterbay_expression::{Kinds, Point};

/// A function of (q, p, t).
#[derive(Debug)]
pub struct CustomFunction {
    part: Part,
    frames: Vec<f64>,
}

impl CustomFunction {
    /// Compiles a description for `dof` degrees of freedom.
    ///
    /// # Errors
    /// [`CustomError`], with the place in the expression.
    pub fn new(description: &FunctionDescription, dof: usize) -> Result<Self, CustomError> {
        let (graph, node) = description.read(dof)?;
        if graph.inputs(node, Kinds::ALL).is_empty() {
            return Err(CustomError::ConstantFunction);
        }
        let mut builder = Builder::new(graph);
        let part = builder.one(&[node])?;
        let Builder { graph, frames, .. } = builder;
        let parameters: Vec<f64> = description.parameters.iter().map(|x| x.1).collect();
        let values = graph.evaluate(&graph.all(&frames), &parameters, &|_| 0.0);
        let frames = frames.iter().map(|node| values.get(node).copied().unwrap_or(0.0)).collect();
        Ok(Self { part, frames })
    }

    /// The value at (q, p, t).
    pub fn value(&self, q: &[f64], p: &[f64], t: f64) -> f64 {
        let point = Point { end: t, ..Point::new(q, p, &[]) };
        let [value] = self.part.program.results(&self.frames[self.part.frame.clone()], &point);
        value
    }
}
