//! Sums and differences of products that keep their last bits where they cancel.

use glam::{DVec2, DVec3};

/// Where `squares_minus_one` cuts.
const FIXED_ONE: f64 = 16_777_216.0;

/// a * b as (rounded product, its rounding error).
pub fn two_product(a: f64, b: f64) -> DVec2 {
    let p = a * b;
    DVec2::new(p, a.mul_add(b, -p))
}

/// a * b + c, rounded about once: where product and c cancel, their difference is exact.
pub fn product_sum(a: f64, b: f64, c: f64) -> f64 {
    let p = two_product(a, b);
    (p.x + c) + p.y
}

/// a^2 + b^2 - c^2 - 1 to 1e-15 of itself, or to 1e-19 where it cancels to less.
pub fn squares_minus_one(a: f64, b: f64, c: f64) -> f64 {
    let aa = two_product(a, a);
    let bb = two_product(b, b);
    let cc = two_product(c, c);
    // Cut at a fixed place, the high parts sum exactly and the low parts to very little.
    let squares = DVec3::new(aa.x, bb.x, cc.x);
    let high = (squares * FIXED_ONE).floor() / FIXED_ONE;
    let low = squares - high;
    let low_sum = (low.x + low.y - low.z) + (aa.y + bb.y - cc.y);
    (high.x - 1.0 + high.y - high.z) + low_sum
}
