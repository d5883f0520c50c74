//! Studies as cells: shards, resumed commands, and commands that are killed give the tables of a
//! command that runs alone.

use super::timeless::timeless;
use super::{afterbay, done};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Instant;

pub(super) const AUTONOMOUS: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 1.0, beta = 0.5, c = 0.1 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 10.0
step = 0.1
[study.local-order]
methods = ["moddg", "rk4"]
base_step = 0.1
steps = [0.1, 0.2]
[study.global-order]
methods = ["moddg", "rk4", "increment-2"]
steps = [0.2, 0.1, 0.05]
[study.energy]
methods = ["moddg", "rk4"]
[study.work-precision]
methods = ["moddg", "adaptive-dop853"]
steps = [0.1, 0.05]
tolerances = [1e-6]
[study.long-run]
methods = ["moddg", "rk4"]
count = 1000
[study.stability]
methods = ["moddg", "rk4"]
steps = { from = 0.05, to = 2.0, count = 6, scale = "log" }
parameter = { name = "c", from = 0.0, to = 2.0, count = 11 }
"#;

const DRIVEN: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 1.0, beta = 0.2, c = 0.1 }
[drive]
force = "f*cos(omega*t)"
parameters = { f = 0.4, omega = 1.35 }
[initial]
q = [0.5]
p = [0.0]
[time]
end = 10.0
step = 0.1
[study.poincare]
methods = ["moddg"]
steps = [0.1, 0.05]
transient = 10
points = 20
[study.bifurcation]
methods = ["moddg"]
steps = [0.1]
parameter = { name = "f", from = 0.2, to = 0.4, count = 20 }
transient = 10
points = 8
[study.resonance]
methods = ["rk4"]
steps = [0.1]
parameter = { name = "omega", from = 1.0, to = 1.4, count = 5 }
transient = 20
periods = 4
[study.basins]
methods = ["moddg"]
steps = [0.1]
grid = { q1 = { from = -2, to = 2, count = 6 }, p1 = { from = -2, to = 2, count = 6 } }
longest = 200
[study.lyapunov]
methods = ["rk4"]
steps = [0.1]
transient = 20.0
time = 100.0
[study.limit-cycle]
methods = ["moddg"]
steps = [0.1]
transient = 200.0
"#;

const SWEEP: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 1.0, beta = 0.5, c = 0.1 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 10.0
step = 0.1
[sweep.vary]
c = [0.0, 0.1, 0.2, 0.3, 0.4]
[run]
methods = ["moddg", "rk4"]
[study.energy]
methods = ["moddg", "rk4"]
"#;

/// A scene with runs of three methods, and without a sweep.
pub(super) fn runs() -> String {
    let scene = SWEEP.replace("[sweep.vary]\nc = [0.0, 0.1, 0.2, 0.3, 0.4]\n", "");
    let methods = "methods = [\"moddg\", \"rk4\", \"adaptive-dop853\"]\ntolerance = 1e-8";
    scene.replacen("methods = [\"moddg\", \"rk4\"]", methods, 1)
}

/// A folder with a scene.
pub(super) struct Place(tempfile::TempDir);

impl Place {
    pub(super) fn new(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("scene.toml"), scene).expect("a scene");
        Self(folder)
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A command on the scene, with a folder for its results.
    pub(super) fn command(&self, task: &str, out: &str, more: &[&str]) -> std::process::Command {
        let mut command = afterbay(&[task, "--no-png"]);
        command.arg(self.path("scene.toml")).arg("--out").arg(self.path(out)).args(more);
        command
    }

    /// Runs a command that must succeed. Returns stdout.
    pub(super) fn run(&self, task: &str, out: &str, more: &[&str]) -> String {
        let (code, stdout, stderr) = done(&mut self.command(task, out, more));
        assert!(matches!(code, Some(0 | 4)), "{task} {more:?}: {code:?} {stdout} {stderr}");
        stdout
    }

    pub(super) fn merge(&self, out: &str) -> (Option<i32>, String, String) {
        done(afterbay(&["merge", "--no-png"]).arg(self.path(out)))
    }

    /// All tables of a folder, without times.
    pub(super) fn tables(&self, out: &str) -> BTreeMap<String, String> {
        // A command that is killed while it writes a table leaves a file without its name.
        let read = |entry: std::io::Result<std::fs::DirEntry>| {
            let path = entry.expect("a file").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            name.ends_with(".csv").then(|| (name, timeless(&path)))
        };
        std::fs::read_dir(self.path(out).join("data")).expect("tables").filter_map(read).collect()
    }

    fn journal(&self, out: &str) -> PathBuf {
        self.path(out).join("parts/1-of-1.jsonl")
    }
}

