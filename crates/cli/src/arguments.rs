//! The command line.

use crate::exit_code;
use afterbay_experiments::data::{DataFormat, Files};
use afterbay_experiments::journal::Shard;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;
use std::str::FromStr;

/// Integrates mechanical systems with friction, accounts for the energy they lose, and measures the
/// accuracy and the cost of each method.
///
/// H is the energy, w_j the energy that friction has taken from degree of freedom j, and K = H + Σ
/// w_j is constant: to rounding with some methods, approximately with others.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, after_help = after_help())]
#[command(max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// Threads, 1 to 1024 [default: one for each processor]. Results do not depend on
    /// their number.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// What to print on stdout.
    #[arg(long, global = true, value_enum, default_value_t = Format::Table)]
    pub(crate) format: Format,
}

/// Names the commands where one is given that does not exist, and the nearest only where it begins
/// alike.
pub(crate) fn refused(mut error: clap::Error) -> clap::Error {
    let first = |value: Option<&ContextValue>| match value {
        Some(ContextValue::String(name)) => name.chars().next(),
        Some(ContextValue::Strings(names)) => names.first().and_then(|name| name.chars().next()),
        _ => None,
    };
    if error.kind() != ErrorKind::InvalidSubcommand {
        return error;
    }
    let given = first(error.get(ContextKind::InvalidSubcommand));
    if given != first(error.get(ContextKind::SuggestedSubcommand)) {
        let names: Vec<_> =
            Arguments::command().get_subcommands().map(|x| x.get_name().to_owned()).collect();
        let said = format!("the commands are {}", names.join(", "));
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![said.into()]));
    }
    error
}

/// Whether `--format json` is among the arguments, which may be wrong otherwise.
pub(crate) fn asks_for_json() -> bool {
    let given: Vec<_> = std::env::args_os().collect();
    given.iter().any(|x| x == "--format=json")
        || given.windows(2).any(|pair| pair[0] == "--format" && pair[1] == "json")
}

/// The end of the help text.
fn after_help() -> String {
    format!("{FIRST_STEPS}\n\n{}", exit_code::HELP)
}

/// Examples, shown after the help.
const FIRST_STEPS: &str = "\
First steps:
  afterbay list systems                            the systems
  afterbay list methods                            the methods
  afterbay check scenes/pendulum.toml              is it valid, what does it do
  afterbay run scenes/pendulum.toml                trajectories, in out/pendulum
  afterbay study scenes/pendulum.toml --out out/p  the studies it declares
  afterbay pick scenes/pendulum.toml --error 1e-6  the cheapest method and step";

