//! The surface where a ray met it: point, normals, shading frame, and what textures need.

use super::attributes::{attribute_color, attribute_normal, attribute_tangent, attribute_texcoord};
use super::math::{Basis, basis_from_tangent, normalize_accurate, to_local, to_world};
use super::ray::{Hit, Ray};
use super::texture::texture_sample;
use super::transform::{
    PlacedInstance, cross_sums, instance_at, inverse_error, transform_height, transform_normal,
    transform_point, transform_reach, transform_vector,
};
use crate::pack::Packed;
use crate::shared::{INSTANCE_FLIPPED, NONE, Texture, Triangle};
use glam::{DVec2, DVec3, DVec4, Vec3};

/// In world space; `wo` is against the ray.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub p: DVec3,
    /// Bound on the error of `p` along `ng`, metres: the `floor` of `offset_origin`.
    pub p_error: f64,
    /// Geometric normal, on wo's side.
    pub ng: DVec3,
    /// wo sees the front face.
    pub front: bool,
    /// Shading frame, its normal on wo's side.
    pub basis: Basis,
    /// Of a clear coat, in the shading frame, unit length, on wo's side.
    pub coat_normal: DVec3,
    /// -1: glTF's bitangent is against the frame's.
    pub bitangent_sign: f64,
    /// COLOR_0
    pub color: DVec4,
    /// Of corners 1 and 2.
    pub barycentrics: DVec2,
    pub triangle: u32,
    pub material: u32,
}

/// Sum of the roundings that put a point and a ray's origin on a surface, in units of the largest
/// terms that they come from: 2^-21, eight units in the last place of float32.
pub const SURFACE_ROUNDING: f64 = 4.76837158203125e-7;

/// Least cosine between wo and the shading normal.
pub const MIN_COS_SHADING: f64 = 1e-3;

/// Normal of the front face in world space, unit length. A mirroring transform turns the winding
/// round, and the front with it (glTF 2.0 section 3.7.4).
pub fn geometric_normal(triangle: &Triangle, instance: &PlacedInstance) -> DVec3 {
    let edge =
        |e: [f32; 3]| transform_vector(instance.world_from_object, Vec3::from_array(e).as_dvec3());
    let n = normalize_accurate(edge(triangle.e1).cross(edge(triangle.e2)));
    if instance.flags & INSTANCE_FLIPPED != 0 {
        -n
    } else {
        n
    }
}

/// How high over a point of the triangle a ray's origin may be that the triangle test in float32 takes for
/// one on it, in units of rounding: e2 . (tvec x e1) is the height times twice the area. Much where edges
/// nearly coincide.
pub fn sliver_error(triangle: &Triangle, instance: &PlacedInstance) -> f64 {
    let e1 = Vec3::from_array(triangle.e1).as_dvec3();
    let e2 = Vec3::from_array(triangle.e2).as_dvec3();
    let (a, b) = (e1.abs(), e2.abs());
    let n = e1.cross(e2);
    let height = b.dot(cross_sums(a.max(b), a)) / n.length();
    height * transform_height(instance.world_from_object, normalize_accurate(n))
}

/// A bound on the error along `ng` of a point of the triangle, and of a ray's origin there once it is
/// taken into the object's space, when both are computed in float32.
pub fn position_error(
    packed: &Packed,
    triangle: &Triangle,
    instance: &PlacedInstance,
    p: DVec3,
    ng: DVec3,
) -> f64 {
    let size = |v: [f32; 3]| Vec3::from_array(v).as_dvec3().abs();
    let reach = size(triangle.p0) + size(triangle.e1) + size(triangle.e2);
    let rows = instance.world_from_object;
    let extent = p.abs() + transform_reach(rows, reach);
    let terms = ng.abs().dot(extent)
        + inverse_error(rows, reach, ng, SURFACE_ROUNDING)
        + sliver_error(triangle, instance);
    f64::from(packed.frame.ray_offset_floor).max(SURFACE_ROUNDING * terms)
}

/// Turns `ns` towards `wo` just so far that the angle between them stays under 90 degrees. Where
/// interpolation or a normal map bends the normal out of sight, reflection has no meaning; this is the
/// nearest normal for which it has.
pub fn bend_towards(ns: DVec3, wo: DVec3) -> DVec3 {
    let cos_theta = ns.dot(wo);
    if cos_theta >= MIN_COS_SHADING {
        return ns;
    }
    // Off the part along wo, then onto the cone around the horizon.
    let across = ns - cos_theta * wo;
    let norm = across.length();
    if norm < MIN_COS_SHADING {
        return wo;
    }
    normalize_accurate(across / norm + MIN_COS_SHADING * wo)
}

