//! Functions of the state whose zeros are events.

use crate::Model;
use crate::Variable;
use crate::observable::Observable;
use crate::study::trajectory::TrajectoryRow;
use afterbay_core::{Abilities, InputError, IntegrateError, StateRef};
use afterbay_systems::{CustomFunction, FunctionDescription};

/// A function of the state.
#[derive(Clone, Debug, PartialEq)]
pub enum Function {
    /// A quantity less a value in the same units.
    Quantity(Observable, f64),
    /// An expression in q1, .., p1, .., t and the parameters; with names of expressions in them.
    Expression(String, Vec<(String, String)>),
}

pub(super) type Value<'a> = Box<dyn Fn(StateRef<'_, f64>) -> f64 + Sync + 'a>;

impl Function {
    /// The function for a model.
    pub(super) fn bind<'a>(
        &self,
        model: &'a Model,
        system: &'a dyn Abilities<f64>,
    ) -> Result<Value<'a>, IntegrateError> {
        match self {
            Self::Quantity(quantity, value) => {
                let (quantity, value) = (*quantity, *value);
                Ok(Box::new(move |state| {
                    let n = model.degrees();
                    match quantity {
                        Observable::Time => state.t - value,
                        Observable::Of(Variable::Q, j) => state.q[j] - value,
                        Observable::Of(Variable::P, j) => state.p[j] - value,
                        Observable::Energy => {
                            state.energy(system) - state.p[n..].iter().sum::<f64>() - value
                        }
                        _ => {
                            let row = TrajectoryRow::of("", 0, state, system, model);
                            quantity.of(&row, &row).unwrap_or(f64::NAN) - value
                        }
                    }
                }))
            }
            Self::Expression(..) => {
                let (function, n) = (self.compiled(model), model.degrees());
                let Some(Ok(function)) = function else {
                    let why =
                        "its expression is not one of this system; Function::compiled says why";
                    return Err(InputError::Unsupported { method: "an event", why }.into());
                };
                Ok(Box::new(move |state| function.value(&state.q[..n], &state.p[..n], state.t)))
            }
        }
    }

    /// The expression, compiled with the parameters of a model; none for a function that is no
    /// expression. The error says where the expression is not one of the system.
    pub fn compiled(
        &self,
        model: &Model,
    ) -> Option<Result<CustomFunction, afterbay_systems::CustomError>> {
        let Self::Expression(text, definitions) = self else { return None };
        let description = FunctionDescription {
            text: text.clone(),
            parameters: model.values(),
            definitions: definitions.clone(),
        };
        Some(CustomFunction::new(&description, model.degrees()))
    }
}
