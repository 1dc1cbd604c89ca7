//! JSON schemas of reports.

use boon::{Compiler, SchemaIndex, Schemas};
use serde_json::{Value, json};

const PLACE: &str = "schema.json";

fn compiled(schema: &Value) -> (Schemas, SchemaIndex) {
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.add_resource(PLACE, schema.clone()).unwrap_or_else(|error| panic!("{error}"));
    let index = compiler.compile(PLACE, &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    (schemas, index)
}

/// Describes a mismatch between `report` and the schema, if any. Members that the schema does not list count as
/// mismatches.
///
/// # Panics
/// If the schema violates its own draft.
pub fn complaint(schema: &Value, report: &Value) -> Option<String> {
    let mut strict = schema.clone();
    strict["unevaluatedProperties"] = json!(false);
    let (schemas, index) = compiled(&strict);
    schemas.validate(report, index).err().map(|error| format!("{error:#}"))
}

/// Checks a schema itself.
///
/// # Panics
/// If it violates its draft.
pub fn check(schema: &Value) {
    compiled(schema);
}