/// Examples of each command, shown after its help.
mod example {
    pub(super) const PAPER: &str = "\
Example:
  afterbay paper --quick --out out/quick";
    pub(super) const RUN: &str = "\
Example:
  afterbay run scenes/pendulum.toml";
    pub(super) const STUDY: &str = "\
Example:
  afterbay study scenes/pendulum.toml --out out/p";
    pub(super) const MERGE: &str = "\
Example, with the two halves of a study on two machines that share a folder:
  afterbay study scenes/pendulum.toml --out out/p --shard 1/2
  afterbay study scenes/pendulum.toml --out out/p --shard 2/2
  afterbay merge out/p";
    pub(super) const PICK: &str = "\
Examples:
  afterbay pick scenes/pendulum.toml --error 1e-6
  afterbay pick scenes/pendulum.toml --error 1e-4 --keep-k --write picked.toml";
    pub(super) const CHECK: &str = "\
Example:
  afterbay check scenes/pendulum.toml";
    pub(super) const CITE: &str = "\
Example:
  afterbay cite scenes/pendulum.toml > pendulum.bib";
    pub(super) const COMPARE: &str = "\
Example, with a scene that is changed in between:
  afterbay run scenes/pendulum.toml --out out/before
  afterbay run scenes/pendulum.toml --out out/after
  afterbay compare out/before out/after";
    pub(super) const SCHEMA: &str = "\
Example:
  afterbay schema > scene.json";
    pub(super) const COMPLETIONS: &str = "\
Example:
  afterbay completions bash > afterbay.bash";
    pub(super) const LIST: &str = "\
Examples:
  afterbay list methods
  afterbay list systems --format json";
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Repeat the paper's experiment and report which results hold: orders, errata, energy balance,
    /// cost, stability.
    #[command(after_help = example::PAPER)]
    Paper {
        /// Folder for report.html, figures/, data/ and run.json.
        #[arg(long, value_name = "DIR", default_value = "out/paper")]
        out: PathBuf,
        /// Use coarser maps and fewer steps.
        #[arg(long)]
        quick: bool,
        #[command(flatten)]
        files: FilesArguments,
    },
    /// Run the methods of a scene's `[run]` table and write the trajectories.
    ///
    /// Writes report.html, which opens in any browser, figures/ (SVG and PNG),
    /// data/trajectory.csv and run.json to a folder. Tables [figure.NAME] of the scene choose
    /// quantities and methods for figures. The table of a run that fails ends with its last good
    /// state. Runs are kept in parts-of-run/: long ones that were stopped go on with --resume.
    #[command(after_help = example::RUN)]
    Run(SceneArguments),
    /// Run the studies that a scene declares: orders, energy balance, cost, stability, attractors.
    ///
    /// A scene declares a study by a table: [study.local-order], [study.global-order],
    /// [study.energy], [study.work-precision], [study.stability], [study.long-run], and for driven
    /// and self-excited systems [study.poincare], [study.bifurcation], [study.resonance],
    /// [study.basins], [study.lyapunov], [study.limit-cycle]. Each study writes its table to data/
    /// and its charts to report.html and figures/. Finished cells are kept in parts/: a study that
    /// was stopped goes on with --resume.
    #[command(after_help = example::STUDY)]
    Study(SceneArguments),
    /// Join the cells that the commands of a sharded study have computed.
    ///
    /// Takes the folder of `study --shard` or `run --shard` and writes report.html, figures/,
    /// data/ and run.json there: the tables of a command without shards, byte by byte, but for
    /// times. Names the cells that are missing.
    #[command(after_help = example::MERGE)]
    Merge {
        /// The folder of the results.
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Join the shares of `run` where there are shares of `study` too.
        #[arg(long)]
        run: bool,
        #[command(flatten)]
        files: FilesArguments,
    },
    /// Find the cheapest method and step that meets an error bound all along the scene.
    ///
    /// Takes the system, the initial state and the end of time from the scene, and ignores its step
    /// and methods. Errors are measured after every step (at 2048 times in longer runs). A step is
    /// recommended only if the steps within 5 % of it and half of it meet the bound as well.
    /// The answer ends with the lines that run it. Nothing is written without --out or --write.
    #[command(after_help = example::PICK)]
    Pick(PickArguments),
    /// Check a scene and show what it would do. Nothing is computed.
    ///
    /// A mistake is shown in its line, with advice, and the exit code is 3.
    #[command(after_help = example::CHECK)]
    Check {
        /// The scene, a TOML file.
        scene: PathBuf,
    },
    /// Print what to cite for the methods of a scene, in BibTeX.
    ///
    /// The entries of afterbay and of the paper it is based on come first. Comments name the
    /// entries of each method of `[run]` and of all studies.
    #[command(after_help = example::CITE)]
    Cite {
        /// The scene, a TOML file.
        scene: PathBuf,
    },
    /// Compare two results: their scenes, the rows of their tables, and their trajectories.
    ///
    /// Writes report.html with the curves of both in one chart, figures/, data/ with the joined
    /// tables and run.json to a folder. Times (column `seconds`) are compared by their ratio and
    /// are no difference.
    #[command(after_help = example::COMPARE)]
    Compare(CompareArguments),
    /// Print the JSON schema of scenes, for editors.
    ///
    /// Editors that support TOML use it to complete and check scenes: write `afterbay schema >
    /// scene.json`, and put `#:schema scene.json` in the first line of a scene.
    #[command(after_help = example::SCHEMA)]
    Schema,
    /// Print completions for a shell.
    ///
    /// For bash, for example: `source <(afterbay completions bash)`.
    #[command(after_help = example::COMPLETIONS)]
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// List methods, systems, or the functions of expressions.
    #[command(after_help = example::LIST)]
    List {
        /// What to list.
        #[arg(value_enum)]
        what: What,
    },
}

