//! Valid scenes are read, and others are refused with a message, a place and advice, within a
//! second.

use super::{SOON, bad, soon};
use afterbay_experiments::scene::{MOST_BYTES, Scene, SceneProblem, text};

#[test]
fn what_is_wrong_is_said_pointed_at_and_soon() {
    let all = bad::all();
    assert!(all.len() >= 70, "{}", all.len());
    let mut wrong = Vec::new();
    for bad in &all {
        let (took, read) = soon(|| text(bad.text.as_bytes()).and_then(Scene::read));
        let short: String = bad.text.chars().take(1200).collect();
        let Err(error) = read else {
            wrong.push(format!("{short}\n  was accepted"));
            continue;
        };
        let (says, help) = (error.problem.to_string(), error.problem.help().unwrap_or_default());
        let at =
            bad.text.get(error.span.clone()).and_then(|at| at.lines().next()).unwrap_or_default();
        if !says.contains(bad.says) || !help.contains(bad.help) || at != bad.at || took > SOON {
            let at: String = at.chars().take(200).collect();
            wrong.push(format!(
                "  expected {:?} / {:?} / {:?}\n  found    {at:?} / {says:?} / {help:?} at {:?} \
                 after {took:?}",
                bad.at, bad.says, bad.help, error.span
            ));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n"));
}

#[test]
fn marks_before_a_text_line_ends_and_whole_numbers_do_not_matter() {
    for good in bad::GOOD {
        let scene = Scene::read(good).unwrap();
        let marked = format!("\u{feff}{}", good.replace('\n', "\r\n"));
        let same = Scene::read(text(marked.as_bytes()).unwrap()).unwrap();
        assert_eq!(format!("{:?}", same.document), format!("{:?}", scene.document));
        let whole = Scene::read(
            &good
                .replace("step = 0.01\n[run]", "step = 1\n[run]")
                .replace("step = 0.1", "step = 1"),
        );
        assert_eq!(whole.unwrap().step, 1.0);
    }
}

#[test]
fn tolerances_have_a_budget() {
    let [good, ..] = bad::GOOD;
    let with = |count: u32| {
        let list: Vec<String> =
            (0..count).map(|i| format!("{:e}", 1e-6 * f64::from(1 + i))).collect();
        Scene::read(&good.replace(
            "[\"leapfrog\"]",
            &format!("[\"leapfrog\"]\ntolerances = [{}]", list.join(", ")),
        ))
    };
    assert_eq!(with(1000).unwrap().studies.work_precision.unwrap().tolerances.len(), 1000);
    let error = with(1001).unwrap_err();
    assert!(
        matches!(error.problem, SceneProblem::Budget { what: "the number of tolerances", .. }),
        "{error:?}"
    );
}

#[test]
fn a_mark_before_a_text_does_not_count_in_its_places() {
    let error = Scene::read(text(b"\xef\xbb\xbf[sistem]\n").unwrap()).unwrap_err();
    assert_eq!(error.span, 1..7);
}

#[test]
fn what_is_quoted_or_remarked_is_no_nesting() {
    let [good, custom, ..] = bad::GOOD;
    Scene::read(&format!("# {}\n# {}\n{good}", ".".repeat(200), "[".repeat(200))).unwrap();
    let long = format!(
        "potential = \"\"\"\n{}q1^2/2 + q2^2/2\"\"\"\nmass",
        "0.5*q1 + 0.5*q2 +\n".repeat(60)
    );
    let potential = custom.lines().find(|line| line.starts_with("potential")).unwrap();
    Scene::read(&custom.replacen(potential, "", 1).replacen("mass", &long, 1)).unwrap();
}

#[test]
fn what_is_no_text_or_too_much_of_it_is_refused() {
    let error = text(b"[system]\nname = \"\xff\"").unwrap_err();
    assert_eq!((error.problem, error.span), (SceneProblem::NoText, 17..17));
    let most = [b'#'; MOST_BYTES + 1];
    assert!(text(&most[1..]).is_ok());
    let error = text(&most).unwrap_err();
    assert!(matches!(error.problem, SceneProblem::TooLarge { .. }));
    assert!(error.problem.help().unwrap().contains("right file"));
}

#[test]
fn a_scene_says_what_it_leaves_out() {
    let [good, ..] = bad::GOOD;
    let scene = Scene::read(&good.replacen("every = 10\n", "", 1).replacen(
        "step = 0.01\nevery = 100",
        "",
        1,
    ))
    .unwrap();
    let names = |rows: &[&'static afterbay_methods::registry::Row]| {
        rows.iter().map(|row| row.name).collect::<Vec<_>>()
    };
    assert_eq!(scene.run.unwrap().every, 1);
    let energy = scene.studies.energy.unwrap();
    assert_eq!(
        (energy.step, energy.every, names(&energy.methods)),
        (0.01, 1, vec!["moddg", "rk4"])
    );
    let work = scene.studies.work_precision.unwrap();
    assert_eq!((work.steps, names(&work.methods)), (vec![0.1, 0.2], vec!["leapfrog"]));
    let stability = scene.studies.stability.unwrap();
    assert_eq!((stability.steps[0], stability.steps[5], stability.end), (0.01, 10.0, 20.0));
    assert_eq!(stability.values, [0.0, 4.5, 9.0]);
    assert!(
        stability
            .steps
            .windows(2)
            .all(|pair| (pair[1] / pair[0] / 1000.0_f64.powf(0.2) - 1.0).abs() < 1e-12)
    );
}

#[test]
fn rules_make_what_lists_make() {
    let with = |dissipation: &str, mass: &str, c: &str, q: &str| {
        let [_, good, ..] = bad::GOOD;
        Scene::read(
            &good
                .replace("[\"c*p1\", \"c*p2\"]", dissipation)
                .replace("[1.0, 2.0]", mass)
                .replace("c = 0.05", c)
                .replace("[0.3, 0.0]", q),
        )
        .unwrap()
    };
    let lists = with("[\"1*c*p1\", \"2*c*p2\"]", "[1.5, 2.0]", "c = 0.05", "[0.3, 0.15]");
    for q in ["[\"c + 0.25\", 0.15]", "{ count = 2, value = \"0.3/i\" }", "\"0.3/i\""] {
        let rules = with("\"i*c*p[i]\"", "\"1 + i/n\"", "b = 0.5, c = \"b/10\"", q);
        let [a, b] = [&lists, &rules].map(|scene| scene.problem.start::<f64>().unwrap());
        assert_eq!(a, b, "{q}");
        let [a, b] = [&lists, &rules].map(|scene| scene.problem.model.system::<f64>().unwrap());
        let ([mut d, mut e], v) = ([[0.0; 2]; 2], [0.7, -0.2]);
        a.dissipation(&[0.0; 2], &v, &v, &mut d);
        b.dissipation(&[0.0; 2], &v, &v, &mut e);
        assert_eq!(d, e, "{q}");
        assert_eq!(a.energy(&[0.1, 0.2], &v), b.energy(&[0.1, 0.2], &v), "{q}");
    }
}

#[test]
fn methods_that_choose_their_steps_are_named_like_the_others() {
    let with = |methods: &str, run: &str, time: &str| {
        let [good, ..] = bad::GOOD;
        let [before, after] =
            good.split_once("[study.local-order]").map(<[&str; 2]>::from).unwrap();
        let study = after.split_once("[study.work-precision]").unwrap().1;
        let study = study.split_once("[study.stability]").unwrap().0;
        let text = format!("{before}[study.work-precision]{study}")
            .replace("[\"moddg\", \"rk4\"]\n", &format!("{methods}\n{run}\n"))
            .replace("step = 0.01\n", time)
            .replace("[\"leapfrog\"]", "[\"leapfrog\", \"adaptive-dop853\"]\ntolerances = [1e-6]");
        Scene::read(&text)
    };
    let names = |rows: &[&afterbay_methods::registry::Row]| -> Vec<_> {
        rows.iter().map(|row| row.name).collect()
    };
    let (both, step) = ("[\"rk4\", \"adaptive-dop853\"]", "step = 0.01\n");
    let scene = with(both, "tolerance = 1e-6", step).unwrap();
    let run = scene.run.unwrap();
    assert_eq!((names(&run.methods), names(&run.adaptive)), (vec!["rk4"], vec!["adaptive-dop853"]));
    let study = scene.studies.work_precision.unwrap();
    assert_eq!(names(&study.methods), ["leapfrog"]);
    assert_eq!(names(&study.adaptive), ["adaptive-dop853"]);

    let run = with("[\"rk4\"]", "tolerance = 1e-6", step).unwrap().run.unwrap();
    assert_eq!(names(&run.adaptive), ["adaptive-collocation"]);

    let free = with("[\"adaptive-dop853\"]", "tolerance = 1e-6", "").unwrap();
    assert_eq!(names(&free.run.unwrap().methods), [""; 0]);
    assert_eq!(free.step, free.problem.end / 1000.0);

    let says = |methods, run, time| with(methods, run, time).unwrap_err().problem.to_string();
    assert_eq!(says(both, "", step), "adaptive-dop853 takes a tolerance instead of a step");
    assert_eq!(says(both, "tolerance = 1e-6", ""), "the key step is missing");
}

#[test]
fn the_cost_of_accuracy_has_steps_and_tolerances_for_the_methods_that_take_them() {
    let with = |keys: &str| {
        let [good, ..] = bad::GOOD;
        let (before, after) = good.split_once("[study.work-precision]\n").unwrap();
        let (_, after) = after.split_once("[study.stability]").unwrap();
        Scene::read(&format!("{before}[study.work-precision]\n{keys}\n[study.stability]{after}"))
            .map(|scene| scene.studies.work_precision.unwrap())
            .map_err(|error| error.problem.to_string())
    };
    let chosen = with("methods = [\"adaptive-dop853\"]\ntolerances = [1e-6]").unwrap();
    assert_eq!((chosen.methods.len(), chosen.steps.len(), chosen.adaptive.len()), (0, 0, 1));
    let fixed = with("methods = [\"rk4\"]\nsteps = [0.1]").unwrap();
    assert_eq!((fixed.methods.len(), fixed.steps.len(), fixed.adaptive.len()), (1, 1, 0));
    for keys in
        ["tolerances = [1e-6]", "methods = [\"rk4\"]", "methods = [\"rk4\"]\ntolerances = [1]"]
    {
        assert_eq!(with(keys).unwrap_err(), "the key steps is missing", "{keys}");
    }
}

/// A scene with these tables behind its system.
fn oscillator(tables: &str) -> Result<Scene, String> {
    let text = format!(
        "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = 0.1 }}\n[initial]\n\
         q = [1.0]\np = [0.0]\n[time]\nend = 4.0\nstep = 0.1\n{tables}\n"
    );
    Scene::read(&text).map_err(|error| error.problem.to_string())
}

#[test]
fn a_study_refuses_what_it_cannot_use() {
    let adaptive = "[run]\nmethods = [\"adaptive-dop853\"]\ntolerance = 1e-6\n";
    let chooses = "adaptive-dop853 chooses its steps, and this study needs methods that take one";
    for (tables, says) in [
        (format!("{adaptive}[study.energy]"), chooses),
        (format!("{adaptive}[study.global-order]\nsteps = [0.1, 0.2]"), chooses),
        ("[study.energy]\nmethods = [\"rk4\", \"adaptive-dop853\"]".into(), chooses),
        (
            "[study.work-precision]\nmethods = [\"adaptive-dop853\"]\ntolerances = [1e-6]\n\
             steps = [0.1]"
                .into(),
            "steps does not belong here: the methods choose their steps",
        ),
        (
            format!("{adaptive}[study.work-precision]\nsteps = [0.1]"),
            "adaptive-dop853 takes a tolerance instead of a step",
        ),
        (
            "[study.long-run]\nmethods = [\"rk4\", \"gonzalez\"]\ncount = 100\n\
             compensated = true"
                .into(),
            "compensated does not belong here: none of the methods compensates roundings",
        ),
        (
            "[study.global-order]\nmethods = [\"rk4\"]\nsteps = [1e-9, 2e-9]".into(),
            "the reference in bytes would be 1.920e11, more than the budget of 1e9",
        ),
    ] {
        assert_eq!(oscillator(&tables).map(drop), Err(says.to_owned()), "{tables}");
    }
    let of = oscillator("[study.work-precision]\ntolerances = [1e-6]").unwrap();
    assert_eq!(of.studies.work_precision.unwrap().adaptive.len(), 5);
}
