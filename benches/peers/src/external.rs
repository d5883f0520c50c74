//! Libraries of other languages, each in a process of its own that answers requests for runs:
//! Boost.odeint, which is compiled here, and by Python heyoka and the LSODA of numbalsoda. Those
//! that a machine lacks are left out by name.
//!
//! A process measures its own runs, so that the time of a request does not count.

use super::Scene;
use super::measure::{Line, Run, Spent, Watch};
use super::tolerances;
use std::cell::{Cell, RefCell};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::rc::Rc;

/// The time that the repetitions of a run take in all, in seconds.
const REPEATED: f64 = 2e-3;
/// The largest number of repetitions of a run within a request.
const MOST_REPEATS: f64 = 200.0;

/// A library that answers requests.
#[derive(Clone)]
pub struct Library {
    /// The names of its lines in the table, and of its methods in requests.
    methods: &'static [(&'static str, &'static str)],
    process: Rc<RefCell<Process>>,
}

/// The libraries that this machine has. `skip` receives a sentence on each of the others.
pub fn found(folder: &Path, mut skip: impl FnMut(String)) -> Vec<Library> {
    let heyoka = python("heyoka", "heyoka_runs.py", &[("heyoka-taylor", "taylor")]);
    let lsoda = python("numbalsoda", "lsoda_runs.py", &[("numbalsoda-lsoda", "lsoda")]);
    [("Boost.odeint", boost(folder)), ("heyoka", heyoka), ("LSODA", lsoda)]
        .into_iter()
        .filter_map(|(name, library)| {
            library.map_err(|why| skip(format!("{name} is left out: {why}"))).ok()
        })
        .collect()
}

/// Boost.odeint, compiled into `folder` for this machine.
fn boost(folder: &Path) -> Result<Library, String> {
    let program = folder.join("boost");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/external/boost.cpp");
    let compiled = Command::new("c++")
        .args(["-O3", "-march=native", "-std=c++17", source, "-o"])
        .arg(&program)
        .output()
        .map_err(|error| format!("there is no C++ compiler c++ ({error})"))?;
    if !compiled.status.success() {
        let text = String::from_utf8_lossy(&compiled.stderr);
        let why = text.lines().find(|line| line.contains("error")).unwrap_or("c++ fails");
        return Err(format!("{why} (on Debian, its package is libboost-dev)"));
    }
    let methods = &[
        ("boost-rkf78", "rkf78"),
        ("boost-bulirsch-stoer", "bulirsch-stoer"),
        ("boost-dopri5", "dopri5"),
        ("boost-rosenbrock4", "rosenbrock4"),
    ];
    Library::start(methods, &mut Command::new(program))
}

