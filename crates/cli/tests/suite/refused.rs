//! Refusals and their exit codes.

use super::{afterbay, bad, done, folder, squeezed};
use afterbay_experiments::scene::Scene;
use std::path::Path;

/// A folder that contains a file.
fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    (folder, path)
}

/// The exit code and stderr of `check`. stdout must be empty.
fn check(path: &Path) -> (Option<i32>, String) {
    let (code, stdout, stderr) = done(afterbay(&["check"]).arg(path));
    assert!(code == Some(0) || stdout.is_empty(), "{stdout}");
    (code, stderr)
}

#[test]
fn a_bad_scene_ends_with_3_and_says_where_and_what_to_do() {
    let (_folder, path) = written("scene.toml", b"");
    for bad in bad::all() {
        std::fs::write(&path, &bad.text).expect("a file");
        let (code, stderr) = check(&path);
        let said = squeezed(&stderr);
        let short: String = stderr.chars().take(2000).collect();
        assert_eq!(code, Some(3), "{short}");
        assert!(said.contains(&squeezed(bad.says)), "{:?} in {short}", bad.says);
        assert!(said.contains(&squeezed(bad.help)), "{:?} in {short}", bad.help);
        assert!(stderr.len() < 4000, "{} bytes: {short}", stderr.len());
        let span = Scene::read(&bad.text).expect_err("a bad scene").span;
        let before = &bad.text[..span.start];
        let (line, column) = (
            before.matches('\n').count() + 1,
            before.rsplit('\n').next().map_or(1, |line| line.chars().count() + 1),
        );
        if span != (0..0) {
            assert!(
                said.contains(&format!("scene.toml:{line}:{column}")),
                "{line}:{column} in {short}"
            );
        }
        if !bad.at.is_empty() && bad.at.len() < 60 && !short.contains("scene.toml:1:") {
            assert!(said.contains(&squeezed(&bad.at)), "{:?} in {short}", bad.at);
        }
    }
}

#[test]
fn a_file_that_is_no_scene_ends_with_3() {
    let (folder, path) = written("scene.toml", b"[system]\nname = \"\xe9\"\n");
    let (code, stderr) = check(&path);
    assert_eq!(code, Some(3));
    assert!(stderr.contains("UTF-8") && stderr.contains("scene.toml:2:9"), "{stderr}");
    std::fs::write(&path, vec![b'#'; (1 << 20) + 1]).expect("a file");
    let (code, stderr) = check(&path);
    assert!(code == Some(3) && squeezed(&stderr).contains("morethan1048576"), "{stderr}");
    for nowhere in [folder.path().to_path_buf(), folder.path().join("nowhere.toml")] {
        let (code, stderr) = check(&nowhere);
        assert!(code == Some(3) && squeezed(&stderr).contains("cannotberead"), "{stderr}");
        assert!(stderr.contains("scenes/"), "{stderr}");
    }
}

/// `pick` and studies follow the motion without events.
#[test]
fn a_wall_that_is_not_followed_ends_with_3_and_a_stop_is_said() {
    let text = std::fs::read_to_string(folder().join("damped-oscillator.toml")).expect("a scene");
    let until = text.find("[run]").expect("runs");
    let scene = |action: &str, more: &str| {
        format!(
            "{}[run]\nmethods = [\"rk4\"]\n[run.events.wall]\nof = \"q1\"\nvalue = -0.3\n\
             direction = \"falling\"\naction = \"{action}\"\n{more}",
            &text[..until]
        )
    };
    let study = "[study.global-order]\nsteps = [0.1, 0.05]\n";
    let (folder, path) = written("scene.toml", scene("bounce", "").as_bytes());
    let pick = || done(afterbay(&["pick", "--error", "1e-2"]).arg(&path));
    let out = folder.path().join("out");
    let study_of = || done(afterbay(&["study", "--no-png", "--out"]).arg(&out).arg(&path));
    let said = |text: &str| squeezed(text);
    let why = said("the event wall changes the state: neither a study nor `pick` follows it");
    let (code, stdout, stderr) = pick();
    assert_eq!((code, stdout.as_str()), (Some(3), ""));
    assert!(said(&stderr).contains(&why) && said(&stderr).contains("`afterbayrun`"), "{stderr}");
    // A scene for `run` alone is valid, and `check` says what else does not take it.
    let (code, stdout, _) = done(afterbay(&["check"]).arg(&path));
    assert!(code == Some(0) && said(&stdout).contains("neitherastudynor"), "{stdout}");
    std::fs::write(&path, scene("bounce", study)).expect("a file");
    for (code, stdout, stderr) in [study_of(), done(afterbay(&["check"]).arg(&path))] {
        assert_eq!((code, stdout.as_str()), (Some(3), ""));
        assert!(said(&stderr).contains(&why), "{stderr}");
    }
    assert!(!out.exists());
    std::fs::write(&path, scene("stop", study)).expect("a file");
    let goes_on = said("wall would end a run; studies and `pick` follow the motion to its end");
    for (code, stdout, stderr) in [pick(), study_of(), done(afterbay(&["check"]).arg(&path))] {
        assert!(code == Some(0) && said(&stdout).contains(&goes_on), "{stdout}{stderr}");
    }
}

