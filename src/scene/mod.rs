//! What a renderer needs of a glTF file, with nothing of the file format left: meshes in object
//! space, instances that place them, materials, images, lights and cameras.
//!
//! Right-handed, y up, metres, radians; colours linear Rec. 709; light in radiometric units.

pub mod bsdf_model;
pub mod metals;

use bsdf_model::BsdfModel;
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// A scene that has been checked: indices are in range, numbers are finite, sizes agree.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub meshes: Vec<Mesh>,
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    pub lights: Vec<PunctualLight>,
    pub cameras: Vec<Camera>,
    pub environment: Option<Environment>,
}

/// A glTF mesh: its primitives share one bounding volume hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    pub primitives: Vec<Primitive>,
}

/// Triangles with one material. All attributes are as long as `positions`.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    pub positions: Vec<Vec3>,
    /// Unit length; flat normals were made where the file has none.
    pub normals: Vec<Vec3>,
    /// xyz unit length, w = handedness (+1 or -1); present where the material needs them.
    pub tangents: Option<Vec<Vec4>>,
    /// COLOR_0, linear RGBA.
    pub colors: Option<Vec<Vec4>>,
    /// TEXCOORD_0, TEXCOORD_1, ...
    pub texcoords: Vec<Vec<Vec2>>,
    pub triangles: Vec<[u32; 3]>,
    /// Index into `Scene::materials`.
    pub material: usize,
}

/// A mesh placed in the world by a node.
#[derive(Clone, Debug)]
pub struct Instance {
    pub name: String,
    /// Index into `Scene::meshes`.
    pub mesh: usize,
    pub world_from_object: Affine3A,
    /// Running number of the glTF node.
    pub node: usize,
}

#[derive(Clone, Debug)]
pub struct Material {
    pub name: String,
    pub model: Model,
    pub alpha_mode: AlphaMode,
    pub double_sided: bool,
    /// Radiance, KHR_materials_emissive_strength included.
    pub emissive: Vec3,
    pub emissive_texture: Option<Texture>,
    pub normal_texture: Option<Texture>,
    pub normal_scale: f32,
}

/// How a surface reflects.
#[derive(Clone, Debug)]
pub enum Model {
    /// glTF 2.0 section 3.9.2.
    MetallicRoughness(MetallicRoughness),
    /// KHR_materials_unlit: shows base colour, meets no light.
    Unlit {
        base_color: Vec4,
        base_color_texture: Option<Texture>,
    },
    /// SNELL_materials_bsdf: one of the lecture's models. Base colour's alpha and texture apply.
    Bsdf {
        bsdf: BsdfModel,
        base_color: Vec4,
        base_color_texture: Option<Texture>,
    },
}

#[derive(Clone, Debug)]
pub struct MetallicRoughness {
    pub base_color: Vec4,
    pub base_color_texture: Option<Texture>,
    pub metallic: f32,
    pub roughness: f32,
    /// Green is roughness, blue is metallic.
    pub metallic_roughness_texture: Option<Texture>,
    /// KHR_materials_ior; 1.5 where the file says nothing.
    pub ior: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    Opaque,
    Mask { cutoff: f32 },
    Blend,
}

/// An image as a material uses it.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Index into `Scene::images`.
    pub image: usize,
    /// Base colour and emissive images are sRGB-encoded, all others linear (glTF 2.0 section 3.9.2).
    pub srgb: bool,
    pub wrap_s: Wrap,
    pub wrap_t: Wrap,
    pub filter: Filter,
    /// Which set of texture coordinates.
    pub texcoord: usize,
    /// KHR_texture_transform as two rows: u' = rows[0] . (u, v, 1), v' = rows[1] . (u, v, 1).
    pub rows: [Vec3; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    Repeat,
    Clamp,
    Mirror,
}

/// Magnification; minification is left to the pixel samples, which are never fewer than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    Nearest,
    Linear,
}

/// Pixels as decoded, row 0 on top, four channels.
#[derive(Clone, Debug)]
pub struct Image {
    pub name: String,
    pub width: u32,
    pub height: u32,
    pub pixels: Pixels,
}

#[derive(Clone, Debug)]
pub enum Pixels {
    Rgba8(Vec<u8>),
    Rgba16(Vec<u16>),
}

/// KHR_lights_punctual, placed in the world and in radiometric units (683 lm = 1 W is not applied:
/// a renderer whose exposure is relative takes candela as W/sr and lux as W/m^2).
#[derive(Clone, Debug)]
pub struct PunctualLight {
    pub name: String,
    pub kind: PunctualKind,
    /// Colour times intensity, linear.
    pub intensity: Vec3,
    pub position: Vec3,
    /// Where the light goes, unit length.
    pub direction: Vec3,
    /// Metres; `None` is unlimited.
    pub range: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    Point,
    Spot { inner_angle: f32, outer_angle: f32 },
    Directional,
}

/// A camera placed in the world, looking along its -z with +y up.
#[derive(Clone, Debug)]
pub struct Camera {
    pub name: String,
    pub world_from_camera: Affine3A,
    pub projection: Projection,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `yfov` radians; without `aspect` the picture's own is taken.
    Perspective {
        yfov: f32,
        aspect: Option<f32>,
        near: f32,
    },
    /// Half extents in metres.
    Orthographic { xmag: f32, ymag: f32, near: f32 },
}

/// An equirectangular map of radiance: u = atan2(d.z, d.x) / (2 pi) + 1/2, v = acos(d.y) / pi.
#[derive(Clone, Debug)]
pub struct Environment {
    pub width: u32,
    pub height: u32,
    /// Row 0 is up (+y).
    pub radiance: Vec<[f32; 3]>,
    pub strength: f32,
    /// Radians about +y, counter-clockwise seen from above.
    pub rotation: f32,
}
