//! Expressions as one graph, in which equal terms are one node.
//!
//! A node's operands come before it, so that every pass is a loop.

use crate::function::Function;
use afterbay_core::Scalar;
use std::collections::{HashMap, HashSet};

/// An expression in a [`Graph`]. It means nothing in another graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node(u32);

/// A number given at evaluation. Degrees of freedom are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Input {
    /// q_j
    Coordinate(u32),
    /// p_j
    Momentum(u32),
    /// v_j = ∂H/∂p_j
    Velocity(u32),
    /// The end of the edge along which a divided difference is taken.
    End,
    /// q_j of one degree of freedom, given apart from the others.
    OwnCoordinate,
    /// p_j of one degree of freedom, given apart from the others.
    OwnMomentum,
}

/// The operation of a node and its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Term {
    /// The bits of an `f64`.
    Constant(u64),
    /// π
    Pi,
    /// The parameter of this index.
    Parameter(u32),
    /// An input.
    Input(Input),
    /// -a
    Negative(Node),
    /// a + b
    Sum(Node, Node),
    /// a - b
    Difference(Node, Node),
    /// a b
    Product(Node, Node),
    /// a/b
    Quotient(Node, Node),
    /// φ(a)
    Of(Function, Node),
    /// φ[a, b] = (φ(b) - φ(a))/(b - a)
    Divided(Function, Node, Node),
    /// The derivative of φ[a, b] by b. Newton's method uses it; it is not differentiated again.
    DividedDerivative(Function, Node, Node),
}

impl Term {
    /// The operands, in order.
    pub fn operands(self) -> impl Iterator<Item = Node> {
        let (a, b) = match self {
            Self::Constant(_) | Self::Pi | Self::Parameter(_) | Self::Input(_) => (None, None),
            Self::Negative(a) | Self::Of(_, a) => (Some(a), None),
            Self::Sum(a, b)
            | Self::Difference(a, b)
            | Self::Product(a, b)
            | Self::Quotient(a, b)
            | Self::Divided(_, a, b)
            | Self::DividedDerivative(_, a, b) => (Some(a), Some(b)),
        };
        a.into_iter().chain(b)
    }
}

/// A set of kinds of inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds(u8);

impl Kinds {
    /// q_j
    pub const COORDINATES: Self = Self(1);
    /// p_j
    pub const MOMENTA: Self = Self(2);
    /// v_j
    pub const VELOCITIES: Self = Self(4);
    /// The end of an edge.
    pub const END: Self = Self(8);
    /// All of them.
    pub const ALL: Self = Self(15);

    /// These kinds except others.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    pub(crate) fn of(input: Input) -> Self {
        match input {
            Input::Coordinate(_) | Input::OwnCoordinate => Self::COORDINATES,
            Input::Momentum(_) | Input::OwnMomentum => Self::MOMENTA,
            Input::Velocity(_) => Self::VELOCITIES,
            Input::End => Self::END,
        }
    }
}

/// Expressions that share their equal terms. Nodes are added and never removed.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    terms: Vec<Term>,
    /// The kinds of inputs each node depends on.
    kinds: Vec<Kinds>,
    places: HashMap<Term, Node>,
}

impl Graph {
    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// The operation of a node.
    ///
    /// # Panics
    /// If the node is of another, larger graph.
    pub fn term(&self, node: Node) -> Term {
        self.terms[node.0 as usize]
    }

    /// Whether the node depends on an input of these kinds.
    pub fn depends(&self, node: Node, kinds: Kinds) -> bool {
        self.kinds[node.0 as usize].meets(kinds)
    }

    /// Whether the node is made of constants and parameters alone.
    pub fn closed(&self, node: Node) -> bool {
        !self.depends(node, Kinds::ALL)
    }

