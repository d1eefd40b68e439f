//! As much of JSON Schema (draft 2020-12) as our own schemas use.

use serde_json::Value;

/// Whether `value` is what `schema`, a part of `root`, describes; otherwise where it is not.
pub fn validate(root: &Value, schema: &Value, value: &Value) -> Result<(), String> {
    let fault = |what: &str| Err(format!("{value} {what}: {schema}"));
    let Some(keywords) = schema.as_object() else {
        return Ok(());
    };
    let number = || value.as_f64().unwrap_or(0.0);
    let length = || value.as_array().map_or(0, Vec::len) as f64;
    for (keyword, rule) in keywords {
        let passing = |rules: &Value| {
            let rules = rules.as_array().map_or(&[][..], Vec::as_slice);
            rules
                .iter()
                .filter(|rule| validate(root, rule, value).is_ok())
                .count()
        };
        let limit = rule.as_f64().unwrap_or(0.0);
        let holds = match keyword.as_str() {
            "$ref" => {
                let path = rule.as_str().unwrap_or("").trim_start_matches('#');
                let target = root
                    .pointer(path)
                    .ok_or(format!("no {rule} in the schema"))?;
                validate(root, target, value)?;
                true
            }
            "type" => match rule.as_str() {
                Some("object") => value.is_object(),
                Some("array") => value.is_array(),
                Some("number") => value.is_number(),
                Some("integer") => value.is_u64() || value.is_i64(),
                Some("string") => value.is_string(),
                Some("boolean") => value.is_boolean(),
                Some("null") => value.is_null(),
                _ => return fault("meets an unknown type"),
            },
            "const" => value == rule,
            "enum" => rule.as_array().is_some_and(|values| values.contains(value)),
            "anyOf" => passing(rule) > 0,
            "oneOf" => passing(rule) == 1,
            "required" => {
                let names = rule.as_array().map_or(&[][..], Vec::as_slice);
                names
                    .iter()
                    .all(|name| name.as_str().is_some_and(|name| value.get(name).is_some()))
            }
            "properties" => {
                for (name, rule) in rule.as_object().into_iter().flatten() {
                    if let Some(value) = value.get(name) {
                        validate(root, rule, value)?;
                    }
                }
                true
            }
            "additionalProperties" => {
                for (name, value) in value.as_object().into_iter().flatten() {
                    if schema["properties"].get(name).is_none() {
                        if *rule == Value::Bool(false) {
                            return fault(&format!("has an unknown {name}"));
                        }
                        validate(root, rule, value)?;
                    }
                }
                true
            }
            "pattern" => match rule.as_str() {
                Some("^fnv1a64:[0-9a-f]{16}$") => {
                    let digits = value.as_str().and_then(|v| v.strip_prefix("fnv1a64:"));
                    digits.is_some_and(|digits| {
                        digits.len() == 16 && digits.chars().all(|c| c.is_ascii_hexdigit())
                    })
                }
                _ => return fault("meets an unknown pattern"),
            },
            "items" => {
                for value in value.as_array().into_iter().flatten() {
                    validate(root, rule, value)?;
                }
                true
            }
            "minItems" => length() >= limit,
            "maxItems" => length() <= limit,
            "minimum" => number() >= limit,
            "maximum" => number() <= limit,
            "exclusiveMinimum" => number() > limit,
            "exclusiveMaximum" => number() < limit,
            "$schema" | "$defs" | "title" | "description" | "default" => true,
            _ => return fault("meets an unknown keyword"),
        };
        if !holds {
            return fault(&format!("breaks {keyword}"));
        }
    }
    Ok(())
}
