//! The media that a path is inside of, where bodies of transmissive materials
//! (`MATERIAL_TRANSMISSIVE`) lie in each other or overlap, and what they do to light between surfaces.
//!
//! Where bodies overlap, the one with the highest index of refraction has the place, of equal ones that
//! with the highest material index; so liquid may be modelled a little into its glass. Only the boundary
//! of the one that has the place is an optical surface. Outside of all is a vacuum.

use super::light::light::LIGHT_DISTANCE_INFINITE;
use super::math::exp_accurate;
use super::spectrum::ior_at;
use crate::pack::Packed;
use crate::shared::{MATERIAL_TRANSMISSIVE, NONE};
use glam::{DVec3, UVec3, Vec3};

/// Material indices, one a body, the one that has the place first; `NONE`: no further one. A fourth
/// body is not entered.
pub const MEDIA_NONE: UVec3 = UVec3::splat(NONE);

/// How a surface parts the media on its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Index beyond the surface over that on wo's side.
    pub eta: f64,
    /// The same medium has the place on both sides, so that there is no optical surface.
    pub hidden: bool,
    /// `eta` depends on the wavelength.
    pub dispersive: bool,
}

/// Whether medium `a` has the place where it overlaps with `b`.
pub fn has_priority(packed: &Packed, a: u32, b: u32) -> bool {
    if a == NONE || b == NONE {
        return a != NONE;
    }
    let ior_a = packed.materials[a as usize].ior;
    let ior_b = packed.materials[b as usize].ior;
    ior_a > ior_b || (ior_a == ior_b && a > b)
}

/// Inside of one more body.
pub fn media_with(packed: &Packed, media: UVec3, index: u32) -> UVec3 {
    if media.z != NONE {
        return media;
    }
    if has_priority(packed, index, media.x) {
        return UVec3::new(index, media.x, media.y);
    }
    if has_priority(packed, index, media.y) {
        return UVec3::new(media.x, index, media.y);
    }
    UVec3::new(media.x, media.y, index)
}

/// Outside of one body with this material.
pub fn media_without(media: UVec3, index: u32) -> UVec3 {
    if media.x == index {
        return UVec3::new(media.y, media.z, NONE);
    }
    if media.y == index {
        return UVec3::new(media.x, media.z, NONE);
    }
    if media.z == index {
        return UVec3::new(media.x, media.y, NONE);
    }
    media
}

/// What a path is inside of on wo's side of a surface, by what it was inside of before. Who sees a
/// boundary's back is in its body, even if the path began there or the body is not closed.
pub fn media_near(packed: &Packed, media: UVec3, material_index: u32, front: bool) -> UVec3 {
    let flags = packed.materials[material_index as usize].flags;
    let transmissive = flags & MATERIAL_TRANSMISSIVE != 0;
    if !transmissive || front || media.to_array().contains(&material_index) {
        return media;
    }
    media_with(packed, media, material_index)
}

/// What it is inside of beyond the surface, by what it is inside of on wo's side.
pub fn media_far(packed: &Packed, media: UVec3, material_index: u32, front: bool) -> UVec3 {
    if packed.materials[material_index as usize].flags & MATERIAL_TRANSMISSIVE == 0 {
        return media;
    }
    if front {
        return media_with(packed, media, material_index);
    }
    media_without(media, material_index)
}

/// Index of refraction of the medium that has the place, at a wavelength in nanometres or at none (0).
pub fn media_ior(packed: &Packed, media: UVec3, wavelength: f64) -> f64 {
    if media.x == NONE {
        return 1.0;
    }
    let material = &packed.materials[media.x as usize];
    ior_at(
        f64::from(material.ior),
        f64::from(material.dispersion),
        wavelength,
    )
}

/// Whether that index depends on the wavelength.
pub fn is_dispersive(packed: &Packed, media: UVec3) -> bool {
    media.x != NONE && packed.materials[media.x as usize].dispersion > 0.0
}

/// The surface of a material in the media of wo's side. What has no other side, or is its own other
/// side as a thin wall is, has its material's index beyond it.
pub fn interface_at(
    packed: &Packed,
    media: UVec3,
    material_index: u32,
    front: bool,
    wavelength: f64,
) -> Interface {
    let material = &packed.materials[material_index as usize];
    if material.flags & MATERIAL_TRANSMISSIVE == 0 {
        return Interface {
            eta: f64::from(material.ior) / media_ior(packed, media, wavelength),
            hidden: false,
            dispersive: false,
        };
    }
    let far = media_far(packed, media, material_index, front);
    if far.x == media.x {
        return Interface {
            eta: 1.0,
            hidden: true,
            dispersive: false,
        };
    }
    Interface {
        eta: media_ior(packed, far, wavelength) / media_ior(packed, media, wavelength),
        hidden: false,
        dispersive: is_dispersive(packed, far) || is_dispersive(packed, media),
    }
}

/// The part of light that a way of this length through the media leaves, by the law of Beer and
/// Lambert. Light from infinitely far away comes unweakened: no body is closed around it.
pub fn transmittance(packed: &Packed, media: UVec3, distance: f64) -> DVec3 {
    // KHR_materials_volume, "Attenuation".
    if media.x == NONE || distance >= LIGHT_DISTANCE_INFINITE {
        return DVec3::ONE;
    }
    let absorption = Vec3::from_array(packed.materials[media.x as usize].absorption).as_dvec3();
    let depth = absorption * distance;
    DVec3::new(
        exp_accurate(-depth.x),
        exp_accurate(-depth.y),
        exp_accurate(-depth.z),
    )
}
