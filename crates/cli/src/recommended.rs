//! The scene that runs a recommendation of `pick`.

use afterbay_analysis::study::pick::Trial;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry;
use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

/// The tables of a scene that the recommendation replaces.
pub(crate) fn lines(scene: &Scene, winner: &Trial) -> String {
    let mut document = DocumentMut::new();
    set(&mut document, "time", "end", Some(number(scene.problem.end)));
    fill(&mut document, winner);
    document.to_string()
}

/// The text of a scene, with the recommendation in place of its own methods and step. A study that
/// takes its methods from `[run]` or its step from `[time]` is given them as its own.
pub(crate) fn scene(text: &str, scene: &Scene, winner: &Trial) -> String {
    // The text has been read as a scene. Were it no TOML, the lines alone would be left.
    let mut document: DocumentMut = text.parse().unwrap_or_default();
    each_table(&mut document, "study", |name, study| keep(name, study, scene));
    // A figure shows methods of `[run]`: by default all.
    each_table(&mut document, "figure", |_, figure| drop(figure.remove("methods")));
    if winner.tolerance.is_none() {
        // It counts steps of another length.
        set(&mut document, "run", "every", None);
    }
    fill(&mut document, winner);
    document.to_string()
}

/// Changes each of the tables in a table.
fn each_table(
    document: &mut DocumentMut,
    name: &str,
    mut change: impl FnMut(&str, &mut dyn TableLike),
) {
    let tables = document.get_mut(name).and_then(Item::as_table_like_mut);
    for (name, table) in tables.into_iter().flat_map(|tables| tables.iter_mut()) {
        if let Some(table) = table.as_table_like_mut() {
            change(&name, table);
        }
    }
}

/// Gives a study the values that it takes from other tables.
fn keep(name: &str, study: &mut dyn TableLike, scene: &Scene) {
    let document = &scene.document;
    if let (false, Some(run)) = (study.contains_key("methods"), &document.run) {
        let tolerances = study.contains_key("tolerances");
        let takes_step =
            |name: &&String| registry::find(name).is_some_and(|row| !row.is_adaptive());
        let names = run.methods.iter().filter(|name| tolerances || takes_step(name));
        put(study, "methods", Array::from_iter(names));
    }
    if let (true, false, Some(step)) =
        (matches!(name, "energy" | "long-run"), study.contains_key("step"), document.time.step)
    {
        put(study, "step", step);
    }
}

/// A number of a scene, small ones as 5.6e-6.
fn number(x: f64) -> Value {
    let written = if (1e-3..1e6).contains(&x) { format!("{x:?}") } else { format!("{x:e}") };
    written.parse().unwrap_or_else(|_| x.into())
}

/// Puts the method and its step or tolerance into `[run]` and `[time]`.
fn fill(document: &mut DocumentMut, winner: &Trial) {
    if winner.tolerance.is_none() {
        set(document, "time", "step", Some(number(winner.h)));
    }
    set(document, "run", "methods", Some(Array::from_iter([winner.method]).into()));
    set(document, "run", "tolerance", winner.tolerance.map(number));
}

/// Sets or removes a value of a table, which is made if there is none.
fn set(document: &mut DocumentMut, table: &str, key: &str, value: Option<Value>) {
    let table = document.entry(table).or_insert_with(toml_edit::table);
    match (table.as_table_like_mut(), value) {
        (Some(table), Some(value)) => put(table, key, value),
        (Some(table), None) => drop(table.remove(key)),
        (None, _) => {}
    }
}

/// Sets a value, and keeps the blanks and the comment around an older one.
fn put(table: &mut dyn TableLike, key: &str, value: impl Into<Value>) {
    let mut value = value.into();
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *value.decor_mut() = old.decor().clone();
    }
    table.insert(key, Item::Value(value));
}
