//! The host's twins of `shaders/shared.wgsl`: every struct and constant that both sides define.
//!
//! Field order, names, offsets and spans are compared with naga's reflection of the shader by
//! `tests/layout.rs`; constants by value. The documentation of each field stands in the shader.

use bytemuck::{Pod, Zeroable};

pub const NONE: u32 = u32::MAX;
pub const BSDF_LAMBERTIAN: u32 = 0;
pub const BSDF_OREN_NAYAR: u32 = 1;
pub const BSDF_OREN_NAYAR_EON: u32 = 2;
pub const BSDF_SPECULAR_REFLECTION: u32 = 3;
pub const BSDF_SPECULAR_TRANSMISSION: u32 = 4;
pub const BSDF_DIELECTRIC: u32 = 5;
pub const BSDF_ROUGH_DIELECTRIC: u32 = 6;
pub const BSDF_TORRANCE_SPARROW: u32 = 7;
pub const BSDF_GLTF: u32 = 8;
pub const BSDF_UNLIT: u32 = 9;
pub const FRESNEL_CONSTANT: u32 = 0;
pub const FRESNEL_DIELECTRIC: u32 = 1;
pub const FRESNEL_CONDUCTOR: u32 = 2;
pub const FRESNEL_CONDUCTOR_APPROXIMATE: u32 = 3;
pub const FRESNEL_SCHLICK: u32 = 4;
pub const DISTRIBUTION_BLINN: u32 = 0;
pub const DISTRIBUTION_ASHIKHMIN_SHIRLEY: u32 = 1;
pub const DISTRIBUTION_BECKMANN: u32 = 2;
pub const DISTRIBUTION_GGX: u32 = 3;
pub const MASKING_NONE: u32 = 0;
pub const MASKING_V_CAVITY: u32 = 1;
pub const MASKING_SMITH: u32 = 2;
pub const MATERIAL_DOUBLE_SIDED: u32 = 1;
pub const MATERIAL_ALPHA_MASK: u32 = 2;
pub const MATERIAL_ALPHA_BLEND: u32 = 4;
pub const MATERIAL_TRANSMISSIVE: u32 = 8;
pub const MATERIAL_EMISSIVE: u32 = 16;
pub const MATERIAL_THIN_WALLED: u32 = 32;
pub const MATERIAL_SPECULAR_GLOSSINESS: u32 = 64;
pub const GLTF_TRANSMISSIVE: u32 = 1;
pub const GLTF_THIN_WALLED: u32 = 2;
pub const GLTF_INSIDE: u32 = 4;
pub const TRIANGLE_CLASS: u32 = 7;
pub const TRIANGLE_CULLED: u32 = 8;
pub const TRIANGLE_ALPHA: u32 = 16;
pub const CLASS_DIFFUSE: u32 = 0;
pub const CLASS_OPAQUE: u32 = 1;
pub const CLASS_CLEAR: u32 = 2;
pub const CLASS_GLASS: u32 = 3;
pub const CLASS_OTHER: u32 = 4;
pub const CLASS_MISS: u32 = 5;
pub const CLASSES: u32 = 6;
pub const WRAP_REPEAT: u32 = 0;
pub const WRAP_CLAMP: u32 = 1;
pub const WRAP_MIRROR: u32 = 2;
pub const FORMAT_RGBA8_UNORM: u32 = 0;
pub const FORMAT_RGBA8_SRGB: u32 = 1;
pub const FORMAT_RGBA16_UNORM: u32 = 2;
pub const FILTER_NEAREST: u32 = 0;
pub const FILTER_LINEAR: u32 = 1;
pub const LAYOUT_TANGENT: u32 = 1;
pub const LAYOUT_COLOR: u32 = 2;
pub const LAYOUT_COLOR_UNORM: u32 = 4;
pub const LAYOUT_TEXCOORD_UNORM: u32 = 8;
pub const LAYOUT_TEXCOORDS_SHIFT: u32 = 8;
pub const NORMAL_STEPS: u32 = 32767;
pub const TANGENT_STEPS: u32 = 16383;
pub const INSTANCE_FLIPPED: u32 = 1;
pub const INSTANCE_KEYS_SHIFT: u32 = 8;
pub const INSTANCE_KEYS_MASK: u32 = 255;
pub const LIGHT_POINT: u32 = 0;
pub const LIGHT_SPOT: u32 = 1;
pub const LIGHT_DIRECTIONAL: u32 = 2;
pub const LIGHT_TRIANGLE: u32 = 3;
pub const LIGHT_ENVIRONMENT: u32 = 4;
pub const LIGHT_PROFILE: u32 = 5;
pub const LIGHT_CLUSTER: u32 = 6;
pub const CAMERA_PERSPECTIVE: u32 = 0;
pub const CAMERA_ORTHOGRAPHIC: u32 = 1;
pub const CAMERA_PANORAMA: u32 = 2;
pub const CAMERA_BROWN_CONRADY: u32 = 3;
pub const CAMERA_FISHEYE: u32 = 4;
pub const BACKGROUND_ENVIRONMENT: u32 = 0;
pub const BACKGROUND_COLOR: u32 = 1;
pub const BACKGROUND_TRANSPARENT: u32 = 2;
pub const ALBEDO_COSINES: u32 = 48;
pub const ALBEDO_ROUGHNESSES: u32 = 40;
pub const ALBEDO_DIELECTRIC_COSINES: u32 = 24;
pub const ALBEDO_DIELECTRIC_ROUGHNESSES: u32 = 18;
pub const ALBEDO_DIELECTRIC_ETAS: u32 = 21;
pub const ETA_MAX: f64 = 3.0;
pub const ALBEDO_SHEEN_SIZE: u32 = 32;
pub const ALBEDO_SHEEN_MAX: f64 = 8.0;
pub const INTERFERENCE_TABLE_SIZE: u32 = 257;
pub const INTERFERENCE_STEP: f64 = 32.0;
pub const INTERFERENCE_CARRIER: f64 = 520.0;

