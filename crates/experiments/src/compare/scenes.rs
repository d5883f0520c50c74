//! The keys of two scenes whose values differ.

use serde::Serialize;
use serde_json::Value;

/// A key that two scenes give different values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The key with its tables: `time.step`.
    pub key: String,
    /// The value in A; none if A has no such key.
    pub a: Option<String>,
    /// The value in B; none if B has no such key.
    pub b: Option<String>,
}

/// The most characters of a value that a table shows.
const WIDEST: usize = 60;

impl Difference {
    /// The key and both values. Long values are shown from where they part, and lists may be
    /// wrapped.
    pub fn row(&self) -> Vec<String> {
        let spaced = |value: &String| match value.starts_with('[') {
            true => value.replace(',', ", "),
            false => value.clone(),
        };
        let [a, b] = [&self.a, &self.b].map(|value| value.as_ref().map_or("–".into(), spaced));
        let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
        let shown = |text: &str| {
            let length = text.chars().count();
            if length <= WIDEST {
                return text.to_owned();
            }
            let from = same.saturating_sub(WIDEST / 4).min(length - WIDEST);
            let part: String = text.chars().skip(from).take(WIDEST).collect();
            let [before, behind] =
                [from > 0, from + WIDEST < length].map(|cut| if cut { "…" } else { "" });
            format!("{before}{part}{behind}")
        };
        vec![self.key.clone(), shown(&a), shown(&b)]
    }
}

/// The differences of two scenes, key by key. Lists are compared as a whole.
pub(super) fn differences(a: &Value, b: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    walk("", Some(a), Some(b), &mut found);
    found
}

fn walk(key: &str, a: Option<&Value>, b: Option<&Value>, found: &mut Vec<Difference>) {
    let tables = [a, b].map(|value| value.and_then(Value::as_object));
    match (a, b) {
        (a, b) if a == b => {}
        _ if tables.iter().any(Option::is_some) => {
            let [a, b] = tables;
            let mut names: Vec<_> = tables.into_iter().flatten().flat_map(|t| t.keys()).collect();
            names.sort();
            names.dedup();
            for name in names {
                let below = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                walk(&below, a.and_then(|a| a.get(name)), b.and_then(|b| b.get(name)), found);
            }
        }
        _ => {
            let [a, b] = [a, b].map(|value| value.map(ToString::to_string));
            found.push(Difference { key: key.into(), a, b });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_of_either_scene_are_found() {
        let a = json!({"time": {"step": 0.1, "end": 5.0}, "run": {"methods": ["rk4"]}, "x": 1});
        let b = json!({"time": {"step": 0.2, "end": 5.0}, "run": {"methods": ["rk4", "moddg"]},
                       "study": {"energy": {"step": 0.1}}, "x": {"y": 1}});
        let found = differences(&a, &b);
        let keys: Vec<_> = found.iter().map(|one| one.key.as_str()).collect();
        assert_eq!(keys, ["run.methods", "study.energy.step", "time.step", "x.y"]);
        assert_eq!(found[0].b.as_deref(), Some(r#"["rk4","moddg"]"#));
        assert_eq!((found[1].a.as_deref(), found[1].b.as_deref()), (None, Some("0.1")));
        assert!(differences(&a, &a).is_empty());
    }

    #[test]
    fn long_values_are_shown_where_they_part() {
        let list = |last: f64| (0..500).map(f64::from).chain([last]).collect::<Vec<_>>();
        let [a, b] = [1.5, 2.5].map(|last| json!({ "initial": { "q": list(last) } }));
        let row = differences(&a, &b)[0].row();
        assert_eq!(row[0], "initial.q");
        assert!(row[1].starts_with('…') && row[1].ends_with("498.0, 499.0, 1.5]"), "{}", row[1]);
        assert!(row[2].ends_with("498.0, 499.0, 2.5]") && row[2].chars().count() == WIDEST + 1);
        let none = Difference { key: "x".into(), a: None, b: Some("1".into()) };
        assert_eq!(none.row(), ["x", "–", "1"]);
    }
}
