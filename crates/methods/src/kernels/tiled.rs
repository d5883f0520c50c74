//! Coloured sweeps of a chain or a ring of equal members, eight members at a time.
//!
//! Members of one colour are not coupled, so a colour is updated in lanes and by any number of
//! threads. The coordinates are cut into tiles that fit the L1 cache. Each change of colour
//! invalidates one more member at each end of a tile. A tile is therefore loaded with one neighbour
//! more than there are changes of colour on either side, takes several steps alone and writes back
//! its own members. Memory is read and written once in up to eight steps; the work repeated beyond
//! the ends is up to 3 % of a tile. The tiles do not depend on the number of threads and a lane
//! computes the same numbers as a single member, so the results are equal to the bit for any number
//! of threads and of steps taken at once. If a step fails, the steps are repeated one by one from
//! the state before.
//!
//! [`Effort`] counts all evaluations, including those beyond the ends and those of unused lanes.

use super::tile::{TILE, Tile};
use super::{Composition, advance};
use afterbay_core::solver::{Equation, Newton, Root, Solver};
use afterbay_core::{
    Coupling, Effort, EndMembers, InputError, Method, Scalar, Separable, State, StepFailure,
    Uniform, f64x8, validate,
};
use bytemuck::{bytes_of, pod_read_unaligned};
use rayon::prelude::*;
use std::array::from_fn;
use std::sync::Arc;

/// The number of members updated at a time.
const LANES: usize = 8;

/// The largest number of steps a tile takes at once.
const MOST_STEPS: usize = 8;
/// The largest number of changes of colour in these steps, unless a single step has more. As many
/// members are computed redundantly with those of a tile.
const REDONE: usize = TILE / 32;

/// The coordinate-increment discrete gradient with red-black sweeps ([`Coupling::coloured`]),
/// vectorised.
#[derive(Clone, Debug)]
pub struct Tiled {
    composition: Composition,
    threads: usize,
}

impl Tiled {
    /// Uses `composition` on one thread.
    pub fn new(composition: Composition) -> Self {
        Self { composition, threads: 1 }
    }

    /// Uses up to `threads` threads of the current pool.
    pub fn on_threads(self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self }
    }

    /// Checks that the members of the system can be coloured with two colours that are updated in
    /// turn.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] with the reason.
    pub fn fits<S: Uniform + ?Sized>(system: &S) -> Result<(), InputError> {
        let why = match system.coupling() {
            Coupling::Dense => "colours are for chains and rings",
            ref coupling if !coupling.two_coloured(system.dof()) => {
                "a ring of two colours has an even number of members"
            }
            _ if system.dissipation_form().coupled => {
                "friction that couples momenta acts on one at a time"
            }
            _ => return system.lanes().map(|_| ()),
        };
        Err(InputError::Unsupported { method: "increment", why })
    }
}

/// The system in lanes, the ends of a chain, the new state, a tile for each thread, and the number
/// of steps the tiles have room for.
#[derive(Clone)]
pub struct Workspace<L> {
    lanes: L,
    ends: Option<EndMembers>,
    new: [Vec<f64>; 3],
    tiles: Vec<Tile>,
    most: usize,
}

