//! A model as written to files: its name and parameters.

use super::Model;
use serde::ser::{SerializeMap, SerializeStruct};
use serde::{Serialize, Serializer};

/// Serializes the name and the parameters. The expressions of a custom system are part of the
/// scene.
impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut model = serializer.serialize_struct("Model", 2)?;
        model.serialize_field("name", self.name())?;
        model.serialize_field("parameters", &Parameters(self))?;
        model.end()
    }
}

struct Parameters<'a>(&'a Model);

impl Serialize for Parameters<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Model::Listed(row, values) => {
                let mut map = serializer.serialize_map(Some(values.len()))?;
                for (i, (parameter, &value)) in row.parameters.iter().zip(values).enumerate() {
                    if row.is_count(i) {
                        map.serialize_entry(parameter.name, &(value as u64))?;
                    } else {
                        map.serialize_entry(parameter.name, &value)?;
                    }
                }
                map.end()
            }
            Model::Custom(custom) => serializer.collect_map(custom.parameters()),
            Model::Driven(model, _) => Parameters(model).serialize(serializer),
        }
    }
}
