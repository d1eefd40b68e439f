// The media that a path is inside of, where bodies of transmissive materials (MATERIAL_TRANSMISSIVE) lie
// in each other or overlap, and what they do to light between surfaces.
//
// Where bodies overlap, the one with the highest index of refraction has the place, of equal ones that
// with the highest material index; so liquid may be modelled a little into its glass. Only the boundary
// of the one that has the place is an optical surface. Outside of all is a vacuum.

import package::shared::{NONE, MATERIAL_TRANSMISSIVE};
import package::bindings::{materials};
import package::light::light::{LIGHT_DISTANCE_INFINITE};
import package::math::{exp_accurate};
import package::spectrum::{ior_at};
import package::variant::{BOUNDARIES};

// Material indices, one a body, the one that has the place first; NONE: no further one. A fourth
// body is not entered.
const MEDIA_NONE: vec3<u32> = vec3(0xffffffffu);

// How a surface parts the media on its sides.
struct Interface {
    eta: f32,    // index beyond the surface over that on wo's side
    hidden: u32, // 1: the same medium has the place on both sides, so that there is no optical surface
    dispersive: u32, // 1: eta depends on the wavelength
}

// Whether medium `a` has the place where it overlaps with `b`.
fn has_priority(a: u32, b: u32) -> bool {
    if a == NONE || b == NONE {
        return a != NONE;
    }
    let ior_a = materials[a].ior;
    let ior_b = materials[b].ior;
    return ior_a > ior_b || (ior_a == ior_b && a > b);
}

// Inside of one more body.
fn media_with(media: vec3<u32>, index: u32) -> vec3<u32> {
    if media.z != NONE {
        return media;
    }
    if has_priority(index, media.x) {
        return vec3(index, media.x, media.y);
    }
    if has_priority(index, media.y) {
        return vec3(media.x, index, media.y);
    }
    return vec3(media.x, media.y, index);
}

// Outside of one body with this material.
fn media_without(media: vec3<u32>, index: u32) -> vec3<u32> {
    if media.x == index {
        return vec3(media.y, media.z, NONE);
    }
    if media.y == index {
        return vec3(media.x, media.z, NONE);
    }
    if media.z == index {
        return vec3(media.x, media.y, NONE);
    }
    return media;
}

// What a path is inside of on wo's side of a surface, by what it was inside of before. Who sees a
// boundary's back is in its body, even if the path began there or the body is not closed.
fn media_near(media: vec3<u32>, material_index: u32, front: bool) -> vec3<u32> {
    let transmissive = BOUNDARIES && (materials[material_index].flags & MATERIAL_TRANSMISSIVE) != 0u;
    if !transmissive || front || any(media == vec3(material_index)) {
        return media;
    }
    return media_with(media, material_index);
}

// What it is inside of beyond the surface, by what it is inside of on wo's side.
fn media_far(media: vec3<u32>, material_index: u32, front: bool) -> vec3<u32> {
    if !BOUNDARIES || (materials[material_index].flags & MATERIAL_TRANSMISSIVE) == 0u {
        return media;
    }
    if front {
        return media_with(media, material_index);
    }
    return media_without(media, material_index);
}

// Index of refraction of the medium that has the place, at a wavelength in nanometres or at none (0).
fn media_ior(media: vec3<u32>, wavelength: f32) -> f32 {
    if media.x == NONE {
        return 1.0;
    }
    return ior_at(materials[media.x].ior, materials[media.x].dispersion, wavelength);
}

// Whether that index depends on the wavelength.
fn is_dispersive(media: vec3<u32>) -> bool {
    return media.x != NONE && materials[media.x].dispersion > 0.0;
}

// The surface of a material in the media of wo's side. What has no other side, or is its own other
// side as a thin wall is, has its material's index beyond it.
fn interface_at(media: vec3<u32>, material_index: u32, front: bool, wavelength: f32) -> Interface {
    if !BOUNDARIES || (materials[material_index].flags & MATERIAL_TRANSMISSIVE) == 0u {
        return Interface(materials[material_index].ior / media_ior(media, wavelength), 0u, 0u);
    }
    let far = media_far(media, material_index, front);
    if far.x == media.x {
        return Interface(1.0, 1u, 0u);
    }
    let dispersive = is_dispersive(far) || is_dispersive(media);
    return Interface(media_ior(far, wavelength) / media_ior(media, wavelength), 0u, select(0u, 1u, dispersive));
}

// The part of light that a way of this length through the media leaves, by the law of Beer and
// Lambert. Light from infinitely far away comes unweakened: no body is closed around it.
fn transmittance(media: vec3<u32>, distance: f32) -> vec3<f32> {
    // KHR_materials_volume, "Attenuation".
    if media.x == NONE || distance >= LIGHT_DISTANCE_INFINITE {
        return vec3(1.0);
    }
    let depth = materials[media.x].absorption * distance;
    return vec3(exp_accurate(-depth.x), exp_accurate(-depth.y), exp_accurate(-depth.z));
}
