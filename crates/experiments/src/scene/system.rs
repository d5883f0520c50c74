//! The system of a scene.

use super::document::{Expression, PerDegree, SystemTable};
use super::numbers::Parameters;
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use afterbay_analysis::study::Problem;
use afterbay_analysis::{Model, ModelError};
use afterbay_core::{InputError, State, validate};
use afterbay_expression::MOST_DEGREES;
use afterbay_systems::{
    CustomError, CustomGeneral, Described, Description, DissipationText, GeneralDescription, Place,
    SYSTEMS, SystemRow,
};

/// The name of a system given by expressions.
const CUSTOM: &str = "custom";
/// The most parameters of a custom system. Each name in an expression is searched among all of
/// them.
const MOST_PARAMETERS: usize = 1000;

/// Makes the system of a table.
///
/// `known` are its parameters as numbers, and `count` is the number of entries of the initial
/// state, if it is given.
pub(super) fn model(
    source: &Source<'_>,
    table: &SystemTable,
    known: &Parameters,
    count: Option<usize>,
) -> Result<Model, SceneError> {
    if table.name == CUSTOM {
        return custom(source, table, count).map(Model::Custom);
    }
    let at = |path: &str, problem: SceneProblem| SceneError { problem, span: source.span(path) };
    let Some(row) = SYSTEMS.iter().find(|row| row.name == table.name) else {
        let known = SYSTEMS.iter().map(|row| row.name).chain([CUSTOM]).map(str::to_owned).collect();
        let problem = SceneProblem::Unknown { what: "system", name: table.name.clone(), known };
        return Err(at("system.name", problem));
    };
    check_keys(source, table, row)?;
    let values = known.iter().map(|(name, value)| (name.as_str(), *value));
    let model = Model::named(row, values).map_err(|error| {
        let path = match &error {
            ModelError::NoParameter { name }
            | ModelError::Whole { name, .. }
            | ModelError::Missing { name }
            | ModelError::Drive { name } => name.as_str(),
            ModelError::Custom(_) => "",
        };
        at(&format!("system.parameters.{path}"), error.clone().into())
    })?;
    match model.system::<f64>() {
        Ok(_) => Ok(model),
        Err(error) => {
            let name = if let InputError::Parameter { name, .. } = error { name } else { "" };
            Err(at(&format!("system.parameters.{name}"), error.into()))
        }
    }
}

/// Checks that the table of a built-in system has its parameters and nothing else.
fn check_keys(source: &Source<'_>, table: &SystemTable, row: &SystemRow) -> Result<(), SceneError> {
    let at = |path: &str, problem: SceneProblem| SceneError { problem, span: source.span(path) };
    let given = [
        ("potential", table.potential.is_some()),
        ("hamiltonian", table.hamiltonian.is_some()),
        ("dissipation", table.dissipation.is_some()),
        ("friction", table.friction.is_some()),
        ("mass", table.mass.is_some()),
    ];
    if let Some((key, _)) = given.into_iter().find(|(_, given)| *given) {
        let why = "only a system called \"custom\" has one";
        return Err(at(&format!("system.{key}"), SceneProblem::Misplaced { key, why }));
    }
    let known = || row.parameters.iter().map(|parameter| parameter.name);
    if let Some(name) = table.parameters.keys().find(|name| !known().any(|known| known == *name)) {
        let (name, known) = (name.clone(), known().map(str::to_owned).collect());
        let path = format!("system.parameters.{name}");
        return Err(at(&path, SceneProblem::Unknown { what: "parameter", name, known }));
    }
    if let Some(missing) = known().find(|name| !table.parameters.contains_key(*name)) {
        let path = if table.parameters.is_empty() { "system" } else { "system.parameters" };
        let key = format!("parameters.{missing}");
        return Err(at(path, SceneProblem::Missing { key }));
    }
    Ok(())
}

