// What every reflection model shares: its answers, and the limits of its inputs.
//
// wo points to the viewer, wi to the light, both unit and away from the surface; the frame's z is the
// shading normal. f excludes the cosine; pdf is per solid angle of wi; a pdf of 0 is "no sample".

// Directions with a smaller |cosine| lie in the surface: nothing is reflected or transmitted along
// them. Squares of it, and D at ALPHA_SMOOTH over them, are still well inside float32.
const MIN_COS: f32 = 1e-12;
// A lobe narrower than this is a delta: float32 directions are too coarse to resolve it.
const ALPHA_SMOOTH: f32 = 1e-3;
// Indices closer than this to each other bend no ray visibly (F < 3e-7), and a rough boundary between
// them would spread light by less than float32 directions resolve: it is taken as smooth.
const ETA_MATCHED: f32 = 1e-3;

// `BsdfSample.delta`
const DELTA: u32 = 1u;
const DELTA_STRAIGHT: u32 = 2u; // and the light goes straight on: the surface is there for its weight only

struct BsdfEval {
    f: vec3<f32>,
    pdf: f32,
}

// For a delta sample pdf is the probability of that choice and f = value / |cos theta_i|, so that
// f * |cos theta_i| / pdf is the weight, as for every other sample.
struct BsdfSample {
    wi: vec3<f32>,
    f: vec3<f32>,
    pdf: f32,
    delta: u32,
}

// For one direction that is given, and for one that is drawn.
struct EvalAndSample {
    eval: BsdfEval,
    sample: BsdfSample,
}

fn no_eval() -> BsdfEval {
    return BsdfEval(vec3(0.0), 0.0);
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, 0u);
}

// The sample of a direction that eval has judged.
fn sample_of(wi: vec3<f32>, eval: BsdfEval) -> BsdfSample {
    if eval.pdf > 0.0 {
        return BsdfSample(wi, eval.f, eval.pdf, 0u);
    }
    return no_sample();
}

// The same direction on the other side of the surface.
fn mirrored(w: vec3<f32>) -> vec3<f32> {
    return vec3(w.x, w.y, -w.z);
}

// Whether both directions lie above the surface.
fn is_reflected(wo: vec3<f32>, wi: vec3<f32>) -> bool {
    return wo.z >= MIN_COS && wi.z >= MIN_COS;
}

// Whether the light comes from below and the viewer is above.
fn is_transmitted(wo: vec3<f32>, wi: vec3<f32>) -> bool {
    return wo.z >= MIN_COS && wi.z <= -MIN_COS;
}
