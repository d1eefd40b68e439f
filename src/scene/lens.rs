//! What a camera's rays go through: a thin lens, and lenses as calibration measures them.

/// A thin lens: all of it sees a point in focus at one place of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Diameter in metres.
    pub aperture: f32,
    /// Metres along the axis to the plane in focus; `None`: to what the middle of the picture shows.
    pub focus: Option<f32>,
}

/// A calibrated camera in OpenCV's terms (its documentation, "Camera Calibration and 3D
/// Reconstruction"): pixels of a picture of `size`, whose first pixel has its centre at (0, 0); x to
/// the right, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    pub size: [u32; 2],
    /// fx, fy in pixels.
    pub focal: [f32; 2],
    /// cx, cy in pixels.
    pub center: [f32; 2],
    pub distortion: Distortion,
}

/// From directions to where they are on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// Brown 1966, "Decentering Distortion of Lenses", with OpenCV's rational and thin-prism terms.
    BrownConrady {
        /// k1 to k6.
        radial: [f32; 6],
        /// p1, p2.
        tangential: [f32; 2],
        /// s1 to s4.
        prism: [f32; 4],
    },
    /// Kannala and Brandt 2006, "A Generic Camera Model and Calibration Method for Conventional,
    /// Wide-Angle, and Fish-Eye Lenses": k1 to k4.
    Fisheye([f32; 4]),
}