/// A camera in world space; `right`, `up`, `forward` are orthonormal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    pub origin: [f32; 3],
    pub kind: u32,
    pub right: [f32; 3],
    pub half_width: f32,
    pub up: [f32; 3],
    pub half_height: f32,
    pub forward: [f32; 3],
    pub near: f32,
    pub closing_origin: [f32; 3],
    pub lens_radius: f32,
    pub closing_right: [f32; 3],
    pub focus: f32,
    pub closing_forward: [f32; 3],
    pub moves: u32,
    pub center: [f32; 2],
    pub reserved: [u32; 2],
    pub distortion: [[f32; 4]; 3],
}

/// What changes between dispatches, and what is one per picture. A uniform.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Frame {
    pub camera: Camera,
    pub background: [f32; 3],
    pub background_kind: u32,
    pub environment_strength: f32,
    pub environment_cos: f32,
    pub environment_sin: f32,
    pub environment_weight: f32,
    pub film_size: [u32; 2],
    pub tile_origin: [u32; 2],
    pub tile_size: [u32; 2],
    pub environment_size: [u32; 2],
    pub environment_cells: [u32; 2],
    pub first_sample: u32,
    pub sample_count: u32,
    pub seed: u32,
    pub max_depth: u32,
    pub light_count: u32,
    pub light_weight_total: f32,
    pub root: u32,
    pub capacity: u32,
    pub ray_offset_floor: f32,
    pub has_alpha: u32,
    pub clamp: f32,
    pub has_thin_walls: u32,
    pub mesh_root: u32,
    pub light_tree_triangles: u32,
    pub light_tree_leaves: u32,
    pub reserved0: u32,
    pub reserved1: [u32; 2],
}

/// Tables that reflection models look up. A uniform, from src/tables.rs.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Tables {
    pub albedo: [[u32; 4]; 480],
    pub albedo_average: [[f32; 4]; 20],
    pub albedo_dielectric: [[u32; 4]; 2268],
    pub albedo_average_dielectric: [[f32; 4]; 189],
    pub albedo_sheen: [[u32; 4]; 128],
    pub interference: [[f32; 4]; 386],
}

/// One triangle of a mesh, in the mesh's object space and in the order of its hierarchy's leaves.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    pub p0: [f32; 3],
    pub vertex0: u32,
    pub e1: [f32; 3],
    pub vertex1: u32,
    pub e2: [f32; 3],
    pub flags: u32,
    pub vertex2: u32,
    pub material: u32,
    pub vertex_layout: u32,
    pub primitive: u32,
}

/// A mesh placed in the world, or a further key of one that moves; the matrix is 3x4, by rows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    pub world_from_object: [[f32; 4]; 3],
    pub root: u32,
    pub first_triangle: u32,
    pub flags: u32,
    pub motion: u32,
}

