//! Figures of trajectories: those a scene asks for, and those it does not.

use afterbay_analysis::progress::Silent;
use afterbay_experiments::artifact::Artifact;
use afterbay_experiments::data::Files;
use afterbay_experiments::experiment;
use afterbay_experiments::record::Output;
use afterbay_experiments::scene::Scene;

const OSCILLATOR: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 20.0
step = 0.01
[run]
methods = ["moddg", "leapfrog"]
every = 10
"#;

/// A chain of `n` masses.
fn chain(n: usize) -> String {
    format!(
        r#"
[system]
name = "custom"
potential = "sum(i, 1, n-1, (q[i+1] - q[i])^2/2)"
dissipation = "c*p[i]"
parameters = {{ c = 0.05 }}
[initial]
q = {{ count = {n}, value = "sin(9*i)" }}
p = 0
[time]
end = 20.0
step = 0.05
[run]
methods = ["increment-2", "leapfrog"]
"#
    )
}

fn output(text: &str) -> Output {
    let scene = Scene::read(text).expect("a scene");
    experiment::run(&scene, &Silent).expect("it runs").0
}

fn figures(output: &Output) -> Vec<&Artifact> {
    output.artifacts.iter().filter(|artifact| artifact.name.ends_with(".svg")).collect()
}

fn names(output: &Output) -> Vec<&str> {
    let name = |figure: &&Artifact| figure.name.trim_start_matches("figures/").len();
    let all = figures(output);
    all.iter().map(|figure| &figure.name[figure.name.len() - name(figure)..]).collect()
}

fn svg<'a>(output: &'a Output, name: &str) -> &'a str {
    let file = format!("figures/{name}.svg");
    let found = output.artifacts.iter().find(|artifact| artifact.name == file);
    &found.expect(name).text
}

#[test]
fn the_figures_shown_without_being_asked_for() {
    let one = output(OSCILLATOR);
    let expected = ["coordinate.svg", "phase-plane.svg", "energy.svg", "deviation-of-k.svg"];
    assert_eq!(names(&one), expected);
    // Two methods that coincide to the eye have a panel each.
    for (name, panels) in [("coordinate", 2), ("energy", 2), ("deviation-of-k", 0)] {
        assert_eq!(svg(&one, name).matches("translate(").count().min(2), panels, "{name}");
    }
    let two = output(&chain(2));
    assert!(names(&two).contains(&"orbit.svg") && !names(&two).contains(&"map-of-q.svg"));
    let many = output(&chain(8));
    assert_eq!(names(&many)[0], "map-of-q.svg");
    assert!(!names(&many).contains(&"orbit.svg"));
}

