//! Drives with one mistake.

use super::Change;

pub(super) const GOOD: &str = r#"
[system]
name = "duffing"
parameters = { alpha = -1.0, beta = 1.0, c = 0.25 }
[drive]
force = ["f*cos(omega*t)"]
parameters = { f = 0.3, omega = "sqrt(1.44)" }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 1.0
step = 0.1
[run]
methods = ["moddg", "rk4"]
[figure.energies]
y = ["H", "W", "S", "s1"]
[study.global-order]
steps = [0.1, 0.05]
[sweep.vary]
f = [0.3, 0.4]
"#;

pub(super) const CHANGES: &[Change] = &[
    (
        r#"force = ["f*cos(omega*t)"]"#,
        r#"force = ["f*cos(omega*t)", "0"]"#,
        r#"force = ["f*cos(omega*t)", "0"]"#,
        "the list of forces has 2 entries where there",
        "",
    ),
    (
        r#"force = ["f*cos(omega*t)"]"#,
        r#"force = ["f*sign(q1)*cos(omega*t)"]"#,
        "sign(q1)",
        "its argument may depend on t and parameters only",
        "",
    ),
    (
        r#"force = ["f*cos(omega*t)"]"#,
        "force = []",
        "force = []",
        "the list is empty: give one force at least",
        "",
    ),
    ("cos(omega*t)", "cos(w0*t)", "w0", "w0", ""),
    (
        "cos(omega*t)",
        "cos(omega*mod(t, 0))",
        "mod(t, 0)",
        "this is NaN in force 1 of the drive",
        "",
    ),
    ("cos(omega*t)", "cos(omega*t) + p1", "p1", "a force of the drive is made of", ""),
    ("cos(omega*t)", "cos(omega*t) + q2", "q2", "q2", ""),
    (
        "cos(omega*t)",
        "cos(omega*t)/(q1 - 1)",
        "f*cos(omega*t)/(q1 - 1)",
        "this is inf in force 1 of the drive",
        "start where H",
    ),
    ("{ f = 0.3,", "{ g = 1.0, f = 0.3,", "g = 1.0", "parameter g is not used", ""),
    ("{ f = 0.3,", "{ c = 1.0, f = 0.3,", "c = 1.0", "a parameter cannot be called \"c\"", ""),
    (
        r#"methods = ["moddg", "rk4"]"#,
        r#"methods = ["moddg-q3-shared"]"#,
        "\"moddg-q3-shared\"",
        "",
        "",
    ),
    (
        "[study.global-order]\nsteps",
        "[study.long-run]\ncount = 10\n#",
        "long-run",
        "this study does not take a [drive]",
        "",
    ),
    (r#""s1"]"#, r#""s2"]"#, "\"s2\"", "", ""),
];
