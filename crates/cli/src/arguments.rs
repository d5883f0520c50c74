//! The command line.

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// Integrates dissipative Hamiltonian systems with an energy reservoir, so that K = H + Σ w is kept exactly, and
/// measures how fast, how accurate and how stable each method is.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 all completed, 2 usage, 3 scene invalid, 4 some runs failed (results are written), 5 results could \
                  not be written, 130 interrupted (what was done is written)."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// Threads for the sweeps, 1 to 1024 [default: all]. Results are the same to the bit for any number.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// What to print on stdout.
    #[arg(long, global = true, value_enum, default_value_t = Format::Table)]
    pub(crate) format: Format,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the paper's experiment again and say what holds: orders, errata, energy books, cost, stability.
    Paper {
        /// Folder for report.html, figures/, data/ and run.json.
        #[arg(long, value_name = "DIR", default_value = "out/paper")]
        out: PathBuf,
        /// The same studies on coarser maps and with fewer steps.
        #[arg(long)]
        quick: bool,
    },
    /// Run the methods of a scene's [run] table and write the trajectories down.
    Run(SceneArguments),
    /// Run the studies a scene declares: orders, energy books, cost, stability, long runs.
    Study(SceneArguments),
    /// Find the cheapest method and step that meets an error on the scene itself, checked against a finer run.
    Pick {
        /// The scene, a TOML file.
        scene: PathBuf,
        /// The largest error of (q, p) and of w at the end of the scene.
        #[arg(long, value_name = "E", value_parser = error_bound)]
        error: f64,
        /// Only methods that keep K to rounding.
        #[arg(long)]
        keep_k: bool,
        /// Only methods that never take energy back from the reservoir of a passive system.
        #[arg(long)]
        passive: bool,
    },
    /// Say whether a scene is valid, and what it would do. Nothing is computed.
    Check {
        /// The scene, a TOML file.
        scene: PathBuf,
    },
    /// Print the JSON schema of scenes, for editors.
    Schema,
    /// Print completions for a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Show what there is.
    List {
        /// What to list.
        #[arg(value_enum)]
        what: What,
    },
}

#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// The scene, a TOML file. `afterbay schema` describes it; the folder scenes/ has ready ones.
    pub(crate) scene: PathBuf,
    /// Folder for report.html, figures/, data/ and run.json [default: out/ and the name of the scene].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write there even if the results of another scene are lost.
    #[arg(long)]
    pub(crate) force: bool,
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
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A table for people.
    Table,
    /// JSON for programs.
    Json,
}
