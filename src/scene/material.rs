//! Materials of a scene: reflection models with their textures, coverage and emission.

use super::Extensions;
use super::bsdf_model::{Alpha, BsdfModel, Distribution};
use glam::{Vec3, Vec4};

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
    /// KHR_materials_pbrSpecularGlossiness.
    SpecularGlossiness(SpecularGlossiness),
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
    /// KHR_materials_ior; 1.5 where the file says nothing, 0 for a surface that reflects everything.
    pub ior: f32,
    pub extensions: Box<Extensions>,
}

/// The archived extension's own parameters, which stand for those of metallic-roughness.
#[derive(Clone, Debug)]
pub struct SpecularGlossiness {
    /// Alpha is coverage.
    pub diffuse: Textured<Vec4>,
    /// Reflectance at normal incidence. The texture's alpha is glossiness.
    pub specular: Textured<Vec3>,
    /// 1 - roughness.
    pub glossiness: f32,
}

/// A factor, and the texture that it multiplies.
#[derive(Clone, Debug, Default)]
pub struct Textured<T> {
    pub factor: T,
    pub texture: Option<Texture>,
}

impl<T> From<T> for Textured<T> {
    fn from(factor: T) -> Self {
        Self {
            factor,
            texture: None,
        }
    }
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
    /// Red, green and blue are sRGB-encoded: those of colours are, others are linear.
    pub srgb: bool,
    pub wrap_s: Wrap,
    pub wrap_t: Wrap,
    pub filter: Filter,
    /// Which set of texture coordinates.
    pub texcoord: usize,
    /// KHR_texture_transform as two rows: u' = rows[0] . (u, v, 1), v' = rows[1] . (u, v, 1).
    pub rows: [Vec3; 2],
}

/// The rows of a texture that is not transformed.
pub const IDENTITY_ROWS: [Vec3; 2] = [Vec3::X, Vec3::Y];

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

impl Material {
    /// KHR_materials_*, of a model that has them.
    pub fn extensions(&self) -> Option<&Extensions> {
        match &self.model {
            Model::MetallicRoughness(model) => Some(&model.extensions),
            _ => None,
        }
    }

    /// All its textures.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let model = match &self.model {
            Model::MetallicRoughness(m) => [&m.base_color_texture, &m.metallic_roughness_texture],
            Model::SpecularGlossiness(m) => [&m.diffuse.texture, &m.specular.texture],
            Model::Unlit {
                base_color_texture, ..
            }
            | Model::Bsdf {
                base_color_texture, ..
            } => [base_color_texture, &None],
        };
        let common = [&self.emissive_texture, &self.normal_texture];
        let extensions = self.extensions().map(Extensions::textures);
        model
            .into_iter()
            .chain(common)
            .chain(extensions.into_iter().flatten())
            .flatten()
    }

    /// Sets of texture coordinates that its textures read: the highest, plus one.
    pub fn texcoord_count(&self) -> usize {
        let sets = self.textures().map(|texture| texture.texcoord + 1);
        sets.max().unwrap_or(0)
    }

    /// Which texture's coordinates the tangents must follow, where the material needs tangents: the
    /// normal texture's (KHR_materials_anisotropy has the same rule), else those of the coat's normals or
    /// of the anisotropy, or the first set's for a lobe that is not round.
    pub fn tangent_source(&self) -> Option<(usize, [Vec3; 2])> {
        let extensions = self.extensions();
        let coat_normal = extensions.and_then(|all| all.clearcoat.normal_texture.as_ref());
        let anisotropy = extensions.and_then(|all| all.anisotropy.strength.texture.as_ref());
        let texture = self.normal_texture.as_ref().or(coat_normal).or(anisotropy);
        if let Some(texture) = texture {
            return Some((texture.texcoord, texture.rows));
        }
        let round = match &self.model {
            Model::MetallicRoughness(model) => model.extensions.anisotropy.strength.factor == 0.0,
            Model::Bsdf { bsdf, .. } => is_round(bsdf),
            Model::SpecularGlossiness(_) | Model::Unlit { .. } => true,
        };
        (!round).then_some((0, IDENTITY_ROWS))
    }
}

/// Whether the model's lobe is the same along the tangent and across it.
fn is_round(bsdf: &BsdfModel) -> bool {
    let distribution = match bsdf {
        BsdfModel::Dielectric { distribution, .. } | BsdfModel::Conductor { distribution, .. } => {
            distribution.as_ref()
        }
        BsdfModel::TorranceSparrow { distribution, .. } => Some(distribution),
        _ => None,
    };
    match distribution {
        None | Some(Distribution::Blinn { .. }) => true,
        Some(Distribution::AshikhminShirley { exponent: [x, y] }) => x == y,
        Some(Distribution::Beckmann { alpha } | Distribution::Ggx { alpha }) => match alpha {
            Alpha::Isotropic(_) => true,
            Alpha::Anisotropic([x, y]) => x == y,
        },
    }
}
