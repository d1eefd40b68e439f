//! What every reflection model shares: its answers, and the limits of its inputs.
//!
//! wo points to the viewer, wi to the light, both unit and away from the surface; the frame's z is the
//! shading normal. f excludes the cosine; pdf is per solid angle of wi; a pdf of 0 is "no sample".

use glam::DVec3;

/// Directions with a smaller |cosine| lie in the surface: nothing is reflected or transmitted along
/// them. Squares of it, and D at `ALPHA_SMOOTH` over them, are still well inside float32.
pub const MIN_COS: f64 = 1e-12;
/// A lobe narrower than this is a delta: float32 directions are too coarse to resolve it.
pub const ALPHA_SMOOTH: f64 = 1e-3;
/// Indices closer than this to each other bend no ray visibly (F < 3e-7), and a rough boundary between
/// them would spread light by less than float32 directions resolve: it is taken as smooth.
pub const ETA_MATCHED: f64 = 1e-3;

/// `BsdfSample::delta`
pub const DELTA: u32 = 1;
/// And the light goes straight on: the surface is there for its weight only.
pub const DELTA_STRAIGHT: u32 = 2;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfEval {
    pub f: DVec3,
    pub pdf: f64,
}

/// For a delta sample `pdf` is the probability of that choice and f = value / |cos theta_i|, so that
/// f * |cos theta_i| / pdf is the weight, as for every other sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    pub wi: DVec3,
    pub f: DVec3,
    pub pdf: f64,
    pub delta: u32,
}

/// For one direction that is given, and for one that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvalAndSample {
    pub eval: BsdfEval,
    pub sample: BsdfSample,
}

pub fn no_eval() -> BsdfEval {
    BsdfEval {
        f: DVec3::ZERO,
        pdf: 0.0,
    }
}

pub fn no_sample() -> BsdfSample {
    BsdfSample {
        wi: DVec3::Z,
        f: DVec3::ZERO,
        pdf: 0.0,
        delta: 0,
    }
}

/// The sample of a direction that `eval` has judged.
pub fn sample_of(wi: DVec3, eval: BsdfEval) -> BsdfSample {
    if eval.pdf > 0.0 {
        return BsdfSample {
            wi,
            f: eval.f,
            pdf: eval.pdf,
            delta: 0,
        };
    }
    no_sample()
}

/// The same direction on the other side of the surface.
pub fn mirrored(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// Whether both directions lie above the surface.
pub fn is_reflected(wo: DVec3, wi: DVec3) -> bool {
    wo.z >= MIN_COS && wi.z >= MIN_COS
}

/// Whether the light comes from below and the viewer is above.
pub fn is_transmitted(wo: DVec3, wi: DVec3) -> bool {
    wo.z >= MIN_COS && wi.z <= -MIN_COS
}
