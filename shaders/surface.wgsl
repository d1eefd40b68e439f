// The surface where a ray met it: point, normals, shading frame, and what textures need.

import package::shared::{Triangle, Instance, Texture, NONE, INSTANCE_FLIPPED};
import package::bindings::{frame, triangles, materials};
import package::math::{Basis, basis_from_tangent, normalize_accurate, to_local, to_world};
import package::ray::{Ray, Hit};
import package::attributes::{attribute_normal, attribute_tangent, attribute_color, attribute_texcoord};
import package::texture::{texture_sample};
import package::intersect::{largest_component};
import package::transform::{cross_sums, instance_at, inverse_error, transform_height, transform_normal, transform_point, transform_reach, transform_vector};
import package::variant::{NORMAL_TEXTURES, COAT_NORMALS};

// In world space; `wo` is against the ray.
struct Surface {
    p: vec3<f32>,
    p_error: f32,            // bound on the error of p along ng, metres: the `floor` of offset_origin
    ng: vec3<f32>,           // geometric normal, on wo's side
    front: u32,              // 1: wo sees the front face
    basis: Basis,            // shading frame, its normal on wo's side
    coat_normal: vec3<f32>,  // of a clear coat, in the shading frame, unit length, on wo's side
    bitangent_sign: f32,     // -1: glTF's bitangent is against the frame's
    color: vec4<f32>,        // COLOR_0
    barycentrics: vec2<f32>, // of corners 1 and 2
    triangle: u32,
    material: u32,
}

// Sum of the roundings that put a point and a ray's origin on a surface, in units of the largest
// terms that they come from: 2^-21, eight units in the last place.
const SURFACE_ROUNDING: f32 = 4.76837158203125e-7;

// Least cosine between wo and the shading normal.
const MIN_COS_SHADING: f32 = 1e-3;

// Normal of the front face in world space, unit length. A mirroring transform turns the winding
// round, and the front with it (glTF 2.0 section 3.7.4).
fn geometric_normal(triangle: Triangle, instance: Instance) -> vec3<f32> {
    let e1 = transform_vector(instance.world_from_object, triangle.e1);
    let e2 = transform_vector(instance.world_from_object, triangle.e2);
    // At unit scale, so that the product of tiny edges does not underflow.
    let size1 = max(abs(e1.x), max(abs(e1.y), abs(e1.z)));
    let size2 = max(abs(e2.x), max(abs(e2.y), abs(e2.z)));
    let n = normalize_accurate(cross(e1 / size1, e2 / size2));
    return select(n, -n, (instance.flags & INSTANCE_FLIPPED) != 0u);
}

// How high over a point of the triangle a ray's origin may be that the triangle test takes for one on it, in
// units of rounding: e2 . (tvec x e1) is the height times twice the area. Much where edges nearly coincide.
fn sliver_error(triangle: Triangle, instance: Instance) -> f32 {
    let a = abs(triangle.e1);
    let b = abs(triangle.e2);
    // At unit scale, as in geometric_normal.
    let size1 = largest_component(a);
    let size2 = largest_component(b);
    let n = cross(triangle.e1 / size1, triangle.e2 / size2);
    let height = dot(b / size2, cross_sums(max(a, b), a / size1)) / sqrt(dot(n, n));
    return height * transform_height(instance.world_from_object, normalize_accurate(n));
}

// A bound on the error along `ng` of a point of the triangle, and of a ray's origin there once it is
// taken into the object's space.
fn position_error(triangle: Triangle, instance: Instance, p: vec3<f32>, ng: vec3<f32>) -> f32 {
    let reach = abs(triangle.p0) + abs(triangle.e1) + abs(triangle.e2);
    let rows = instance.world_from_object;
    let extent = abs(p) + transform_reach(rows, reach);
    let terms = dot(abs(ng), extent) + inverse_error(rows, reach, ng, SURFACE_ROUNDING)
        + sliver_error(triangle, instance);
    return max(frame.ray_offset_floor, SURFACE_ROUNDING * terms);
}

// Turns `ns` towards `wo` just so far that the angle between them stays under 90 degrees. Where
// interpolation or a normal map bends the normal out of sight, reflection has no meaning; this is the
// nearest normal for which it has.
fn bend_towards(ns: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let cos_theta = dot(ns, wo);
    if cos_theta >= MIN_COS_SHADING {
        return ns;
    }
    // Off the part along wo, then onto the cone around the horizon.
    let across = ns - cos_theta * wo;
    let norm = sqrt(dot(across, across));
    if norm < MIN_COS_SHADING {
        return wo;
    }
    return normalize_accurate(across / norm + MIN_COS_SHADING * wo);
}

