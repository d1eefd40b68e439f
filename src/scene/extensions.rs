//! What the ratified extensions of glTF's metallic-roughness model add to it: one structure each, whose
//! default changes nothing.

use super::{Texture, Textured};
use glam::Vec3;

#[derive(Clone, Debug, Default)]
pub struct Extensions {
    /// KHR_materials_transmission: share of what enters the dielectric that passes through; red.
    pub transmission: Textured<f32>,
    pub diffuse_transmission: DiffuseTransmission,
    /// `None`: the surface is a thin wall.
    pub volume: Option<Volume>,
    /// KHR_materials_dispersion: 20 over the Abbe number; 0 for none.
    pub dispersion: f32,
    pub specular: Specular,
    pub clearcoat: Clearcoat,
    pub sheen: Sheen,
    pub anisotropy: Anisotropy,
    pub iridescence: Iridescence,
}

/// KHR_materials_diffuse_transmission.
#[derive(Clone, Debug)]
pub struct DiffuseTransmission {
    /// Share of the diffuse light that leaves on the other side; alpha.
    pub share: Textured<f32>,
    /// sRGB.
    pub color: Textured<Vec3>,
}

/// KHR_materials_volume with a thickness: the surface bounds a medium.
#[derive(Clone, Debug)]
pub struct Volume {
    /// What is left of white light after `attenuation_distance`; above 0, at most 1.
    pub attenuation_color: Vec3,
    /// Metres; `None` for a medium that absorbs nothing.
    pub attenuation_distance: Option<f32>,
}

/// KHR_materials_specular.
#[derive(Clone, Debug)]
pub struct Specular {
    /// Alpha.
    pub strength: Textured<f32>,
    /// Factor on the reflectance at normal incidence, may exceed 1; sRGB.
    pub color: Textured<Vec3>,
}

/// KHR_materials_clearcoat.
#[derive(Clone, Debug)]
pub struct Clearcoat {
    /// Red.
    pub coat: Textured<f32>,
    /// Green.
    pub roughness: Textured<f32>,
    /// The coat is smooth where it has none of its own, whatever is below it.
    pub normal_texture: Option<Texture>,
    pub normal_scale: f32,
}

/// KHR_materials_sheen.
#[derive(Clone, Debug, Default)]
pub struct Sheen {
    /// sRGB.
    pub color: Textured<Vec3>,
    /// Alpha.
    pub roughness: Textured<f32>,
}

/// KHR_materials_anisotropy.
#[derive(Clone, Debug, Default)]
pub struct Anisotropy {
    /// Blue; red and green are the direction.
    pub strength: Textured<f32>,
    /// Radians, from the tangent to the bitangent.
    pub rotation: f32,
}

/// KHR_materials_iridescence.
#[derive(Clone, Debug)]
pub struct Iridescence {
    /// Red.
    pub strength: Textured<f32>,
    pub film_ior: f32,
    /// Nanometres where the texture is 0 and where it is 1; green.
    pub thickness: Textured<[f32; 2]>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self {
            share: 0.0.into(),
            color: Vec3::ONE.into(),
        }
    }
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            strength: 1.0.into(),
            color: Vec3::ONE.into(),
        }
    }
}

impl Default for Clearcoat {
    fn default() -> Self {
        Self {
            coat: 0.0.into(),
            roughness: 0.0.into(),
            normal_texture: None,
            normal_scale: 1.0,
        }
    }
}

impl Default for Iridescence {
    fn default() -> Self {
        Self {
            strength: 0.0.into(),
            film_ior: 1.3,
            thickness: [100.0, 400.0].into(),
        }
    }
}

impl Volume {
    /// Absorption coefficients per metre (KHR_materials_volume, section "Attenuation"): the logarithm of
    /// what is left, over the distance.
    ///
    /// No finite absorption leaves nothing; a colour of 0 is taken for the smallest normal float32,
    /// of which the absorption is 87 over the distance.
    pub fn absorption(&self) -> Vec3 {
        let Some(distance) = self.attenuation_distance else {
            return Vec3::ZERO;
        };
        let of = |left: f32| {
            let left = f64::from(left.clamp(f32::MIN_POSITIVE, 1.0));
            // Finite, however short the distance.
            (left.ln().abs() / f64::from(distance)).min(f64::from(f32::MAX)) as f32
        };
        self.attenuation_color.map(of)
    }
}

impl Extensions {
    /// Light passes through: by transmission or diffuse transmission.
    pub fn is_transmissive(&self) -> bool {
        self.transmission.factor > 0.0 || self.diffuse_transmission.share.factor > 0.0
    }

    /// The places of all textures.
    pub fn textures(&self) -> [&Option<Texture>; 13] {
        [
            &self.transmission.texture,
            &self.diffuse_transmission.share.texture,
            &self.diffuse_transmission.color.texture,
            &self.specular.strength.texture,
            &self.specular.color.texture,
            &self.anisotropy.strength.texture,
            &self.clearcoat.coat.texture,
            &self.clearcoat.roughness.texture,
            &self.clearcoat.normal_texture,
            &self.sheen.color.texture,
            &self.sheen.roughness.texture,
            &self.iridescence.strength.texture,
            &self.iridescence.thickness.texture,
        ]
    }
}