/// The kinds of files that are written.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct FilesArguments {
    /// The format of the tables in data/. Beside each, NAME.json names its columns, their types and
    /// units, and its origin.
    #[arg(id = "data", long = "data", value_name = "FORMAT")]
    #[arg(value_enum, default_value_t = Data::Csv)]
    pub(crate) tables: Data,
    /// Write the charts as SVG alone, and remove their earlier PNG files. They take most of the
    /// time of a short command.
    #[arg(long)]
    pub(crate) no_png: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Data {
    /// Comma-separated values.
    Csv,
    /// Two-dimensional arrays for NumPy; words are numbers that NAME.json explains.
    Npy,
    /// A JSON object for each row.
    Jsonl,
}

impl From<FilesArguments> for Files {
    fn from(FilesArguments { tables, no_png }: FilesArguments) -> Self {
        let tables = match tables {
            Data::Csv => DataFormat::Csv,
            Data::Npy => DataFormat::Npy,
            Data::Jsonl => DataFormat::Jsonl,
        };
        Self { tables, png: !no_png }
    }
}

#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// The scene, a TOML file. `afterbay schema` describes it, and the folder scenes/ contains
    /// examples.
    pub(crate) scene: PathBuf,
    /// Folder for report.html, figures/, data/ and run.json [default: out/ and the name of the
    /// scene].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Remove the results of another scene, and forget the finished cells of this one.
    #[arg(long)]
    pub(crate) force: bool,
    /// Compute only the cells that an earlier command with this folder did not finish.
    #[arg(long, conflicts_with = "force")]
    pub(crate) resume: bool,
    /// Compute the K-th of N shares of the cells and keep them for `afterbay merge`.
    ///
    /// `auto` takes K and N from a job array of SLURM (SLURM_ARRAY_TASK_ID, _COUNT, _MIN and
    /// _STEP), `auto/N` takes K from HyperQueue (HQ_TASK_ID, from 1).
    #[arg(long, value_name = "K/N")]
    pub(crate) shard: Option<ShardArgument>,
    /// Print the cells with their estimated costs, and compute nothing.
    #[arg(long, conflicts_with_all = ["resume", "force", "shard"])]
    pub(crate) plan: bool,
    #[command(flatten)]
    pub(crate) files: FilesArguments,
}

/// A share of the cells, or where to read it from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardArgument {
    Given(Shard),
    /// From SLURM.
    Slurm,
    /// From HyperQueue, with the number of all.
    HyperQueue(usize),
}

impl FromStr for ShardArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('/') {
            None if text == "auto" => Ok(Self::Slurm),
            Some(("auto", count)) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::HyperQueue(count)),
                _ => Err("auto/N needs a whole number N from 1, such as auto/8".into()),
            },
            _ => text.parse().map(Self::Given).map_err(|error: &str| error.to_owned()),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct PickArguments {
    /// The scene, a TOML file.
    pub(crate) scene: PathBuf,
    /// The largest error allowed in every q_j, p_j and w_j, all along the scene.
    #[arg(long, value_name = "E", value_parser = error_bound, allow_negative_numbers = true)]
    pub(crate) error: f64,
    /// Count errors at the end of the scene only.
    #[arg(long)]
    pub(crate) at_end: bool,
    /// Consider only methods that keep K to rounding.
    #[arg(long)]
    pub(crate) keep_k: bool,
    /// Consider only methods that never take energy back from the reservoir of a passive system.
    #[arg(long)]
    pub(crate) passive: bool,
    /// Folder for report.html with the charts of the runs that were tried, figures/, data/ and
    /// run.json.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write the scene to this file, with the recommended method and step in place of its own.
    /// Comments are kept, and studies keep their methods and steps.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) write: Option<PathBuf>,
    /// Overwrite the results of another scene, and the file of --write.
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) files: FilesArguments,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// The folder of the result A, as `run`, `study`, `paper` or `pick --out` wrote it.
    #[arg(value_name = "DIR_A")]
    pub(crate) a: PathBuf,
    /// The folder of the result B.
    #[arg(value_name = "DIR_B")]
    pub(crate) b: PathBuf,
    /// Folder for report.html, figures/, data/ and run.json.
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    pub(crate) out: PathBuf,
    /// Overwrite other results.
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) files: FilesArguments,
}

/// A positive, finite number.
fn error_bound(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error.is_finite() => Ok(error),
        _ => Err("an error is a positive, finite number such as 1e-8".into()),
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum What {
    /// Every method with its order, what it keeps and what it needs.
    Methods,
    /// Every system with its equations and parameters.
    Systems,
    /// What the expressions of a scene are made of.
    Functions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A table for people.
    Table,
    /// JSON for programs.
    Json,
}
