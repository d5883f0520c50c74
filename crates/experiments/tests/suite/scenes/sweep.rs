//! Sweeps: their points, and their tables against those of single scenes.

use afterbay_analysis::progress::Silent;
use afterbay_experiments::experiment;
use afterbay_experiments::record::Output;
use afterbay_experiments::scene::Scene;

const SCENE: &str = r#"[system]
name = "duffing"
parameters = { c = 0.1, alpha = "1 + c", beta = 1 }
[initial]
q = ["2*c"]
p = [0.5]
[time]
end = 2.0
step = 0.1
[run]
methods = ["moddg", "rk4"]
[study.global-order]
steps = [0.1, 0.05]
"#;

fn with(sweep: &str) -> Scene {
    let text = format!("{SCENE}[sweep]\n{sweep}\n");
    Scene::read(&text).unwrap_or_else(|error| panic!("{sweep}: {error}"))
}

fn table<'a>(output: &'a Output, name: &str) -> &'a str {
    let found = output.artifacts.iter().find(|x| x.name == format!("data/{name}.csv"));
    &found.unwrap_or_else(|| panic!("no {name}")).text
}

fn values(scene: &Scene) -> Vec<Vec<f64>> {
    let sweep = scene.sweep.as_ref().expect("a sweep");
    (0..sweep.count()).map(|index| sweep.values(index)).collect()
}

#[test]
fn points_are_all_combinations() {
    let scene = with("vary.c = [0.1, 0.2]\nvary.p1 = { from = 0, to = 1, count = 3 }");
    let expected = [[0.1, 0.0], [0.1, 0.5], [0.1, 1.0], [0.2, 0.0], [0.2, 0.5], [0.2, 1.0]];
    assert_eq!(values(&scene), expected);
    assert_eq!(scene.sweep.as_ref().unwrap().names, ["c", "p1"]);
}

/// A draw depends on the seed and the number of its point alone.
#[test]
fn draws_are_reproducible_and_have_their_distribution() {
    let draw = |samples: usize, seed: u64| {
        let text = format!(
            "vary.p1 = {{ uniform = [2, 3] }}\nvary.q1 = {{ normal = [5, 0.1] }}\n\
             samples = {samples}\nseed = {seed}"
        );
        values(&with(&text))
    };
    let (few, many) = (draw(3, 7), draw(400, 7));
    assert_eq!(few, many[..3]);
    assert_ne!(few, draw(3, 8));
    let mean = |k: usize| many.iter().map(|x| x[k]).sum::<f64>() / 400.0;
    let deviation =
        |k: usize| (many.iter().map(|x| (x[k] - mean(k)).powi(2)).sum::<f64>() / 400.0).sqrt();
    assert!(many.iter().all(|x| (2.0..3.0).contains(&x[0])));
    // Six standard deviations of the estimates.
    assert!((mean(0) - 2.5).abs() < 0.09 && (deviation(0) - 12f64.sqrt().recip()).abs() < 0.05);
    assert!((mean(1) - 5.0).abs() < 0.03 && (deviation(1) - 0.1).abs() < 0.025);
}

/// The rows of each point are those of the scene with the values written into it. Expressions of
/// parameters and of the initial state follow.
#[test]
fn tables_are_those_of_single_scenes() {
    let swept = with("vary.c = [0.1, 0.3]\nvary.p1 = [0.5, -1]");
    for (command, name) in [
        (
            experiment::run as fn(&Scene, &dyn afterbay_analysis::progress::Progress) -> _,
            "trajectory",
        ),
        (experiment::study, "global_orders"),
    ] {
        let (all, findings) = command(&swept, &Silent).unwrap();
        assert!(findings[0].statement.starts_with("4 of 4 points"), "{}", findings[0].statement);
        let mut rows = table(&all, name).lines();
        let header = rows.next().unwrap();
        let mut count = 0;
        for (index, (c, p)) in
            [("0.1", "0.5"), ("0.1", "-1"), ("0.3", "0.5"), ("0.3", "-1")].into_iter().enumerate()
        {
            let text = SCENE.replace("c = 0.1", &format!("c = {c}"));
            let text = text.replace("p = [0.5]", &format!("p = [{p}]"));
            let (single, _) = command(&Scene::read(&text).unwrap(), &Silent).unwrap();
            let mut lines = table(&single, name).lines();
            assert_eq!(header, format!("point,sweep_c,sweep_p1,{}", lines.next().unwrap()));
            let p: f64 = p.parse().unwrap();
            for line in lines {
                assert_eq!(rows.next(), Some(&*format!("{index},{c},{p:?},{line}")));
                count += 1;
            }
        }
        assert!(rows.next().is_none() && count > 8, "{count}");
        let numbers = table(&all, if name == "trajectory" { "sweep_of_run" } else { "sweep" });
        assert!(numbers.starts_with("point,sweep_c,sweep_p1,topic,of,what,value"), "{numbers}");
    }
}

