// Rays, what they hit, and how a new ray starts on a surface without meeting it again.

struct Ray {
    origin: vec3<f32>,
    t_min: f32,
    direction: vec3<f32>, // unit length in world space
    t_max: f32,
    time: f32,            // in [0, 1) from when the shutter opens to when it closes
}

// Where a ray met a triangle: the point is p0 + u e1 + v e2.
struct Hit {
    t: f32,
    u: f32,
    v: f32,
    instance: u32, // NONE: nothing was hit
    triangle: u32, // index in `triangles`
}

// Rounding of the sum below, a few units in the last place: 2^-21.
const ORIGIN_ROUNDING: f32 = 4.76837158203125e-7;

// Moves `p` off the surface with unit normal `ng`, to the side that `w` points to. `floor` is the
// error of `p` along the normal in metres, `Surface.p_error`; the rounding of `p` itself is added.
//
// In the manner of Pharr, Jakob and Humphreys, "Physically Based Rendering", section 6.8: bounds of
// the error, not a constant that fits one scale of scene.
fn offset_origin(p: vec3<f32>, ng: vec3<f32>, w: vec3<f32>, floor: f32) -> vec3<f32> {
    let distance = floor + ORIGIN_ROUNDING * dot(abs(ng), abs(p));
    return p + ng * select(distance, -distance, dot(ng, w) < 0.0);
}
