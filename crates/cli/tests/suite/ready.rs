//! The example scenes.

use super::{afterbay, done, folder};
use std::collections::BTreeSet;

#[test]
fn every_ready_scene_is_valid_and_every_system_and_study_has_one() {
    let (mut systems, mut studies) = (BTreeSet::new(), BTreeSet::new());
    for file in std::fs::read_dir(folder()).expect("the folder").flatten() {
        let path = file.path();
        let (code, stdout, stderr) = done(afterbay(&["check", "--format", "json"]).arg(&path));
        assert_eq!(code, Some(0), "{stderr}");
        let plans: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        let plans = plans.as_array().expect("a list");
        assert!(
            plans.iter().any(|plan| plan["what"] == "run"),
            "{} has nothing to run",
            path.display()
        );
        studies.extend(plans.iter().filter_map(|plan| plan["what"].as_str().map(str::to_owned)));
        let text = std::fs::read_to_string(&path).expect("a scene");
        assert!(text.starts_with("# "), "{} does not say what it is", path.display());
        let name = text.lines().find_map(|line| line.strip_prefix("name = ")).expect("a system");
        systems.insert(name.trim_matches('"').to_owned());
    }
    let (_, listed, _) = done(&mut afterbay(&["list", "systems", "--format", "json"]));
    let listed: serde_json::Value = serde_json::from_str(&listed).expect("JSON");
    let listed = listed.as_array().expect("a list").iter().filter_map(|row| row["name"].as_str());
    for name in listed.chain(["custom"]) {
        assert!(systems.contains(name), "no scene for {name}");
    }
    for study in
        ["local-order", "global-order", "energy", "work-precision", "stability", "long-run"]
    {
        assert!(studies.contains(study), "no scene for {study}");
    }
}
