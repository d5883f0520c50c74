//! Custom systems that are not valid, and places inside their expressions.

use super::{Bad, Change};

pub(super) const GOOD: &str = r#"[system]
name = "custom"
potential = "q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3"
dissipation = ["c*p1", "c*p2"]
mass = [1.0, 2.0]
parameters = { c = 0.05 }
[initial]
q = [0.3, 0.0]
p = [0.0, 0.4]
[time]
end = 10.0
step = 0.1
[run]
methods = ["increment-2"]
"#;

const V: &str = "q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3";
const D: &str = "[\"c*p1\", \"c*p2\"]";

pub(super) const CHANGES: &[Change] = &[
    (V, "q1^2/2 + p1", "p1", "p1 has no place here: a potential is made of coordinates", ""),
    (V, "q1^2/2 + qq2", "qq2", "qq2 is not known", ""),
    (V, "q1^2/2 + x", "x", "x is not known", "known here are q1, q2, t, c, pi"),
    (V, "q1^2/2 + theta", "theta", "theta is not known", "known here are q1, q2"),
    (V, "q1^2/2 + v1", "v1", "v1 has no place here: a potential is made of coordinates", ""),
    (V, "q1^2/2 + cos(time)", "time", "time is not known", "the time is called t"),
    (V, "q1**2/2", "*", "* where", "powers are written ^, as in q1^2"),
    (V, "c(1 - q1)", "(", "missing between c and (", "write c*(..)"),
    (V, "0.5 q1", "q1", "missing between 0.5 and q1", "write 0.5*q1"),
    (V, "9,81*q1", ",", ", where", "numbers are written with a point"),
    (V, "max(q1)", ")", ") where an operator or a comma", ""),
    (
        V,
        "step(q1)",
        "step",
        "step is not known",
        "the functions with jumps are sign, floor and mod",
    ),
    (V, "sign(q1)", "sign(q1)", "sign has no place here", "tanh(x/eps) is a smooth sign"),
    (V, "q2^2/2 + (q1 - 1)^(2 + c)", "(q1 - 1)^(2 + c)", "this is NaN", "as a number"),
    (V, "sum(i, 1, 2, q[i+1])", "q[i+1]", "q[3] does not exist", ""),
    (V, "sum(i, 1, 2, q[k])", "k", "k is not known", ""),
    (V, "sum(q1, 1, 2, q1)", "q1", "q1 cannot be the index of a sum", "take another name"),
    (V, "sum(c, 1, 2, c*q1)", "c", "c cannot be the index of a sum", "take another name"),
    (V, "sum(3, 1, 2, q1)", "3", "3 cannot be the index of a sum", "take another name"),
    (D, "\"c*p[i+1]\"", "p[i+1]", "p[3] does not exist: entries are counted from 1 to 2", ""),
    ("c = 0.05", "c = \"2*c\"", "c = \"2*c\"", "c is defined by itself", ""),
    ("c = 0.05", "c = \"1/0\"", "c = \"1/0\"", "this is inf", ""),
    ("c = 0.05", "c = \"1/k\"", "k", "k is not known", "known here are pi; `parameters`"),
    ("q = [0.3, 0.0]", "q = [0.3, \"2*k\"]", "k", "k is not known", ""),
    ("q = [0.3, 0.0]", "q = { count = 3, value = 0 }", "q", "q has 3", ""),
    ("q = [0.3, 0.0]", "q = { value = 0 }", "q", "the key count is missing", ""),
    (V, "q1^2/2 + sinn(q1)", "sinn", "sinn is not known: do you mean sin?", ""),
    (V, "q1^2/2 + q3", "q3", "q3 is beyond the last of 2 degrees of freedom", "have entries"),
    (V, "q1^2/2 + q0", "q0", "q0 is no coordinate", ""),
    (
        V,
        "q1^2/2 +",
        "",
        "the expression ends where a number, a name or a parenthesis should be",
        "",
    ),
    (V, "q1^2/2 ++* q2", "*", "* where a number", ""),
    (V, "", "", "the expression ends where", ""),
    (
        V,
        "(q1^2/2",
        "",
        "the expression ends where an operator or a closing parenthesis",
        "is not closed",
    ),
    (V, "sin q1", "q1", "q1 where the parenthesis of a function", ""),
    (V, "1e999*q1", "1e999", "1e999 is too large or too small", ""),
    (V, "q1^2/2 + q2^2/2 + 1/q2", "1/q2", "inf in the potential", "start where"),
    (V, "sqrt(q2^2 + q2^4)", "initial", "= NaN is not finite", "powers of max(x, 0)"),
    (V, "q2^2 + log(q1 - 1.3)", "log(q1 - 1.3)", "NaN in the potential", "start where"),
    ("\"c*p2\"", "\"c*p3\"", "p3", "p3 is beyond the last of 2", ""),
    ("\"c*p2\"", "\"c*v3\"", "v3", "v3 is beyond the last of 2", ""),
    (
        "mass = [1.0, 2.0]",
        "hamiltonian = \"p1^2 + p2^2\"",
        "potential = \"q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3\"",
        "potential does not belong here: `hamiltonian` is the whole of H",
        "",
    ),
    ("\"c*p2\"", "\"cc*p2\"", "cc", "cc is not known: do you mean c?", ""),
    ("\"c*p2\"", "\"c*p2/q2\"", "c*p2/q2", "in entry 2 of the dissipation", "start where"),
    ("\"c*p2\"", "\"c*sqrt(-1)*p2\"", "sqrt(-1)", "NaN in entry 2", "start where"),
    (
        D,
        "[\"c*p1\"]",
        "dissipation = [\"c*p1\"]",
        "the dissipation has 1 entry where there are 2",
        "",
    ),
    (D, "[]", "dissipation = []", "give one force at least", ""),
    (D, "[\"c*p1\", true]", "true", "true or false, where a number or text", ""),
    ("mass = [1.0, 2.0]", "mass = []", "mass = []", "give one mass at least", ""),
    ("mass = [1.0, 2.0]", "mass = [1.0, 0]", "0", "m2 = 0.0 must be positive", ""),
    ("mass = [1.0, 2.0]", "mass = [\"-c\", 1]", "\"-c\"", "m1 = -0.05 must be positive", ""),
    (
        "mass = [1.0, 2.0]",
        "mass = [\"q1\", 1]",
        "q1",
        "a mass is made of numbers and parameters",
        "",
    ),
    ("mass = [1.0, 2.0]", "mass = [1.0, \"1/0\"]", "1/0", "inf in mass 2", "start where"),
    (
        "mass = [1.0, 2.0]",
        "mass = [1.0, 2.0, 3.0]",
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "2 entries where there are 3",
        "",
    ),
    ("c = 0.05", "c = 0.05, d = 1", "d = 1", "parameter d is not used", ""),
    ("c = 0.05", "q1 = 0.05", "q1 = 0.05", "a parameter cannot be called \"q1\"", ""),
    ("c = 0.05", "\"a b\" = 0.05", "\"a b\" = 0.05", "a parameter cannot be called \"a b\"", ""),
    ("c = 0.05", "", "c", "c is not known", ""),
    (
        "potential = \"q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3\"\n",
        "",
        "system",
        "the key potential is missing",
        "",
    ),
    (
        "mass =",
        "friction = [[\"c\", 0], [0, \"c\"]]\nmass =",
        "friction = [[\"c\", 0], [0, \"c\"]]",
        "given by `dissipation` already",
        "",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "friction = [[\"c\", 0], [0]]",
        "friction = [[\"c\", 0], [0]]",
        "the row of the friction matrix has 1 entry",
        "",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "friction = [[\"c\", 0]]",
        "friction = [[\"c\", 0]]",
        "the friction matrix has 1 entry where there are 2",
        "",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "friction = []",
        "friction = []",
        "give one row at least",
        "",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "friction = [[\"c\", 0], [0, \"k\"]]",
        "k",
        "k is not known",
        "",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]",
        "dissipaton = [\"c*p1\"]",
        "dissipaton",
        "there is no key",
        "mean dissipation",
    ),
    (
        "dissipation = [\"c*p1\", \"c*p2\"]\nmass = [1.0, 2.0]\nparameters = { c = 0.05 }",
        "parameters = {}\nmass = []",
        "mass = []",
        "give one mass",
        "",
    ),
    (
        "q = [0.3, 0.0]",
        "q = [0.3]",
        "q = [0.3]",
        "q has 1 entry and the number of degrees of freedom is 2",
        "",
    ),
    ("p = [0.0, 0.4]", "p = []", "p = []", "p has 0 entries", ""),
    ("\"increment-2\"", "\"moddg\"", "\"moddg\"", "moddg does not apply", "list methods"),
    (
        "\"increment-2\"",
        "\"linear-exact\"",
        "\"linear-exact\"",
        "linear-exact does not apply",
        "list methods",
    ),
    (
        "\"c*p1\", \"c*p2\"]\nmass",
        "\"c*p1*p2^2\", \"c*p2\"]\nmass",
        "\"increment-2\"",
        "increment-2 does not apply: D depends on the momenta of others",
        "list methods",
    ),
    (
        "[run]",
        "[study.stability]\nsteps = [0.1]\n\
         parameter = { name = \"d\", from = 0, to = 1, count = 2 }\n[run]",
        "name = \"d\"",
        "there is no parameter d",
        "the only one is c",
    ),
    (
        "mass = [1.0, 2.0]",
        "mass = [\"c\", 2.0]\n[study.stability]\nsteps = [0.1]\n\
         parameter = { name = \"c\", from = 0, to = 1, count = 2 }\n[system.x]",
        "x",
        "there is no key x",
        "the keys are",
    ),
];

/// Errors in expressions that are quoted in every form of TOML.
pub(super) fn places() -> impl Iterator<Item = Bad> {
    let line = format!("potential = \"{V}\"");
    let written = [
        ("'q1^2/2 + ahem'", "ahem"),
        ("\"q1\\u005e2/2 + ahem\"", "ahem"),
        ("\"q1^2/2\\t+\\n\\x20ahem + q2\"", "ahem"),
        ("\"\"\"\nq1^2/2 +\n  ahem +\n q2\"\"\"", "ahem"),
        ("\"\"\"q1^2/2 + \\\n   ahem\"\"\"", "ahem"),
        ("'''\nq1^2/2\n + ahem'''", "ahem"),
        ("\"q1^2/2 + \\u0061hem\"", "\\u0061hem"),
        ("\"q1^2/2 + é\"", "é"),
    ];
    written.into_iter().flat_map(move |(text, at)| {
        let text = GOOD.replacen(&line, &format!("potential = {text}"), 1);
        let bad = |text: String| Bad {
            text,
            at: at.into(),
            says: if at == "é" { "é where a number" } else { "ahem is not known" },
            help: "",
        };
        [bad(text.clone()), bad(text.replace('\n', "\r\n"))]
    })
}
