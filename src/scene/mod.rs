//! What a renderer needs of a glTF file, with nothing of the file format left: meshes in object
//! space, instances that place them, materials, images, lights and cameras.
//!
//! Right-handed, y up, metres, radians; colours linear Rec. 709; light in radiometric units.

pub mod bsdf_model;
pub mod extensions;
pub mod lens;
pub mod material;
pub mod metals;
mod profile;
pub mod sky;

pub use extensions::Extensions;
pub use lens::{Distortion, Intrinsics, Lens};
pub use material::{
    AlphaMode, Filter, Material, MetallicRoughness, Model, SpecularGlossiness, Texture, Textured,
    Wrap,
};
pub use profile::Profile;

use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A scene that has been checked: indices are in range, numbers are finite, sizes agree.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub meshes: Vec<Arc<Mesh>>,
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub images: Vec<Arc<Image>>,
    pub lights: Vec<PunctualLight>,
    /// How the lights spread that were measured.
    pub profiles: Vec<Arc<Profile>>,
    pub cameras: Vec<Camera>,
    pub environment: Option<Environment>,
}

/// A glTF mesh: its primitives share one bounding volume hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    pub primitives: Vec<Primitive>,
}

impl Mesh {
    pub fn triangle_count(&self) -> usize {
        let primitives = self.primitives.iter();
        primitives.map(|primitive| primitive.triangles.len()).sum()
    }
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
    /// Index into `Scene::meshes`.
    pub mesh: usize,
    /// Running number of the glTF node.
    pub node: usize,
    /// Where it is when the shutter opens.
    pub world_from_object: Affine3A,
    /// Where it is at further times, in equal steps until the shutter closes; none: it stands still.
    pub motion: Box<[Affine3A]>,
    /// It may be elsewhere, or its mesh another one, in another picture of the same sequence.
    pub animated: bool,
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
    /// Colour times intensity, linear; of a profile the factor on its candela.
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
    Spot {
        inner_angle: f32,
        outer_angle: f32,
    },
    Directional,
    /// A point whose intensity depends on the direction: EXT_lights_ies.
    Profile {
        /// In `Scene::profiles`.
        profile: usize,
        /// Where the azimuth is 0: unit length, at right angles to the light's direction. A quarter of
        /// a turn on it points along `azimuth_zero` x `direction`.
        azimuth_zero: Vec3,
    },
}

/// A camera placed in the world, looking along its -z with +y up.
#[derive(Clone, Debug)]
pub struct Camera {
    pub name: String,
    pub world_from_camera: Affine3A,
    /// Where it is when the shutter closes; `None`: it stands still.
    pub closing: Option<Affine3A>,
    pub projection: Projection,
    /// `None`: a pinhole.
    pub lens: Option<Lens>,
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
    Orthographic {
        xmag: f32,
        ymag: f32,
        near: f32,
    },
    /// All around, laid out as an environment map in the camera's own frame.
    Panorama,
    Intrinsics(Intrinsics),
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