    /// The value of a node that is a constant.
    pub fn constant(&self, node: Node) -> Option<f64> {
        match self.term(node) {
            Term::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Whether the node is the constant 0.
    pub fn is_zero(&self, node: Node) -> bool {
        self.constant(node) == Some(0.0)
    }

    /// The node of that term, if there is one.
    pub(crate) fn find(&self, term: Term) -> Option<Node> {
        self.places.get(&term).copied()
    }

    /// The node of that term, a new one if there is none.
    pub(crate) fn insert(&mut self, term: Term) -> Node {
        if let Some(&node) = self.places.get(&term) {
            return node;
        }
        let kinds = match term {
            Term::Input(input) => Kinds::of(input),
            _ => Kinds(term.operands().fold(0, |kinds, a| kinds | self.kinds[a.0 as usize].0)),
        };
        let node = Node(self.terms.len() as u32);
        self.terms.push(term);
        self.kinds.push(kinds);
        self.places.insert(term, node);
        node
    }

    /// The nodes among `roots` and their operands, at any depth, that depend on these kinds.
    /// Operands come before the nodes they enter.
    pub fn cone(&self, roots: &[Node], kinds: Kinds) -> Vec<Node> {
        self.reach(roots, |x| self.depends(x, kinds))
    }

    /// `roots` and all their operands, at any depth. Operands come before the nodes they enter.
    pub fn all(&self, roots: &[Node]) -> Vec<Node> {
        self.reach(roots, |_| true)
    }

    fn reach(&self, roots: &[Node], keep: impl Fn(Node) -> bool) -> Vec<Node> {
        let mut seen = HashSet::new();
        let mut stack: Vec<Node> = roots.iter().copied().filter(|&x| keep(x)).collect();
        while let Some(node) = stack.pop() {
            if seen.insert(node) {
                stack.extend(self.term(node).operands().filter(|&x| keep(x)));
            }
        }
        let mut nodes: Vec<Node> = seen.into_iter().collect();
        nodes.sort_unstable();
        nodes
    }

    /// The values of `nodes`. Each must stand behind its operands, as [`Graph::all`] orders them.
    ///
    /// # Panics
    /// If a node is a parameter beyond the last of `parameters`.
    pub fn evaluate<T: Scalar>(
        &self,
        nodes: &[Node],
        parameters: &[T],
        input: &dyn Fn(Input) -> T,
    ) -> HashMap<Node, T> {
        let mut values: HashMap<Node, T> = HashMap::with_capacity(nodes.len());
        for &node in nodes {
            let at = |x: Node| values.get(&x).copied().unwrap_or(T::zero());
            let value = match self.term(node) {
                Term::Constant(bits) => T::from_f64(f64::from_bits(bits)),
                Term::Pi => T::from_f64(4.0) * T::one().atan(),
                Term::Parameter(index) => parameters[index as usize],
                Term::Input(of) => input(of),
                Term::Negative(a) => -at(a),
                Term::Sum(a, b) => at(a) + at(b),
                Term::Difference(a, b) => at(a) - at(b),
                Term::Product(a, b) => at(a) * at(b),
                Term::Quotient(a, b) => at(a) / at(b),
                Term::Of(function, a) => function.at(at(a)),
                Term::Divided(function, a, b) => function.divided(at(a), at(b)).value,
                Term::DividedDerivative(function, a, b) => function.divided(at(a), at(b)).slope,
            };
            values.insert(node, value);
        }
        values
    }

    /// The inputs of these kinds that a node depends on, in ascending order.
    pub fn inputs(&self, node: Node, kinds: Kinds) -> Vec<Input> {
        let cone = self.cone(&[node], kinds).into_iter();
        let mut inputs: Vec<Input> = cone
            .filter_map(|x| match self.term(x) {
                Term::Input(input) => Some(input),
                _ => None,
            })
            .collect();
        inputs.sort_unstable();
        inputs
    }

    /// The node with its inputs of these kinds replaced by other nodes.
    pub fn substitute(
        &mut self,
        root: Node,
        kinds: Kinds,
        inputs: impl Fn(&mut Self, Input) -> Node,
    ) -> Node {
        let mut images: HashMap<Node, Node> = HashMap::new();
        for node in self.cone(&[root], kinds) {
            let image = |x: Node| images.get(&x).copied().unwrap_or(x);
            let replaced = match self.term(node) {
                Term::Input(input) => inputs(self, input),
                term => {
                    let [a, b] = pair(term).map(|x| x.map(image));
                    self.rebuild(term, a, b).unwrap_or(node)
                }
            };
            images.insert(node, replaced);
        }
        images.get(&root).copied().unwrap_or(root)
    }

    /// Copies a node to another graph, with its inputs renamed. Expressions that are equal after
    /// that become one node.
    pub fn copy(&self, root: Node, to: &mut Self, rename: impl Fn(Input) -> Input) -> Node {
        let mut images: HashMap<Node, Node> = HashMap::new();
        let mut image = root;
        // The root is the last of all.
        for node in self.all(&[root]) {
            let term = match self.term(node) {
                Term::Input(input) => Term::Input(rename(input)),
                term => term,
            };
            let [a, b] = pair(term).map(|x| x.and_then(|x| images.get(&x).copied()));
            image = to.rebuild(term, a, b).unwrap_or_else(|| to.insert(term));
            images.insert(node, image);
        }
        image
    }

    /// This operation on the operands a and b.
    fn rebuild(&mut self, term: Term, a: Option<Node>, b: Option<Node>) -> Option<Node> {
        Some(match (term, a, b) {
            (Term::Negative(_), Some(a), _) => self.negative(a),
            (Term::Of(function, _), Some(a), _) => self.of(function, a),
            (Term::Sum(..), Some(a), Some(b)) => self.sum(a, b),
            (Term::Difference(..), Some(a), Some(b)) => self.difference(a, b),
            (Term::Product(..), Some(a), Some(b)) => self.product(a, b),
            (Term::Quotient(..), Some(a), Some(b)) => self.quotient(a, b),
            (Term::Divided(function, ..), Some(a), Some(b)) => self.divided(function, a, b),
            (Term::DividedDerivative(function, ..), Some(a), Some(b)) => {
                self.divided_derivative(function, a, b)
            }
            _ => return None,
        })
    }
}

fn pair(term: Term) -> [Option<Node>; 2] {
    let mut operands = term.operands();
    [operands.next(), operands.next()]
}
