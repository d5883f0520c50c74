//! Figures and units that are not valid.

use super::Change;

/// A scene with a figure and nothing to show.
const ALONE: &str = r#"[system]
name = "duffing"
parameters = { alpha = 1, beta = 1, c = 0.1 }
[initial]
q = [1]
p = [0]
[time]
end = 1
step = 0.1
[figure.a]
y = "q1"
"#;

/// Changes of [`GOOD`](super::named::GOOD), which ends with `count = 1000`.
pub(super) const CHANGES: &[Change] = &[
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\ntitle = \"a\\u0000\"",
        "title = \"a\\u0000\"",
        "a title or a unit has no control characters",
        "leave out escapes",
    ),
    (
        "count = 1000",
        "count = 1000\n[units]\nq = \"m\\u001b\"",
        "q = \"m\\u001b\"",
        "a title or a unit has no control characters",
        "leave out escapes",
    ),
    (
        "[system]",
        "title = \"\\uffff\"\n[system]",
        "title = \"\\uffff\"",
        "a title or a unit has no control characters",
        "leave out escapes",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q7\"",
        "y = \"q7\"",
        "there is no quantity q7",
        "there are t, q1, p1, w1, W, H, K, K - K0",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = [\"q1\", \"q0\"]",
        "\"q0\"",
        "there is no quantity q0",
        "there are t, ",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\nx = \"time\"\ny = \"q1\"",
        "x = \"time\"",
        "there is no quantity time",
        "there are t, ",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\nmethods = [\"moddg\", \"leapfrog\"]",
        "\"leapfrog\"",
        "there is no method in [run] named leapfrog",
        "there are moddg, rk4",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = [\"q1\", \"H\", \"q1\"]",
        "\"q1\"",
        "q1 is in the list already",
        "",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\nmethods = [\"rk4\", \"rk4\"]",
        "\"rk4\"",
        "rk4 is in the list already",
        "",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = []",
        "y = []",
        "give one quantity at least",
        "",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\nmethods = []",
        "methods = []",
        "give one method at least",
        "",
    ),
    ("count = 1000", "count = 1000\n[figure.a]\nx = \"q1\"", "a", "the key y is missing", "map ="),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\nmap = \"q\"",
        "map = \"q\"",
        "map does not belong here",
        "",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\nmap = \"q\"\nlog = true",
        "log = true",
        "log does not belong here",
        "",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\nmap = \"H\"",
        "\"H\"",
        "there is no choice H",
        "there are q, p, w",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.a]\ny = \"q1\"\ncolour = \"red\"",
        "colour",
        "there is no key colour",
        "the keys are log, map, methods, title, x, y",
    ),
    (
        "count = 1000",
        "count = 1000\n[figure.\"../a\"]\ny = \"q1\"",
        "\"../a\"",
        "\"../a\" cannot be the name of a figure",
        "letters, digits",
    ),
    ("count = 1000", "count = 1000\n[figure]\na = 1", "1", "a number, where a table", ""),
    (
        "count = 1000",
        "count = 1000\n[units]\nmomentum = \"N s\"",
        "momentum",
        "there is no key momentum",
        "the keys are energy, p, q, time",
    ),
    (super::named::GOOD, ALONE, "a", "figures show the trajectories of [run]", ""),
];