fn custom(
    source: &Source<'_>,
    table: &SystemTable,
    count: Option<usize>,
) -> Result<Described, SceneError> {
    let at = |path: &str, problem: SceneProblem| SceneError { problem, span: source.span(path) };
    if table.parameters.len() > MOST_PARAMETERS {
        let problem = SceneProblem::Budget {
            what: "the number of parameters",
            size: table.parameters.len() as f64,
            limit: MOST_PARAMETERS as f64,
            change: "write numbers into the expressions",
        };
        return Err(at("system.parameters", problem));
    }
    if table.potential.is_none() && table.hamiltonian.is_none() {
        return Err(at("system", SceneProblem::Missing { key: "potential".into() }));
    }
    let whole = [("potential", table.potential.is_some()), ("mass", table.mass.is_some())];
    if let (Some(_), Some((key, _))) = (&table.hamiltonian, whole.into_iter().find(|x| x.1)) {
        let why = "`hamiltonian` is the whole of H(q, p)";
        return Err(at(&format!("system.{key}"), SceneProblem::Misplaced { key, why }));
    }
    for (key, what, list) in [
        ("system.dissipation", "force", table.dissipation.as_ref()),
        ("system.mass", "mass", table.mass.as_ref()),
    ] {
        if matches!(list, Some(PerDegree::List(list)) if list.is_empty()) {
            return Err(at(key, SceneProblem::Empty { what }));
        }
        if let (Some(PerDegree::Rule(_)), None) = (list, dof(table, count)) {
            return Err(at(key, SceneProblem::NoCount));
        }
    }
    if table.friction.as_ref().is_some_and(Vec::is_empty) {
        return Err(at("system.friction", SceneProblem::Empty { what: "row" }));
    }
    if table.dissipation.is_some() && table.friction.is_some() {
        let why = "the friction is given by `dissipation` already";
        return Err(at("system.friction", SceneProblem::Misplaced { key: "friction", why }));
    }
    let energy = if table.hamiltonian.is_some() { "hamiltonian" } else { "potential" };
    described(table, count).map_err(|error| located(source, error, &format!("system.{energy}")))
}

/// The number of degrees of freedom: the length of a list of the system, else `count`.
fn dof(table: &SystemTable, count: Option<usize>) -> Option<usize> {
    let listed = |given: &Option<PerDegree>| match given {
        Some(PerDegree::List(list)) => Some(list.len()),
        Some(PerDegree::Rule(_)) | None => None,
    };
    let rows = table.friction.as_ref().map(Vec::len);
    listed(&table.mass).or(listed(&table.dissipation)).or(rows).or(count)
}

/// A sentence that names the source of N: a list of the system, q, or an index in an expression.
pub(super) fn sets_dof(table: &SystemTable, count: Option<usize>, model: &Model) -> String {
    let dof = model.degrees();
    if table.name != CUSTOM {
        return match model.parameters().contains(&"n") {
            true => "the parameter n of the system sets this number".to_owned(),
            false => format!("{} has {dof}", table.name),
        };
    }
    let listed = |given: &Option<PerDegree>| matches!(given, Some(PerDegree::List(_)));
    let lists = [
        ("mass", listed(&table.mass)),
        ("dissipation", listed(&table.dissipation)),
        ("friction", table.friction.is_some()),
    ];
    match lists.into_iter().find(|x| x.1) {
        Some((key, _)) => format!("the length of `{key}` sets this number"),
        None if count == Some(dof) => "the length of `q` sets this number".to_owned(),
        None => format!("q{dof} or p{dof} is the last that the expressions of the system mention"),
    }
}

/// Says of a list of texts in place of rows that friction is a matrix.
pub(super) fn in_friction(source: &Source<'_>, error: SceneError) -> SceneError {
    let friction = source.span("system.friction");
    match error.problem {
        SceneProblem::Kind { expected, .. }
            if expected == "a list" && friction.contains(&error.span.start) =>
        {
            SceneError { problem: SceneProblem::NoMatrix, ..error }
        }
        _ => error,
    }
}

