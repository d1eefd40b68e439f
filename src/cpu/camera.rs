//! Camera rays. The film's aspect is in `half_width` and `half_height` already.

use crate::cpu::math::{PI, normalize_accurate, sincos_accurate};
use crate::cpu::ray::Ray;
use crate::shared::{
    CAMERA_BROWN_CONRADY, CAMERA_FISHEYE, CAMERA_ORTHOGRAPHIC, CAMERA_PANORAMA, Camera,
};
use glam::{DMat2, DVec2, DVec3, DVec4, UVec2, Vec2, Vec3, Vec4};

/// Farther than any scene, metres: near the largest float32, and finite.
pub const CAMERA_FAR: f64 = 1e30;

/// Newton's steps back through a lens: the shader's.
pub const UNDISTORT_STEPS: u32 = 10;

/// The camera in float64, at a moment.
#[derive(Clone, Copy, Debug)]
pub struct PlacedCamera {
    pub kind: u32,
    pub origin: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// Half the film's extents at one metre of depth, and its centre.
    pub half: DVec2,
    pub center: DVec2,
    pub near: f64,
    pub lens_radius: f64,
    pub focus: f64,
    pub distortion: [DVec4; 3],
}

/// The camera at `time`, in [0, 1] of the shutter's opening: place and axes go straight from one pose to
/// the other, and the axes are made orthonormal again.
pub fn camera_at(camera: &Camera, time: f64) -> PlacedCamera {
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let mut placed = PlacedCamera {
        kind: camera.kind,
        origin: vector(camera.origin),
        right: vector(camera.right),
        up: vector(camera.up),
        forward: vector(camera.forward),
        half: Vec2::new(camera.half_width, camera.half_height).as_dvec2(),
        center: Vec2::from(camera.center).as_dvec2(),
        near: camera.near.into(),
        lens_radius: camera.lens_radius.into(),
        focus: camera.focus.into(),
        distortion: camera.distortion.map(|row| Vec4::from(row).as_dvec4()),
    };
    if camera.moves == 0 {
        return placed;
    }
    let between = |from: DVec3, to: [f32; 3]| from.lerp(vector(to), time);
    placed.origin = between(placed.origin, camera.closing_origin);
    placed.forward = normalize_accurate(between(placed.forward, camera.closing_forward));
    let right = between(placed.right, camera.closing_right);
    placed.right = normalize_accurate(right - right.dot(placed.forward) * placed.forward);
    placed.up = placed.right.cross(placed.forward);
    placed
}

/// The ray through `position` on the film, pixels, row 0 on top: glTF 2.0 section 3.10.3. Starts
/// at the camera and counts from its near plane. `lens`: on the unit disk, where it passes the lens.
pub fn camera_ray(camera: &PlacedCamera, film_size: UVec2, position: DVec2, lens: DVec2) -> Ray {
    let ndc = 2.0 * position / film_size.as_dvec2() - 1.0;
    let ray = |origin: DVec3, t_min: f64, direction: DVec3| Ray {
        origin,
        t_min,
        direction,
        t_max: CAMERA_FAR,
        time: 0.0,
    };
    if camera.kind == CAMERA_PANORAMA {
        return ray(camera.origin, camera.near, panorama_direction(camera, ndc));
    }
    // To the right and down, at one metre of depth.
    let mut film = ndc * camera.half + camera.center;
    if camera.kind == CAMERA_FISHEYE {
        return ray(camera.origin, camera.near, fisheye_direction(camera, film));
    }
    if camera.kind == CAMERA_BROWN_CONRADY {
        film = undistort(camera, film);
    }
    let across = film.x * camera.right - film.y * camera.up;
    if camera.kind == CAMERA_ORTHOGRAPHIC {
        return ray(camera.origin + across, camera.near, camera.forward);
    }
    let mut origin = camera.origin;
    let mut direction = camera.forward + across;
    if camera.lens_radius > 0.0 {
        // Through the point that the pinhole's ray has in the plane in focus (Potmesil and Chakravarty
        // 1981, "A Lens and Aperture Camera Model for Synthetic Image Generation").
        let offset = camera.lens_radius * (lens.x * camera.right + lens.y * camera.up);
        origin += offset;
        direction -= offset / camera.focus;
    }
    // The camera's axes are orthonormal, so this is also how far along the ray one metre of depth is.
    let length = direction.length();
    ray(origin, camera.near * length, direction / length)
}

/// All around, as an environment map is laid out, with +x to the camera's right, +y up and +z behind it.
pub fn panorama_direction(camera: &PlacedCamera, ndc: DVec2) -> DVec3 {
    let around = sincos_accurate(PI * ndc.x);
    let down = sincos_accurate(0.5 * PI * (ndc.y + 1.0));
    down.x * around.y * camera.right + down.y * camera.up - down.x * around.x * camera.forward
}