// Turns `ns` just so far that what it mirrors of `wo` stays over the geometric surface: a normal map
// describes a relief, whose steep sides reflect the rest of it and never the inside. `ns` and `ng` lie
// on wo's side. (Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", on
// adapting the shading normal.)
fn lift_reflection(ns: vec3<f32>, ng: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let mirrored = 2.0 * dot(ns, wo) * ns - wo;
    let height = dot(mirrored, ng);
    if height >= MIN_COS_SHADING {
        return ns;
    }
    let lifted = normalize_accurate(mirrored + (MIN_COS_SHADING - height) * ng);
    return normalize_accurate(wo + lifted);
}

// The normal that a normal map tells in the mesh's own frame (glTF 2.0 section 3.9.3). Without tangents the
// axes of the map are unknown, and any will do.
fn mapped_normal(triangle: Triangle, barycentrics: vec2<f32>, smooth_frame: Basis, texture: Texture, scale: f32) -> vec3<f32> {
    let uv = attribute_texcoord(triangle, barycentrics, texture.texcoord);
    let texel = texture_sample(texture, uv).xyz * 2.0 - 1.0;
    return normalize_accurate(to_world(smooth_frame, vec3<f32>(texel.xy * scale, texel.z)));
}

// The hit of `ray`; not for a miss.
fn surface_at(ray: Ray, hit: Hit) -> Surface {
    let triangle = triangles[hit.triangle];
    let instance = instance_at(hit.instance, ray.time);
    let barycentrics = vec2<f32>(hit.u, hit.v);
    let wo = -ray.direction;

    let rows = instance.world_from_object;
    let p = transform_point(rows, triangle.p0 + hit.u * triangle.e1 + hit.v * triangle.e2);

    let n_front = geometric_normal(triangle, instance);
    let front = dot(n_front, wo) >= 0.0;
    let side = select(-1.0, 1.0, front);

    // The front's shading normal. One that points behind its own face is taken for a mistake of
    // orientation; one of no length, as the geometric normal.
    var n = normalize_accurate(transform_normal(rows, attribute_normal(triangle, barycentrics)));
    if dot(n, n) == 0.0 {
        n = n_front;
    }
    n = select(n, -n, dot(n, n_front) < 0.0);

    let object_tangent = attribute_tangent(triangle, barycentrics);
    let tangent = transform_vector(rows, object_tangent.xyz);
    let flipped = (instance.flags & INSTANCE_FLIPPED) != 0u;
    let handedness = select(object_tangent.w, -object_tangent.w, flipped);

    let smooth_frame = basis_from_tangent(n, tangent, handedness);
    let normal_texture = materials[triangle.material].normal_texture;
    if NORMAL_TEXTURES && normal_texture.texels != NONE {
        let scale = materials[triangle.material].normal_scale;
        n = mapped_normal(triangle, barycentrics, smooth_frame, normal_texture, scale);
    }

    // The back of a double-sided surface has the reversed normal (glTF 2.0 section 3.9.6).
    let ns = lift_reflection(bend_towards(n * side, wo), n_front * side, wo);
    let basis = basis_from_tangent(ns, tangent, 1.0);

    // KHR_materials_clearcoat: the coat is as smooth as the mesh, or has a map of its own.
    var coat_normal = vec3<f32>(0.0, 0.0, 1.0);
    let coat_texture = materials[triangle.material].coat_normal_texture;
    if COAT_NORMALS && materials[triangle.material].coat > 0.0 &&
        (normal_texture.texels != NONE || coat_texture.texels != NONE) {
        var n_coat = smooth_frame.n;
        if coat_texture.texels != NONE {
            let scale = materials[triangle.material].coat_normal_scale;
            n_coat = mapped_normal(triangle, barycentrics, smooth_frame, coat_texture, scale);
        }
        coat_normal = to_local(basis, lift_reflection(bend_towards(n_coat * side, wo), n_front * side, wo));
    }
    return Surface(
        p,
        position_error(triangle, instance, p, n_front),
        n_front * side,
        select(0u, 1u, front),
        basis,
        coat_normal,
        select(handedness * side, 1.0, handedness == 0.0),
        attribute_color(triangle, barycentrics),
        barycentrics,
        hit.triangle,
        triangle.material,
    );
}

// TEXCOORD_`number` at the hit.
fn texcoord(surface: Surface, number: u32) -> vec2<f32> {
    return attribute_texcoord(triangles[surface.triangle], surface.barycentrics, number);
}