#[test]
fn a_scene_with_nothing_to_do_ends_with_3() {
    let [_, good, ..] = bad::GOOD;
    let (_folder, path) = written("scene.toml", good.as_bytes());
    let (code, _, stderr) = done(afterbay(&["study"]).arg(&path));
    assert!(code == Some(3) && stderr.contains("the scene has no [study.*]"), "{stderr}");
    std::fs::write(&path, good.replace("[run]\nmethods", "[study.energy]\nmethods"))
        .expect("a file");
    let (code, _, stderr) = done(afterbay(&["run"]).arg(&path));
    assert!(code == Some(3) && stderr.contains("the scene has no [run]"), "{stderr}");
    assert!(stderr.contains("afterbay schema"), "{stderr}");
}

#[test]
fn arguments_that_make_no_sense_end_with_2() {
    for (arguments, says) in [
        (&["pick", "x.toml", "--error", "0"][..], "positive, finite number such as 1e-8"),
        (&["pick", "x.toml", "--error", "-1"], "positive, finite number"),
        (&["pick", "x.toml", "--error", "nan"], "positive, finite number"),
        (&["pick", "x.toml", "--error", "inf"], "positive, finite number"),
        (&["pick", "x.toml", "--error", "small"], "positive, finite number"),
        (&["pick", "x.toml"], "--error <E>"),
        (&["run", "x.toml", "--threads", "0"], "1..=1024"),
        (&["run", "x.toml", "--threads", "-1"], "1..=1024"),
        (&["run", "x.toml", "--threads", "two"], "--threads <N>"),
        (&["run", "x.toml", "--format", "xml"], "table, json"),
        (&["run", "x.toml", "--forse"], "--force"),
        (&["run"], "<SCENE>"),
        (&["study"], "<SCENE>"),
        (&["check"], "<SCENE>"),
        (&["stuyd", "x.toml"], "'study'"),
        (&["completions", "basch"], "bash"),
        (&["completions"], "<SHELL>"),
        (&["schema", "x.toml"], "unexpected argument"),
    ] {
        let (code, stdout, stderr) = done(&mut afterbay(arguments));
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(stderr.contains(says), "{says:?} in {stderr}");
    }
}

#[test]
fn results_go_nowhere_they_do_not_belong_and_that_ends_with_5() {
    let (folder, occupied) = written("occupied", b"a file, not a folder");
    let scene = super::folder().join("pendulum.toml");
    let (code, stdout, stderr) = done(afterbay(&["run", "--out"]).arg(&occupied).arg(&scene));
    assert_eq!((code, stdout.as_str()), (Some(5), ""));
    assert!(stderr.contains("could not be written") && stderr.contains("--out DIR"), "{stderr}");
    let said = squeezed(&stderr);
    assert!(said.contains("itisafile,notafolder") && !said.contains("oserror"), "{stderr}");

    let out = folder.path().join("out");
    let run = |scene: &str, more: &[&str]| {
        done(afterbay(&["run", "--out"]).arg(&out).arg(super::folder().join(scene)).args(more))
    };
    assert_eq!(run("pendulum.toml", &[]).0, Some(0));
    assert_eq!(run("pendulum.toml", &[]).0, Some(0), "the same scene may be run again");
    let before = std::fs::read_to_string(out.join("run.json")).expect("written");
    let (code, stdout, stderr) = run("duffing.toml", &[]);
    assert_eq!((code, stdout.as_str()), (Some(5), ""));
    assert!(
        stderr.contains("holds the results of another scene") && stderr.contains("--force"),
        "{stderr}"
    );
    assert_eq!(std::fs::read_to_string(out.join("run.json")).expect("still there"), before);
    assert_eq!(run("duffing.toml", &["--force"]).0, Some(0));
    assert_ne!(std::fs::read_to_string(out.join("run.json")).expect("written"), before);

    let (code, stdout, stderr) = done(afterbay(&["paper", "--quick", "--out"]).arg(&out));
    assert_eq!((code, stdout.as_str()), (Some(5), ""));
    assert!(stderr.contains("holds results of `afterbay run`"), "{stderr}");

    let report = folder.path().join("report.html");
    std::fs::write(&report, "of something else").expect("written");
    let mut command = afterbay(&["run", "--force", "--out"]);
    let (code, _, stderr) = done(command.arg(folder.path()).arg(&scene));
    assert_eq!(code, Some(5), "{stderr}");
    assert!(stderr.contains("report.html is not overwritten"), "{stderr}");
    assert_eq!(std::fs::read_to_string(&report).expect("still there"), "of something else");

    let data = folder.path().join("mine/data");
    std::fs::create_dir_all(&data).expect("a folder");
    std::fs::write(data.join("trajectory.csv"), "mine").expect("written");
    let mut command = afterbay(&["run", "--out"]);
    let (code, _, stderr) = done(command.arg(folder.path().join("mine")).arg(&scene));
    assert_eq!(code, Some(5), "{stderr}");
    let kept = std::fs::read_to_string(data.join("trajectory.csv"));
    assert_eq!(kept.expect("still there"), "mine");
}

