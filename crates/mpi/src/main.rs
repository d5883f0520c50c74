//! A study over the ranks of an MPI job.
//!
//! Rank 0 hands out cells one by one, the most expensive first, so that no rank waits behind an
//! expensive one. Each other rank computes the cells it is given and keeps them in a journal of its
//! own. At the end rank 0 joins all journals and writes the results. A rank that dies ends the job;
//! `--resume` computes what is missing.

use afterbay_experiments::counted;
use afterbay_experiments::ReportError;
use afterbay_experiments::experiment::{Cells, perform};
use afterbay_experiments::journal::{Joined, Journal, JournalError, Ledger, Shard, Start};
use afterbay_analysis::progress::Progress;
use afterbay_experiments::record::{Files, StorageError, prepare};
use afterbay_experiments::scene::{MOST_BYTES, Scene, Task, text};
use clap::Parser;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Source};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;
use thiserror::Error;

/// Runs the studies of a scene over the ranks of an MPI job: mpirun -n N afterbay-mpi SCENE.
///
/// Rank 0 hands out the cells and the others compute them, so N is at least 2. The results are
/// those of `afterbay study`, byte by byte, but for times.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// The scene, a TOML file that all ranks can read.
    scene: PathBuf,
    /// The folder of the results, which all ranks share.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Compute the trajectories of `[run]`, of a sweep or of each method, instead of the studies.
    #[arg(long)]
    run: bool,
    /// Compute only the cells that an earlier job did not finish.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Forget the cells that are finished.
    #[arg(long)]
    force: bool,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

