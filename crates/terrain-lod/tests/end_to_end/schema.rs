//! `summary.json` is what its schema says, and the schema knows every column.

use std::path::Path;

use serde_json::{Value, json};

use crate::program::terrain_lod;

/// The schema with its named parts.
struct Schema(Value);

impl Schema {
    fn of_the_summary() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/summary.schema.json");
        Self(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
    }

    fn complaints(&self, value: &Value) -> Vec<String> {
        let mut found = Vec::new();
        self.check(&self.0, value, "$", &mut found);
        found
    }

    /// The keywords that the schema uses; another one is a complaint, so that it is not left unchecked.
    fn check(&self, schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
        for (keyword, wanted) in schema.as_object().unwrap() {
            let holds = match keyword.as_str() {
                "$ref" => {
                    let name = wanted.as_str().unwrap().strip_prefix('#').unwrap();
                    self.check(self.0.pointer(name).unwrap(), value, place, found);
                    true
                }
                "type" => is_of_type(value, wanted),
                "const" => value == wanted,
                "enum" => wanted.as_array().unwrap().contains(value),
                "minimum" => value.as_f64().is_none_or(|number| number >= wanted.as_f64().unwrap()),
                "required" => wanted.as_array().unwrap().iter().all(|name| value.get(name.as_str().unwrap()).is_some()),
                "items" => {
                    let items = value.as_array().into_iter().flatten().enumerate();
                    items.for_each(|(i, item)| self.check(wanted, item, &format!("{place}[{i}]"), found));
                    true
                }
                "properties" => {
                    let known =
                        wanted.as_object().unwrap().iter().filter_map(|(name, s)| Some((name, s, value.get(name)?)));
                    known.for_each(|(name, s, value)| self.check(s, value, &format!("{place}.{name}"), found));
                    true
                }
                "additionalProperties" => {
                    self.check_others(schema, wanted, value, place, found);
                    true
                }
                "$schema" | "$defs" | "title" | "description" => true,
                _ => false,
            };
            if !holds {
                found.push(format!("{place}: {keyword} {wanted}"));
            }
        }
    }

    fn check_others(&self, schema: &Value, wanted: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
        let others =
            value.as_object().into_iter().flatten().filter(|(name, _)| schema["properties"].get(name).is_none());
        for (name, other) in others {
            match wanted {
                Value::Bool(false) => found.push(format!("{place}.{name} is not in the schema")),
                _ => self.check(wanted, other, &format!("{place}.{name}"), found),
            }
        }
    }
}

fn is_of_type(value: &Value, wanted: &Value) -> bool {
    let is = |name: &Value| match name.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        other => panic!("unknown type {other}"),
    };
    wanted.as_array().map_or_else(|| is(wanted), |any| any.iter().any(is))
}

/// A new column belongs into the schema, and into METHODOLOGY.md.
#[test]
fn the_written_summary_keeps_the_schema_and_has_the_facts_of_the_machine() {
    let place = tempfile::tempdir().unwrap();
    let arguments = ["bench", "--no-gpu", "--suite", "smoke", "--aa", "--out", "results"];
    terrain_lod(place.path(), &arguments);
    let read = |name: &str| -> Value {
        serde_json::from_slice(&std::fs::read(place.path().join("results").join(name)).unwrap()).unwrap()
    };
    let summary = read("summary.json");
    assert_eq!(Schema::of_the_summary().complaints(&summary), [""; 0]);
    assert_eq!(summary["machine"], read("machine.json"));
    assert_eq!(summary["aa"].as_array().unwrap().len(), 8, "a check for each run");
    let rows = csv::Reader::from_path(place.path().join("results/summary.csv")).unwrap().into_records().count();
    assert_eq!(summary["rows"].as_array().unwrap().len(), rows);
    assert_eq!(summary["rows"][0]["repeat_times"]["plan_ms_p50"].as_array().unwrap().len(), 3);
}

#[test]
fn the_check_finds_what_is_wrong() {
    let schema = Schema(json!({
        "type": "object", "required": ["a"], "additionalProperties": false,
        "properties": { "a": { "type": ["integer", "null"], "minimum": 0 }, "b": { "$ref": "#/$defs/t" } },
        "$defs": { "t": { "type": "array", "items": { "enum": ["x"] } } }
    }));
    assert_eq!(schema.complaints(&json!({ "a": null, "b": ["x"] })), [""; 0]);
    let wrong =
        [json!({}), json!({ "a": -1 }), json!({ "a": 1.5 }), json!({ "a": 1, "c": 2 }), json!({ "a": 1, "b": ["y"] })];
    for value in wrong.into_iter().chain([json!([])]) {
        assert!(!schema.complaints(&value).is_empty(), "{value}");
    }
}
