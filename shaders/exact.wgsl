// Sums and differences of products that keep their last bits where they cancel.

// Where squares_minus_one cuts: 16 bits before the point, 16 behind.
const FIXED_ONE: f32 = 65536.0;

// shader only: float64 has a fused multiply-add that gives the rounding error at once.
fn high_half(a: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a) & 0xfffff000u);
}

// a * b as (rounded product, its rounding error).
fn two_product(a: f32, b: f32) -> vec2<f32> {
    // Dekker 1971, "A Floating-Point Technique for Extending the Available Precision"; the halves are
    // cut by bits, so that all partial products are exact and contraction to fma changes nothing.
    let p = a * b;
    let ah = high_half(a);
    let bh = high_half(b);
    let al = a - ah;
    let bl = b - bh;
    return vec2(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl);
}

// a * b + c, rounded about once: where product and c cancel, their difference is exact.
fn product_sum(a: f32, b: f32, c: f32) -> f32 {
    let p = two_product(a, b);
    return (p.x + c) + p.y;
}

// a^2 + b^2 - c^2 - 1 to 1e-7 of itself, or to 1e-11 where it cancels to less.
fn squares_minus_one(a: f32, b: f32, c: f32) -> f32 {
    let aa = two_product(a, a);
    let bb = two_product(b, b);
    let cc = two_product(c, c);
    // Cut at a fixed place, the high parts sum exactly and the low parts to very little. Knuth's exact
    // sum is no help here: drivers simplify (a + b) - a to b.
    let squares = vec3(aa.x, bb.x, cc.x);
    let high = floor(squares * FIXED_ONE) / FIXED_ONE;
    let low = squares - high;
    let low_sum = (low.x + low.y - low.z) + (aa.y + bb.y - cc.y);
    return (high.x - 1.0 + high.y - high.z) + low_sum;
}
