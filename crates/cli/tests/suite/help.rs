//! The help of each command: its width, and its examples, which are run.

use super::{afterbay, done, folder};
use std::collections::BTreeSet;
use std::process::Command;

/// The commands that the help names, and an empty name for the command itself.
fn commands() -> Vec<String> {
    let (_, help, _) = done(&mut afterbay(&["--help"]));
    let list = help.split_once("Commands:\n").expect("commands").1;
    let lines = list.lines().take_while(|line| !line.is_empty());
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    let names = names.filter(|name| *name != "help").map(str::to_owned);
    names.chain([String::new()]).collect()
}

/// The help of a command, with `COLUMNS` if it is set.
fn help(command: &str, columns: Option<&str>) -> String {
    let name = (!command.is_empty()).then_some(command);
    let mut asked = afterbay(&[]);
    asked.args(name).arg("--help").envs(columns.map(|columns| ("COLUMNS", columns)));
    let (code, help, stderr) = done(&mut asked);
    assert_eq!(code, Some(0), "{command}: {stderr}");
    help
}

#[test]
fn help_is_as_wide_as_the_terminal_and_at_most_100_columns() {
    for command in commands() {
        for (columns, limit) in [(None, 100), (Some("80"), 80), (Some("200"), 100)] {
            let text = help(&command, columns);
            let widest = text.lines().map(|line| line.chars().count()).max();
            assert!(widest.is_some_and(|width| width <= limit), "{widest:?} in {text}");
        }
    }
}

#[test]
fn the_examples_of_each_command_work() {
    let place = tempfile::tempdir().expect("a folder");
    let scenes = place.path().join("scenes");
    std::fs::create_dir(&scenes).expect("a folder");
    let name = "pendulum.toml";
    std::fs::copy(folder().join(name), scenes.join(name)).expect("a scene");
    let (all, mut seen) = (commands(), BTreeSet::new());
    assert!(all.len() > 8, "{all:?}");
    for command in all {
        let text = help(&command, None);
        let lines = text.lines().filter_map(|line| line.strip_prefix("  afterbay "));
        // What an example does stands two blanks behind it.
        let examples: Vec<_> = lines.filter_map(|line| line.split("  ").next()).collect();
        assert!(!examples.is_empty(), "{command} has no example: {text}");
        assert!(examples.iter().any(|example| example.starts_with(&command)), "{text}");
        for example in examples {
            // `command.rs` runs the paper, which takes longer than the rest of these.
            if command == "paper" {
                assert!(example.starts_with("paper --quick --out "), "{example}");
                continue;
            }
            if !seen.insert(example.trim_end().to_owned()) {
                continue;
            }
            let (code, _, stderr) = done(
                Command::new("sh")
                    .args(["-c", &format!("\"$AFTERBAY\" {example}")])
                    .env("AFTERBAY", env!("CARGO_BIN_EXE_afterbay"))
                    .current_dir(place.path()),
            );
            assert_eq!(code, Some(0), "{example}: {stderr}");
        }
    }
    for file in ["scene.json", "afterbay.bash", "picked.toml", "out/p/report.html"] {
        assert!(place.path().join(file).exists(), "{file}");
    }
}