/// The reason for which a rank ends early.
#[derive(Debug, Error)]
enum Trouble {
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{}: {why}", path.display())]
    Scene { path: PathBuf, why: String },
    #[error("{0}; go on with --resume, or compute all cells again with --force")]
    Journal(#[from] JournalError),
    #[error(transparent)]
    Storage(#[from] StorageError),
    #[error(transparent)]
    Study(#[from] ReportError),
    #[error("the threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("start at least two ranks: mpirun -n 2 afterbay-mpi ..")]
    TooFew,
    #[error("{missing} of {} missing; go on with --resume", counted(all, "cell"))]
    Missing { missing: usize, all: usize },
}

impl Trouble {
    /// The exit code of the command `afterbay` for the same.
    fn code(&self) -> u8 {
        match self {
            Self::TooFew | Self::Threads(_) => 2,
            Self::Unreadable { .. } | Self::Scene { .. } => 3,
            Self::Study(_) | Self::Missing { .. } => 4,
            Self::Journal(_) | Self::Storage(_) => 5,
        }
    }
}

/// The number that stands for the end of the work.
const NO_MORE: u64 = u64::MAX;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let Some(universe) = mpi::initialize() else {
        eprintln!("MPI could not be started");
        return ExitCode::from(2);
    };
    let (world, signal) = (universe.world(), Signal::listen());
    match rank(&world, &arguments, &signal) {
        Ok(()) => ExitCode::from(signal.code()),
        Err(trouble) => {
            eprintln!("rank {}: {trouble}", world.rank());
            // The other ranks wait for messages that will not come.
            world.abort(i32::from(trouble.code()))
        }
    }
}

/// The work of one rank.
fn rank<C: Communicator>(world: &C, arguments: &Arguments, signal: &Signal) -> Result<(), Trouble> {
    if world.size() < 2 {
        return Err(Trouble::TooFew);
    }
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build_global()?;
    let scene = read(&arguments.scene)?;
    let task = if arguments.run { Task::Run } else { Task::Study };
    let cells = Cells::new(task, &scene)?;
    let (out, first) = (&arguments.out, world.rank() == 0);
    let work = (task, &scene);
    let mut missing = Vec::new();
    if first {
        prepare(out)?;
        let start = match (arguments.resume, arguments.force) {
            (true, _) => Start::Resume,
            (_, true) => Start::Force,
            _ => Start::Fresh,
        };
        // The folder is free again when this journal is closed, for those of the others.
        let journal = Journal::open(out, work, (cells.plan(), Shard::WHOLE), start)?;
        let open = |&index: &usize| journal.recall(&cells.plan()[index].key).is_none();
        missing = (0..cells.plan().len()).filter(open).collect();
        missing.sort_by(|&a, &b| cells.plan()[b].cost.total_cmp(&cells.plan()[a].cost));
    }
    world.barrier();
    if first {
        println!("{} cells, {} to compute", cells.plan().len(), missing.len());
        hand_out(world, &missing, signal);
    } else {
        let shard = Shard { number: world.rank() as usize, count: world.size() as usize - 1 };
        let journal = Journal::open(out, work, (cells.plan(), shard), Start::Resume)?;
        compute(world, &cells, &journal, signal)?;
    }
    world.barrier();
    if first { join((out, task), &cells, signal) } else { Ok(()) }
}

/// Gives each rank that asks the next cell, and the end of the work when there is none.
fn hand_out<C: Communicator>(world: &C, missing: &[usize], signal: &Signal) {
    let (mut next, mut at_work) = (missing.iter(), world.size() - 1);
    while at_work > 0 {
        let (_, status) = world.any_process().receive::<u64>();
        let cell = if signal.stopped() { None } else { next.next() };
        at_work -= i32::from(cell.is_none());
        let answer = cell.map_or(NO_MORE, |&cell| cell as u64);
        world.process_at_rank(status.source_rank()).send(&answer);
    }
}

/// Asks for cells, computes them and keeps them.
fn compute<C: Communicator>(
    world: &C,
    cells: &Cells<'_>,
    journal: &Journal,
    signal: &Signal,
) -> Result<(), Trouble> {
    let root = world.process_at_rank(0);
    loop {
        root.send(&(world.rank() as u64));
        let (cell, _) = root.receive::<u64>();
        if cell == NO_MORE {
            return Ok(());
        }
        let index = cell as usize;
        let clock = Instant::now();
        let result = cells.compute(index, journal, signal)?;
        // The result of an interrupted run is not the result of the cell.
        if !signal.stopped() {
            journal.keep(&cells.plan()[index].key, &result, clock.elapsed())?;
        }
    }
}

/// Joins the journals of all ranks and writes the results.
fn join(
    (out, task): (&Path, Task),
    cells: &Cells<'_>,
    signal: &Signal,
) -> Result<(), Trouble> {
    let Joined { journal, task, scene } = Journal::join(out, task)?;
    let missing = journal.missing(cells.plan()).count();
    if missing > 0 {
        return Err(Trouble::Missing { missing, all: cells.plan().len() });
    }
    if let Some((results, _)) = perform(task, &scene, &journal, signal)? {
        results.write(out, Files::default())?;
        println!("Report: {}", out.join("report.html").display());
    }
    Ok(())
}

/// Reads a scene. Its title is the name of the file where it has none.
fn read(path: &Path) -> Result<Scene, Trouble> {
    let unreadable = |source| Trouble::Unreadable { path: path.into(), source };
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let wrong = |why: String| Trouble::Scene { path: path.into(), why };
    let text = text(&bytes[..bytes.len().min(MOST_BYTES + 1)])
        .map_err(|error| wrong(error.problem.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene =
        Scene::read_in(folder, text).map_err(|error| wrong(error.problem.to_string()))?;
    scene.call_by(path);
    Ok(scene)
}

/// SIGINT and SIGTERM, which end the work after the cells under way are dropped.
struct Signal {
    stopped: Arc<AtomicBool>,
    number: Arc<AtomicUsize>,
}

impl Signal {
    fn listen() -> Self {
        let signal = Self { stopped: Arc::default(), number: Arc::default() };
        for number in [SIGINT, SIGTERM] {
            // Without a handler the signal ends the rank as it does by default.
            let _ = signal_hook::flag::register(number, Arc::clone(&signal.stopped));
            let kept = Arc::clone(&signal.number);
            let _ = signal_hook::flag::register_usize(number, kept, number as usize);
        }
        signal
    }

    /// 128 and the number of the signal; 0 without one.
    fn code(&self) -> u8 {
        match self.number.load(Ordering::Relaxed) {
            0 => 0,
            number => 128 + number as u8,
        }
    }
}

impl Progress for Signal {
    fn begin(&self, _stage: &str, _total: usize) {}

    fn advance(&self) {}

    fn stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}
