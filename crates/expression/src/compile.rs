//! Compilation of nodes to a program. Products are fused with the sums they enter, and a register
//! is reused once its value is no longer needed.

use crate::graph::{Graph, Kinds, Node, Term};
use crate::program::{Instruction, Program, REGISTERS, Register, TooManyRegisters};
use std::collections::{HashMap, HashSet};

/// The number of registers of a small program.
pub(super) const SMALL: usize = 16;
/// The largest number of inputs that are all loaded at the start of a run.
const PRELOADED: usize = 8;

/// One instruction to be: a term, or a product with the sum it enters.
#[derive(Clone, Copy)]
enum Operation {
    Term(Term),
    ProductSum(Node, Node, Node),
    ProductDifference(Node, Node, Node),
    /// The derivative of this divided difference. The same instruction computes both.
    DividedDerivative(Node),
}

impl Operation {
    fn operands(self) -> impl Iterator<Item = Node> {
        let (term, fused, with) = match self {
            Self::Term(term) => (Some(term), None, None),
            Self::ProductSum(a, b, c) | Self::ProductDifference(a, b, c) => {
                (None, Some([a, b, c]), None)
            }
            Self::DividedDerivative(divided) => (None, None, Some(divided)),
        };
        term.into_iter().flat_map(Term::operands).chain(fused.into_iter().flatten()).chain(with)
    }
}

struct Compiler<'a> {
    graph: &'a Graph,
    /// The number of nodes of the program that have this node as an operand; results count twice
    /// more.
    uses: HashMap<Node, u32>,
    /// The number of registers that a node takes to compute; empty if operands are computed in the
    /// order of the text.
    registers: HashMap<Node, usize>,
}

/// The program that keeps `results` in registers to the end and gives each of `given` with its
/// index as soon as it is computed.
///
/// A small program computes operands in the order of the text, which was measured to be faster. A
/// large one computes first what takes most registers, so that few values wait.
pub(super) fn compile(
    graph: &Graph,
    results: &[Node],
    given: &[(u32, Node)],
) -> Result<Program, TooManyRegisters> {
    match compile_in_order(graph, results, given, false) {
        Ok(program) if program.registers <= SMALL => Ok(program),
        _ => compile_in_order(graph, results, given, true),
    }
}

fn compile_in_order(
    graph: &Graph,
    results: &[Node],
    given: &[(u32, Node)],
    few_registers: bool,
) -> Result<Program, TooManyRegisters> {
    let roots: Vec<Node> = results.iter().copied().chain(given.iter().map(|x| x.1)).collect();
    let mut uses = HashMap::new();
    let cone = graph.cone(&roots, Kinds::ALL);
    for &node in &cone {
        graph.term(node).operands().for_each(|x| *uses.entry(x).or_insert(0) += 1);
    }
    // A result keeps a register of its own and is not fused into a sum.
    roots.iter().for_each(|&x| *uses.entry(x).or_insert(0) += 2);
    let mut compiler = Compiler { graph, uses, registers: HashMap::new() };
    for node in cone.into_iter().filter(|_| few_registers) {
        let registers = compiler.count_registers(node);
        compiler.registers.insert(node, registers);
    }
    let order = compiler.order(&roots);

    // The frame, the inputs, and the last time each value is needed.
    let (mut frame, mut inputs, mut last) = (Vec::new(), Vec::new(), HashMap::new());
    for (time, &node) in order.iter().enumerate() {
        match graph.term(node) {
            Term::Input(_) => inputs.push(node),
            _ if graph.closed(node) => frame.push(node),
            _ => last.extend(compiler.operation(node).operands().map(|x| (x, time))),
        }
    }
    last.extend(results.iter().map(|&x| (x, order.len())));
    let preloaded =
        if inputs.len() <= PRELOADED { std::mem::take(&mut inputs) } else { Vec::new() };
    let mut wanted: HashMap<Node, Vec<u32>> = HashMap::new();
    given.iter().for_each(|&(index, x)| wanted.entry(x).or_default().push(index));

    let mut bank = Bank { places: HashMap::new(), free: Vec::new(), count: 0 };
    let mut code = Vec::new();
    let give = |code: &mut Vec<Instruction>, node: Node, a: Register| {
        let indices = wanted.get(&node).into_iter().flatten();
        code.extend(indices.map(|&index| Instruction::Give { index, a }));
    };
    for &node in frame.iter().chain(&preloaded) {
        let at = bank.take(node)?;
        give(&mut code, node, at);
    }
    for (time, &node) in order.iter().enumerate() {
        let operation = compiler.operation(node);
        let computed = bank.places.get(&node).copied();
        if computed.is_some() && !matches!(operation, Operation::DividedDerivative(_)) {
            continue;
        }
        let operands: Vec<(Node, Register)> =
            operation.operands().filter_map(|x| Some((x, *bank.places.get(&x)?))).collect();
        for &(x, at) in &operands {
            if last.get(&x) == Some(&time) && bank.places.remove(&x).is_some() {
                bank.free.push(at);
            }
        }
        if let Some(at) = computed {
            give(&mut code, node, at);
            continue;
        }
        let to = bank.take(node)?;
        let derivative = compiler
            .divided_derivative(node)
            .map(|derivative| bank.take(derivative))
            .transpose()?;
        let at = |k: usize| operands.get(k).map_or(0, |x| x.1);
        let (a, b, c) = (at(0), at(1), at(2));
        code.push(match operation {
            Operation::ProductSum(..) => Instruction::ProductSum { to, a, b, c },
            Operation::ProductDifference(..) => Instruction::ProductDifference { to, a, b, c },
            // The instruction of the divided difference, which comes before, has computed it.
            Operation::DividedDerivative(_) => continue,
            Operation::Term(term) => match term {
                Term::Divided(function, ..) => {
                    Instruction::Divided { function, to, derivative, a, b }
                }
                Term::Input(input) => Instruction::Load { to, input },
                Term::Negative(_) => Instruction::Negative { to, a },
                Term::Sum(..) => Instruction::Sum { to, a, b },
                Term::Difference(..) => Instruction::Difference { to, a, b },
                Term::Product(..) => Instruction::Product { to, a, b },
                Term::Quotient(..) => Instruction::Quotient { to, a, b },
                Term::Of(function, _) => Instruction::Of { function, to, a },
                // In the frame.
                Term::Constant(_) | Term::Pi | Term::Parameter(_) | Term::DividedDerivative(..) => {
                    continue;
                }
            },
        });
        give(&mut code, node, to);
        // A result that was given and is no operand.
        if !last.contains_key(&node) && bank.places.remove(&node).is_some() {
            bank.free.push(to);
        }
    }
    let inputs = preloaded.iter().filter_map(|&x| match graph.term(x) {
        Term::Input(input) => Some(input),
        _ => None,
    });
    let results = results.iter().filter_map(|x| bank.places.get(x).copied()).collect();
    Ok(Program {
        inputs: inputs.collect(),
        frame: frame.into(),
        code: code.into(),
        results,
        registers: bank.count,
    })
}