/// A texture as one material uses it: texels, sampler, and the affine map from KHR_texture_transform.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texture {
    pub row_u: [f32; 3],
    pub texels: u32,
    pub row_v: [f32; 3],
    pub wrap: u32,
    pub size: [u32; 2],
    pub texcoord: u32,
    pub format: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Material {
    pub base_color: [f32; 4],
    pub emissive: [f32; 3],
    pub emission_weight: f32,
    pub model: u32,
    pub flags: u32,
    pub alpha_cutoff: f32,
    pub normal_scale: f32,
    pub metallic: f32,
    pub roughness: f32,
    pub ior: f32,
    pub fresnel: u32,
    pub eta: [f32; 3],
    pub distribution: u32,
    pub k: [f32; 3],
    pub masking: u32,
    pub alpha: [f32; 2],
    pub transmission: f32,
    pub dispersion: f32,
    pub absorption: [f32; 3],
    pub diffuse_transmission: f32,
    pub diffuse_transmission_color: [f32; 3],
    pub specular: f32,
    pub specular_color: [f32; 3],
    pub anisotropy: f32,
    pub anisotropy_rotation: [f32; 2],
    pub coat: f32,
    pub coat_roughness: f32,
    pub sheen_color: [f32; 3],
    pub sheen_roughness: f32,
    pub iridescence: f32,
    pub film_ior: f32,
    pub film_thickness: [f32; 2],
    pub coat_normal_scale: f32,
    pub reserved0: u32,
    pub reserved1: [u32; 2],
    pub base_color_texture: Texture,
    pub metallic_roughness_texture: Texture,
    pub normal_texture: Texture,
    pub emissive_texture: Texture,
    pub transmission_texture: Texture,
    pub diffuse_transmission_texture: Texture,
    pub diffuse_transmission_color_texture: Texture,
    pub specular_texture: Texture,
    pub specular_color_texture: Texture,
    pub anisotropy_texture: Texture,
    pub coat_texture: Texture,
    pub coat_roughness_texture: Texture,
    pub coat_normal_texture: Texture,
    pub sheen_color_texture: Texture,
    pub sheen_roughness_texture: Texture,
    pub iridescence_texture: Texture,
    pub film_thickness_texture: Texture,
}

/// One entry of the table of lights; also an entry of its alias table (Walker 1977, Vose 1991).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Light {
    pub position: [f32; 3],
    pub kind: u32,
    pub direction: [f32; 3],
    pub alias_index: u32,
    pub edge2: [f32; 3],
    pub alias_threshold: f32,
    pub radiance: [f32; 3],
    pub weight: f32,
    pub cos_inner: f32,
    pub cos_outer: f32,
    pub range: f32,
    pub triangle: u32,
    pub instance: u32,
    pub profile: u32,
    pub profile_rows: u32,
    pub profile_columns: u32,
}

/// A node of the light tree: what the lights below it are like.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightNode {
    pub centre: [f32; 3],
    pub radius2: f32,
    pub facing: [f32; 3],
    pub weight: f32,
    pub light: u32,
    pub reserved0: u32,
    pub reserved1: [u32; 2],
}

/// What glTF's extensions add to a reflection model, after texturing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(non_snake_case, reason = "the letters of the formulas")]
pub struct Gltf {
    pub F0: [f32; 3],
    pub F90: f32,
    pub metallic: f32,
    pub transmission: f32,
    pub rotation: [f32; 2],
    pub diffuse_transmission_color: [f32; 3],
    pub diffuse_transmission: f32,
    pub sheen_color: [f32; 3],
    pub sheen_roughness: f32,
    pub coat_normal: [f32; 3],
    pub coat: f32,
    pub coat_roughness: f32,
    pub iridescence: f32,
    pub film_ior: f32,
    pub film_thickness: f32,
    pub flags: u32,
    pub reserved0: u32,
    pub reserved1: [u32; 2],
}

/// A reflection model with its parameters after texturing, in the local frame of a hit: what the
/// reflection functions take and what the laboratory's queries carry.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bsdf {
    pub reflectance: [f32; 3],
    pub model: u32,
    pub eta: [f32; 3],
    pub fresnel: u32,
    pub k: [f32; 3],
    pub distribution: u32,
    pub alpha: [f32; 2],
    pub roughness: f32,
    pub masking: u32,
    pub gltf: Gltf,
}

/// The laboratory: one query and its answer (kernels/bsdf_lab).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LabQuery {
    pub bsdf: Bsdf,
    pub wo: [f32; 3],
    pub cos_theta: f32,
    pub wi: [f32; 3],
    pub reserved: u32,
    pub u: [f32; 3],
    pub reserved1: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LabAnswer {
    pub f: [f32; 3],
    pub pdf: f32,
    pub wi: [f32; 3],
    pub delta: u32,
}
