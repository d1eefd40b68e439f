//! KHR_materials_variants: materials that are chosen together.

use super::error::GltfError;
use super::json::Json;

const NAME: &str = "KHR_materials_variants";

/// The names of a file's variants.
pub fn variants(root: &Json<'_>) -> Result<Vec<String>, GltfError> {
    match root.extension(NAME)? {
        Some(extension) => {
            let variants = extension.objects("variants")?;
            Ok(variants.iter().map(Json::name).collect())
        }
        None => Ok(Vec::new()),
    }
}

/// The material of a primitive in a variant, which must be one of the file's; its own where no mapping
/// names the variant. `None` is the default material.
pub fn material<'a>(
    primitive: &Json<'a>,
    variant: Option<usize>,
) -> Result<Option<(usize, Json<'a>)>, GltfError> {
    if let (Some(variant), Some(extension)) = (variant, primitive.extension(NAME)?) {
        for mapping in extension.objects("mappings")? {
            for number in mapping.elements("variants")? {
                if number.as_uint()? == variant as u64 {
                    let material = mapping.required("material")?;
                    return Ok(Some(material.follow("materials")?));
                }
            }
        }
    }
    primitive.reference("material", "materials")
}
