//! The command line.

use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Integrates dissipative Hamiltonian systems with an energy reservoir, so that K = H + Σ w is kept exactly, and
/// measures how fast, how accurate and how stable each method is.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 completed, 2 usage, 5 results could not be written.")]
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
    /// Show what there is.
    List {
        /// What to list.
        #[arg(value_enum)]
        what: What,
    },
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