impl<S> Method<Vec<f64>, S> for Tiled
where
    S: Uniform + ?Sized,
{
    type Workspace = Workspace<Arc<S::Lanes>>;

    fn workspace(&self, system: &S) -> Result<Workspace<Arc<S::Lanes>>, InputError> {
        validate::masses(system)?;
        Self::fits(system)?;
        let n = system.dof();
        // A lane uses the mass of one member for all eight. Unequal masses would not conserve K.
        if (1..n).any(|j| system.mass(j) != system.mass(0)) {
            let why = "members updated side by side must have equal masses";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        let sweeps = self.composition.sweeps().next_multiple_of(2);
        let most = (REDONE / sweeps).clamp(1, MOST_STEPS);
        let tile = Tile::new(n, system.coupling() == Coupling::Ring, most * sweeps);
        let threads = self.threads.min(rayon::current_num_threads()).min(n.div_ceil(TILE)).max(1);
        Ok(Workspace {
            lanes: Arc::new(system.lanes()?),
            ends: system.ends(),
            new: [0; 3].map(|_| vec![0.0; n]),
            tiles: vec![tile; threads],
            most,
        })
    }

    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: f64,
        state: &mut State<Vec<f64>>,
        workspace: &mut Workspace<Arc<S::Lanes>>,
    ) -> Result<Effort, StepFailure> {
        self.burst(system, h, 1, state, workspace)
    }

    fn steps(
        &self,
        system: &S,
        h: f64,
        count: u64,
        state: &mut State<Vec<f64>>,
        workspace: &mut Workspace<Arc<S::Lanes>>,
    ) -> Result<Effort, (u64, StepFailure)> {
        let (mut effort, mut done) = (Effort::default(), 0);
        let mut most = workspace.most;
        while done < count {
            let burst = usize::try_from(count - done).map_or(most, |left| left.min(most));
            match self.burst(system, h, burst, state, workspace) {
                Ok(spent) => {
                    effort += spent;
                    done += burst as u64;
                }
                Err(failure) if burst == 1 => return Err((done, failure)),
                // The steps are repeated one by one to find the first that fails. The state is
                // unchanged.
                Err(_) => most = 1,
            }
        }
        Ok(effort)
    }
}

impl Tiled {
    /// Takes several steps at once. If one fails, the state stays as it was before all of them.
    fn burst<S: Uniform + ?Sized>(
        &self,
        system: &S,
        h: f64,
        count: usize,
        state: &mut State<Vec<f64>>,
        workspace: &mut Workspace<Arc<S::Lanes>>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { lanes, ends, new, tiles, .. } = workspace;
        let n = state.q.len();
        let dissipative = !system.dissipation_form().zero;
        let ends = ends.as_ref();
        let steps = Steps { system, lanes, ends, h, count, dissipative, old: state };
        let share = n.div_ceil(TILE).div_ceil(tiles.len()) * TILE;
        let part = |(first, (tile, new)): (usize, (&mut Tile, [&mut [f64]; 3]))| {
            steps.carry(&self.composition, tile, first * share, new)
        };
        let [q, p, w] = new;
        let evaluations = match &mut tiles[..] {
            [tile] => part((0, (tile, [q, p, w]))),
            tiles => (q.par_chunks_mut(share), p.par_chunks_mut(share), w.par_chunks_mut(share))
                .into_par_iter()
                .map(|(q, p, w)| [q, p, w])
                .zip(tiles)
                .map(|(new, tile)| (tile, new))
                .enumerate()
                .map(part)
                // An ordered reduction, so that the first of several failures is reported.
                .reduce(|| Ok(0), |before, after| Ok(before? + after?)),
        }?;
        std::mem::swap(&mut state.q, q);
        std::mem::swap(&mut state.p, p);
        if dissipative {
            std::mem::swap(&mut state.w, w);
        }
        Ok(Effort { evaluations, iterations: evaluations }.shared_by(n))
    }
}

/// The parameters of the steps, shared by all tiles.
struct Steps<'a, S: Uniform + ?Sized> {
    system: &'a S,
    lanes: &'a S::Lanes,
    ends: Option<&'a EndMembers>,
    h: f64,
    count: usize,
    dissipative: bool,
    old: &'a State<Vec<f64>>,
}

