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
    let result = match arguments.command {
        Command::Paper { out, quick } => paper::run(&out, quick, arguments.threads, arguments.format),
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