#[test]
fn a_figure_is_not_shown_twice() {
    let own = "[figure.mine]\nx = \"q1\"\ny = \"p1\"\n";
    let names_with = |figure: &str| {
        let found = output(&format!("{OSCILLATOR}\n{figure}"));
        names(&found).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let shown = names_with(own);
    assert!(shown.iter().any(|name| name == "mine.svg"));
    assert!(shown.iter().all(|name| name != "phase-plane.svg"), "{shown:?}");
    // Another quantity is another figure.
    assert!(names_with(&own.replace("p1", "w1")).iter().any(|name| name == "phase-plane.svg"));
}

#[test]
fn masses_that_move_alike_have_a_panel_each() {
    let alike = chain(4).replace("sin(9*i)", "i*(5 - i)");
    let output = output(&alike);
    assert!(svg(&output, "coordinates").matches("translate(").count() >= 4);
    assert!(output.report.html(Files::default()).contains("Some curves coincide"));
}

#[test]
fn a_scene_chooses_figures_titles_and_units() {
    let text = format!(
        "title = \"A <damped> oscillator\"\n{OSCILLATOR}\n[units]\ntime = \"s\"\nq = \"m\"\n\
         [figure.z]\nx = \"q1\"\ny = \"w1\"\nmethods = [\"leapfrog\"]\n\
         [figure.energy]\ny = \"K - K0\"\nlog = true\ntitle = \"My own\"\n"
    );
    let output = output(&text);
    assert_eq!(names(&output)[..2], ["z.svg", "energy.svg"], "in the order of the scene");
    // The deviation of K is the scene's own figure.
    assert_eq!(names(&output)[2..], ["coordinate.svg", "phase-plane.svg"]);
    let (z, energy) = (svg(&output, "z"), svg(&output, "energy"));
    assert!(z.contains("w1 against q1 by leapfrog") && z.contains("q1 [m]"));
    assert!(energy.contains("My own") && energy.contains("time t [s]"));
    assert!(energy.contains("|K − K₀|") && energy.contains("leapfrog"));
    let html = output.report.html(Files::default());
    assert!(html.contains("<h1>A &lt;damped&gt; oscillator</h1>"));
    let first = |part: &str| html.find(part).expect("it is there");
    assert!(first("<figure") < first("<table"), "a chart comes before the tables");
}

#[test]
fn a_study_begins_with_its_charts_and_shows_orders_at_the_steps() {
    let text = OSCILLATOR.to_owned() + "[study.global-order]\nsteps = [0.1, 0.04, 0.02]\n";
    let scene = Scene::read(&text).expect("a scene");
    let (output, _) = experiment::study(&scene, &Silent).expect("it runs");
    let html = output.report.html(Files::default());
    let first = |part: &str| html.find(part).expect("it is there");
    assert!(first("class=\"verdict") < first("<figure") && first("<figure") < first("<table"));
    let chart = svg(&output, "global-error-q");
    assert!([">0.1<", ">0.04<", ">0.02<", "slope 2"].iter().all(|text| chart.contains(text)));
}

#[test]
fn every_figure_is_a_picture_too() {
    let (folder, output) = (tempfile::tempdir().expect("a folder"), output(OSCILLATOR));
    output.write(folder.path(), Files::default()).expect("written");
    for figure in figures(&output) {
        let path = folder.path().join(&figure.name).with_extension("png");
        let png = std::fs::read(path).expect("a picture");
        assert!(png.starts_with(b"\x89PNG\r\n"), "{}", figure.name);
        // 1.5 million pixels with some drawing on them.
        assert!(png.len() > 10_000, "{} has {} bytes", figure.name, png.len());
    }
    let linked = || {
        let report = std::fs::read_to_string(folder.path().join("report.html")).expect("a report");
        report.contains(".png")
    };
    assert!(linked());
    // If no PNG files are asked for, those of an earlier command are removed.
    output.write(folder.path(), Files { png: false, ..Files::default() }).expect("written");
    for figure in figures(&output) {
        let path = folder.path().join(&figure.name);
        assert!(path.exists() && !path.with_extension("png").exists(), "{}", figure.name);
    }
    assert!(!linked());
}

#[test]
fn a_long_chain_makes_small_figures() {
    let text =
        chain(500) + "[figure.a]\nmap = \"p\"\n[figure.b]\nmap = \"w\"\nmethods = [\"leapfrog\"]\n";
    let output = output(&text);
    for figure in figures(&output) {
        assert!(figure.text.len() < 700_000, "{} has {} bytes", figure.name, figure.text.len());
    }
    assert!(svg(&output, "a").contains("leapfrog") && svg(&output, "a").contains("increment-2"));
    assert!(svg(&output, "b").contains("w_i") && !svg(&output, "b").contains("increment-2"));
    let html = output.report.html(Files::default());
    assert!(html.contains("90 of 500 degrees of freedom") && html.contains("128 of 500"));
}

#[test]
fn a_run_that_fails_is_shown_as_far_as_it_came() {
    let text = OSCILLATOR
        .replace("damped-oscillator", "duffing")
        .replace("k = 1.0, b = 0.1", "alpha = 1.0, beta = 1.0, c = 0.1")
        .replace("step = 0.01", "step = 2.0")
        .replace("every = 10", "every = 1")
        .replace("\"moddg\"", "\"rk4\"");
    let output =
        output(&(text + "[figure.a]\nmap = \"q\"\n[figure.b]\nx = \"K\"\ny = [\"q1\", \"W\"]\n"));
    assert!(output.manifest.runs.iter().any(|run| run.outcome != "completed"));
    assert!(figures(&output).iter().all(|figure| !figure.text.contains("NaN")));
}