/// The system of the expressions of a table. A rule is repeated for each degree of freedom.
fn described(table: &SystemTable, count: Option<usize>) -> Result<Described, CustomError> {
    let dof = dof(table, count);
    let texts = |list: &[Expression]| list.iter().map(Expression::text).collect::<Vec<_>>();
    let each = |given: &PerDegree| match given {
        PerDegree::List(list) => texts(list),
        PerDegree::Rule(rule) => vec![rule.text(); dof.unwrap_or(0).min(MOST_DEGREES + 1)],
    };
    let dissipation = match (&table.dissipation, &table.friction) {
        (Some(forces), _) => DissipationText::Forces(each(forces)),
        (None, Some(rows)) => DissipationText::Matrix(rows.iter().map(|row| texts(row)).collect()),
        (None, None) => DissipationText::None,
    };
    let (mut parameters, mut definitions) = (Vec::new(), Vec::new());
    for (name, value) in &table.parameters {
        match value {
            Expression::Number(value) => parameters.push((name.clone(), *value)),
            Expression::Text(text) => definitions.push((name.clone(), text.clone())),
        }
    }
    if let Some(hamiltonian) = &table.hamiltonian {
        let hamiltonian = hamiltonian.text();
        let description =
            GeneralDescription { hamiltonian, dissipation, parameters, definitions, dof };
        return CustomGeneral::new(&description).map(Described::General);
    }
    let description = Description {
        potential: table.potential.as_ref().map(Expression::text).unwrap_or_default(),
        dissipation,
        masses: table.mass.as_ref().map(each).unwrap_or_default(),
        parameters,
        definitions,
        dof,
    };
    Described::separable(&description)
}

/// Adds the place in the scene to a problem of a custom system. `energy` is the path of V or H.
pub(super) fn located(source: &Source<'_>, error: CustomError, energy: &str) -> SceneError {
    let span = match &error {
        CustomError::Expression { place, span, .. }
        | CustomError::NotFinite { place, span, .. } => source.span_within(&path(*place), span),
        CustomError::Name { name, .. }
        | CustomError::Value { name, .. }
        | CustomError::Unused { name }
        | CustomError::NoParameter { name } => source.span(&format!("system.parameters.{name}")),
        CustomError::Count { list, .. } => source.span(match *list {
            "list of masses" => "system.mass",
            "dissipation" => "system.dissipation",
            "list of forces" => "drive.force",
            _ => "system.friction",
        }),
        CustomError::Input(InputError::Mass { dof, .. }) => {
            source.span(&format!("system.mass.{dof}"))
        }
        CustomError::ConstantFunction => source.span("run.events"),
        CustomError::NoPeriod { .. } | CustomError::PeriodRange { .. } => {
            source.span("drive.period")
        }
        CustomError::Empty
        | CustomError::NeedsClock
        | CustomError::TooLarge { .. }
        | CustomError::Input(_) => source.span(energy),
    };
    SceneError { problem: SceneProblem::Custom(error), span }
}

/// The path of an expression. A rule for all degrees of freedom has the path of its key.
fn path(place: Place) -> String {
    match place {
        Place::Potential => "system.potential".into(),
        Place::Hamiltonian => "system.hamiltonian".into(),
        Place::Definition(_) => "system.parameters".into(),
        Place::Mass(j) => format!("system.mass.{j}"),
        Place::Dissipation(j) => format!("system.dissipation.{j}"),
        Place::Friction(i, j) => format!("system.friction.{i}.{j}"),
        Place::Force(j) => format!("drive.force.{j}"),
        Place::Period => "drive.period".into(),
        // Events have their places reported by the planner.
        Place::Function => "run.events".into(),
    }
}

/// Checks that the energy and the forces are finite at the start.
pub(super) fn finite_at(
    source: &Source<'_>,
    problem: &Problem,
    start: &State<Vec<f64>>,
) -> Result<(), SceneError> {
    let at = |path: &str, error: InputError| SceneError {
        problem: error.into(),
        span: source.span(path),
    };
    let mut model = &problem.model;
    if let Model::Driven(system, drive) = model {
        drive.check_at(&start.q, start.t).map_err(|error| located(source, error, "drive.force"))?;
        model = system;
    }
    let n = model.degrees();
    let (q, p) = (&start.q[..n], &start.p[..n]);
    if let Model::Custom(custom) = model {
        return custom.check_at(q, p, start.t).map_err(|error| match error {
            CustomError::Input(error) => at("initial", error),
            _ => located(source, error, "system"),
        });
    }
    let system = model.system::<f64>().map_err(|error| at("system", error))?;
    validate::finite_at(&*system, q, p).map_err(|error| at("initial", error))
}
