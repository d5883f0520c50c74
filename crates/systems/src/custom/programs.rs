//! Programs of one graph, with their frames in one array.

use super::failure::{CustomError, Place};
use afterbay_core::Scalar;
use afterbay_expression::{
    BLOCK, Graph, Node, Point, Program, REGISTERS, TooManyRegisters, is_wide,
};
use std::array::from_fn;
use std::ops::Range;

/// The largest number of nodes of the graph, of instructions of all programs, and of second
/// derivatives. A choice, to bound memory.
const LARGEST_SIZE: usize = 1 << 20;

/// A program and the range of its frame among all frames.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) program: Program,
    pub(super) frame: Range<usize>,
}

/// Runs programs at `count` points, up to eight together unless numbers are wide. Calls `give` with
/// the point, and the index and the value of each result.
pub(super) fn run_at<'a, T: Scalar>(
    parts: &[Part],
    frames: &[T],
    count: usize,
    point: impl Fn(usize) -> Point<'a, T>,
    mut give: impl FnMut(usize, u32, T),
) {
    for Part { program, frame } in parts {
        let frame = &frames[frame.clone()];
        let mut first = 0;
        while first < count {
            let left = first..count;
            // Sines and other functions are computed one by one, also at a point that is repeated.
            first += if const { is_wide::<T>() } || left.len() <= 2 {
                program.run(frame, &point(first), |index, x| give(first, index, x));
                1
            } else if left.len() <= 5 {
                run_together::<T, 4>(program, frame, left, &point, &mut give)
            } else {
                run_together::<T, 8>(program, frame, left, &point, &mut give)
            };
        }
    }
}

/// Runs a program at the first P of the points that are left, and returns P. If fewer are left, the
/// last one is repeated.
#[inline(always)]
fn run_together<'a, T: Scalar, const P: usize>(
    program: &Program,
    frame: &[T],
    left: Range<usize>,
    point: impl Fn(usize) -> Point<'a, T>,
    mut give: impl FnMut(usize, u32, T),
) -> usize {
    let points: [_; P] = from_fn(|i| point((left.start + i).min(left.end - 1)));
    program.run_at(frame, &points, |index, values| {
        left.clone().zip(values).for_each(|(i, x)| give(i, index, x));
    });
    P
}

/// Programs in the making, of one graph.
pub(super) struct Builder {
    pub(super) graph: Graph,
    /// The frames of all programs, one after another.
    pub(super) frames: Vec<Node>,
    pub(super) instructions: usize,
}

impl Builder {
    pub(super) fn new(graph: Graph) -> Self {
        Self { graph, frames: Vec::new(), instructions: 0 }
    }

    /// Whether all sizes are within their limits.
    pub(super) fn fits(&self, second: usize) -> Result<(), CustomError> {
        let counts = [
            ("terms", self.graph.len()),
            ("instructions", self.instructions),
            ("second derivatives", second),
        ];
        for (what, count) in counts {
            if count > LARGEST_SIZE {
                return Err(CustomError::TooLarge { what, count, limit: LARGEST_SIZE });
            }
        }
        Ok(())
    }

    /// A program with its frame behind those of the others.
    pub(super) fn part(&mut self, program: Program) -> Part {
        self.instructions += program.size();
        let start = self.frames.len();
        self.frames.extend_from_slice(program.frame_nodes());
        let zero = self.graph.number(0.0);
        self.frames.resize(start + program.frame_nodes().len().next_multiple_of(BLOCK), zero);
        Part { program, frame: start..self.frames.len() }
    }

    /// The program of a few results.
    pub(super) fn one(&mut self, results: &[Node]) -> Result<Part, CustomError> {
        let program = Program::new(&self.graph, results).map_err(crowded)?;
        let part = self.part(program);
        self.fits(0)?;
        Ok(part)
    }

    /// The parts of some nodes that can be singular and depend on coordinates alone.
    pub(super) fn singular(&mut self, nodes: &[Node]) -> Result<Vec<Part>, CustomError> {
        let mut parts: Vec<Node> = Vec::new();
        for &node in nodes {
            parts.extend(self.graph.singular_parts(node));
        }
        parts.sort_unstable();
        parts.dedup();
        parts.into_iter().map(|part| self.one(&[part])).collect()
    }

    /// The programs of many results, which give each with its index.
    pub(super) fn many(&mut self, results: &[Node]) -> Result<Vec<Part>, CustomError> {
        let numbered: Vec<_> = (0..).zip(results.iter().copied()).collect();
        let programs = Program::many(&self.graph, &numbered).map_err(crowded)?;
        let parts = programs.into_iter().map(|program| self.part(program)).collect();
        self.fits(0)?;
        Ok(parts)
    }
}

/// The nodes that depend on parameters alone, in order of evaluation: those of `evaluated`, which
/// do, and the parts of other fields and of each place that do. Such parts of D decide its sign.
pub(super) fn closed(
    graph: &Graph,
    mut evaluated: Vec<Node>,
    fields: &[Node],
    places: &[(Place, Node, Range<usize>)],
) -> Vec<Node> {
    let parts = graph.all(fields).into_iter().chain(places.iter().map(|x| x.1));
    evaluated.extend(parts.filter(|&x| graph.closed(x)));
    graph.all(&evaluated)
}

pub(super) fn crowded(_: TooManyRegisters) -> CustomError {
    CustomError::TooLarge { what: "values needed at once", count: REGISTERS + 1, limit: REGISTERS }
}
