//! The guide and the README are right: their scenes are valid, their commands run, and the output
//! they show appears.

use afterbay_analysis::study::outcome::{COMPLETED, INTERRUPTED};
use afterbay_analysis::study::stability::Verdict;
use std::path::Path;
use std::process::Command;

/// A fenced block: the text behind the fence and the lines enclosed.
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

/// The output and the exit code of a shell command in a folder. Charts are drawn as SVG alone,
/// since pictures take most of the time.
fn shell(folder: &Path, line: &str) -> (Vec<String>, i32) {
    let command = line.strip_prefix("afterbay ").unwrap_or_else(|| panic!("not ours: {line}"));
    let draws =
        ["run ", "study ", "compare ", "merge "].iter().any(|name| command.starts_with(name));
    let command = match command.split_once(' ') {
        Some((name, rest)) if draws => format!("{name} --no-png {rest}"),
        _ => command.to_owned(),
    };
    let output = Command::new("sh")
        .args(["-c", &format!("\"$AFTERBAY\" {command}")])
        .env("AFTERBAY", env!("CARGO_BIN_EXE_afterbay"))
        // A sentence is shown as one line, however long.
        .env("COLUMNS", "1000")
        .current_dir(folder)
        .output()
        .expect("it is run");
    let printed = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8(bytes).expect("text"))
        .concat();
    (printed.lines().map(str::to_owned).collect(), output.status.code().expect("an exit code"))
}

/// Whether a printed line matches the one shown. `…` matches anything, and blanks match any number
/// of blanks.
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

/// The number, or the bound `≤ error + doubt`, between two phrases.
fn error_between(text: &str, before: &str, after: &str) -> f64 {
    let from = text.split_once(before).unwrap_or_else(|| panic!("no {before:?} in {text}")).1;
    let said = from.split_once(after).unwrap_or_else(|| panic!("no {after:?} in {from}")).0;
    let numbers = said.trim_start_matches('≤').split('+');
    numbers.map(|x| x.trim().parse::<f64>().unwrap_or_else(|_| panic!("{x:?} in {text}"))).sum()
}

/// The output of `pick` agrees with its JSON, its methods exist, and its errors are within the
/// bound.
fn picks(folder: &Path, command: &str, printed: &[String]) {
    let bound: f64 = command
        .split_whitespace()
        .skip_while(|word| *word != "--error")
        .nth(1)
        .and_then(|bound| bound.parse().ok())
        .expect("an error");
    let methods = shell(folder, "afterbay list methods").0.join("\n");
    let known = |name: &str| methods.split_whitespace().any(|word| word == name);
    let said =
        |start: &str| printed.iter().find(|line| line.contains(start)).expect(start).as_str();
    let line = said("is the cheapest within");
    let (winner, setting) = line.split_once(" with ").expect("a method");
    assert!(known(winner), "{winner} is no method");
    let (by, value) =
        setting.split_once(" is the").expect("a setting").0.split_once(" = ").expect("a value");
    assert!(by == "step" || by == "tolerance", "{setting}");
    assert!(value.parse::<f64>().is_ok_and(|value| value > 0.0 && value <= 20.0), "{setting}");
    for error in [
        error_between(line, ", error ", " in (q, p)"),
        error_between(line, "in (q, p) and ", " in w on the way"),
        error_between(line.rsplit_once(", ").expect("errors at the end").1, "", " and "),
        error_between(said("Checked"), "err by ", " at most"),
    ] {
        assert!(error >= 0.0 && error <= bound, "{error} in {line}");
    }
    for error in [
        error_between(said("Checked"), "differs by ", " in (q, p)"),
        error_between(said("Checked"), "in (q, p) and ", " in w"),
    ] {
        assert!(error <= 2.0 * bound, "{error}");
    }
    // The scene has been written, and is not overwritten.
    let (again, _) = command.split_once(" --write").unwrap_or((command, ""));
    let (text, code) = shell(folder, &format!("{again} --format json"));
    assert_eq!(code, 0, "{}", text.join("\n"));
    let found: serde_json::Value = serde_json::from_str(&text.join("\n")).expect("JSON");
    let all = found["qualified"].as_array().expect("a list");
    assert!(all.len() > 1);
    for one in all {
        assert!(
            known(one["method"].as_str().expect("a name")) && one["why_not"].is_null(),
            "{one}"
        );
        for error in ["error_qp", "error_w", "end_qp", "end_w"] {
            assert!(one[error].as_f64().is_some_and(|error| error <= bound), "{error} of {one}");
        }
    }
}