impl<S: Uniform + ?Sized> Steps<'_, S> {
    /// Moves the members from `first` on, tile by tile. Returns the number of evaluations.
    fn carry(
        &self,
        composition: &Composition,
        tile: &mut Tile,
        first: usize,
        [q, p, w]: [&mut [f64]; 3],
    ) -> Result<u64, StepFailure> {
        let mut evaluations = 0;
        let sweeps = composition.sweeps();
        let new = q.chunks_mut(TILE).zip(p.chunks_mut(TILE)).zip(w.chunks_mut(TILE));
        for (i, ((q, p), w)) in new.enumerate() {
            let mut changes = self.count * sweeps.next_multiple_of(2);
            tile.load(self.old, first + i * TILE, q.len(), changes);
            for _ in 0..self.count {
                for (sweep, fraction) in composition.fractions::<f64>().enumerate() {
                    for colour in if sweep % 2 == 0 { [0, 1] } else { [1, 0] } {
                        evaluations += self.sweep(fraction * self.h, tile, colour, changes)?;
                        // The next sweep begins with the colour with which this one ends.
                        changes -= usize::from(colour == sweep % 2);
                    }
                }
                // So does the next step if the number of sweeps is even.
                changes -= sweeps % 2;
            }
            tile.store([q, p, w])?;
        }
        Ok(evaluations)
    }

    /// Updates the members of one colour: the tile's own, and beyond its ends as many as there are
    /// changes of colour to come.
    #[inline]
    fn sweep(
        &self,
        h: f64,
        tile: &mut Tile,
        colour: usize,
        beyond: usize,
    ) -> Result<u64, StepFailure> {
        let mut range = tile.range(colour, beyond);
        let mut evaluations = 0;
        if let Some([first, last]) = self.ends {
            let n = self.old.q.len();
            if !range.is_empty() && tile.member(colour, range.start).is_multiple_of(n) {
                evaluations += self.end(&**first, h, tile, [colour, range.start])?;
                range.start += 1;
            }
            if !range.is_empty() && tile.member(colour, range.end - 1) % n == n - 1 {
                evaluations += self.end(&**last, h, tile, [colour, range.end - 1])?;
                range.end -= 1;
            }
        }
        let mut member = tile.member(colour, range.start);
        let [[q, beside], [p, _], [w, _]] = [&mut tile.q, &mut tile.p, &mut tile.w]
            .map(|[even, odd]| if colour == 0 { [even, odd] } else { [odd, even] });
        let left = &beside[range.start + colour - 1..range.end + colour - 1];
        let right = &beside[range.start + colour..range.end + colour];
        let (left, left_rest) = left.as_chunks();
        let (right, right_rest) = right.as_chunks();
        let (q, q_rest) = q[range.clone()].as_chunks_mut();
        let (p, p_rest) = p[range.clone()].as_chunks_mut();
        let (w, w_rest) = w[range].as_chunks_mut();
        // Members that need more iterations are often adjacent.
        let mut ordinary = true;
        for ((((q, p), w), left), right) in q.iter_mut().zip(p).zip(w).zip(left).zip(right) {
            evaluations += self.lanes(h, member, [left, right], [q, p, w], &mut ordinary)?;
            member += 2 * LANES;
        }
        if !q_rest.is_empty() {
            // Lanes without a member repeat the last one.
            let fill = |rest: &[f64]| -> [f64; LANES] { from_fn(|k| rest[k.min(rest.len() - 1)]) };
            let (mut q, mut p, mut w) = (fill(q_rest), fill(p_rest), fill(w_rest));
            let beside = [&fill(left_rest), &fill(right_rest)];
            evaluations +=
                self.lanes(h, member, beside, [&mut q, &mut p, &mut w], &mut ordinary)?;
            for (rest, lanes) in [(q_rest, q), (p_rest, p), (w_rest, w)] {
                let len = rest.len();
                rest.copy_from_slice(&lanes[..len]);
            }
        }
        Ok(evaluations)
    }

    /// Updates the first or the last member of a chain, which obeys a law of its own.
    #[cold]
    fn end(
        &self,
        end: &dyn Separable<f64>,
        h: f64,
        tile: &mut Tile,
        [colour, entry]: [usize; 2],
    ) -> Result<u64, StepFailure> {
        let dof = tile.member(colour, entry) % self.old.q.len();
        let beside = &tile.q[1 - colour];
        let (left, right) = (beside[entry + colour - 1], beside[entry + colour]);
        let (mut window, mut momenta) =
            ([left, tile.q[colour][entry], right], [0.0, tile.p[colour][entry], 0.0]);
        let beside = [&mut window[..], &mut momenta];
        let moved = advance(end, &Newton, [h, 0.0], [1, dof], beside, self.dissipative)?;
        tile.q[colour][entry] = moved.q;
        tile.p[colour][entry] = moved.p;
        tile.w[colour][entry] += moved.dw;
        Ok(moved.evaluations)
    }

    /// Updates eight members between the given neighbours: `member` and every second one after it.
    #[inline(always)]
    fn lanes(
        &self,
        h: f64,
        member: usize,
        beside: [&[f64; LANES]; 2],
        moved: [&mut [f64; LANES]; 3],
        ordinary: &mut bool,
    ) -> Result<u64, StepFailure> {
        let [q, p, w] = moved;
        if *ordinary
            && let Some(evaluations) = self.together(&Ordinary, h, member, beside, [q, p, w])
        {
            return Ok(evaluations);
        }
        let evaluations = self.carefully(h, member, beside, [q, p, w])?;
        *ordinary = evaluations <= 2 * LANES as u64;
        Ok(evaluations)
    }

    /// Updates the lanes if two evaluations may not be enough.
    #[cold]
    #[inline(never)]
    fn carefully(
        &self,
        h: f64,
        member: usize,
        beside: [&[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Result<u64, StepFailure> {
        match self.together(&Direct, h, member, beside, [q, p, w]) {
            Some(evaluations) => Ok(evaluations),
            None => self.one_by_one(h, member, beside.map(|x| *x), [q, p, w]),
        }
    }

    /// Solves all lanes together, if every lane converges.
    #[inline(always)]
    fn together(
        &self,
        solver: &impl Solver,
        h: f64,
        member: usize,
        [left, right]: [&[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Option<u64> {
        let zero = f64x8::from_f64(0.0);
        // One load each; passed by value, the arrays would go through the stack.
        let load = |x: &[f64; LANES]| -> f64x8 { pod_read_unaligned(bytes_of(x)) };
        let (mut window, mut momenta) = ([load(left), load(q), load(right)], [zero, load(p), zero]);
        let beside = [&mut window[..], &mut momenta];
        let steps = [h, 0.0].map(f64x8::from_f64);
        let moved =
            advance(self.lanes, solver, steps, [1, member], beside, self.dissipative).ok()?;
        (*q, *p) = (moved.q.to_array(), moved.p.to_array());
        if self.dissipative {
            *w = (load(w) + moved.dw).to_array();
        }
        Some(LANES as u64 * moved.evaluations)
    }

    /// Solves each member alone.
    #[cold]
    #[inline(never)]
    fn one_by_one(
        &self,
        h: f64,
        member: usize,
        [left, right]: [[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Result<u64, StepFailure> {
        let mut evaluations = 0;
        for k in 0..LANES {
            let dof = (member + 2 * k) % self.old.q.len();
            let (mut window, mut momenta) = ([left[k], q[k], right[k]], [0.0, p[k], 0.0]);
            let beside = [&mut window[..], &mut momenta];
            let moved =
                advance(self.system, &Newton, [h, 0.0], [1, dof], beside, self.dissipative)?;
            (q[k], p[k]) = (moved.q, moved.p);
            w[k] += moved.dw;
            evaluations += moved.evaluations;
        }
        Ok(evaluations)
    }
}

/// Newton's iteration with exactly two evaluations.
struct Ordinary;

impl Solver for Ordinary {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let root = Newton::ordinary(start, equation);
        root.ok_or(StepFailure::NewtonStalled { dof, iterations: 2, update: 0.0 })
    }
}

/// Newton's direct iteration; if a lane does not converge, each member is solved alone.
struct Direct;

impl Solver for Direct {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let root = Newton::direct(start, equation);
        root.ok_or(StepFailure::NewtonStalled { dof, iterations: 0, update: 0.0 })
    }
}
