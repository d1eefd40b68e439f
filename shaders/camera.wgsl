// Camera rays. The film's aspect is in half_width and half_height already.

import package::shared::{Camera, CAMERA_ORTHOGRAPHIC, CAMERA_PANORAMA, CAMERA_BROWN_CONRADY, CAMERA_FISHEYE};
import package::math::{PI, normalize_accurate, sincos_accurate};
import package::ray::{Ray};
import package::variant::{MOTION, LENS, HAS_PANORAMA, HAS_FISHEYE, HAS_BROWN_CONRADY};

// Farther than any scene, metres: near the largest float32, and finite.
const CAMERA_FAR: f32 = 1e30;

// Newton's steps back through a lens. From the film's own point they come down to the root of every lens
// that src/pack/camera.rs lets pass, which takes the same steps.
const UNDISTORT_STEPS: u32 = 10u;

// The camera at `time`, in [0, 1] of the shutter's opening: place and axes go straight from one pose to
// the other, and the axes are made orthonormal again.
fn camera_at(camera: Camera, time: f32) -> Camera {
    if !MOTION || camera.moves == 0u {
        return camera;
    }
    var placed = camera;
    placed.origin = mix(camera.origin, camera.closing_origin, time);
    placed.forward = normalize_accurate(mix(camera.forward, camera.closing_forward, time));
    let right = mix(camera.right, camera.closing_right, time);
    placed.right = normalize_accurate(right - dot(right, placed.forward) * placed.forward);
    placed.up = cross(placed.right, placed.forward);
    return placed;
}

// The ray through `position` on the film, pixels, row 0 on top: glTF 2.0 section 3.10.3. Starts
// at the camera and counts from its near plane. `lens`: on the unit disk, where it passes the lens.
fn camera_ray(camera: Camera, film_size: vec2<u32>, position: vec2<f32>, lens: vec2<f32>) -> Ray {
    let ndc = 2.0 * position / vec2<f32>(film_size) - 1.0;
    if HAS_PANORAMA && camera.kind == CAMERA_PANORAMA {
        return Ray(camera.origin, camera.near, panorama_direction(camera, ndc), CAMERA_FAR, 0.0);
    }
    // To the right and down, at one metre of depth.
    var film = ndc * vec2<f32>(camera.half_width, camera.half_height) + camera.center;
    if HAS_FISHEYE && camera.kind == CAMERA_FISHEYE {
        return Ray(camera.origin, camera.near, fisheye_direction(camera, film), CAMERA_FAR, 0.0);
    }
    if HAS_BROWN_CONRADY && camera.kind == CAMERA_BROWN_CONRADY {
        film = undistort(camera, film);
    }
    let across = film.x * camera.right - film.y * camera.up;
    if camera.kind == CAMERA_ORTHOGRAPHIC {
        return Ray(camera.origin + across, camera.near, camera.forward, CAMERA_FAR, 0.0);
    }
    var origin = camera.origin;
    var direction = camera.forward + across;
    if LENS && camera.lens_radius > 0.0 {
        // Through the point that the pinhole's ray has in the plane in focus (Potmesil and Chakravarty 1981,
        // "A Lens and Aperture Camera Model for Synthetic Image Generation").
        let offset = camera.lens_radius * (lens.x * camera.right + lens.y * camera.up);
        origin += offset;
        direction -= offset / camera.focus;
    }
    // The camera's axes are orthonormal, so this is also how far along the ray one metre of depth is.
    let length = sqrt(dot(direction, direction));
    return Ray(origin, camera.near * length, direction / length, CAMERA_FAR, 0.0);
}

// All around, as an environment map is laid out, with +x to the camera's right, +y up and +z behind it.
fn panorama_direction(camera: Camera, ndc: vec2<f32>) -> vec3<f32> {
    let around = sincos_accurate(PI * ndc.x);
    let down = sincos_accurate(0.5 * PI * (ndc.y + 1.0));
    return down.x * around.y * camera.right + down.y * camera.up - down.x * around.x * camera.forward;
}

