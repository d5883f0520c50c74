//! The drive of a scene.

use super::document::{DriveTable, Expression, PerDegree, SystemTable};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use super::system::located;
use afterbay_analysis::Model;
use afterbay_core::Drive;
use afterbay_systems::{CustomDrive, CustomError, DriveDescription};

/// Adds the drive of a table to the system, if any of its forces is not 0.
pub(super) fn driven(
    source: &Source<'_>,
    system: &SystemTable,
    table: &DriveTable,
    model: Model,
) -> Result<Model, SceneError> {
    let dof = model.degrees();
    let forces = match &table.force {
        PerDegree::List(list) if list.is_empty() => {
            let span = source.span("drive.force");
            return Err(SceneError { problem: SceneProblem::Empty { what: "force" }, span });
        }
        PerDegree::List(list) => list.iter().map(Expression::text).collect(),
        PerDegree::Rule(rule) => vec![rule.text(); dof],
    };
    let (mut parameters, mut definitions) = (Vec::new(), Vec::new());
    for (name, value) in system.parameters.iter().chain(&table.parameters) {
        match value {
            Expression::Number(value) => parameters.push((name.clone(), *value)),
            Expression::Text(text) => definitions.push((name.clone(), text.clone())),
        }
    }
    let period = table.period.as_ref().map(Expression::text);
    let description = DriveDescription { forces, parameters, definitions, period };
    let refuse = |error: CustomError| match &error {
        CustomError::Name { name, .. }
        | CustomError::Value { name, .. }
        | CustomError::Unused { name }
            if table.parameters.contains_key(name) =>
        {
            let span = source.span_of(&["drive", "parameters", name]);
            SceneError { problem: SceneProblem::Custom(error), span }
        }
        _ => located(source, error, "drive.force"),
    };
    let (drive, unused) = CustomDrive::new(&description, dof).map_err(refuse)?;
    if let Some(name) = unused.into_iter().find(|name| table.parameters.contains_key(name)) {
        return Err(refuse(CustomError::Unused { name }));
    }
    if Drive::<f64>::driven(&drive).is_empty() {
        return Ok(model);
    }
    Ok(Model::Driven(Box::new(model), drive))
}