/// The library behind a Python script, if `python3` can import the module that it needs.
fn python(
    module: &str,
    script: &str,
    methods: &'static [(&'static str, &'static str)],
) -> Result<Library, String> {
    let has = Command::new("python3").args(["-c", &format!("import {module}")]).output();
    if !has.is_ok_and(|has| has.status.success()) {
        return Err(format!("python3 cannot import {module} (pip install {module})"));
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("external").join(script);
    Library::start(methods, Command::new("python3").arg(script))
}

impl Library {
    fn start(
        methods: &'static [(&'static str, &'static str)],
        command: &mut Command,
    ) -> Result<Self, String> {
        let process = Process::start(command).map_err(|error| error.to_string())?;
        Ok(Self { methods, process: Rc::new(RefCell::new(process)) })
    }

    /// The lines of its methods on a scene.
    pub fn lines(&self, scene: &Scene) -> Vec<Line> {
        self.methods.iter().filter_map(|names| self.line(scene.clone(), *names)).collect()
    }

    fn line(&self, scene: Scene, (name, method): (&'static str, &'static str)) -> Option<Line> {
        if !suits(method, &scene) {
            return None;
        }
        let process = Rc::clone(&self.process);
        Some(Line::peer(name, tolerances(), move |tolerance| {
            let request = format!("{} {method} {tolerance:e}", scene.name);
            let (process, repeats) = (Rc::clone(&process), Cell::new(2));
            let run: Run = Box::new(move |last, watch| {
                let spent = process.borrow_mut().run(&request, repeats.get(), last, watch)?;
                if let Some(seconds) = spent.seconds {
                    repeats.set((REPEATED / seconds).clamp(1.0, MOST_REPEATS) as u32);
                }
                Ok(spent)
            });
            Ok(run)
        }))
    }
}

/// Whether a method can run a scene in seconds.
fn suits(method: &str, scene: &Scene) -> bool {
    match method {
        // Its Jacobian is written for one degree of freedom.
        "rosenbrock4" => scene.dof() == 1,
        // Its matrices are dense.
        "lsoda" => scene.dof() <= 64,
        // The others are explicit, and C2 is stiff: a million steps at any tolerance.
        _ => scene.name != "C2",
    }
}

/// A process that reads requests and writes answers.
struct Process {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Process {
    fn start(command: &mut Command) -> std::io::Result<Self> {
        let missing = || std::io::Error::other("the process has no pipes");
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let requests = child.stdin.take().ok_or_else(missing)?;
        let answers = BufReader::new(child.stdout.take().ok_or_else(missing)?);
        Ok(Self { child, requests, answers })
    }

    /// Asks for a run, shows its states to the watcher, and writes the last one to `last`.
    fn run(
        &mut self,
        request: &str,
        repeats: u32,
        last: &mut [f64],
        mut watch: Option<Watch<'_>>,
    ) -> Result<Spent, String> {
        let show = u8::from(watch.is_some());
        writeln!(self.requests, "{request} {repeats} {show}").map_err(|e| e.to_string())?;
        let (mut line, mut unreadable) = (String::new(), None);
        loop {
            line.clear();
            if self.answers.read_line(&mut line).map_err(|error| error.to_string())? == 0 {
                return Err("the process has ended".into());
            }
            let (kind, rest) = line.trim_end().split_once(' ').unwrap_or((line.trim_end(), ""));
            match kind {
                // The answer is read to its end, so that the next request gets its own.
                "state" => match numbers(rest.split(' '), last) {
                    Ok(()) => watch.iter_mut().for_each(|watch| watch(last)),
                    Err(why) => unreadable = unreadable.or(Some(why)),
                },
                "done" => return unreadable.map_or_else(|| done(rest, last), Err),
                _ => return Err(rest.to_owned()),
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // A process that has ended already needs no more.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Reads `SECONDS STEPS EVALUATIONS Y..`.
fn done(text: &str, last: &mut [f64]) -> Result<Spent, String> {
    let bad = || format!("unreadable: {text}");
    let mut words = text.split(' ');
    let mut next = || words.next().ok_or_else(bad);
    let seconds: f64 = next()?.parse().map_err(|_| bad())?;
    if !(seconds > 0.0 && seconds.is_finite()) {
        return Err(bad());
    }
    let steps = next()?.parse().map_err(|_| bad())?;
    let evaluations = next()?.parse().map_err(|_| bad())?;
    numbers(words, last)?;
    Ok(Spent { steps, evaluations, iterations: None, seconds: Some(seconds) })
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>, to: &mut [f64]) -> Result<(), String> {
    let found: Result<Vec<f64>, _> = words.map(str::parse).collect();
    let found = found.map_err(|error| error.to_string())?;
    if found.len() != to.len() {
        return Err(format!("{} numbers in place of {}", found.len(), to.len()));
    }
    to.copy_from_slice(&found);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    /// A shell that answers like a library.
    fn answering(text: &str) -> Process {
        let script = format!("while read request; do printf '{text}'; done");
        Process::start(Command::new("sh").args(["-c", &script])).unwrap()
    }

    #[test]
    fn answers_are_read() {
        let mut process = answering("state 1 2 3\\ndone 0.5 7 9 4 5 6e-1\\n");
        let (mut last, mut seen) = ([0.0; 3], Vec::new());
        let spent =
            process.run("A x 1", 1, &mut last, Some(&mut |y| seen.push(y.to_vec()))).unwrap();
        assert_eq!((spent.seconds, spent.steps, spent.evaluations), (Some(0.5), 7, 9));
        assert_eq!((last, seen), ([4.0, 5.0, 0.6], vec![vec![1.0, 2.0, 3.0]]));
    }

    #[test]
    fn an_answer_that_is_no_state_is_a_failure() {
        let mut last = [0.0; 3];
        for (text, why) in [
            ("failed too stiff\\n", "too stiff"),
            ("done 0.5 7 9 4 5\\n", "2 numbers in place of 3"),
            ("done x 7 9 4 5 6\\n", "unreadable: x 7 9 4 5 6"),
        ] {
            let error = answering(text).run("A x 1", 1, &mut last, None).unwrap_err();
            assert_eq!(error, why);
        }
        let mut ended = Process::start(&mut Command::new("true")).unwrap();
        ended.child.wait().unwrap();
        assert!(ended.run("A x 1", 1, &mut last, None).is_err());
    }

    /// If Boost is installed, its programs integrate the equations of the scenes.
    #[test]
    fn boost_solves_the_scenes() {
        let folder = tempfile::tempdir().unwrap();
        let Ok(library) = boost(folder.path()) else { return };
        for scene in scenes::all().into_iter().filter(|scene| scene.name != "C2") {
            let exact = scene.reference().unwrap();
            for line in
                library.lines(&scene).iter().filter(|line| line.method != "boost-rosenbrock4")
            {
                let mut end = scene.start();
                let run = (line.bind)(crate::Setting::Tolerance(1e-10)).unwrap();
                run(&mut end, None).unwrap();
                let error = end.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 1e-6, "{}, {}: {error:e}", scene.name, line.method);
            }
        }
    }
}
