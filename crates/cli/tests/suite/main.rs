//! All tests of the command in one program.

#![cfg(test)]

#[path = "../../../experiments/tests/suite/scenes/bad/mod.rs"]
mod bad;
mod cite;
mod command;
mod compare;
mod formats;
mod guide;
mod help;
#[cfg(unix)]
mod interrupt;
mod merge;
mod mistakes;
mod ready;
mod recommended;
mod refused;
mod shards;
mod streams;
mod takeover;
mod threads;
mod timeless;
mod widths;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The command with arguments.
fn afterbay(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterbay"));
    command.args(arguments).env_remove("NO_COLOR").env_remove("COLUMNS");
    command
}

/// The exit code, stdout and stderr.
fn done(command: &mut Command) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = command.output().expect("it is run");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (status.code(), text(stdout), text(stderr))
}

/// The folder of example scenes.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// A text without blanks and without the bars beside the parts of broken lines.
fn squeezed(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace() && !"│|".contains(*c)).collect()
}
