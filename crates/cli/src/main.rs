//! The `afterbay` command.

mod arguments;
mod bars;
mod failure;
mod list;
mod paper;
mod table;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

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
