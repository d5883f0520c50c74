//! The `afterbay` command.

mod arguments;
mod bars;
mod list;
mod paper;
mod table;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

/// How the command ended, for scripts.
mod exit {
    /// Results could not be written.
    pub(crate) const STORAGE: u8 = 5;
    /// The command line was not understood.
    pub(crate) const USAGE: u8 = 2;
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(threads) = arguments.threads {
        // Fails only if the pool exists already, which it does not yet.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global();
    }
    let result = match arguments.command {
        Command::Paper { out, quick } => paper::run(&out, quick, arguments.format),
        Command::List { what } => list::run(what, arguments.format),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("{:?}", miette::Report::new(failure.diagnostic));
            ExitCode::from(failure.code)
        }
    }
}
