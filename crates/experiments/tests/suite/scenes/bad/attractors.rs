//! Studies of attractors with one mistake.

use super::Change;

pub(super) const GOOD: &str = r#"
[system]
name = "duffing"
parameters = { alpha = -1.0, beta = 1.0, c = 0.25 }
[drive]
force = ["f*cos(omega*t)"]
parameters = { f = 0.3, omega = 1.2 }
period = "2*pi/omega"
[initial]
q = [1.0]
p = [0.0]
[time]
end = 1.0
step = 0.1
[study.poincare]
methods = ["moddg", "rk4"]
steps = [0.2]
starts = 2
spread = 0.5
points = 7
[study.bifurcation]
methods = ["moddg"]
parameter = { name = "f", from = 0.2, to = 0.3, count = 3 }
transient = 9
section = { of = "p1", value = 0.1 }
[study.resonance]
methods = ["moddg"]
parameter = { name = "omega", from = 0.8, to = 1.4, count = 5 }
[study.basins]
methods = ["moddg"]
grid = { q1 = { from = -1, to = 1, count = 4 }, p1 = { from = -1, to = 2, count = 3 } }
longest = 50
[study.lyapunov]
methods = ["moddg"]
steps = [0.05]
time = 40.0
rows = 8
[study.limit-cycle]
methods = ["moddg"]
periods = 2
parameter = { name = "f", from = 0.2, to = 0.4 }
"#;

pub(super) const CHANGES: &[Change] = &[
    (
        "2*pi/omega\"",
        "pi/omega\"",
        "period = \"pi/omega\"",
        "is no period of the drive: force 1 is",
        "",
    ),
    ("2*pi/omega\"", "0\"", "period = \"0\"", "it must be positive and finite", ""),
    ("2*pi/omega\"", "2*pi/t\"", "t", "", ""),
    ("points = 7", "points = 0", "points = 0", "points = 0 must be at least 1", ""),
    (
        "[study.resonance]\n",
        "[study.resonance]\nperiods = 0\n",
        "periods = 0",
        "periods = 0 must be at least 1",
        "",
    ),
    (
        "to = 0.3, count = 3",
        "to = 0.3, count = 1",
        "to = 0.3",
        "to = 0.3 must be that of `from`, where there is one value",
        "",
    ),
    ("starts = 2", "starts = 0", "starts = 0", "starts = 0 must be from 1 to 100000", ""),
    ("spread = 0.5", "spread = -0.5", "spread = -0.5", "spread = -0.5 must be positive", ""),
    ("spread = 0.5\n", "", "poincare", "the key spread is missing", "spread = 0.5"),
    (
        "spread = 0.5",
        "interval = 1.0",
        "interval = 1.0",
        "the interval 1.0 is no multiple of the period",
        "5.2",
    ),
    (
        "section = {",
        "interval = 1.0\nsection = {",
        "interval = 1.0",
        "interval does not belong here",
        "",
    ),
    ("of = \"p1\"", "of = \"p2\"", "of = \"p2\"", "there is no coordinate or momentum p2", ""),
    ("of = \"p1\"", "of = \"w1\"", "of = \"w1\"", "there is no coordinate or momentum w1", ""),
    ("name = \"f\"", "name = \"g\"", "name = \"g\"", "there is no parameter g", ""),
    (
        "name = \"omega\"",
        "name = \"f\"",
        "name = \"f\"",
        "f cannot be varied: it does not change the period",
        "",
    ),
    (
        ", p1 = { from = -1, to = 2, count = 3 }",
        "",
        "grid",
        "a map of basins has two axes",
        "grid =",
    ),
    ("p1 = { from = -1", "p3 = { from = -1", "p3", "there is no coordinate or momentum p3", ""),
    ("longest = 50", "longest = 0", "longest = 0", "longest = 0 must be at least 1", ""),
    ("time = 40.0", "time = 0.0", "time = 0.0", "time = 0 must be positive", ""),
    ("rows = 8", "rows = 900", "rows = 900", "with a step between two rows", ""),
    ("periods = 2", "periods = 0", "periods = 0", "periods = 0 must be at least 1", ""),
    ("to = 0.4 }", "to = 0.2 }", "to = 0.2", "another value than `from`", ""),
    ("to = 0.4 }", "to = 0.4, count = 3 }", "count", "there is no key count", ""),
    (
        "count = 4 }",
        "count = 400000 }",
        "count = 400000",
        "count = 400000 must be from 1 to 100000",
        "",
    ),
    (
        "points = 7",
        "points = 70000000",
        "points = 70000000",
        "the output in bytes would be",
        "take fewer points",
    ),
    (
        "from = 0.2, to = 0.4 }",
        "from = 0.2, to = 0.4, count = 5 }",
        "count",
        "there is no key count",
        "leave it out: a branch of limit cycles has the values",
    ),
    (
        "transient = 9",
        "transient = 90000000000",
        "bifurcation",
        "the number of steps would be",
        "shorter transients",
    ),
    (
        "force = [\"f*cos(omega*t)\"]",
        "force = [\"f*cos(omega*t^2)\"]",
        "period = \"2*pi/omega\"",
        "is no period",
        "",
    ),
    (
        "force = [\"f*cos(omega*t)\"]\nparameters = { f = 0.3, omega = 1.2 }\n\
         period = \"2*pi/omega\"",
        "force = [\"f*cos(omega*t^2)\"]\nparameters = { f = 0.3, omega = 1.2 }",
        "poincare",
        "the dependence on t shows no period",
        "2*pi/omega",
    ),
];
