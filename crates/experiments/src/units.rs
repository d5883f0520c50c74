//! The units of quantities.

use afterbay_analysis::{Observable, Variable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Names of units. They label the axes of charts; nothing is converted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitsTable {
    /// The unit of t and of steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// The unit of the coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub q: Option<String>,
    /// The unit of the momenta.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<String>,
    /// The unit of H, w and K.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
}

impl UnitsTable {
    /// The label of a quantity of time, for instance `time t [s]`.
    pub(crate) fn time(&self, quantity: &str) -> String {
        with(quantity, self.time.as_deref())
    }

    /// The unit of a column of a table, which its name determines: t and h are times, q1 is a
    /// coordinate, w1 and H are energies.
    pub(crate) fn of_column(&self, name: &str) -> Option<&str> {
        let unit = match name.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "t" | "h" => &self.time,
            "q" => &self.q,
            "p" => &self.p,
            "w" | "s" | "st" | "H" | "K" => &self.energy,
            _ => &None,
        };
        unit.as_deref()
    }

    /// The label of a result that begins with the name of a column, as in `H at the end [J]`.
    pub(crate) fn result(&self, what: &str) -> String {
        let column = what.trim_start_matches("Σ ").split(' ').next();
        with(what, column.and_then(|column| self.of_column(column)))
    }

    /// The label of an axis that shows `quantity`, which is of the kind of an observable.
    pub(crate) fn observable(&self, observable: Observable, quantity: &str) -> String {
        match observable {
            Observable::Time => self.time(quantity),
            Observable::Of(variable, _) => self.variable(variable, quantity),
            _ => self.energy(quantity),
        }
    }

    /// The label of an energy.
    pub(crate) fn energy(&self, quantity: &str) -> String {
        with(quantity, self.energy.as_deref())
    }

    /// The label of a variable.
    pub(crate) fn variable(&self, variable: Variable, quantity: &str) -> String {
        let unit = match variable {
            Variable::Q => &self.q,
            Variable::P => &self.p,
            Variable::W | Variable::S => &self.energy,
        };
        with(quantity, unit.as_deref())
    }
}

/// A label: a quantity and its unit, if there is one.
fn with(quantity: &str, unit: Option<&str>) -> String {
    unit.map_or_else(|| quantity.to_owned(), |unit| format!("{quantity} [{unit}]"))
}
