//! The scene that `pick --write` makes.

use super::{afterbay, done};
use std::path::Path;

const SCENE: &str = "\
# A lesson.
[system]
name = \"damped-oscillator\" # the paper's
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 2.0
step = 0.5 # coarse
[run]
methods = [\"adaptive-dop853\", \"rk4\"]
tolerance = 1e-3
every = 4
[figure.plane]
x = \"q1\"
y = \"p1\"
methods = [\"rk4\"]
[study.energy]
[study.work-precision]
steps = [0.1]
";

/// The exit code, stdout and stderr of `pick --write`.
fn pick(scene: &Path, file: &Path, error: &str, more: &[&str]) -> (Option<i32>, String, String) {
    let mut command = afterbay(&["pick", "--error", error]);
    done(command.arg(scene).arg("--write").arg(file).args(more))
}

#[test]
fn the_scene_of_a_recommendation_is_valid_and_keeps_its_comments_and_its_studies() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, file) = (folder.path().join("scene.toml"), folder.path().join("picked.toml"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let (code, stdout, stderr) = pick(&scene, &file, "1e-3", &["--format", "json"]);
    assert_eq!(code, Some(0), "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let winner = &answer["qualified"][0];
    let name = winner["method"].as_str().expect("a name");
    let text = std::fs::read_to_string(&file).expect("a scene");
    for kept in ["# A lesson.\n", "# the paper's\n", "# coarse\n", "parameters = { k = 1.0, b"] {
        assert!(text.contains(kept), "{kept:?} in {text}");
    }
    assert!(text.contains(&format!("\nmethods = [\"{name}\"]\n")), "{text}");
    assert_eq!(text.contains("\ntolerance"), !winner["tolerance"].is_null(), "{text}");
    assert!(text.contains("[study.energy]\nmethods = [\"rk4\"]\nstep = 0.5\n"), "{text}");

    let (code, plans, stderr) = done(afterbay(&["check", "--format", "json"]).arg(&file));
    assert_eq!(code, Some(0), "{stderr} in {text}");
    let plans: serde_json::Value = serde_json::from_str(&plans).expect("JSON");
    assert_eq!(plans[0]["methods"], serde_json::json!([name]));
    let out = folder.path().join("out");
    let (code, _, stderr) = done(afterbay(&["run", "--no-png", "--out"]).arg(&out).arg(&file));
    assert_eq!(code, Some(0), "{stderr}");

    // The lines alone, in place of the scene's own tables, are a scene as well.
    let lines = answer["lines"].as_str().expect("lines");
    let (start, _) = SCENE.split_once("[time]").expect("the tables before");
    std::fs::write(&scene, format!("{start}{lines}")).expect("a scene");
    let (code, _, stderr) = done(afterbay(&["check"]).arg(&scene));
    assert_eq!(code, Some(0), "{stderr} in {start}{lines}");
}

#[test]
fn a_recommended_tolerance_has_two_digits_and_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, file) = (folder.path().join("scene.toml"), folder.path().join("picked.toml"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let error = "3.7e-6";
    let (code, stdout, stderr) = pick(&scene, &file, error, &["--format", "json"]);
    assert_eq!(code, Some(0), "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let by_tolerance: Vec<_> = answer["qualified"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|one| !one["tolerance"].is_null())
        .collect();
    let all = afterbay_methods::registry::ADAPTIVE.len();
    assert_eq!(by_tolerance.len(), all, "{stdout}");
    for one in by_tolerance {
        let tolerance = one["tolerance"].as_f64().expect("a number");
        assert!(format!("{tolerance:e}").len() <= "3.7e-6".len(), "{tolerance:e}");
        for part in ["error_qp", "error_w"] {
            assert!(one[part].as_f64().is_some_and(|found| found <= 3.7e-6), "{one}");
        }
        assert!(one["checked"]["most"].as_f64().is_some_and(|found| found <= 3.7e-6), "{one}");
    }
}

#[test]
fn a_file_is_overwritten_only_by_force_and_not_without_a_recommendation() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, file) = (folder.path().join("scene.toml"), folder.path().join("picked.toml"));
    std::fs::write(&scene, SCENE).expect("a scene");
    std::fs::write(&file, "mine").expect("a file");
    let (code, _, stderr) = pick(&scene, &file, "1e-3", &[]);
    assert!(code == Some(5) && stderr.contains("--force"), "{stderr}");
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), "mine");
    let (code, stdout, stderr) = pick(&scene, &file, "1e-3", &["--force"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("To run it") && stdout.contains("[time]\nend = 2.0\n"), "{stdout}");
    assert!(std::fs::read_to_string(&file).expect("a file").contains("# coarse"));

    let none = folder.path().join("none.toml");
    let (code, stdout, _) = pick(&scene, &none, "1e-300", &[]);
    assert!(code != Some(0) && !none.exists(), "{stdout}");
}

/// A place that cannot be written is found before the search, and the answer is printed if writing
/// fails after it.
#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_written_is_not_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).expect("a scene");
    let nowhere = folder.path().join("nowhere/found.toml");
    for file in [nowhere.as_path(), folder.path()] {
        let (code, stdout, stderr) = pick(&scene, file, "1e-3", &["--force"]);
        assert_eq!((code, stdout.as_str()), (Some(5), ""));
        assert!(stderr.contains("could not be written"), "{stderr}");
    }
    let (code, stdout, stderr) = pick(&scene, Path::new("/dev/full"), "1e-3", &["--force"]);
    assert!(code == Some(5) && stdout.contains("is the cheapest within 1e-3"), "{stdout}");
    assert!(stderr.contains("could not be written"), "{stderr}");
    let more = ["--force", "--format", "json"];
    let (code, stdout, _) = pick(&scene, Path::new("/dev/full"), "1e-3", &more);
    let answer: serde_json::Value = serde_json::from_str(&stdout).expect("one JSON");
    assert!(code == Some(5) && answer["written"].is_null() && answer["lines"].is_string());
}

#[test]
fn pick_says_that_it_does_not_follow_a_sweep() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scene, file] = ["scene.toml", "picked.toml"].map(|name| folder.path().join(name));
    let sweep = "[sweep]\nvary = { b = [0.1, 0.2], q1 = [1.0, 2.0] }\n";
    let until = SCENE.find("[figure").expect("figures");
    std::fs::write(&scene, format!("{}{sweep}", &SCENE[..until])).expect("a scene");
    let (code, stdout, stderr) = pick(&scene, &file, "1e-2", &[]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("Sweep: `pick` does not follow the sweep of b and q1"), "{stdout}");
}