impl Compiler<'_> {
    /// The operation of a node. A product that enters one sum only is fused with it.
    fn operation(&self, node: Node) -> Operation {
        let fused = |x: Node| match self.graph.term(x) {
            Term::Product(a, b) if self.uses.get(&x) == Some(&1) && !self.graph.closed(x) => {
                Some((a, b))
            }
            _ => None,
        };
        match self.graph.term(node) {
            Term::Sum(x, y) => match (fused(x), fused(y)) {
                (_, Some((a, b))) => Operation::ProductSum(a, b, x),
                (Some((a, b)), None) => Operation::ProductSum(a, b, y),
                (None, None) => Operation::Term(Term::Sum(x, y)),
            },
            Term::Difference(x, y) => match fused(y) {
                Some((a, b)) => Operation::ProductDifference(a, b, x),
                None => Operation::Term(Term::Difference(x, y)),
            },
            Term::DividedDerivative(function, a, b) => {
                match self.graph.find(Term::Divided(function, a, b)) {
                    Some(divided) => Operation::DividedDerivative(divided),
                    None => Operation::Term(self.graph.term(node)),
                }
            }
            term => Operation::Term(term),
        }
    }

    /// The derivative of a divided difference, if the program uses it.
    fn divided_derivative(&self, node: Node) -> Option<Node> {
        let Term::Divided(function, a, b) = self.graph.term(node) else { return None };
        self.graph
            .find(Term::DividedDerivative(function, a, b))
            .filter(|derivative| self.uses.contains_key(derivative))
    }

    /// The operands of a node, those that take most registers last.
    fn operands(&self, node: Node) -> Vec<Node> {
        let mut operands: Vec<Node> = self.operation(node).operands().collect();
        operands.sort_by_key(|x| self.registers.get(x).copied().unwrap_or(1));
        operands
    }

    /// The number of registers that a node takes if its operands are computed in the best order,
    /// by R. Sethi and J. D. Ullman, J. ACM 17 (1970) 715-728. Shared nodes count each time.
    fn count_registers(&self, node: Node) -> usize {
        let needs = self.operands(node).into_iter().rev();
        let needs = needs.map(|x| self.registers.get(&x).copied().unwrap_or(1));
        needs.enumerate().map(|(held, needed)| held + needed).max().unwrap_or(1)
    }

    /// All nodes of the program, operands before the nodes they enter and close to them. Closed
    /// nodes are in the frame, so that their operands are left out.
    fn order(&self, roots: &[Node]) -> Vec<Node> {
        let (mut order, mut seen) = (Vec::new(), HashSet::new());
        for &root in roots {
            let mut stack = vec![(root, false)];
            while let Some((node, ready)) = stack.pop() {
                if ready {
                    order.push(node);
                } else if seen.insert(node) {
                    stack.push((node, true));
                    if !self.graph.closed(node) {
                        stack.extend(self.operands(node).into_iter().map(|x| (x, false)));
                    }
                }
            }
        }
        order
    }
}

/// The registers in use.
struct Bank {
    places: HashMap<Node, Register>,
    free: Vec<Register>,
    count: usize,
}

impl Bank {
    fn take(&mut self, node: Node) -> Result<Register, TooManyRegisters> {
        let register = match self.free.pop() {
            Some(register) => register,
            None if self.count < REGISTERS => {
                self.count += 1;
                (self.count - 1) as Register
            }
            None => return Err(TooManyRegisters),
        };
        self.places.insert(node, register);
        Ok(register)
    }
}
