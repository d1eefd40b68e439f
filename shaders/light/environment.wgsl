// Light from infinitely far: an equirectangular map of radiance and the table that samples it.
// (u, v) of a direction: u = atan2(z, x) / (2 pi) + 1/2, v = acos(y) / pi from the top row, after
// the map's rotation about +y is taken back. A density over (u, v) becomes one per solid angle by
// d omega = 2 pi^2 sin(theta) du dv.

import package::variant::{ENVIRONMENT};
import package::math::{PI, INV_PI, sqr, sincos_accurate, atan2_accurate};
import package::bindings::{frame, environment, environment_cells};

// The sampler's numbers are multiples of one over this, and so are the table's probabilities.
const SAMPLE_STEPS: f32 = 0x1p24f;

// Where a direction, of any length, falls on the map: [0, 1]^2.
fn environment_uv(d: vec3<f32>) -> vec2<f32> {
    let x = d.x * frame.environment_cos - d.z * frame.environment_sin;
    let z = d.x * frame.environment_sin + d.z * frame.environment_cos;
    // acos(y) would lose half of its digits near the poles.
    let theta = atan2_accurate(sqrt(x * x + z * z), d.y);
    return vec2<f32>(atan2_accurate(z, x) * (0.5 * INV_PI) + 0.5, theta * INV_PI);
}

// The inverse: a unit vector.
fn environment_direction(uv: vec2<f32>) -> vec3<f32> {
    let theta = sincos_accurate(PI * uv.y);
    let phi = sincos_accurate(PI * (2.0 * uv.x - 1.0));
    let x = theta.x * phi.y;
    let z = theta.x * phi.x;
    return vec3<f32>(
        x * frame.environment_cos + z * frame.environment_sin,
        theta.y,
        z * frame.environment_cos - x * frame.environment_sin,
    );
}

// One texel of the map; wraps around horizontally, ends at the poles.
fn environment_texel(x: i32, y: i32) -> vec3<f32> {
    let size = vec2<i32>(frame.environment_size);
    let place = vec2<i32>((x + size.x) % size.x, clamp(y, 0, size.y - 1));
    return textureLoad(environment, place, 0).rgb;
}

// Radiance that arrives from direction d, filtered bilinearly between texel centres.
fn Le_environment(d: vec3<f32>) -> vec3<f32> {
    if !ENVIRONMENT || frame.environment_strength == 0.0 {
        return vec3<f32>(0.0);
    }
    let place = environment_uv(d) * vec2<f32>(frame.environment_size) - 0.5;
    let corner = floor(place);
    let fraction = place - corner;
    let x = i32(corner.x);
    let y = i32(corner.y);
    let top = mix(environment_texel(x, y), environment_texel(x + 1, y), fraction.x);
    let bottom = mix(environment_texel(x, y + 1), environment_texel(x + 1, y + 1), fraction.x);
    return frame.environment_strength * mix(top, bottom, fraction.y);
}

// Cumulative probability of the row's cells up to and with cell x; that of the rows in column
// environment_cells.x. A multiple of 2^-24, as the sampler's numbers are.
fn environment_cumulative(x: u32, y: u32) -> f32 {
    return textureLoad(environment_cells, vec2<u32>(x, y), 0).x;
}

// Density of a cell over the unit square of (u, v).
fn environment_density(x: u32, y: u32) -> f32 {
    return textureLoad(environment_cells, vec2<u32>(x, y), 0).y;
}

// Bisection for the first of `count` cells of row y (or rows, where `rows`) whose cumulative
// probability is above u, and how far into it u lies, in (0, 1).
fn environment_find(u: f32, count: u32, y: u32, rows: bool) -> vec2<f32> {
    var first = 0u;
    var remaining = count - 1u;
    while remaining > 0u {
        let half = remaining / 2u;
        let cell = select(vec2<u32>(first + half, y), vec2<u32>(frame.environment_cells.x, first + half), rows);
        if environment_cumulative(cell.x, cell.y) <= u {
            first += half + 1u;
            remaining -= half + 1u;
        } else {
            remaining = half;
        }
    }
    let cell = select(vec2<u32>(first, y), vec2<u32>(frame.environment_cells.x, first), rows);
    let above = environment_cumulative(cell.x, cell.y);
    var below = 0.0;
    if first > 0u {
        let before = select(cell - vec2<u32>(1u, 0u), cell - vec2<u32>(0u, 1u), rows);
        below = environment_cumulative(before.x, before.y);
    }
    // Each of the sampler's numbers stands for an interval of one step; taking its middle keeps
    // cells that few numbers reach from being met at one edge only. Counted in whole steps, since
    // a compiler may reorder float additions.
    let steps_in = u32(u * SAMPLE_STEPS) - u32(below * SAMPLE_STEPS);
    let steps_across = u32(above * SAMPLE_STEPS) - u32(below * SAMPLE_STEPS);
    return vec2<f32>(f32(first), (f32(steps_in) + 0.5) / f32(steps_across));
}

