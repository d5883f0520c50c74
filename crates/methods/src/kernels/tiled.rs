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

use super::side_by_side::Steps;
use super::tile::{TILE, Tile};
use crate::hidden_coupling::states_coupling;
use crate::increment::Composition;
use afterbay_core::{
    Coupling, Effort, EndMembers, InputError, Method, State, StepFailure, Uniform, validate,
};
use rayon::prelude::*;
use std::sync::Arc;

/// The largest number of steps a tile takes at once. A choice: memory is then read once in this
/// number of steps.
const MOST_STEPS: usize = 8;
/// The largest number of changes of colour in these steps, unless a single step has more. As many
/// members are computed twice for each tile: one in 32. A choice.
const MOST_CHANGES: usize = TILE / 32;

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
        states_coupling("increment", system, true)?;
        let n = system.dof();
        // A lane uses the mass of one member for all eight. Unequal masses would not conserve K.
        if (1..n).any(|j| system.mass(j) != system.mass(0)) {
            let why = "members updated side by side must have equal masses";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        let sweeps = self.composition.sweeps().next_multiple_of(2);
        let most = (MOST_CHANGES / sweeps).clamp(1, MOST_STEPS);
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