// Kannala and Brandt 2006, "A Generic Camera Model and Calibration Method for Conventional, Wide-Angle,
// and Fish-Eye Lenses", equation 6: the distance on the film as a polynomial of the angle.
fn fisheye_direction(camera: Camera, film: vec2<f32>) -> vec3<f32> {
    let distance = sqrt(dot(film, film));
    if distance == 0.0 {
        return camera.forward;
    }
    let k = camera.distortion[0];
    var theta = distance;
    for (var step = 0u; step < UNDISTORT_STEPS; step++) {
        let t2 = theta * theta;
        let reached = theta * (1.0 + t2 * (k.x + t2 * (k.y + t2 * (k.z + t2 * k.w))));
        let slope = 1.0 + t2 * (3.0 * k.x + t2 * (5.0 * k.y + t2 * (7.0 * k.z + t2 * 9.0 * k.w)));
        theta -= (reached - distance) / slope;
    }
    let turned = sincos_accurate(theta);
    let across = (film.x * camera.right - film.y * camera.up) / distance;
    return normalize_accurate(turned.x * across + turned.y * camera.forward);
}

// Where `p`, at one metre of depth, to the right and down, is on the film: OpenCV's model, with radial
// (k1 to k6), tangential (p1, p2) and thin-prism terms (s1 to s4).
fn distort(camera: Camera, p: vec2<f32>) -> vec2<f32> {
    let k1_k2_p1_p2 = camera.distortion[0];
    let k3_to_k6 = camera.distortion[1];
    let s = camera.distortion[2];
    let r2 = dot(p, p);
    let over = 1.0 + r2 * (k1_k2_p1_p2.x + r2 * (k1_k2_p1_p2.y + r2 * k3_to_k6.x));
    let under = 1.0 + r2 * (k3_to_k6.y + r2 * (k3_to_k6.z + r2 * k3_to_k6.w));
    let tangential = k1_k2_p1_p2.zw;
    return p * (over / under)
        + 2.0 * tangential * p.x * p.y + tangential.yx * (r2 + 2.0 * p * p)
        + s.xz * r2 + s.yw * (r2 * r2);
}

// The columns of distort's derivative: by p.x, then by p.y.
fn distort_derivative(camera: Camera, p: vec2<f32>) -> mat2x2<f32> {
    let k1_k2_p1_p2 = camera.distortion[0];
    let k3_to_k6 = camera.distortion[1];
    let s = camera.distortion[2];
    let r2 = dot(p, p);
    let over = 1.0 + r2 * (k1_k2_p1_p2.x + r2 * (k1_k2_p1_p2.y + r2 * k3_to_k6.x));
    let under = 1.0 + r2 * (k3_to_k6.y + r2 * (k3_to_k6.z + r2 * k3_to_k6.w));
    let over_slope = k1_k2_p1_p2.x + r2 * (2.0 * k1_k2_p1_p2.y + r2 * 3.0 * k3_to_k6.x);
    let under_slope = k3_to_k6.y + r2 * (2.0 * k3_to_k6.z + r2 * 3.0 * k3_to_k6.w);
    let radial = over / under;
    // By r2, and what goes with r2 otherwise.
    let slope = (over_slope * under - over * under_slope) / (under * under);
    let by_r2 = p * slope + k1_k2_p1_p2.wz + s.xz + 2.0 * s.yw * r2;
    let t = k1_k2_p1_p2.zw;
    return mat2x2<f32>(
        vec2<f32>(radial + 2.0 * t.x * p.y + 4.0 * t.y * p.x, 2.0 * t.y * p.y) + 2.0 * p.x * by_r2,
        vec2<f32>(2.0 * t.x * p.x, radial + 2.0 * t.y * p.x + 4.0 * t.x * p.y) + 2.0 * p.y * by_r2);
}

// The point that distort takes to `film`.
fn undistort(camera: Camera, film: vec2<f32>) -> vec2<f32> {
    var p = film;
    for (var step = 0u; step < UNDISTORT_STEPS; step++) {
        let away = distort(camera, p) - film;
        let J = distort_derivative(camera, p);
        let determinant = J[0].x * J[1].y - J[0].y * J[1].x;
        p -= vec2<f32>(J[1].y * away.x - J[1].x * away.y, J[0].x * away.y - J[0].y * away.x) / determinant;
    }
    return p;
}
