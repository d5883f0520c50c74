//! Initial states from files.

use afterbay_experiments::scene::Scene;

const SCENE: &str = r#"[system]
name = "custom"
potential = "sum(i, 1, n-1, (q[i+1] - q[i])^2)"
[initial]
q = { file = "start.csv", column = "x" }
p = { file = "start.csv", column = 3 }
[time]
end = 1.0
step = 0.1
[run]
methods = ["increment-2"]
"#;

fn read(file: &str, scene: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("start.csv"), file).expect("a file");
    Scene::read_in(folder.path(), scene).map_err(|error| error.to_string())
}

#[test]
fn columns_are_found_by_name_and_number() {
    let file = "# made by hand\nt, x, v\n0, 0.5, 1e-3\n1, -2, 7\n2, 3, 8\n";
    let scene = read(file, SCENE).unwrap();
    assert_eq!(scene.problem.q, [0.5, -2.0, 3.0]);
    assert_eq!(scene.problem.p, [1e-3, 7.0, 8.0]);
    // The document has the numbers, so that the record of a run needs no file.
    let document = serde_json::to_value(&scene.document).unwrap();
    assert_eq!(document["initial"]["q"], serde_json::json!([0.5, -2.0, 3.0]));
    let plain = SCENE.replace(", column = \"x\"", "").replace("column = 3", "column = 2");
    let scene = read("1,2\n3,4\n", &plain).unwrap();
    assert_eq!((&scene.problem.q[..], &scene.problem.p[..]), (&[1.0, 3.0][..], &[2.0, 4.0][..]));
}

#[test]
fn what_is_wrong_with_a_file_is_said() {
    let good = "x,y,v\n1,2,3\n4,5,6\n";
    let is = |file: &str, from: &str, to: &str, says: &str| {
        let error = read(file, &SCENE.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(says), "{error}");
    };
    is(good, "start.csv", "absent.csv", "absent.csv cannot be read: No such file");
    is(good, "\"x\"", "\"z\"", "there is no column z; there are x, y, v");
    is(good, "column = 3", "column = 4", "line 2 has no column 4");
    is(good, "column = 3", "column = 0", "columns are counted from 1");
    is("1,2,3\n", "", "", "its first line names no columns");
    is("x,y,v\n1,2,a\n", "", "", "line 2 has \"a\", where a number is expected");
    is("x,y,x\n1,2,3\n", "", "", "several columns are called x");
    is("x,y,v\n1,2,3\n1,2,3,4\n", "", "", "line 3 has 4 columns, those before it have 3");
    is("x,y,v\n1,2,inf\n", "", "", "line 2 has \"inf\"");
    is("x,y,v\n", "", "", "it has no numbers");
    is(good, "column = 3 }", "count = 2 }", "count does not belong here: the file has the entries");
    is(good, "file = \"start.csv\", column = 3 }", "column = 3 }", "the key file is missing");
}