#[test]
fn shards_give_the_tables_of_one_command() {
    let runs = runs();
    for (task, scene) in
        [("study", AUTONOMOUS), ("study", DRIVEN), ("study", SWEEP), ("run", SWEEP), ("run", &runs)]
    {
        let place = Place::new(scene);
        place.run(task, "alone", &[]);
        place.run(task, "shared", &["--shard", "2/3"]);
        if scene == AUTONOMOUS {
            // A command that is refused leaves nothing that the others stumble over.
            let (code, _, stderr) = done(&mut place.command(task, "shared", &[]));
            assert!(code == Some(5) && stderr.contains("unfinished work"), "{stderr}");
        }
        for shard in ["3/3", "1/3"] {
            place.run(task, "shared", &["--shard", shard]);
        }
        let (code, _, stderr) = place.merge("shared");
        assert!(matches!(code, Some(0 | 4)), "{stderr}");
        let (alone, shared) = (place.tables("alone"), place.tables("shared"));
        assert!(!alone.is_empty());
        for (name, table) in &alone {
            assert!(table.lines().count() > 1, "{name} is empty");
            assert_eq!(Some(table), shared.get(name), "{task}: {name}");
        }
        assert_eq!(alone.len(), shared.len());
    }
}

#[test]
fn a_plan_has_each_cell_once_and_shards_divide_it() {
    for (task, scene) in [("study", AUTONOMOUS), ("study", DRIVEN), ("run", SWEEP)] {
        let place = Place::new(scene);
        let plan = place.run(task, "nothing", &["--plan", "--format", "json"]);
        let plan: serde_json::Value = serde_json::from_str(&plan).expect("JSON");
        let keys: std::collections::BTreeSet<&str> = plan["cells"]
            .as_array()
            .expect("cells")
            .iter()
            .filter_map(|x| x["key"].as_str())
            .collect();
        assert_eq!(keys.len(), plan["cells"].as_array().expect("cells").len());
        assert!(!place.path("nothing").exists(), "a plan writes nothing");
        let mut found = 0;
        for shard in ["1/2", "2/2"] {
            let said = place.run(task, "out", &["--shard", shard, "--format", "json"]);
            let said: serde_json::Value = serde_json::from_str(&said).expect("JSON");
            found += said["cells"].as_u64().expect("a number");
        }
        assert_eq!(found as usize, keys.len());
    }
}

/// Parts of two scenes cannot be joined, so that none is added to those of another scene.
#[test]
fn a_forced_share_takes_the_place_of_its_own_part_alone() {
    let place = Place::new(SWEEP);
    let share = |scene: &str, shard: &str| {
        std::fs::write(place.path("scene.toml"), scene).expect("a scene");
        let more = ["--force", "--shard", shard];
        let (code, _, stderr) = done(&mut place.command("study", "out", &more));
        (code, stderr)
    };
    let other = SWEEP.replace("0.4]", "0.5]");
    assert_eq!(share(SWEEP, "1/2").0, Some(0));
    let (code, said) = share(&other, "2/2");
    assert!(code == Some(5) && said.contains("another scene"), "{code:?} {said}");
    for shard in ["1/2", "2/2"] {
        assert_eq!(share(&other, shard).0, Some(0), "{shard}");
    }
    let (code, _, stderr) = place.merge("out");
    assert!(matches!(code, Some(0 | 4)), "{stderr}");
}

/// A journal cut at any byte: the torn line is dropped and its cell is computed again.
#[test]
fn a_torn_journal_is_completed() {
    let place = Place::new(AUTONOMOUS);
    place.run("study", "out", &[]);
    let whole = place.tables("out");
    let journal = std::fs::read(place.journal("out")).expect("a journal");
    for share in [0.02, 0.3, 0.77, 0.999] {
        let cut = (share * journal.len() as f64) as usize;
        std::fs::write(place.journal("out"), &journal[..cut]).expect("it is written");
        place.run("study", "out", &["--resume"]);
        assert_eq!(place.tables("out"), whole, "cut at {cut}");
    }
    // A damaged line in the middle.
    let mut damaged = journal.clone();
    let at = journal.len() / 2;
    damaged[at] = if journal[at] == b'A' { b'B' } else { b'A' };
    std::fs::write(place.journal("out"), &damaged).expect("it is written");
    let (code, _, stderr) = done(&mut place.command("study", "out", &["--resume"]));
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("not whole"), "{stderr}");
    assert_eq!(place.tables("out"), whole);
}

/// The number of commands that are killed; the variable AFTERBAY_KILLS asks for more.
fn kills() -> u64 {
    std::env::var("AFTERBAY_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(6)
}

#[test]
fn killed_commands_lose_nothing_that_was_finished() {
    let place = Place::new(DRIVEN);
    let begin = Instant::now();
    place.run("study", "whole", &[]);
    let (time, whole) = (begin.elapsed(), place.tables("whole"));
    let mut seed = 1_u64;
    let mut share = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 * 2f64.powi(-53)
    };
    for n in 0..kills() {
        let out = format!("killed-{n}");
        // Killed up to three times, and then completed.
        for _ in 0..3 {
            let mut child = place
                .command("study", &out, &["--resume"])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("it starts");
            std::thread::sleep(time.mul_f64(share()));
            child.kill().expect("it is killed");
            child.wait().expect("it ends");
        }
        place.run("study", &out, &["--resume"]);
        assert_eq!(place.tables(&out), whole, "kill {n}");
        std::fs::remove_dir_all(place.path(&out)).expect("it is removed");
    }
}

