//! The most common force of a drive, a cos(ωt + φ) or a sin(ωt + φ), found by its form. Its value
//! is that of its program to rounding, and takes less time.

use afterbay_core::Scalar;
use afterbay_expression::{Function, Graph, Input, Node, Term};

/// The constants of a wave, as nodes or as values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave<X> {
    amplitude: X,
    /// The sine or the cosine.
    function: Function,
    frequency: X,
    phase: Option<X>,
}

impl Wave<Node> {
    /// `root` as a wave in the end of an edge, which is the time of a drive.
    pub(super) fn new(graph: &mut Graph, root: Node) -> Option<Self> {
        if let Term::Negative(wave) = graph.term(root) {
            let wave = Self::new(graph, wave)?;
            return Some(Self { amplitude: graph.negative(wave.amplitude), ..wave });
        }
        let one = graph.number(1.0);
        let (amplitude, wave) = closed_factor(graph, root).unwrap_or((one, root));
        let Term::Of(function @ (Function::Sin | Function::Cos), argument) = graph.term(wave)
        else {
            return None;
        };
        let (turning, phase) = match graph.term(argument) {
            Term::Sum(a, b) if graph.closed(b) => (a, Some(b)),
            Term::Sum(a, b) if graph.closed(a) => (b, Some(a)),
            Term::Difference(a, b) if graph.closed(b) => (a, Some(graph.negative(b))),
            _ => (argument, None),
        };
        let (frequency, time) = closed_factor(graph, turning).unwrap_or((one, turning));
        let is_time = graph.term(time) == Term::Input(Input::End);
        is_time.then_some(Self { amplitude, function, frequency, phase })
    }

    /// The nodes of the constants.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Node> {
        [self.amplitude, self.frequency].into_iter().chain(self.phase)
    }

    /// The wave with the values of its nodes.
    pub(super) fn with<T>(&self, value: impl Fn(&Node) -> T) -> Wave<T> {
        Wave {
            amplitude: value(&self.amplitude),
            function: self.function,
            frequency: value(&self.frequency),
            phase: self.phase.as_ref().map(value),
        }
    }
}

impl<T: Scalar> Wave<T> {
    /// The value at t.
    pub(super) fn at(&self, t: T) -> T {
        let argument = match self.phase {
            Some(phase) => self.frequency.mul_add(t, phase),
            None => self.frequency * t,
        };
        let (sin, cos) = argument.sin_cos();
        self.amplitude * if self.function == Function::Sin { sin } else { cos }
    }
}

/// A product as its closed factor and the other.
fn closed_factor(graph: &Graph, node: Node) -> Option<(Node, Node)> {
    match graph.term(node) {
        Term::Product(a, b) if graph.closed(a) => Some((a, b)),
        Term::Product(a, b) if graph.closed(b) => Some((b, a)),
        _ => None,
    }
}