/// A run that fails at one point leaves the others.
#[test]
fn a_failure_is_of_its_point() {
    let text = SCENE.replace("beta = 1", "beta = -1").replace("end = 2.0", "end = 10.0");
    let text = format!("{text}[sweep]\nvary.p1 = [0.1, 5.0]\n");
    let (output, findings) = experiment::run(&Scene::read(&text).unwrap(), &Silent).unwrap();
    let statement = &findings[0].statement;
    assert!(statement.contains("2 of 2 points; 2 of 4 runs completed"), "{statement}");
    assert!(table(&output, "trajectory").lines().any(|line| line.starts_with("0,0.1,rk4,100,")));
}

/// The scene at each point is the one that is checked, in whatever order points are asked for.
#[test]
fn points_do_not_depend_on_each_other() {
    let scene = with("vary.c = [0.1, 0.2]\nvary.p1 = [0.5, -1]\nvary.beta = [1, 2]");
    let at = |index| scene.at(index).expect("a point").problem;
    let told = |index| format!("{:?}", at(index));
    for (index, (c, p, beta)) in
        [(0.1, 0.5, 1.0), (0.1, -1.0, 1.0), (0.2, 0.5, 1.0)].into_iter().enumerate()
    {
        let values: Vec<f64> = at(index).model.values().into_iter().map(|x| x.1).collect();
        assert_eq!(values, [1.0 + c, beta, c]);
        assert_eq!((at(index).q, at(index).p), (vec![2.0 * c], vec![p]));
    }
    let backwards: Vec<String> = (0..8).rev().map(told).collect();
    assert!((0..8).map(told).eq(backwards.into_iter().rev()));
}

#[test]
fn mistakes_are_refused() {
    for (sweep, says) in [
        ("vary.k = [1]", "there is no parameter or initial value k"),
        ("vary.q2 = [1]", "there is no parameter or initial value q2"),
        ("vary.alpha = [1]", "alpha cannot be varied: it is computed from other parameters"),
        ("vary.c = []", "the list is empty"),
        ("vary.c = [1, 1]", "1 is in the list already"),
        ("vary.c = { from = 1, to = 2 }", "the key count is missing"),
        ("vary.c = { from = 1, to = 2, count = 3, uniform = [0, 1] }", "this is no list, range"),
        ("vary.c = { from = 1, to = 2, count = 1 }", "to = 2 must be that of `from`"),
        ("vary.c = {}", "this is no list, range"),
        ("vary.c = { uniform = [1, 0] }\nsamples = 3", "uniform = 1 must be below"),
        ("vary.c = { uniform = [-1e308, 1e308] }\nsamples = 3", "must be below the other bound"),
        ("vary.c = { from = -1e308, to = 1e308, count = 3 }", "at a finite distance from `from`"),
        (
            "vary.c = { from = 1e-300, to = 1e300, count = 3, scale = \"log\" }",
            "within a factor of 1e307 of `from`",
        ),
        ("vary.c = { normal = [1, -1] }\nsamples = 3", "normal = -1 must be a mean"),
        ("vary.c = { uniform = [0, 1] }", "the key samples is missing"),
        ("vary.c = [1]\nsamples = 3", "samples does not belong here"),
        ("vary.c = [1]\nseed = 3", "seed does not belong here"),
        ("vary.c = { uniform = [0, 1] }\nsamples = 0", "samples = 0 must be at least 1"),
        ("vary.c = { from = 0, to = 1, count = 200000 }", "must be from 1 to 100000"),
        (
            "vary.c = { from = 0, to = 1, count = 1000 }\n\
             vary.p1 = { from = 0, to = 1, count = 1001 }",
            "more than the budget",
        ),
        ("vary = {}", "the list is empty"),
    ] {
        let error = Scene::read(&format!("{SCENE}[sweep]\n{sweep}\n")).unwrap_err();
        assert!(error.to_string().contains(says), "{sweep}: {error}");
    }
    let singular = SCENE.replace("q = [\"2*c\"]", "q = [\"1/c\"]");
    let error = Scene::read(&format!("{singular}[sweep]\nvary.c = [1, 0]\n")).unwrap_err();
    assert_eq!(error.to_string(), "at c = 0: this is inf");
    // The first point that is not valid is named, though p1 varies faster.
    let sweep = "vary.c = [1, 0, 2]\nvary.p1 = { from = 0, to = 1, count = 1000 }";
    let error = Scene::read(&format!("{singular}[sweep]\n{sweep}\n")).unwrap_err();
    assert_eq!(error.to_string(), "at c = 0, p1 = 0: this is inf");
}