#[test]
fn what_is_unfinished_is_not_forgotten_by_mistake() {
    let place = Place::new(AUTONOMOUS);
    place.run("study", "out", &[]);
    // A finished study is computed anew.
    place.run("study", "out", &[]);
    let journal = std::fs::read_to_string(place.journal("out")).expect("a journal");
    let half: Vec<&str> = journal.lines().take(9).collect();
    std::fs::write(place.journal("out"), half.join("\n") + "\n").expect("it is written");
    let (code, _, stderr) = done(&mut place.command("study", "out", &[]));
    assert_eq!(code, Some(5), "{stderr}");
    assert!(stderr.contains("8 of 27 cells") && stderr.contains("--resume"), "{stderr}");
    let stdout = place.run("study", "out", &["--resume"]);
    assert!(stdout.contains("8 of 27 cells"), "{stdout}");
    std::fs::write(place.journal("out"), half.join("\n") + "\n").expect("it is written");
    let stdout = place.run("study", "out", &["--force"]);
    assert!(!stdout.contains("were there"), "{stdout}");
}

#[test]
fn two_commands_do_not_share_cells() {
    let place = Place::new(AUTONOMOUS);
    place.run("study", "out", &["--shard", "1/2"]);
    let lock = |name: &str| {
        let file = File::options().write(true).open(place.path("out").join("parts").join(name));
        file.expect("a file")
    };
    let shard = lock("1-of-2.jsonl");
    shard.try_lock().expect("nobody has it");
    let output = done(&mut place.command("study", "out", &["--shard", "1/2", "--resume"]));
    assert!(output.0 == Some(5) && output.2.contains("another command"), "{}", output.2);
    place.run("study", "out", &["--shard", "2/2"]);
    drop(shard);
    // A shard at work keeps out what takes the whole folder.
    let folder = lock("lock");
    folder.try_lock_shared().expect("nobody has it");
    let whole = done(&mut place.command("study", "out", &["--resume"]));
    for output in [whole, place.merge("out")] {
        assert!(output.0 == Some(5) && output.2.contains("another command"), "{}", output.2);
    }
}

#[test]
fn a_job_array_names_the_share() {
    let place = Place::new(SWEEP);
    let with = |argument: &str, variables: &[(&str, &str)]| {
        let mut command = place.command("run", "out", &["--shard", argument, "--format", "json"]);
        let (code, stdout, stderr) = done(command.envs(variables.iter().copied()));
        (code, stdout + &stderr)
    };
    let array = [("SLURM_ARRAY_TASK_ID", "6"), ("SLURM_ARRAY_TASK_COUNT", "3")];
    let places = [("SLURM_ARRAY_TASK_MIN", "2"), ("SLURM_ARRAY_TASK_STEP", "2")];
    let (code, said) = with("auto", &[array, places].concat());
    assert!(code == Some(0) && said.contains("3/3"), "{said}");
    let (code, said) = with("auto/4", &[("HQ_TASK_ID", "2")]);
    assert!(code == Some(0) && said.contains("2/4"), "{said}");
    for (argument, variables, word) in [
        ("auto", &[][..], "SLURM_ARRAY_TASK_ID"),
        ("auto", &array[..], "SLURM_ARRAY_TASK_ID is 6"),
        ("auto/4", &[("HQ_TASK_ID", "0")][..], "HQ_TASK_ID is 0"),
        ("5/4", &[][..], "K/N"),
        ("0/4", &[][..], "K/N"),
        ("auto/0", &[][..], "auto/N"),
    ] {
        let (code, said) = with(argument, variables);
        assert!(code == Some(2) && said.contains(word), "{argument}: {said}");
    }
}

/// A disk that is full in the middle of a journal.
#[cfg(unix)]
#[test]
fn a_full_disk_ends_with_5_and_tears_nothing() {
    let place = Place::new(AUTONOMOUS);
    place.run("study", "whole", &[]);
    let command = place.command("study", "full", &[]);
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let quoted: Vec<String> = words.map(|word| format!("'{}'", word.to_string_lossy())).collect();
    // Files of at most 8 blocks; without the signal, writing fails as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f 8; exec {}", quoted.join(" "));
    let (code, _, stderr) = done(std::process::Command::new("sh").args(["-c", &script]));
    assert_eq!(code, Some(5), "{stderr}");
    assert!(stderr.contains("parts"), "{stderr}");
    place.run("study", "full", &["--resume"]);
    assert_eq!(place.tables("full"), place.tables("whole"));
}

/// A command whose output cannot be printed ends with exit code 5. If a message of failure cannot
/// be printed, the exit code is that of the failure.
#[cfg(target_os = "linux")]
#[test]
fn a_stream_without_room_is_no_panic() {
    let full = || std::fs::File::options().write(true).open("/dev/full").expect("a device");
    let mut completions = afterbay(&["completions", "bash"]);
    let code = |command: &mut std::process::Command| command.status().expect("it is run").code();
    assert_eq!(code(completions.stdout(full()).stderr(std::process::Stdio::null())), Some(5));
    assert_eq!(code(afterbay(&["check", "no-such-scene.toml"]).stderr(full())), Some(3));
}