/// Kannala and Brandt 2006, "A Generic Camera Model and Calibration Method for Conventional,
/// Wide-Angle, and Fish-Eye Lenses", equation 6: the distance on the film as a polynomial of the angle.
pub fn fisheye_direction(camera: &PlacedCamera, film: DVec2) -> DVec3 {
    let distance = film.length();
    if distance == 0.0 {
        return camera.forward;
    }
    let theta = fisheye_angle(camera.distortion[0], distance).0;
    let turned = sincos_accurate(theta);
    let across = (film.x * camera.right - film.y * camera.up) / distance;
    normalize_accurate(turned.x * across + turned.y * camera.forward)
}

/// The angle that a lens shows at `distance` on the film, and how far the steps are from the root.
// cpu only: the shader has no use for what is left.
pub fn fisheye_angle(k: DVec4, distance: f64) -> (f64, f64) {
    let mut theta = distance;
    let reached =
        |theta: f64, t2: f64| theta * (1.0 + t2 * (k.x + t2 * (k.y + t2 * (k.z + t2 * k.w))));
    for _ in 0..UNDISTORT_STEPS {
        let t2 = theta * theta;
        theta -= (reached(theta, t2) - distance) / fisheye_slope(k, theta);
    }
    (theta, reached(theta, theta * theta) - distance)
}

/// Film per angle.
// cpu only: a part of the shader's loop.
pub fn fisheye_slope(k: DVec4, theta: f64) -> f64 {
    let t2 = theta * theta;
    1.0 + t2 * (3.0 * k.x + t2 * (5.0 * k.y + t2 * (7.0 * k.z + t2 * 9.0 * k.w)))
}

/// Where `p`, at one metre of depth, to the right and down, is on the film: OpenCV's model, with radial
/// (k1 to k6), tangential (p1, p2) and thin-prism terms (s1 to s4).
pub fn distort(camera: &PlacedCamera, p: DVec2) -> DVec2 {
    let [k1_k2_p1_p2, k3_to_k6, s] = camera.distortion;
    let r2 = p.dot(p);
    let over = 1.0 + r2 * (k1_k2_p1_p2.x + r2 * (k1_k2_p1_p2.y + r2 * k3_to_k6.x));
    let under = 1.0 + r2 * (k3_to_k6.y + r2 * (k3_to_k6.z + r2 * k3_to_k6.w));
    let tangential = DVec2::new(k1_k2_p1_p2.z, k1_k2_p1_p2.w);
    p * (over / under)
        + 2.0 * tangential * p.x * p.y
        + DVec2::new(tangential.y, tangential.x) * (r2 + 2.0 * p * p)
        + DVec2::new(s.x, s.z) * r2
        + DVec2::new(s.y, s.w) * (r2 * r2)
}

/// The columns of `distort`'s derivative: by `p.x`, then by `p.y`.
pub fn distort_derivative(camera: &PlacedCamera, p: DVec2) -> DMat2 {
    let [k1_k2_p1_p2, k3_to_k6, s] = camera.distortion;
    let r2 = p.dot(p);
    let over = 1.0 + r2 * (k1_k2_p1_p2.x + r2 * (k1_k2_p1_p2.y + r2 * k3_to_k6.x));
    let under = 1.0 + r2 * (k3_to_k6.y + r2 * (k3_to_k6.z + r2 * k3_to_k6.w));
    let over_slope = k1_k2_p1_p2.x + r2 * (2.0 * k1_k2_p1_p2.y + r2 * 3.0 * k3_to_k6.x);
    let under_slope = k3_to_k6.y + r2 * (2.0 * k3_to_k6.z + r2 * 3.0 * k3_to_k6.w);
    let radial = over / under;
    // By r2, and what goes with r2 otherwise.
    let slope = (over_slope * under - over * under_slope) / (under * under);
    let t = DVec2::new(k1_k2_p1_p2.z, k1_k2_p1_p2.w);
    let by_r2 =
        p * slope + DVec2::new(t.y, t.x) + DVec2::new(s.x, s.z) + 2.0 * DVec2::new(s.y, s.w) * r2;
    DMat2::from_cols(
        DVec2::new(radial + 2.0 * t.x * p.y + 4.0 * t.y * p.x, 2.0 * t.y * p.y) + 2.0 * p.x * by_r2,
        DVec2::new(2.0 * t.x * p.x, radial + 2.0 * t.y * p.x + 4.0 * t.x * p.y) + 2.0 * p.y * by_r2,
    )
}

/// The point that `distort` takes to `film`.
pub fn undistort(camera: &PlacedCamera, film: DVec2) -> DVec2 {
    let mut p = film;
    for _ in 0..UNDISTORT_STEPS {
        let away = distort(camera, p) - film;
        p -= distort_derivative(camera, p).inverse() * away;
    }
    p
}
