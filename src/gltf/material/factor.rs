//! Numbers of materials in their ranges.

use super::super::error::GltfError;
use super::super::json::Json;
use super::Policy;

/// Doubts the properties of an object that the specification has no such name for.
pub fn known_keys<'a>(
    json: &Json<'a>,
    keys: &[&str],
    policy: &mut dyn Policy<'a>,
) -> Result<(), GltfError> {
    for key in json
        .value()
        .as_object()
        .into_iter()
        .flat_map(|all| all.keys())
    {
        let known = keys.contains(&key.as_str()) || matches!(key.as_str(), "extensions" | "extras");
        if !known && let Some(value) = json.get(key) {
            policy.doubt(
                &value,
                &format!("the unknown property `{key}`"),
                "is ignored",
            )?;
        }
    }
    Ok(())
}

/// A factor from 0 to 1; what lies outside is moved to the nearer end.
pub fn strength<'a>(
    json: &Json<'a>,
    key: &str,
    default: f32,
    policy: &mut dyn Policy<'a>,
) -> Result<f32, GltfError> {
    let value = json.number(key)?.unwrap_or(default);
    Ok(inside(json, key, [value], policy)?[0])
}

/// The same for each channel of a colour.
pub fn color<'a, const N: usize>(
    json: &Json<'a>,
    key: &str,
    default: [f32; N],
    policy: &mut dyn Policy<'a>,
) -> Result<[f32; N], GltfError> {
    let value = json.vector(key)?.unwrap_or(default);
    inside(json, key, value, policy)
}

fn inside<'a, const N: usize>(
    json: &Json<'a>,
    key: &str,
    value: [f32; N],
    policy: &mut dyn Policy<'a>,
) -> Result<[f32; N], GltfError> {
    let clamped = value.map(|value| value.clamp(0.0, 1.0));
    if clamped != value
        && let Some(found) = json.get(key)
    {
        policy.doubt(&found, "a factor outside of 0 to 1", "is clamped")?;
    }
    Ok(clamped)
}

/// A number that has to be `least` or more.
pub fn at_least(json: &Json<'_>, key: &str, least: f32, default: f32) -> Result<f32, GltfError> {
    let Some(found) = json.get(key) else {
        return Ok(default);
    };
    let value = found.as_number()?;
    if value >= least {
        Ok(value)
    } else {
        Err(found.invalid(format!("it is {value}; it must be at least {least}")))
    }
}
