//! Queries as they are written: one JSON object a line.

use super::Input;
use super::material::{MaterialError, bsdf_of, material_of};
use crate::pack::model::{ModelError, lower_fresnel};
use crate::scene::bsdf_model::Fresnel;
use crate::shared::Material;
use bytemuck::Zeroable;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Directions this far from unit length are normalised; beyond, they are a mistake.
pub const UNIT_TOLERANCE: f64 = 1e-3;
/// Samples of an albedo query that names no number.
const SAMPLES_DEFAULT: u64 = 65_536;
/// Ten minutes on a slow machine.
const SAMPLES_MAX: u64 = 1 << 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    Fresnel,
    Eval,
    Sample,
    Albedo,
}

/// A query that has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    pub kind: Kind,
    pub input: Input,
    /// Of an albedo query.
    pub samples: u64,
}

/// A line that is no query, with the id that the complaint goes to.
#[derive(Debug, PartialEq)]
pub struct Rejected {
    pub id: Value,
    pub error: QueryError,
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum QueryError {
    #[error("not JSON: {0}")]
    Json(String),
    #[error("a query is a JSON object")]
    Object,
    #[error("`{0}` is missing")]
    Missing(&'static str),
    #[error("`{field}`: {message}")]
    Field {
        field: &'static str,
        message: String,
    },
    #[error("this is a query of kind {0}, asked for among others: use `snell bsdf mixed`")]
    Kind(String),
    #[error("`{field}` has length {length}, not 1")]
    Length { field: &'static str, length: f64 },
    #[error("`{field}` is {value}, but must be {range}")]
    Range {
        field: &'static str,
        value: f64,
        range: &'static str,
    },
    #[error("`fresnel`: {0}")]
    Fresnel(ModelError),
    #[error("`material`: {0}")]
    Material(#[from] MaterialError),
}

/// Reads one line. `kind` is what all queries of this run are; `None` takes each query's own word.
pub fn parse(line: &[u8], kind: Option<Kind>) -> Result<(Value, Query), Rejected> {
    let mut value: Value = serde_json::from_slice(line).map_err(|error| Rejected {
        id: Value::Null,
        error: QueryError::Json(error.to_string()),
    })?;
    let id = value.get_mut("id").map_or(Value::Null, Value::take);
    match check(&value, kind) {
        Ok(query) => Ok((id, query)),
        Err(error) => Err(Rejected { id, error }),
    }
}

fn check(query: &Value, expected: Option<Kind>) -> Result<Query, QueryError> {
    if !query.is_object() {
        return Err(QueryError::Object);
    }
    let kind = match (expected, optional::<Kind>(query, "kind")?) {
        (Some(kind), None) => kind,
        (None, Some(kind)) => kind,
        (Some(kind), Some(own)) if kind == own => kind,
        (Some(_), Some(_)) => return Err(QueryError::Kind(query["kind"].to_string())),
        (None, None) => return Err(QueryError::Missing("kind")),
    };
    let mut material = Material::zeroed();
    let mut input = Input {
        bsdf: Zeroable::zeroed(),
        wo: DVec3::Z,
        wi: DVec3::Z,
        u: DVec3::ZERO,
        cos_theta: 1.0,
    };
    let mut samples = 0;
    if kind == Kind::Fresnel {
        let fresnel: Fresnel = required(query, "fresnel")?;
        lower_fresnel(&fresnel, &mut material).map_err(QueryError::Fresnel)?;
        let cos_theta: f64 = required(query, "cos_theta")?;
        in_range(
            "cos_theta",
            cos_theta,
            cos_theta.abs() <= 1.0,
            "from -1 to 1",
        )?;
        // From below the surface looks as it does from above: eta is told from the seen side.
        input.cos_theta = cos_theta.abs();
    } else {
        let value = query
            .get("material")
            .ok_or(QueryError::Missing("material"))?;
        material = material_of(value)?;
        input.wo = direction(query, "wo")?;
    }
    input.bsdf = bsdf_of(&material);
    match kind {
        Kind::Fresnel => {}
        Kind::Eval => input.wi = direction(query, "wi")?,
        Kind::Sample => {
            let u: [f64; 3] = required(query, "u")?;
            for value in u {
                in_range(
                    "u",
                    value,
                    (0.0..1.0).contains(&value),
                    "at least 0 and less than 1",
                )?;
            }
            input.u = DVec3::from_array(u);
        }
        Kind::Albedo => {
            samples = optional(query, "samples")?.unwrap_or(SAMPLES_DEFAULT);
            let range = 2..=SAMPLES_MAX;
            in_range(
                "samples",
                samples as f64,
                range.contains(&samples),
                "from 2 to 2^30",
            )?;
        }
    }
    Ok(Query {
        kind,
        input,
        samples,
    })
}

fn optional<T: for<'a> Deserialize<'a>>(
    query: &Value,
    field: &'static str,
) -> Result<Option<T>, QueryError> {
    match query.get(field) {
        None => Ok(None),
        Some(value) => T::deserialize(value)
            .map(Some)
            .map_err(|error| QueryError::Field {
                field,
                message: error.to_string(),
            }),
    }
}

fn required<T: for<'a> Deserialize<'a>>(
    query: &Value,
    field: &'static str,
) -> Result<T, QueryError> {
    optional(query, field)?.ok_or(QueryError::Missing(field))
}

fn direction(query: &Value, field: &'static str) -> Result<DVec3, QueryError> {
    let w = DVec3::from_array(required(query, field)?);
    let length = w.length();
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(w / length)
    } else {
        Err(QueryError::Length { field, length })
    }
}

fn in_range(
    field: &'static str,
    value: f64,
    holds: bool,
    range: &'static str,
) -> Result<(), QueryError> {
    if holds {
        Ok(())
    } else {
        Err(QueryError::Range {
            field,
            value,
            range,
        })
    }
}
