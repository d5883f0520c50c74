//! Compilation of nodes to a program. Products are fused with the sums they enter, and a register
//! is reused once its value is no longer needed.

use crate::graph::{Graph, Kinds, Node, Term};
use crate::program::{Instruction, Program, REGISTERS, Register, SMALL, TooManyRegisters};
use std::collections::{HashMap, HashSet};

/// The largest number of inputs that are all loaded at the start of a run.
const PRELOADED: usize = 8;

impl Program {
    /// The program of a few results, which [`Program::results`] reads at the end of a run.
    ///
    /// # Errors
    /// [`TooManyRegisters`]
    pub fn new(graph: &Graph, results: &[Node]) -> Result<Self, TooManyRegisters> {
        compile(graph, results, &[])
    }

    /// Programs of many results, each with an index. [`Program::run`] passes a result on as soon as
    /// it is computed. Results that need too many registers together are spread over several
    /// programs. There is no program of no results.
    ///
    /// # Errors
    /// [`TooManyRegisters`], if a single result needs more than there are.
    pub fn many(graph: &Graph, results: &[(u32, Node)]) -> Result<Vec<Self>, TooManyRegisters> {
        let (mut programs, mut stack) = (Vec::new(), Vec::new());
        if !results.is_empty() {
            stack.push(results);
        }
        while let Some(part) = stack.pop() {
            match compile(graph, &[], part) {
                Ok(program) => programs.push(program),
                Err(TooManyRegisters) if part.len() > 1 => {
                    let (first, second) = part.split_at(part.len() / 2);
                    stack.extend([second, first]);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(programs)
    }
}

/// A pending instruction: a term, or a product with the sum it enters.
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

    /// Its instruction. It has none if the value is in the frame, or if the instruction of a
    /// divided difference, which comes before, has computed it.
    fn instruction(
        self,
        to: Register,
        derivative: Option<Register>,
        [a, b, c]: [Register; 3],
    ) -> Option<Instruction> {
        let term = match self {
            Self::ProductSum(..) => return Some(Instruction::ProductSum { to, a, b, c }),
            Self::ProductDifference(..) => {
                return Some(Instruction::ProductDifference { to, a, b, c });
            }
            Self::DividedDerivative(_) => return None,
            Self::Term(term) => term,
        };
        Some(match term {
            Term::Divided(function, ..) => Instruction::Divided { function, to, derivative, a, b },
            Term::Input(input) => Instruction::Load { to, input },
            Term::Negative(_) => Instruction::Negative { to, a },
            Term::Sum(..) => Instruction::Sum { to, a, b },
            Term::Difference(..) => Instruction::Difference { to, a, b },
            Term::Product(..) => Instruction::Product { to, a, b },
            Term::Quotient(..) => Instruction::Quotient { to, a, b },
            Term::Of(function, _) => Instruction::Of { function, to, a },
            Term::Constant(_) | Term::Pi | Term::Parameter(_) | Term::DividedDerivative(..) => {
                return None;
            }
        })
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
/// large one first computes the operand that takes most registers, so that few registers are in
/// use.
fn compile(
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
    let compiler = Compiler::new(graph, &roots, few_registers);
    let order = compiler.order(&roots);
    let (mut frame, mut inputs) = (Vec::new(), Vec::new());
    for &node in &order {
        match graph.term(node) {
            Term::Input(input) => inputs.push((node, input)),
            _ if graph.closed(node) => frame.push(node),
            _ => {}
        }
    }
    if inputs.len() > PRELOADED {
        inputs.clear();
    }
    let mut emitter = Emitter::new(&compiler, &order, results, given);
    for &node in frame.iter().chain(inputs.iter().map(|(node, _)| node)) {
        emitter.load(node)?;
    }
    for (time, &node) in order.iter().enumerate() {
        emitter.compute(time, node)?;
    }
    let Emitter { bank, code, .. } = emitter;
    Ok(Program {
        inputs: inputs.into_iter().map(|(_, input)| input).collect(),
        frame: frame.into(),
        code: code.into(),
        results: results.iter().filter_map(|x| bank.places.get(x).copied()).collect(),
        registers: bank.count,
    })
}

impl<'a> Compiler<'a> {
    fn new(graph: &'a Graph, roots: &[Node], few_registers: bool) -> Self {
        let mut uses = HashMap::new();
        let cone = graph.cone(roots, Kinds::ALL);
        for &node in &cone {
            graph.term(node).operands().for_each(|x| *uses.entry(x).or_insert(0) += 1);
        }
        // A result keeps a register of its own and is not fused into a sum.
        roots.iter().for_each(|&x| *uses.entry(x).or_insert(0) += 2);
        let mut compiler = Self { graph, uses, registers: HashMap::new() };
        for node in cone.into_iter().filter(|_| few_registers) {
            let registers = compiler.count_registers(node);
            compiler.registers.insert(node, registers);
        }
        compiler
    }

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

/// Writes instructions one after another, at times 0, 1, 2, ..., and assigns their registers.
struct Emitter<'a> {
    compiler: &'a Compiler<'a>,
    /// The indices under which a node is given.
    indices: HashMap<Node, Vec<u32>>,
    /// The last time at which each value is an operand, or the end for results.
    last_use: HashMap<Node, usize>,
    bank: Bank,
    code: Vec<Instruction>,
}

impl<'a> Emitter<'a> {
    fn new(
        compiler: &'a Compiler<'a>,
        order: &[Node],
        results: &[Node],
        given: &[(u32, Node)],
    ) -> Self {
        let mut last_use = HashMap::new();
        for (time, &node) in order.iter().enumerate() {
            let is_input = matches!(compiler.graph.term(node), Term::Input(_));
            if !is_input && !compiler.graph.closed(node) {
                last_use.extend(compiler.operation(node).operands().map(|x| (x, time)));
            }
        }
        last_use.extend(results.iter().map(|&x| (x, order.len())));
        let mut indices: HashMap<Node, Vec<u32>> = HashMap::new();
        given.iter().for_each(|&(index, x)| indices.entry(x).or_default().push(index));
        let bank = Bank { places: HashMap::new(), free: Vec::new(), count: 0 };
        Self { compiler, indices, last_use, bank, code: Vec::new() }
    }

    /// Assigns a register to a node that is loaded before the program runs.
    fn load(&mut self, node: Node) -> Result<(), TooManyRegisters> {
        let at = self.bank.take(node)?;
        self.give(node, at);
        Ok(())
    }

    fn give(&mut self, node: Node, a: Register) {
        let indices = self.indices.get(&node).into_iter().flatten();
        self.code.extend(indices.map(|&index| Instruction::Give { index, a }));
    }

    /// Writes the instruction of a node, unless an earlier one or the frame has its value.
    fn compute(&mut self, time: usize, node: Node) -> Result<(), TooManyRegisters> {
        let operation = self.compiler.operation(node);
        let computed = self.bank.places.get(&node).copied();
        if computed.is_some() && !matches!(operation, Operation::DividedDerivative(_)) {
            return Ok(());
        }
        let operands = self.last_operands(time, operation);
        if let Some(at) = computed {
            self.give(node, at);
            return Ok(());
        }
        let to = self.bank.take(node)?;
        let derivative = self.compiler.divided_derivative(node);
        let derivative = derivative.map(|derivative| self.bank.take(derivative)).transpose()?;
        let Some(instruction) = operation.instruction(to, derivative, operands) else {
            return Ok(());
        };
        self.code.push(instruction);
        self.give(node, to);
        // A result that was given and is no operand.
        if !self.last_use.contains_key(&node) {
            self.bank.release(node);
        }
        Ok(())
    }

    /// The registers of the operands. Those that are needed for the last time become free.
    fn last_operands(&mut self, time: usize, operation: Operation) -> [Register; 3] {
        let held = operation.operands().filter_map(|x| Some((x, *self.bank.places.get(&x)?)));
        let held: Vec<(Node, Register)> = held.collect();
        for (x, _) in &held {
            if self.last_use.get(x) == Some(&time) {
                self.bank.release(*x);
            }
        }
        [0, 1, 2].map(|k| held.get(k).map_or(0, |x| x.1))
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

    fn release(&mut self, node: Node) {
        self.free.extend(self.places.remove(&node));
    }
}
