//! A cursor over the file's JSON that knows where it stands, so that every error can say so.
//!
//! The `gltf` crate's own types are not used for this: its validation indexes out of range on a
//! hostile POSITION, its indices are cut to 32 bits, a scene without `nodes` is refused, and its
//! type errors name a line instead of a place in the glTF. `tests/gltf.rs` reads the same files
//! through it as an independent check.

use super::error::GltfError;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A parsed file.
pub struct Document {
    pub path: PathBuf,
    pub root: Value,
}

/// A value in a document and the path that leads to it.
#[derive(Clone)]
pub struct Json<'a> {
    document: &'a Document,
    value: &'a Value,
    pub at: String,
}

impl<'a> Json<'a> {
    pub fn root(document: &'a Document) -> Self {
        Self {
            document,
            value: &document.root,
            at: String::new(),
        }
    }

    pub fn file(&self) -> &'a Path {
        &self.document.path
    }

    pub fn value(&self) -> &'a Value {
        self.value
    }

    pub fn invalid(&self, what: impl Into<String>) -> GltfError {
        GltfError::Invalid {
            file: self.document.path.clone(),
            at: self.at.clone(),
            what: what.into(),
        }
    }

    pub fn missing_feature(&self, name: &str, feature: &'static str) -> GltfError {
        GltfError::MissingFeature {
            file: self.file().to_owned(),
            at: self.at.clone(),
            name: name.to_owned(),
            feature,
        }
    }

    pub fn unsupported_extension(&self, name: &str) -> GltfError {
        GltfError::UnsupportedExtension {
            file: self.document.path.clone(),
            at: self.at.clone(),
            name: name.to_owned(),
        }
    }

    pub fn get(&self, key: &str) -> Option<Json<'a>> {
        Some(self.with(self.value.get(key)?, key))
    }

    /// The names of an object's properties.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> {
        let object = self.value.as_object();
        object
            .into_iter()
            .flat_map(|object| object.keys().map(String::as_str))
    }

    /// The path of a property, whether it is there or not.
    pub fn place(&self, key: &str) -> String {
        if self.at.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.at)
        }
    }

    fn with(&self, value: &'a Value, key: &str) -> Json<'a> {
        Json {
            document: self.document,
            value,
            at: self.place(key),
        }
    }

    pub fn required(&self, key: &str) -> Result<Json<'a>, GltfError> {
        self.get(key)
            .ok_or_else(|| self.invalid(format!("`{key}` is missing")))
    }

    /// A property that holds an object.
    pub fn object(&self, key: &str) -> Result<Option<Json<'a>>, GltfError> {
        match self.get(key) {
            Some(json) if !json.value.is_object() => Err(json.not("an object")),
            found => Ok(found),
        }
    }

    /// The same, without properties where it is absent.
    pub fn object_or_empty(&self, key: &str) -> Result<Json<'a>, GltfError> {
        const EMPTY: &Value = &Value::Null;
        Ok(self.object(key)?.unwrap_or_else(|| self.with(EMPTY, key)))
    }

    pub fn extension(&self, name: &str) -> Result<Option<Json<'a>>, GltfError> {
        match self.object("extensions")? {
            Some(extensions) => extensions.object(name),
            None => Ok(None),
        }
    }

    fn not(&self, expected: &str) -> GltfError {
        const SHOWN: usize = 40;
        let mut text: String = self.value.to_string().chars().take(SHOWN + 1).collect();
        if text.chars().count() > SHOWN {
            text = text.chars().take(SHOWN).chain("...".chars()).collect();
        }
        self.invalid(format!("{text} is not {expected}"))
    }

    /// The elements of an array property; none where it is absent.
    pub fn elements(&self, key: &str) -> Result<Vec<Json<'a>>, GltfError> {
        let Some(array) = self.get(key) else {
            return Ok(Vec::new());
        };
        array.items()
    }

    /// The elements of this value, an array.
    pub fn items(&self) -> Result<Vec<Json<'a>>, GltfError> {
        let values = self.value.as_array();
        let values = values.ok_or_else(|| self.not("an array"))?;
        Ok(values
            .iter()
            .enumerate()
            .map(|(index, value)| Json {
                document: self.document,
                value,
                at: format!("{}[{index}]", self.at),
            })
            .collect())
    }

    /// The elements of an array property, each of which must be an object.
    pub fn objects(&self, key: &str) -> Result<Vec<Json<'a>>, GltfError> {
        let elements = self.elements(key)?;
        match elements.iter().find(|element| !element.value.is_object()) {
            Some(element) => Err(element.not("an object")),
            None => Ok(elements),
        }
    }

    /// What an object or an array holds, by name or by number.
    pub fn children(&self) -> Vec<Json<'a>> {
        match self.value {
            Value::Object(object) => {
                let values = object.iter();
                values.map(|(key, value)| self.with(value, key)).collect()
            }
            Value::Array(array) => {
                let values = array.iter().enumerate();
                values
                    .map(|(index, value)| Json {
                        document: self.document,
                        value,
                        at: format!("{}[{index}]", self.at),
                    })
                    .collect()
            }
            _ => Vec::new(),
        }
    }

    pub fn as_uint(&self) -> Result<u64, GltfError> {
        // JSON has one kind of number: 3.0 is the integer 3.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        if let Some(value) = self.value.as_u64() {
            return Ok(value);
        }
        match self.value.as_f64() {
            Some(value) if (0.0..=EXACT).contains(&value) && value.fract() == 0.0 => {
                Ok(value as u64)
            }
            _ => Err(self.not("a non-negative integer")),
        }
    }

    pub fn uint(&self, key: &str) -> Result<Option<u64>, GltfError> {
        self.get(key).map(|json| json.as_uint()).transpose()
    }

    pub fn as_number(&self) -> Result<f32, GltfError> {
        let value = self.value.as_f64().ok_or_else(|| self.not("a number"))? as f32;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.not("a number that 32-bit floating point can hold"))
        }
    }

    pub fn number(&self, key: &str) -> Result<Option<f32>, GltfError> {
        self.get(key).map(|json| json.as_number()).transpose()
    }

    pub fn numbers(&self, key: &str) -> Result<Option<Vec<f32>>, GltfError> {
        if self.get(key).is_none() {
            return Ok(None);
        }
        let elements = self.elements(key)?;
        elements
            .iter()
            .map(Json::as_number)
            .collect::<Result<_, _>>()
            .map(Some)
    }

    pub fn vector<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>, GltfError> {
        let Some(values) = self.numbers(key)? else {
            return Ok(None);
        };
        let count = values.len();
        <[f32; N]>::try_from(values).map(Some).map_err(|_| {
            let mut at = self.clone();
            at.at = self.place(key);
            at.invalid(format!("{count} numbers where {N} belong"))
        })
    }

    pub fn boolean(&self, key: &str) -> Result<Option<bool>, GltfError> {
        self.get(key)
            .map(|json| {
                json.value
                    .as_bool()
                    .ok_or_else(|| json.not("true or false"))
            })
            .transpose()
    }

    pub fn string(&self, key: &str) -> Result<Option<&'a str>, GltfError> {
        self.get(key)
            .map(|json| json.value.as_str().ok_or_else(|| json.not("a string")))
            .transpose()
    }

    pub fn as_string(&self) -> Result<&'a str, GltfError> {
        self.value.as_str().ok_or_else(|| self.not("a string"))
    }

    /// The object's own name, or its path: `meshes[2]`.
    pub fn name(&self) -> String {
        match self.value.get("name").and_then(Value::as_str) {
            Some(name) if !name.is_empty() => name.to_owned(),
            _ => self.at.clone(),
        }
    }

    /// Follows this value, an index, into a top-level array.
    pub fn follow(&self, section: &str) -> Result<(usize, Json<'a>), GltfError> {
        let index = self.as_uint()?;
        let list = self.document.root.get(section).and_then(Value::as_array);
        let count = list.map_or(0, Vec::len);
        let (index, value) = usize::try_from(index)
            .ok()
            .and_then(|index| Some((index, list?.get(index)?)))
            .ok_or_else(|| {
                self.invalid(format!(
                    "{index} is out of range: there are {count} {section}"
                ))
            })?;
        let found = Json {
            document: self.document,
            value,
            at: format!("{section}[{index}]"),
        };
        if !value.is_object() {
            return Err(found.not("an object"));
        }
        Ok((index, found))
    }

    pub fn reference(
        &self,
        key: &str,
        section: &str,
    ) -> Result<Option<(usize, Json<'a>)>, GltfError> {
        self.get(key).map(|json| json.follow(section)).transpose()
    }
}
