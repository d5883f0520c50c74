//! The `afterbay` command.

mod arguments;
mod bars;
mod check;
mod cite;
mod compare;
mod exit_code;
mod experiment;
mod failure;
mod incomplete;
mod interrupt;
mod list;
mod merge;
mod paper;
mod pick;
mod printable;
mod recommended;
mod scene;
mod shard;
mod table;

use afterbay_experiments::scene::Task;
use arguments::{Arguments, Command, Format};
use clap::{CommandFactory, Parser};
use failure::{Failure, FailureJson};
use std::process::ExitCode;

fn main() -> ExitCode {
    // Names of methods stay whole. A hook that is installed already would do.
    let _ = miette::set_hook(Box::new(|_| {
        let options = miette::MietteHandlerOpts::new();
        Box::new(options.word_splitter(textwrap::WordSplitter::NoHyphenation).build())
    }));
    let arguments = Arguments::try_parse().unwrap_or_else(|error| {
        let error = arguments::refused(error);
        if error.use_stderr() && arguments::asks_for_json() {
            // A failure to print has nowhere to go but the exit code.
            let _ = table::json(&FailureJson::usage(&error));
        }
        error.exit()
    });
    let format = arguments.format;
    let result = threads(arguments.threads).and_then(|()| match arguments.command {
        Command::Paper { out, quick, files } => paper::run((&out, files.into()), quick, format),
        Command::Run(arguments) => experiment::run(Task::Run, &arguments, format),
        Command::Study(arguments) => experiment::run(Task::Study, &arguments, format),
        Command::Merge { folder, run, files } => {
            let task = if run { Task::Run } else { Task::Study };
            merge::run((&folder, task), files.into(), format)
        }
        Command::Pick(arguments) => pick::run(&arguments, format),
        Command::Check { scene } => check::run(&scene, format),
        Command::Cite { scene } => cite::run(&scene, format),
        Command::Compare(arguments) => compare::run(&arguments, format),
        Command::Schema => {
            table::json(&afterbay_experiments::scene::schema())?;
            Ok(ExitCode::SUCCESS)
        }
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "afterbay", &mut script);
            table::bytes(&script)?;
            Ok(ExitCode::SUCCESS)
        }
        Command::List { what } => list::run(what, format),
    });
    match result {
        Ok(code) => code,
        Err(failure) => {
            // A failure to print has nowhere to go but the exit code.
            let _ = (format == Format::Json).then(|| table::json(&failure.json()));
            failure.tell()
        }
    }
}

/// Starts the threads of parallel computations; `None` stands for one per processor.
fn threads(count: Option<u16>) -> Result<(), Failure> {
    let count = usize::from(count.unwrap_or(0));
    rayon::ThreadPoolBuilder::new().num_threads(count).build_global().map_err(Failure::threads)
}
