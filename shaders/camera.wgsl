// Camera rays. The film's aspect is in half_width and half_height already.

import package::shared::{Camera, CAMERA_ORTHOGRAPHIC};
import package::ray::{Ray};

// Farther than any scene, metres: near the largest float32, and finite.
const CAMERA_FAR: f32 = 1e30;

// The ray through `position` on the film, pixels, row 0 on top: glTF 2.0 section 3.10.3. Starts
// at the camera and counts from its near plane.
fn camera_ray(camera: Camera, film_size: vec2<u32>, position: vec2<f32>) -> Ray {
    let ndc = 2.0 * position / vec2<f32>(film_size) - 1.0;
    let across = ndc.x * camera.half_width * camera.right - ndc.y * camera.half_height * camera.up;
    if camera.kind == CAMERA_ORTHOGRAPHIC {
        return Ray(camera.origin + across, camera.near, camera.forward, CAMERA_FAR, 0.0);
    }
    let direction = camera.forward + across;
    // The camera's axes are orthonormal, so this is also how far along the ray one metre of depth is.
    let length = sqrt(dot(direction, direction));
    return Ray(camera.origin, camera.near * length, direction / length, CAMERA_FAR, 0.0);
}