#[test]
fn control_characters_of_a_scene_do_not_reach_the_terminal() {
    let text = "[system]\nname = 'duffing'\nparameters = { alpha = 1.0, beta = 1.0, c = 0.1 }\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n\
                [run]\nmethods = [\"\\u001b[31mred\"]\n";
    for text in [text.to_owned(), format!("# \u{1b}[31m\n{text}")] {
        let (_folder, path) = written("scene.toml", text.as_bytes());
        let (code, stderr) = check(&path);
        assert_eq!(code, Some(3), "{stderr:?}");
        assert!(!stderr.contains('\u{1b}'), "{stderr:?}");
    }
}

#[test]
fn results_of_a_scene_without_a_name_have_a_folder_of_their_own() {
    let text = "[system]\nname = 'duffing'\nparameters = { alpha = 1.0, beta = 1.0, c = 0.1 }\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n\
                [run]\nmethods = ['rk4']\n";
    for name in ["...toml", "..toml"] {
        let (folder, path) = written(name, text.as_bytes());
        let mut command = afterbay(&["run", "--no-png"]);
        let (code, _, stderr) = done(command.arg(path).current_dir(folder.path()));
        assert_eq!(code, Some(0), "{stderr}");
        assert!(folder.path().join("out").join(name).join("report.html").exists(), "{name}");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2, "{name}");
    }
}

#[test]
fn a_run_that_fails_ends_with_4_and_its_results_are_written() {
    let text = std::fs::read_to_string(folder().join("damped-oscillator.toml")).expect("a scene");
    let changed =
        text.replacen("step = 0.01", "step = 4", 1).replacen("end = 20.0", "end = 4000", 1);
    let until = changed.find("[study.").expect("studies");
    let changed = changed[..until].replace("every = 10\n", "").replace("rk4", "moddg-fixed-point");
    let (folder, path) = written("scene.toml", changed.as_bytes());
    let out = folder.path().join("out");
    let (code, stdout, stderr) = done(afterbay(&["run", "--out"]).arg(&out).arg(&path));
    assert_eq!(code, Some(4), "{stdout}{stderr}");
    assert!(
        stdout.contains("did not complete") && stdout.contains("moddg-fixed-point"),
        "{stdout}"
    );
    assert!(out.join("report.html").exists() && out.join("data/trajectory.csv").exists());
}

#[test]
fn programs_read_the_error_as_json() {
    let [good, ..] = bad::GOOD;
    let (_folder, path) = written("bad.toml", good.replace("\"moddg\"", "\"mdodg\"").as_bytes());
    let (code, stdout, _) = done(afterbay(&["check", "--format", "json"]).arg(&path));
    let error: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let at = good.split("\"moddg\"").next().expect("text before it");
    let column = at.rsplit('\n').next().expect("a line").len() + 1;
    assert_eq!(code, Some(3));
    assert_eq!(error["error"], "there is no method mdodg");
    assert_eq!(error["help"], "did you mean moddg?");
    assert_eq!(error["place"], serde_json::json!([at.matches('\n').count() + 1, column]));
    assert_eq!(error["exit_code"], 3);
}

