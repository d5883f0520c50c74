//! What is printed is as wide as the terminal.

use super::{afterbay, done};
use std::sync::LazyLock;

/// A scene with runs that fail, for long reasons.
const SCENE: &str = "\
[system]
name = \"damped-oscillator\"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 8.0
step = 0.5
[run]
methods = [\"moddg-fixed-point\", \"moddg-p4-single-printed\", \"leapfrog\", \"rk4\", \"gonzalez\"]
[study.local-order]
base_step = 0.05
steps = [0.2, 0.1]
[study.global-order]
steps = [4.0, 0.1]
[study.energy]
step = 4.0
[study.work-precision]
steps = [4.0, 0.1]
[study.long-run]
step = 4.0
count = 100
";

/// Commands with their exit codes.
const COMMANDS: [(&[&str], i32); 9] = [
    (&["list", "methods"], 0),
    (&["list", "systems"], 0),
    (&["list", "functions"], 0),
    (&["check", "scene.toml"], 0),
    (&["run", "scene.toml", "--no-png"], 0),
    (&["run", "coarse.toml", "--no-png"], 4),
    (&["study", "scene.toml", "--no-png", "--force"], 4),
    (&["pick", "scene.toml", "--error", "1e-4", "--out", "pick", "--no-png", "--force"], 0),
    (&["pick", "scene.toml", "--error", "1e-300"], 4),
];

/// [`widest`] with 80 columns, for both tests.
static NARROW: LazyLock<Vec<(usize, String)>> = LazyLock::new(|| widest(Some("80")));

/// The widest line that each command prints, with `COLUMNS` if it is set, and its text.
fn widest(columns: Option<&str>) -> Vec<(usize, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let coarse = SCENE.replacen("step = 0.5", "step = 4", 1);
    for (name, text) in [("scene.toml", SCENE), ("coarse.toml", coarse.as_str())] {
        std::fs::write(folder.path().join(name), text).expect("a scene");
    }
    let text = |(arguments, expected): &(&[&str], i32)| {
        let mut command = afterbay(arguments);
        command.current_dir(folder.path()).envs(columns.map(|columns| ("COLUMNS", columns)));
        let (code, stdout, stderr) = done(&mut command);
        assert_eq!(code, Some(*expected), "{arguments:?}: {stdout}{stderr}");
        let width = stdout.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        (width, format!("{arguments:?}\n{stdout}"))
    };
    COMMANDS.iter().map(text).collect()
}

#[test]
fn no_line_is_wider_than_the_terminal() {
    for (columns, limit) in [(Some("80"), 80), (None, 120), (Some("100"), 100), (Some("0"), 120)] {
        let all = if limit == 80 { NARROW.clone() } else { widest(columns) };
        for (width, text) in &all {
            assert!(*width <= limit, "{columns:?}: {width} in {text}");
        }
        assert!(all.iter().any(|(width, _)| *width + 12 > limit), "{columns:?} is not filled");
    }
}

#[test]
fn what_does_not_fit_is_left_out_and_named() {
    let narrow = &*NARROW;
    let [methods, systems] = [&narrow[0].1, &narrow[1].1];
    assert!(methods.contains("needs") && !methods.contains("the exact flow"), "{methods}");
    assert!(methods.contains("Left out at this width: orders of q, p, w;"), "{methods}");
    assert!(systems.contains("m1, m2, l1, l2, g,"), "{systems}");
    let wide = widest(Some("400"));
    assert!(wide.iter().all(|(_, text)| !text.contains("Left out")), "{}", wide[0].1);
    assert!(wide[0].1.contains("the exact flow"), "{}", wide[0].1);
    // The reason of a failure stands below the table.
    let (_, coarse) = &narrow[5];
    assert!(coarse.contains("│ run     moddg-fixed-point"), "{coarse}");
    assert!(coarse.contains("\nmoddg-fixed-point with h = 4: step 1"), "{coarse}");
}
