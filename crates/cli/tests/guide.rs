//! The guide and the README do what they say: their scenes are checked, their commands run, and the output they show appears.

use afterbay_analysis::study::outcome::{COMPLETED, INTERRUPTED};
use afterbay_analysis::study::stability::Verdict;
use std::path::Path;
use std::process::Command;

/// A fenced block of a text: what stands behind the fence, and what it encloses.
struct Block {
    info: String,
    lines: Vec<String>,
}

fn blocks(text: &str) -> Vec<Block> {
    let (mut all, mut open) = (Vec::new(), None::<Block>);
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => open = Some(Block { info: info.to_owned(), lines: Vec::new() }),
            (Some(_), Some(_)) => all.extend(open.take()),
            (Some(block), None) => block.lines.push(line.to_owned()),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    all
}

/// What a shell in the folder prints, and its exit code.
fn shell(folder: &Path, line: &str) -> (Vec<String>, i32) {
    let command = line.strip_prefix("afterbay ").unwrap_or_else(|| panic!("not ours: {line}"));
    let output = Command::new("sh")
        .args(["-c", &format!("\"$AFTERBAY\" {command}")])
        .env("AFTERBAY", env!("CARGO_BIN_EXE_afterbay"))
        .current_dir(folder)
        .output()
        .expect("it is run");
    let printed =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("text")).concat();
    (printed.lines().map(str::to_owned).collect(), output.status.code().expect("an exit code"))
}

/// Is this the line shown? `…` stands for anything, blanks for any number of them.
fn is_shown(printed: &str, shown: &str) -> bool {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (printed, shown) = (words(printed), words(shown));
    let mut rest = printed.as_str();
    for (i, part) in shown.split('…').enumerate() {
        let part = if i == 0 { part } else { part.trim() };
        match rest.find(part) {
            Some(at) if i > 0 || at == 0 => rest = &rest[at + part.len()..],
            _ => return false,
        }
    }
    rest.is_empty() || shown.ends_with('…')
}

/// Runs the commands of a block. The lines under a command must be among what it prints, in their order.
fn follow(folder: &Path, block: &Block) {
    let (mut printed, mut code) = (Vec::<String>::new().into_iter(), 0);
    for line in &block.lines {
        match line.strip_prefix("$ ") {
            Some("echo $?") => printed = vec![code.to_string()].into_iter(),
            Some(command) => {
                let (lines, ended) = shell(folder, command);
                (printed, code) = (lines.into_iter(), ended);
            }
            None => {
                let before: Vec<_> = printed.as_slice().to_vec();
                assert!(printed.any(|found| is_shown(&found, line)), "{line:?} in\n{}", before.join("\n"));
            }
        }
    }
}

fn holds(text: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    for block in blocks(text) {
        let mut words = block.info.split_whitespace();
        match words.next() {
            Some("toml") => {
                let name =
                    words.next().and_then(|word| word.strip_prefix("scene:")).expect("a scene has a name");
                let lines = block.lines.join("\n") + "\n";
                std::fs::write(folder.path().join(name), lines).expect("a scene");
                let (printed, code) = shell(folder.path(), &format!("afterbay check {name}"));
                let expected = if words.next() == Some("invalid") { 3 } else { 0 };
                assert_eq!(code, expected, "{}", printed.join("\n"));
            }
            Some("console") => follow(folder.path(), &block),
            // Rust blocks are doc tests; what is for a shell alone builds or installs.
            Some("rust" | "sh") => {}
            other => panic!("a block of {other:?} is not tested"),
        }
    }
}

#[test]
fn the_guide_does_what_it_says() {
    holds(include_str!("../../../docs/guide.md"));
}

#[test]
fn the_readme_does_what_it_says() {
    holds(include_str!("../../../README.md"));
}

#[test]
fn the_tables_have_the_columns_the_guide_promises() {
    let guide = include_str!("../../../docs/guide.md");
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["first.toml", "studies.toml", "stability.toml"] {
        let all = blocks(guide);
        let block = all.iter().find(|block| block.info.ends_with(name)).expect("the scene");
        std::fs::write(folder.path().join(name), block.lines.join("\n")).expect("a scene");
        let command = if name == "first.toml" { "run" } else { "study" };
        let (printed, code) = shell(folder.path(), &format!("afterbay {command} {name} --out out --force"));
        assert_eq!(code, 0, "{}", printed.join("\n"));
    }
    let mut tables = 0;
    for table in std::fs::read_dir(folder.path().join("out/data")).expect("tables").flatten() {
        let name = table.file_name().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(table.path()).expect("a table");
        let header = text.lines().next().unwrap_or_default().replace("q1,p1,w1", "q1..qN,p1..pN,w1..wN");
        let row = guide
            .lines()
            .find(|line| line.contains(&format!("`{name}`")))
            .unwrap_or_else(|| panic!("no {name}"));
        let columns = row.split('`').nth(3).expect("columns");
        assert!(header.starts_with(columns), "{name} has {header}, not {columns}");
        tables += 1;
    }
    assert_eq!(tables, 7);
}

#[test]
fn the_guide_knows_every_outcome_and_verdict() {
    let guide = include_str!("../../../docs/guide.md");
    let source = include_str!("../../analysis/src/study/outcome.rs");
    let words = source.lines().filter_map(|line| line.split("=> \"").nth(1)?.split('"').next());
    let outcomes: Vec<_> = words.chain([COMPLETED, INTERRUPTED]).map(str::to_owned).collect();
    assert!(outcomes.len() > 10, "{outcomes:?}");
    let verdicts = Verdict::ALL.map(|verdict| serde_json::to_value(verdict).expect("a word"));
    let verdicts = verdicts.iter().map(|word| word.as_str().expect("a word").to_owned());
    for word in outcomes.into_iter().chain(verdicts) {
        assert!(guide.contains(&format!("`{word}`")), "{word}");
    }
}