/// Turns `ns` just so far that what it mirrors of `wo` stays over the geometric surface: a normal map
/// describes a relief, whose steep sides reflect the rest of it and never the inside. `ns` and `ng` lie
/// on wo's side. (Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", on
/// adapting the shading normal.)
pub fn lift_reflection(ns: DVec3, ng: DVec3, wo: DVec3) -> DVec3 {
    let mirrored = 2.0 * ns.dot(wo) * ns - wo;
    let height = mirrored.dot(ng);
    if height >= MIN_COS_SHADING {
        return ns;
    }
    let lifted = normalize_accurate(mirrored + (MIN_COS_SHADING - height) * ng);
    normalize_accurate(wo + lifted)
}

/// The normal that a normal map tells in the mesh's own frame (glTF 2.0 section 3.9.3). Without tangents the
/// axes of the map are unknown, and any will do.
pub fn mapped_normal(
    packed: &Packed,
    triangle: &Triangle,
    barycentrics: DVec2,
    smooth_frame: Basis,
    texture: &Texture,
    scale: f64,
) -> DVec3 {
    let uv = attribute_texcoord(packed, triangle, barycentrics, texture.texcoord);
    let texel = texture_sample(packed, texture, uv).truncate() * 2.0 - 1.0;
    let bent = DVec3::new(texel.x * scale, texel.y * scale, texel.z);
    normalize_accurate(to_world(smooth_frame, bent))
}

/// The hit of `ray`; not for a miss.
pub fn surface_at(packed: &Packed, ray: Ray, hit: Hit) -> Surface {
    let triangle = &packed.triangles[hit.triangle as usize];
    let instance = instance_at(packed, hit.instance, ray.time);
    let barycentrics = DVec2::new(hit.u, hit.v);
    let wo = -ray.direction;

    let corner = |v: [f32; 3]| Vec3::from_array(v).as_dvec3();
    let local = corner(triangle.p0) + hit.u * corner(triangle.e1) + hit.v * corner(triangle.e2);
    let rows = instance.world_from_object;
    let p = transform_point(rows, local);

    let n_front = geometric_normal(triangle, &instance);
    let front = n_front.dot(wo) >= 0.0;
    let side = if front { 1.0 } else { -1.0 };

    // The front's shading normal. One that points behind its own face is taken for a mistake of
    // orientation; one of no length, as the geometric normal.
    let mut n = normalize_accurate(transform_normal(
        rows,
        attribute_normal(packed, triangle, barycentrics),
    ));
    if n == DVec3::ZERO {
        n = n_front;
    }
    if n.dot(n_front) < 0.0 {
        n = -n;
    }

    let object_tangent = attribute_tangent(packed, triangle, barycentrics);
    let tangent = transform_vector(rows, object_tangent.truncate());
    let flipped = instance.flags & INSTANCE_FLIPPED != 0;
    let handedness = if flipped {
        -object_tangent.w
    } else {
        object_tangent.w
    };

    let material = &packed.materials[triangle.material as usize];
    let smooth_frame = basis_from_tangent(n, tangent, handedness);
    let normal_texture = &material.normal_texture;
    if normal_texture.texels != NONE {
        let scale = f64::from(material.normal_scale);
        n = mapped_normal(
            packed,
            triangle,
            barycentrics,
            smooth_frame,
            normal_texture,
            scale,
        );
    }

    // The back of a double-sided surface has the reversed normal (glTF 2.0 section 3.9.6).
    let ns = lift_reflection(bend_towards(n * side, wo), n_front * side, wo);
    let basis = basis_from_tangent(ns, tangent, 1.0);

    // KHR_materials_clearcoat: the coat is as smooth as the mesh, or has a map of its own.
    let mut coat_normal = DVec3::Z;
    let coat_texture = &material.coat_normal_texture;
    if material.coat > 0.0 && (normal_texture.texels != NONE || coat_texture.texels != NONE) {
        let mut n_coat = smooth_frame.n;
        if coat_texture.texels != NONE {
            let scale = f64::from(material.coat_normal_scale);
            n_coat = mapped_normal(
                packed,
                triangle,
                barycentrics,
                smooth_frame,
                coat_texture,
                scale,
            );
        }
        let visible = lift_reflection(bend_towards(n_coat * side, wo), n_front * side, wo);
        coat_normal = to_local(basis, visible);
    }
    Surface {
        p,
        p_error: position_error(packed, triangle, &instance, p, n_front),
        ng: n_front * side,
        front,
        basis,
        coat_normal,
        bitangent_sign: if handedness == 0.0 {
            1.0
        } else {
            handedness * side
        },
        color: attribute_color(packed, triangle, barycentrics),
        barycentrics,
        triangle: hit.triangle,
        material: triangle.material,
    }
}

/// `TEXCOORD_number` at the hit.
pub fn texcoord(packed: &Packed, surface: &Surface, number: u32) -> DVec2 {
    let triangle = &packed.triangles[surface.triangle as usize];
    attribute_texcoord(packed, triangle, surface.barycentrics, number)
}
