//! As much of JSON Schema as `report.schema.json` uses. A keyword that is not known here fails.

use regex::Regex;
use serde_json::Value;

/// What of `value` is not as the schema says, each with its place.
pub fn errors(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "$", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    for (keyword, rule) in schema.as_object().expect("a schema is an object") {
        let right = match keyword.as_str() {
            "$schema" | "title" | "$defs" | "properties" => true,
            "$ref" => {
                let target =
                    rule.as_str().and_then(|path| root.pointer(path.strip_prefix('#')?)).expect("a reference leads on");
                check(root, target, value, at, found);
                true
            }
            "type" => has_type(rule.as_str().unwrap_or_default(), value),
            "const" => rule == value,
            "enum" => rule.as_array().is_some_and(|allowed| allowed.contains(value)),
            "minimum" => value.as_f64() >= rule.as_f64(),
            "minLength" => value.as_str().map(|text| text.chars().count() as u64) >= rule.as_u64(),
            "minItems" => value.as_array().map(|items| items.len() as u64) >= rule.as_u64(),
            "pattern" => {
                let pattern = Regex::new(rule.as_str().unwrap_or_default()).expect("a pattern is an expression");
                value.as_str().is_some_and(|text| pattern.is_match(text))
            }
            "required" => {
                let names = rule.as_array().into_iter().flatten().filter_map(Value::as_str);
                names.into_iter().all(|name| value.get(name).is_some())
            }
            "additionalProperties" => {
                assert_eq!(rule, &Value::Bool(false), "nothing else is known of this keyword");
                let known = |name: &String| schema["properties"].get(name).is_some();
                value.as_object().is_none_or(|fields| fields.keys().all(known))
            }
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, rule, item, &format!("{at}[{index}]"), found);
                }
                true
            }
            unknown => panic!("the keyword {unknown} is not known"),
        };
        if !right {
            found.push(format!("{at}: {keyword} {rule} does not hold of {value}"));
        }
    }
    for (name, rule) in schema["properties"].as_object().into_iter().flatten() {
        if let Some(field) = value.get(name) {
            check(root, rule, field, &format!("{at}.{name}"), found);
        }
    }
}

fn has_type(name: &str, value: &Value) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        unknown => panic!("the type {unknown} is not known"),
    }
}
