// "Average the samples": adds each pixel's samples of this dispatch to the tile's film, one after
// another in the order of their numbers, so that how samples are split into dispatches changes no bit.

import package::bindings::{frame};
import package::kernels::state::{paths, counters, plane, COUNTER_CLAMPED, PLANE_RADIANCE, WORKGROUP};
import package::kernels::slots::{pixel_slot, tile_slots};
import package::estimator::{is_finite, clamp_radiance};

// The sum of radiance and alpha, what rounding took from it, the sum of squares, and counts. The
// host reads it as it stands (src/gpu/render.rs).
struct FilmCell {
    sum: vec4<f32>,
    lost: vec4<f32>,
    squares: vec3<f32>,
    non_finite: u32,
}

@group(1) @binding(2) var<storage, read_write> film: array<FilmCell>;

@compute @workgroup_size(WORKGROUP)
fn accumulate_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile_slots() {
        return;
    }
    let first = pixel_slot(vec2(id.x % frame.tile_size.x, id.x / frame.tile_size.x));
    var cell = film[id.x];
    for (var sample = 0u; sample < frame.sample_count; sample++) {
        var L = bitcast<vec4<f32>>(paths[plane(PLANE_RADIANCE, first + sample * tile_slots())]);
        if !(is_finite(L.x) && is_finite(L.y) && is_finite(L.z)) {
            cell.non_finite += 1u;
            continue;
        }
        let clamped = clamp_radiance(L.xyz, frame.clamp);
        if any(clamped != L.xyz) {
            atomicAdd(&counters[COUNTER_CLAMPED], 1u);
        }
        L = vec4(clamped, L.w);
        // Kahan 1965, "Pracniques: further remarks on reducing truncation errors": `lost` is what
        // the last addition dropped, added to the next one.
        let added = L - cell.lost;
        let sum = cell.sum + added;
        cell.lost = (sum - cell.sum) - added;
        cell.sum = sum;
        cell.squares += L.xyz * L.xyz;
    }
    film[id.x] = cell;
}