/// A custom system has parameters that are expressions of others, and may have many entries.
#[test]
fn what_cannot_be_varied_is_told_from_what_is_not_there() {
    let refused = |potential: &str, name: &str| {
        let text = format!(
            "[system]\nname = 'custom'\npotential = '{potential}'\n\
             parameters = {{ k = 1, w = '2*k' }}\n[initial]\nq = '1'\np = '0'\n\
             [time]\nend = 1.0\nstep = 0.1\n[sweep]\nvary.{name} = [1, 2]\n"
        );
        let problem = Scene::read(&text).expect_err("a mistake").problem;
        (problem.to_string(), problem.help().unwrap_or_default())
    };
    let (said, _) = refused("w*q1^2 + q2^2", "w");
    assert_eq!(said, "w cannot be varied: it is computed from other parameters");
    let (_, help) = refused("w*q1^2 + q2^2", "zz");
    assert_eq!(help, "there are k, q1, q2, p1, p2");
    let (_, help) = refused("w*q1^2 + q6^2", "zz");
    assert_eq!(help, "there are k, q1, q2, .., q6, p1, p2, .., p6");
    // Nor can a study vary it.
    for study in ["stability]\nsteps = [0.1]", "bifurcation]\ninterval = 1.0"] {
        let text = format!(
            "[system]\nname = 'custom'\npotential = 'w*q1^2'\n\
             parameters = {{ k = 1, w = '2*k' }}\n[initial]\nq = [1.0]\np = [0.0]\n\
             [time]\nend = 1.0\nstep = 0.1\n[study.{study}\n\
             methods = ['rk4']\nparameter = {{ name = 'w', from = 1, to = 2, count = 2 }}\n"
        );
        let said = Scene::read(&text).expect_err("a mistake").problem.to_string();
        assert_eq!(said, "w cannot be varied: it is computed from other parameters", "{study}");
    }
}

/// A driven oscillator, with each study of its attractors.
const DRIVEN: &str = r#"[system]
name = "duffing"
parameters = { c = 0.3, alpha = 1, beta = 1 }
[drive]
force = ["f*cos(omega*t)"]
parameters = { f = 0.5, omega = 1.5 }
[initial]
q = [0.3]
p = [0.5]
[time]
end = 2.0
step = 0.1
[run]
methods = ["moddg"]
events = { turn = { of = "p1" } }
[study.energy]
[study.poincare]
transient = 20
points = 40
[study.bifurcation]
parameter = { name = "f", from = 0.1, to = 0.2, count = 2 }
transient = 20
points = 40
[study.resonance]
parameter = { name = "omega", from = 1.0, to = 1.2, count = 2 }
transient = 20
[study.basins]
grid = { q1 = { from = -1, to = 1, count = 2 }, p1 = { from = -1, to = 1, count = 2 } }
longest = 100
[study.lyapunov]
time = 40
"#;

/// An oscillator with a limit cycle, with the studies that take no drive.
const AUTONOMOUS: &str = r#"[system]
name = "modified-van-der-pol"
parameters = { mu = 0.3, alpha = 1, beta = 0.1 }
[initial]
q = [0.3]
p = [0.5]
[time]
end = 30.0
step = 0.1
[run]
methods = ["moddg"]
[study.local-order]
base_step = 0.1
steps = [0.2, 0.1]
[study.long-run]
count = 200
[study.limit-cycle]
[study.stability]
parameter = { name = "beta", from = 0.1, to = 0.4, count = 3 }
methods = ["rk4"]
steps = { from = 0.5, to = 3, count = 11 }
"#;

/// At each point, every study is that of the scene with the values written into it.
#[test]
fn studies_are_those_of_the_system_at_each_point() {
    for (text, tables) in [
        (DRIVEN, &["energy", "poincare", "bifurcation", "resonance", "basins", "lyapunov"][..]),
        (AUTONOMOUS, &["local_orders", "long_run", "limit_cycle", "stability"]),
    ] {
        let swept = format!("{text}[sweep]\nvary.alpha = [1, 1.25]\nvary.q1 = [0.3, 0.4]\n");
        let (all, _) = experiment::study(&Scene::read(&swept).unwrap(), &Silent).unwrap();
        let mut first = vec![String::new(); tables.len()];
        for (index, (alpha, q)) in
            [("1.0", "0.3"), ("1.0", "0.4"), ("1.25", "0.3"), ("1.25", "0.4")]
                .into_iter()
                .enumerate()
        {
            let text = text.replace("alpha = 1", &format!("alpha = {alpha}"));
            let scene = Scene::read(&text.replace("q = [0.3]", &format!("q = [{q}]"))).unwrap();
            let (single, _) = experiment::study(&scene, &Silent).unwrap();
            for (name, first) in tables.iter().zip(&mut first) {
                let of_point = format!("{index},{alpha},{q},");
                let rows = table(&all, name).lines().filter_map(|row| row.strip_prefix(&of_point));
                let alone: Vec<&str> = table(&single, name).lines().skip(1).collect();
                assert!(rows.eq(alone.iter().copied()), "{name} at {of_point}");
                match index {
                    0 => *first = alone.join("\n"),
                    _ => assert!(alpha == "1.0" || *first != alone.join("\n"), "{name}"),
                }
                assert!(!alone.is_empty(), "{name}");
            }
        }
    }
}