/// Runs the commands of a block. The lines below a command must appear in its output, in their
/// order.
fn follow(folder: &Path, block: &Block) {
    let (mut printed, mut code) = (Vec::<String>::new().into_iter(), 0);
    for line in &block.lines {
        match line.strip_prefix("$ ") {
            Some("echo $?") => printed = vec![code.to_string()].into_iter(),
            Some(command) => {
                let (lines, ended) = shell(folder, command);
                if command.starts_with("afterbay pick") {
                    picks(folder, command, &lines);
                }
                (printed, code) = (lines.into_iter(), ended);
            }
            None => {
                let before: Vec<_> = printed.as_slice().to_vec();
                assert!(
                    printed.any(|found| is_shown(&found, line)),
                    "{line:?} in\n{}",
                    before.join("\n")
                );
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
                let name = words
                    .next()
                    .and_then(|word| word.strip_prefix("scene:"))
                    .expect("a scene has a name");
                let lines = block.lines.join("\n") + "\n";
                std::fs::write(folder.path().join(name), lines).expect("a scene");
                let (printed, code) = shell(folder.path(), &format!("afterbay check {name}"));
                let expected = if words.next() == Some("invalid") { 3 } else { 0 };
                assert_eq!(code, expected, "{}", printed.join("\n"));
            }
            Some("console") => follow(folder.path(), &block),
            // Rust blocks are doc tests; blocks for the shell only build or install.
            Some("rust" | "sh") => {}
            other => panic!("a block of {other:?} is not tested"),
        }
    }
}

#[test]
fn the_guide_does_what_it_says() {
    holds(include_str!("../../../../docs/guide.md"));
}

#[test]
fn the_readme_does_what_it_says() {
    holds(include_str!("../../../../README.md"));
}

#[test]
fn the_tables_have_the_columns_the_guide_promises() {
    let guide = include_str!("../../../../docs/guide.md");
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["first.toml", "studies.toml", "stability.toml"] {
        let all = blocks(guide);
        let block = all.iter().find(|block| block.info.ends_with(name)).expect("the scene");
        std::fs::write(folder.path().join(name), block.lines.join("\n")).expect("a scene");
        let command = if name == "first.toml" { "run" } else { "study" };
        let (printed, code) =
            shell(folder.path(), &format!("afterbay {command} {name} --out {name}.out"));
        assert_eq!(code, 0, "{}", printed.join("\n"));
    }
    let mut tables = 0;
    let folders = ["first", "studies", "stability"]
        .map(|name| folder.path().join(format!("{name}.toml.out/data")));
    let entries = folders.iter().flat_map(|data| std::fs::read_dir(data).expect("tables"));
    for table in entries.flatten() {
        let name = table.file_name().to_string_lossy().into_owned();
        if !name.ends_with(".csv") {
            continue;
        }
        let text = std::fs::read_to_string(table.path()).expect("a table");
        let header =
            text.lines().next().unwrap_or_default().replace("q1,p1,w1", "q1..qN,p1..pN,w1..wN");
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
    let guide = include_str!("../../../../docs/guide.md");
    let source = include_str!("../../../analysis/src/study/outcome.rs");
    let words = source.lines().filter_map(|line| line.split("=> \"").nth(1)?.split('"').next());
    let outcomes: Vec<_> = words.chain([COMPLETED, INTERRUPTED]).map(str::to_owned).collect();
    assert!(outcomes.len() > 10, "{outcomes:?}");
    let verdicts = Verdict::ALL.map(|verdict| serde_json::to_value(verdict).expect("a word"));
    let verdicts = verdicts.iter().map(|word| word.as_str().expect("a word").to_owned());
    for word in outcomes.into_iter().chain(verdicts) {
        assert!(guide.contains(&format!("`{word}`")), "{word}");
    }
}
