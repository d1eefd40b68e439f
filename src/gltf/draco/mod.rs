//! KHR_draco_mesh_compression: primitives whose triangles and attributes lie in a Draco stream.

mod frame;
mod points;
mod stream;

use super::accessor::{Accessors, Overrides, store};
use super::error::GltfError;
use super::json::Json;
use super::notes::Notes;
use gltf::json::mesh::TRIANGLES;

pub const NAME: &str = "KHR_draco_mesh_compression";

/// What a primitive's accessors hold instead of what lies in their buffer views; nothing where it is
/// not compressed. An uncompressed copy that the file may bring, too, is not read.
pub fn read(
    primitive: &Json<'_>,
    attributes: &Json<'_>,
    accessors: Accessors<'_>,
    notes: &mut Notes,
) -> Result<Overrides, GltfError> {
    let mut overrides = Overrides::new();
    let Some(extension) = primitive.extension(NAME)? else {
        return Ok(overrides);
    };
    if primitive.uint("mode")?.unwrap_or(u64::from(TRIANGLES)) != u64::from(TRIANGLES) {
        return Err(primitive.invalid("it is Draco's and not a list of triangles"));
    }
    let view = accessors.buffers.view(&extension, "bufferView")?;
    let view = view.ok_or_else(|| extension.invalid("`bufferView` is missing"))?;
    let (index_number, indices) = primitive.required("indices")?.follow("accessors")?;
    let triangles = indices.required("count")?.as_uint()? / 3;
    let take = |bytes: u64| {
        accessors
            .budget
            .take(bytes, extension.file(), &extension.at)
    };
    let damaged = |what: String| extension.invalid(format!("the Draco stream is damaged: {what}"));
    let decoded = stream::decode(view.bytes, triangles, take, damaged)?;

    // Each number is 8 bytes on its way and 4 at most where it stays.
    const NUMBER: u64 = 12;
    take(3 * NUMBER * triangles)?;
    let corners = decoded.triangles.as_flattened().iter();
    let corners: Vec<f64> = corners.map(|&index| f64::from(index)).collect();
    overrides.insert(index_number, store(&indices, 1, &corners)?);
    let ids = extension
        .object("attributes")?
        .ok_or_else(|| extension.invalid("`attributes` is missing"))?;
    for key in ids.keys() {
        let id = ids.required(key)?;
        let (number, accessor) = attributes.required(key)?.follow("accessors")?;
        // Four components at most.
        take(4 * NUMBER * decoded.point_count() as u64)?;
        if accessor.required("count")?.as_uint()? != decoded.point_count() as u64 {
            notes.add(
                "accessors that count other than their Draco stream are as long as the stream",
                &extension.at,
            );
        }
        let values = decoded.values(id.as_uint()?);
        let (components, values) = values.map_err(|what| id.invalid(what))?;
        overrides.insert(number, store(&accessor, components, &values)?);
    }
    Ok(overrides)
}