// (Direction, pdf per solid angle), the choice of this light not included. pdf 0: no light.
fn environment_sample(u: vec2<f32>) -> vec4<f32> {
    if frame.environment_weight == 0.0 {
        return vec4<f32>(0.0);
    }
    let cells = vec2<f32>(frame.environment_cells);
    let row = environment_find(u.y, frame.environment_cells.y, 0u, true);
    let column = environment_find(u.x, frame.environment_cells.x, u32(row.x), false);
    let uv = vec2<f32>(column.x + column.y, row.x + row.y) / cells;
    let density = environment_density(u32(column.x), u32(row.x));
    let sin_theta = sincos_accurate(PI * uv.y).x;
    return vec4<f32>(environment_direction(uv), density / (2.0 * sqr(PI) * sin_theta));
}

// Directions that environment_sample_facing chooses between.
const ENVIRONMENT_CANDIDATES: f32 = 2.0;

struct EnvironmentSample {
    wi: vec3<f32>,
    pdf: f32,      // per solid angle, of both candidates together, whose integral is their number; 0: no light
    weight: f32,   // one over the probability with which this one of the two was taken
}

// One of two directions of environment_sample, by the number u_choice in proportion to the cosine with ns: of the
// side of ns, or of both where the surface transmits.
//
// Two samples x of density p may both be taken, as the sum of w g / (2 p) with a heuristic's weight w of 2 p
// against the density of the other technique (Veach and Guibas 1995, "Optimally combining sampling techniques", the
// multi-sample model). Of the two terms one is taken with probability cos / (cos + cos'), and divided by it: the same
// expectation for one ray, if terms without a cosine are 0. Which is resampled importance sampling (Talbot, Cline and
// Egbert 2005) of the product p cos, and asks nothing of how the two depend on each other. The second is half
// of the square further in both axes: somewhere else in the sky, and as even as the first over a pixel's samples.
fn environment_sample_facing(ns: vec3<f32>, transmits: bool, u_choice: f32, u: vec2<f32>) -> EnvironmentSample {
    var result = EnvironmentSample(vec3<f32>(0.0), 0.0, 0.0);
    var sum = 0.0;
    var candidate_u = u;
    for (var i = 0; i < i32(ENVIRONMENT_CANDIDATES); i++) {
        let candidate = environment_sample(candidate_u);
        let cosine = dot(candidate.xyz, ns);
        let share = select(max(cosine, 0.0), abs(cosine), transmits);
        sum += share;
        if share > 0.0 && u_choice * sum <= share {
            result = EnvironmentSample(candidate.xyz, ENVIRONMENT_CANDIDATES * candidate.w, share);
        }
        candidate_u += select(vec2<f32>(0.5), vec2<f32>(-0.5), candidate_u >= vec2<f32>(0.5));
    }
    if result.pdf > 0.0 {
        result.weight = sum / result.weight;
    }
    return result;
}

// Density of environment_sample at the unit vector d.
fn environment_pdf(d: vec3<f32>) -> f32 {
    let sin_theta = sqrt(d.x * d.x + d.z * d.z);
    if frame.environment_weight == 0.0 || sin_theta == 0.0 {
        return 0.0;
    }
    let cell = vec2<u32>(environment_uv(d) * vec2<f32>(frame.environment_cells));
    let last = frame.environment_cells - 1u;
    let density = environment_density(min(cell.x, last.x), min(cell.y, last.y));
    return density / (2.0 * sqr(PI) * sin_theta);
}