#[test]
fn programs_read_errors_of_the_command_line_as_json() {
    for (arguments, says) in [
        (&["--format", "json", "run"][..], "required arguments"),
        (&["--format=json", "list", "foo"], "invalid value 'foo'"),
        (&["check", "a.toml", "b.toml", "--format", "json"], "unexpected argument 'b.toml'"),
    ] {
        let (code, stdout, stderr) = done(&mut afterbay(arguments));
        let error: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        assert_eq!((code, &error["exit_code"]), (Some(2), &serde_json::json!(2)));
        let said = error["error"].as_str().expect("a message");
        assert!(said.contains(says) && !said.starts_with("error"), "{said}");
        assert!(error["help"].as_str().is_some_and(|help| help.contains("--help")), "{stdout}");
        assert!(stderr.contains(says), "{stderr}");
    }
    let (code, stdout, _) = done(&mut afterbay(&["list", "foo"]));
    assert_eq!((code, stdout.as_str()), (Some(2), ""));
}

/// Runs of a sweep that end alike have one row, and the reason of the first.
#[test]
fn runs_that_fail_alike_are_counted() {
    let text = std::fs::read_to_string(folder().join("damped-oscillator.toml")).expect("a scene");
    let until = text.find("[study.").expect("studies");
    let text = text[..until].replace("end = 20.0", "end = 4000").replace("every = 10\n", "");
    let text = text.replace("step = 0.01", "step = 4");
    let sweep = "[sweep]\nvary = { k = { from = 1.0, to = 2.0, count = 30 } }\n";
    let (folder, path) = written("scene.toml", (text + sweep).as_bytes());
    let out = folder.path().join("out");
    let mut command = afterbay(&["run", "--no-png", "--out"]);
    let (code, stdout, stderr) = done(command.arg(&out).arg(&path));
    assert_eq!(code, Some(4), "{stdout}{stderr}");
    for method in ["leapfrog", "rk4"] {
        let is_row = |line: &&str| line.contains(method) && line.contains("not-finite");
        assert_eq!(stdout.lines().filter(is_row).count(), 1, "{stdout}");
    }
    assert!(
        stdout.contains("rk4 with h = 4 at k = 1: step") && stdout.contains("  30 "),
        "{stdout}"
    );
    assert!(squeezed(&stdout).contains("Thefirstofeachrow;allarein"), "{stdout}");
}

/// The plan names the methods that choose their steps, too.
#[test]
fn the_plan_of_a_scene_is_what_a_study_runs() {
    let [good, ..] = bad::GOOD;
    let steps = "[\"leapfrog\"]\nsteps = { from = 0.1, to = 0.2, count = 2 }\n";
    for (keys, methods, detail) in [
        (steps.to_owned(), &["leapfrog"][..], "2 steps"),
        (
            format!("{steps}tolerances = [1e-8]\n"),
            &[
                "leapfrog",
                "adaptive-collocation",
                "adaptive-dop853",
                "adaptive-verner98",
                "adaptive-verner87",
                "adaptive-radau",
            ],
            "2 steps, 1 tolerance",
        ),
        (
            "[\"adaptive-radau\"]\ntolerances = [1e-6, 1e-8]\n".to_owned(),
            &["adaptive-radau"],
            "2 tolerances",
        ),
    ] {
        assert!(good.contains(steps));
        let (_folder, path) = written("plan.toml", good.replace(steps, &keys).as_bytes());
        let (_, stdout, stderr) = done(afterbay(&["check", "--format", "json"]).arg(&path));
        let plans: serde_json::Value = serde_json::from_str(&stdout).expect(&stderr);
        let plans = plans.as_array().expect("plans");
        let cost = plans.iter().find(|plan| plan["what"] == "work-precision").expect("its plan");
        assert_eq!(cost["methods"], serde_json::json!(methods), "{keys}");
        assert_eq!(cost["detail"], detail);
    }
}

#[test]
fn the_plan_names_samples_and_says_where_there_is_nothing_to_do() {
    let text = std::fs::read_to_string(folder().join("damped-oscillator.toml")).expect("a scene");
    let until = |table: &str| text[..text.find(table).expect(table)].to_owned();
    let run = until("[study.").replace("every = 10", "sample = 0.3");
    let long = run.replace("end = 20.0", "end = 1e300").replace("step = 0.01", "step = 1e300");
    let every = long.replace("sample = 0.3\n", "");
    for (text, says) in [
        (until("[run]"), "It has no [run] and no [study.*]: there is nothing to do."),
        (run, "2000 steps of 0.01, 67 states at multiples of 0.3"),
        (every, "1 step of 1e300, every state kept"),
    ] {
        let (_folder, path) = written("plan.toml", text.as_bytes());
        let (code, stdout, stderr) = done(afterbay(&["check"]).arg(&path));
        assert_eq!(code, Some(0), "{stderr}");
        assert!(stdout.contains(says), "{stdout}");
    }
}
