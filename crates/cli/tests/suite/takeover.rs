//! A folder belongs to one scene: to its results, and to the cells that are finished.

use super::shards::Place;
use super::{afterbay, done};
use std::process::Stdio;
use std::time::{Duration, Instant};

const SCENE: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 1.0, beta = 0.5, c = 0.1 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 10.0
step = 0.1
[run]
methods = ["moddg"]
[study.energy]
"#;

/// Many points, each of some steps.
const SWEEP: &str = "[sweep]\nvary.c = { from = 0.0, to = 1.0, count = 40 }\n";

fn another(scene: &str) -> String {
    scene.replace("beta = 0.5", "beta = 0.6")
}

fn write(place: &Place, scene: &str) {
    std::fs::write(place.path("scene.toml"), scene).expect("a scene");
}

fn names(place: &Place, folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(place.path(folder)).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The exit code and stderr.
fn tried(place: &Place, task: &str, more: &[&str]) -> (Option<i32>, String) {
    let (code, _, stderr) = done(&mut place.command(task, "out", more));
    (code, stderr)
}

#[test]
fn force_removes_the_results_of_the_other_scene_and_nothing_else() {
    let place = Place::new(SCENE);
    for task in ["study", "run"] {
        place.run(task, "out", &[]);
    }
    let both = names(&place, "out/figures");
    assert!(both.iter().any(|name| name.starts_with("balance")), "{both:?}");
    for name in ["out/data/own.csv", "out/figures/own.svg", "out/notes.txt"] {
        std::fs::write(place.path(name), "mine").expect("a file");
    }
    write(&place, &another(SCENE));
    assert_eq!(tried(&place, "run", &[]).0, Some(5));
    place.run("run", "out", &["--force"]);
    let of_run = ["own.csv", "trajectory.csv", "trajectory.json"];
    assert_eq!(names(&place, "out/data"), of_run);
    let figures = names(&place, "out/figures");
    assert!(figures.iter().all(|name| !name.starts_with("balance")), "{figures:?}");
    assert!(figures.contains(&"own.svg".to_owned()) && figures.len() > 1, "{figures:?}");
    assert!(place.path("out/notes.txt").exists());
    // `--force` in a folder of the same scene keeps the tables of the other command.
    place.run("study", "out", &["--force"]);
    let kept = names(&place, "out/data");
    assert!(of_run.iter().all(|name| kept.contains(&(*name).to_owned())), "{kept:?}");
    assert!(kept.contains(&"energy.csv".to_owned()), "{kept:?}");
}

/// The finished cells of a command that took over a folder and was killed are not lost, and belong
/// to its scene.
#[test]
fn what_was_begun_by_force_is_resumed_after_a_kill() {
    let place = Place::new(&format!("{SCENE}{SWEEP}"));
    place.run("run", "out", &[]);
    let long = another(SCENE).replace("end = 10.0", "end = 200.0");
    write(&place, &format!("{long}{SWEEP}"));
    let mut command = place.command("study", "out", &["--force"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let (mut child, patience) = (child.expect("it starts"), Instant::now());
    let lines = || {
        let journal = std::fs::read_to_string(place.path("out/parts/1-of-1.jsonl"));
        journal.map_or(0, |text| text.lines().count())
    };
    while lines() < 3 && patience.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("it is killed");
    child.wait().expect("it ends");
    assert!((3..40).contains(&lines()), "{} lines", lines());
    let whole = std::fs::read_to_string(place.path("scene.toml")).expect("the scene");
    write(&place, &format!("{SCENE}{SWEEP}"));
    for task in ["run", "study"] {
        let (code, said) = tried(&place, task, &[]);
        assert!(code == Some(5) && said.contains("another scene"), "{task}: {code:?} {said}");
    }
    write(&place, &whole);
    let stdout = place.run("study", "out", &["--resume"]);
    assert!(stdout.contains("of 40 cells were there already"), "{stdout}");
}

#[test]
fn a_folder_in_which_a_command_is_at_work_is_not_used_by_another() {
    let place = Place::new(SCENE);
    place.run("study", "out", &[]);
    let lock = std::fs::File::options().write(true).open(place.path("out/parts/lock"));
    let lock = lock.expect("a lock");
    lock.try_lock().expect("nobody has it");
    let busy = |more: &[&str]| {
        let (code, said) = tried(&place, "run", more);
        assert!(code == Some(5) && said.contains("another command"), "{code:?} {said}");
    };
    busy(&[]);
    write(&place, &another(SCENE));
    busy(&["--force"]);
    assert!(place.path("out/data/energy.csv").exists());
    drop(lock);
    assert_eq!(tried(&place, "run", &["--force"]).0, Some(0));
    assert!(!place.path("out/data/energy.csv").exists());
}

/// Tables that older versions left beside the results of another scene.
#[test]
fn a_comparison_leaves_out_the_tables_of_another_scene() {
    let place = Place::new(SCENE);
    place.run("study", "out", &[]);
    write(&place, &another(SCENE));
    place.run("study", "other", &[]);
    place.run("run", "other", &[]);
    for name in ["trajectory.csv", "trajectory.json"] {
        let [from, to] = ["other", "out"].map(|of| place.path(of).join("data").join(name));
        std::fs::copy(from, to).expect("a copy");
    }
    let [a, b, out] = ["out", "other", "compared"].map(|name| place.path(name));
    let mut command = afterbay(&["compare", "--no-png", "--out"]);
    let (code, stdout, stderr) = done(command.arg(out).args([a, b]));
    assert_eq!(code, Some(0), "{stderr}");
    let said: String = stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("Left out, since they come from another scene: 1 table."), "{said}");
    assert_eq!(place.tables("compared").into_keys().collect::<Vec<_>>(), ["energy.csv"]);
}

/// A run and a study of a sweep have tables and figures of their own.
#[test]
fn a_run_and_a_study_of_a_sweep_keep_each_others_numbers() {
    let place = Place::new(&format!("{SCENE}{SWEEP}").replace("count = 40", "count = 3"));
    place.run("study", "out", &[]);
    let (of_study, figures) = (place.tables("out"), names(&place, "out/figures"));
    place.run("run", "out", &[]);
    let both = place.tables("out");
    assert!(of_study.iter().all(|(name, table)| both.get(name) == Some(table)));
    assert!(both["sweep_of_run.csv"].contains("Trajectories"));
    let now = names(&place, "out/figures");
    assert!(figures.iter().all(|name| now.contains(name)) && now.len() > figures.len());
}

#[cfg(unix)]
#[test]
fn a_link_to_nothing_is_called_so() {
    let place = Place::new(SCENE);
    std::os::unix::fs::symlink("nowhere", place.path("out")).expect("a link");
    let (code, said) = tried(&place, "run", &[]);
    assert!(code == Some(5) && said.contains("it is a link to nothing"), "{code:?} {said}");
}
