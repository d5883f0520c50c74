//! The mistakes that end a first attempt, and texts that only look like one.

use super::{afterbay, done, squeezed};

const SCENE: &str = "\
[system]
name = \"custom\"
potential = \"g*(1 - cos(q1))\"
dissipation = [\"c*p1\"]
parameters = { g = 9.81, c = 0.1 }
[initial]
q = [3.0]
p = [0.0]
[time]
end = 1.0
step = 0.01
[run]
methods = [\"rk4\"]
";

const V: &str = "g*(1 - cos(q1))";
const INITIAL: &str = "[initial]\nq = [3.0]\np = [0.0]\n";
const METHODS: &str = "[\"rk4\"]";
const OSCILLATOR: &str = "\
name = \"damped-oscillator\"
parameters = { k = 1, b = 0.1 }
";
const CUSTOM: &str = "\
name = \"custom\"
potential = \"g*(1 - cos(q1))\"
dissipation = [\"c*p1\"]
parameters = { g = 9.81, c = 0.1 }
";

/// Parts of the scene, what stands in their place, and words that are said in this order. A scene
/// without words is valid.
const MISTAKES: &[(&str, &str, &[&str])] = &[
    (V, "g*(1 - cos(x))", &["x is not known", "known here are q1, t, c, g"]),
    (V, "g*theta^2", &["theta is not known", "known here are q1"]),
    (V, "g*q1 + v1", &["v1 has no place here", "coordinates, t and parameters"]),
    ("c*p1", "c*x", &["x is not known", "known here are q1, p1, v1, t, c, g"]),
    (V, "g*q[1]", &[]),
    (V, "ln(g + q1^2)", &[]),
    (V, "g*max(0, q1)^2", &[]),
    (V, "g*cos(t)*q1", &[]),
    (V, "g*cos(time)*q1", &["time is not known", "the time is called t"]),
    (V, "g*q1**2", &["* where", "powers are written ^"]),
    (V, "g(1 - q1)", &["missing between g and (", "write g*(..)"]),
    (V, "g*q1^2 + 0.5 q1", &["missing between 0.5 and q1", "write 0.5*q1"]),
    (V, "9,81*q1*g", &[", where", "numbers are written with a point, as in 9.81"]),
    (V, "g*(1 - cos(q1)", &["the expression ends where", "what was opened is not closed"]),
    (V, "g*q1 +", &["the expression ends where a number, a name or a parenthesis should be"]),
    (V, "g*cosh(q1", &["the expression ends where"]),
    (INITIAL, "", &["the key initial is missing", "for example", "[initial]", "q = [1.0]"]),
    ("step = 0.01\n", "", &["the key step is missing", "such as step = 0.01"]),
    ("dissipation = [\"c*p1\"]", "friction = [\"c\"]", &["is a matrix", "friction = [[\"c\"]]"]),
    ("dissipation", "damping", &["there is no key damping", "dissipation, friction"]),
    ("[initial]", "mass = \"1/10\"\n[initial]", &[]),
    (
        "q = [3.0]",
        "q = [3.0, 1.0]",
        &["q has 2 entries", "degrees of freedom is 1", "length of `dissipation` sets"],
    ),
    ("p = [0.0]", "p = [0.0, 1.0]", &["p has 2 entries", "length of `dissipation` sets"]),
    (
        "dissipation = [\"c*p1\"]",
        "mass = [\"c\", 1]",
        &["q has 1 entry and", "is 2", "length of `mass` sets"],
    ),
    ("[\"c*p1\"]", "[\"c*p1\", \"c*p2\"]", &["q has 1 entry and", "length of `dissipation`"]),
    ("step = 0.01", "step = 0.03", &["1.0 is no multiple of", "0.025 and 0.04 divide it"]),
    (METHODS, "[\"rk4\"]\nevery = 0", &["every = 0 must be a whole number from 1"]),
    (
        METHODS,
        "[\"RK4\", \"verlet\", \"rk4\", \"adaptive-dop\"]",
        &["no methods RK4, verlet, adaptive-dop", "mean rk4?", "leapfrog?", "adaptive-dop853?"],
    ),
    (METHODS, "[\"RK5\"]", &["there is no method RK5", "did you mean rk4?"]),
    (METHODS, "[]", &["the list is empty: give one method at least"]),
    ("[run]", "[study.global-order]\nsteps = [0.1]\n[run]", &["two steps at least"]),
    (
        "[run]",
        "[study.local-order]\nbase_step = 0.003\nsteps = [0.3]\n[run]",
        &["the end 1.0 is no multiple of base_step = 0.003", "0.0025 and 0.004 divide it"],
    ),
    (
        "[run]",
        "[study.local-order]\nbase_step = 0.01\nsteps = [0.105]\n[run]",
        &["the step 0.105 is no multiple of base_step = 0.01", "write 0.11"],
    ),
    (CUSTOM, "name = \"dufing\"\n", &["there is no system dufing", "mean duffing?"]),
    (CUSTOM, "name = \"pendulum\"\n", &["there is no system pendulum", "custom"]),
    ("c = 0.1", "c = 0.1, d = 2", &["parameter d is not used"]),
    (CUSTOM, "name = \"damped-oscillator\"\nparameters = { k = 1, c = 0.1 }\n", &["k, b"]),
    ("[initial]", "mass = [-1]\n[initial]", &["m1 = -1.0 must be positive"]),
    ("q = [3.0]", "q = [nan]", &["nan is not a finite number"]),
    ("p = [0.0]", "p = [-inf]", &["-inf is not a finite number"]),
    ("q = [3.0]", "q = [1e-400]", &["1e-400 is too small to be told from 0"]),
    (METHODS, "[\"linear-exact\"]", &["does not apply", "leapfrog, rk4,", "apply; `afterbay list"]),
    (CUSTOM, OSCILLATOR, &[]),
];

fn written(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("a scene");
    (folder, path)
}

/// Whether the words occur in this order, blanks and breaks of lines aside.
fn says(text: &str, words: &[&str]) -> bool {
    let text = squeezed(text);
    let mut rest = text.as_str();
    words.iter().all(|word| match rest.split_once(&squeezed(word)) {
        Some((_, behind)) => {
            rest = behind;
            true
        }
        None => false,
    })
}

#[test]
fn each_mistake_is_named_with_what_to_write_instead() {
    let mut wrong = Vec::new();
    for &(part, with, words) in MISTAKES {
        assert!(SCENE.contains(part), "{part}");
        let (folder, path) = written(&SCENE.replacen(part, with, 1));
        let (code, _, stderr) = done(afterbay(&["check"]).arg(&path));
        if code != Some(if words.is_empty() { 0 } else { 3 }) || !says(&stderr, words) {
            wrong.push(format!("{with}: {code:?} and {words:?} in {stderr}"));
        } else if words.is_empty() {
            let out = folder.path().join("out");
            let (code, _, stderr) = done(afterbay(&["run", "--out"]).arg(&out).arg(&path));
            assert_eq!(code, Some(0), "{with}: {stderr}");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_method_that_does_not_apply_is_met_with_those_that_do() {
    let energy = "hamiltonian = \"(1 + c*q1^2)*p1^2/2 + g*q1^2\"";
    let scene = SCENE.replacen("potential = \"g*(1 - cos(q1))\"", energy, 1).replacen(
        METHODS,
        "[\"leapfrog\"]",
        1,
    );
    let (_folder, path) = written(&scene);
    let (code, _, stderr) = done(afterbay(&["check"]).arg(&path));
    assert_eq!(code, Some(3), "{stderr}");
    let words = ["leapfrog does not apply", "not separable", "rk4, relaxed-rk4,", "apply"];
    assert!(says(&stderr, &words), "{stderr}");
}

#[test]
fn a_command_that_does_not_exist_is_met_with_those_that_do() {
    for (name, words) in [
        ("plot", &["'plot'", "run, study, merge, pick"][..]),
        ("stuyd", &["'study'"]),
        ("simulate", &["run, study, merge, pick"]),
    ] {
        let (code, stdout, stderr) = done(&mut afterbay(&[name]));
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{name}");
        assert!(says(&stderr, words), "{words:?} in {stderr}");
        assert!(!stderr.contains("'completions'"), "{stderr}");
    }
}

#[test]
fn a_mistake_comes_as_json_on_stdout_where_json_is_asked_for() {
    let (_folder, path) = written(&SCENE.replacen(V, "g*theta^2", 1));
    for command in [&["check"][..], &["run"], &["study"], &["pick", "--error", "1e-3"]] {
        let (code, stdout, _) = done(afterbay(command).args(["--format", "json"]).arg(&path));
        let error: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        assert_eq!(code, Some(3), "{command:?}");
        assert_eq!(error["error"], "theta is not known", "{command:?}");
        assert!(error["help"].as_str().is_some_and(|help| help.contains("q1")), "{error}");
        assert_eq!(error["place"], serde_json::json!([3, 16]));
    }
}
