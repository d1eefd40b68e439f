// "Average the samples": adds this dispatch's samples, weighted by the pixel filter, to the tile's film. A pixel's come one
// after another in the order of their numbers, and those of one number in the order of their pixels, so that
// how samples are split into dispatches changes no bit.

import package::bindings::{frame};
import package::kernels::state::{paths, counters, plane, sample_place, is_covered, COUNTER_CLAMPED, PLANE_RADIANCE, WORKGROUP};
import package::kernels::slots::{pixel_slot, sampled_slots};
import package::estimator::{is_finite, clamp_radiance};
import package::filter::{filter_offset, filter_weight, FILTER_REACH};

// Weighted sums of radiance and alpha, what rounding took from them, the weighted sum of squares, and counts. The
// host reads it as it stands (src/gpu/render.rs).
struct FilmCell {
    sum: vec4<f32>,
    lost: vec4<f32>,
    squares: vec3<f32>,
    non_finite: u32,    // of this pixel's own samples
    weight: f32,
    weight_lost: f32,
    weight_squares: f32,
    reserved: u32,
}

@group(1) @binding(2) var<storage, read_write> film: array<FilmCell>;

fn is_finite_radiance(L: vec3<f32>) -> bool {
    return is_finite(L.x) && is_finite(L.y) && is_finite(L.z);
}

@compute @workgroup_size(WORKGROUP)
fn accumulate_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.tile_size.x * frame.tile_size.y {
        return;
    }
    // From the corner of what is sampled: the first of the pixels whose samples count here.
    let corner = vec2(id.x % frame.tile_size.x, id.x / frame.tile_size.x);
    let own = pixel_slot(corner + FILTER_REACH);
    var cell = film[id.x];
    for (var sample = 0u; sample < frame.sample_count; sample++) {
        let first = sample * sampled_slots();
        let L_own = bitcast<vec3<f32>>(paths[plane(PLANE_RADIANCE, own + first)].xyz);
        if !is_finite_radiance(L_own) {
            cell.non_finite += 1u;
        } else if any(clamp_radiance(L_own, frame.clamp) != L_own) {
            atomicAdd(&counters[COUNTER_CLAMPED], 1u);
        }
        // Of this number, the pixels around and this one.
        var around = vec4<f32>(0.0);
        var weights = vec2<f32>(0.0);
        for (var y = 0u; y <= 2u * FILTER_REACH; y++) {
            for (var x = 0u; x <= 2u * FILTER_REACH; x++) {
                let radiance = paths[plane(PLANE_RADIANCE, pixel_slot(corner + vec2(x, y)) + first)];
                let L = bitcast<vec3<f32>>(radiance.xyz);
                if !is_finite_radiance(L) {
                    continue;
                }
                let beside = vec2<f32>(vec2<i32>(vec2(x, y)) - i32(FILTER_REACH));
                let weight = filter_weight(filter_offset(sample_place(radiance)) + beside);
                let clamped = clamp_radiance(L, frame.clamp);
                around += weight * vec4(clamped, select(0.0, 1.0, is_covered(radiance)));
                cell.squares += weight * clamped * clamped;
                weights += vec2(weight, weight * weight);
            }
        }
        // Kahan 1965, "Pracniques: further remarks on reducing truncation errors": `lost` is what
        // the last addition dropped, added to the next one.
        let added = around - cell.lost;
        let sum = cell.sum + added;
        cell.lost = (sum - cell.sum) - added;
        cell.sum = sum;
        let weight_added = weights.x - cell.weight_lost;
        let weight_sum = cell.weight + weight_added;
        cell.weight_lost = (weight_sum - cell.weight) - weight_added;
        cell.weight = weight_sum;
        cell.weight_squares += weights.y;
    }
    film[id.x] = cell;
}
