//! The shaders' own transcendental functions against the standard library's in float64.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
mod queries;

use queries::{Inputs, compare, on_lavapipe, relative, within};
use snell::cpu::{erf::*, exact::*, math::*};

#[test]
fn exponentials() {
    let queries = Inputs::new(1).queries(|inputs, q| {
        q.wo = [
            inputs.range(-86.0, 86.0),
            inputs.range(-1.0, 1.0) * inputs.log_range(1e-7, 30.0),
            inputs.log_range(1e-30, 1e30),
        ];
        q.wi = [
            match inputs.pick(2) {
                0 => inputs.log_range(1e-12, 1e12),
                _ => -inputs.log_range(1e-12, 0.999),
            },
            inputs.unit(),
            inputs.range(0.0, 6.0),
        ];
    });
    let gpu = on_lavapipe(
        "import package::math::{exp_accurate, expm1_accurate, log_accurate, log1p_accurate, pow_accurate};",
        "",
        &[
            "exp_accurate(q.wo.x)",
            "expm1_accurate(q.wo.y)",
            "log_accurate(q.wo.z)",
            "log1p_accurate(q.wi.x)",
            "pow_accurate(q.wi.y, q.wi.z)",
        ],
        &queries,
    );
    compare(
        "exponentials",
        &[
            relative("exp_accurate"),
            relative("expm1_accurate"),
            relative("log_accurate"),
            relative("log1p_accurate"),
            relative("pow_accurate"),
        ],
        &queries,
        &gpu,
        |q| {
            vec![
                exp_accurate(q.wo.x),
                expm1_accurate(q.wo.y),
                log_accurate(q.wo.z),
                log1p_accurate(q.wi.x),
                pow_accurate(q.wi.y, q.wi.z),
            ]
        },
        |_, _| true,
    );
}

#[test]
fn angles() {
    let queries = Inputs::new(2).queries(|inputs, q| {
        q.wo = [
            inputs.range(-1.0, 1.0) * inputs.log_range(1e-5, 100.0),
            inputs.range(-1.0, 1.0),
            inputs.range(-1.0, 1.0) * inputs.log_range(1e-6, 1.0),
        ];
    });
    let gpu = on_lavapipe(
        "import package::math::{sincos_accurate, atan2_accurate, acos_accurate, asin_accurate};",
        "let turn = sincos_accurate(q.wo.x);",
        &[
            "turn.x",
            "turn.y",
            "atan2_accurate(q.wo.z, q.wo.y)",
            "acos_accurate(q.wo.y)",
            "asin_accurate(q.wo.z)",
        ],
        &queries,
    );
    compare(
        "angles",
        &[
            // Near a zero other than 0 the argument's own last bit is as large as the value.
            within("sin", 1e-2),
            within("cos", 1e-2),
            relative("atan2_accurate"),
            relative("acos_accurate"),
            relative("asin_accurate"),
        ],
        &queries,
        &gpu,
        |q| {
            let turn = sincos_accurate(q.wo.x);
            vec![
                turn.x,
                turn.y,
                atan2_accurate(q.wo.z, q.wo.y),
                acos_accurate(q.wo.y),
                asin_accurate(q.wo.z),
            ]
        },
        |_, _| true,
    );
}

#[test]
fn error_functions() {
    let queries = Inputs::new(3).queries(|inputs, q| {
        q.wo = [
            inputs.range(-1.0, 1.0) * inputs.log_range(1e-6, 9.0),
            inputs.log_range(1e-6, 1e4),
            inputs.unit().max(3e-8),
        ];
    });
    let gpu = on_lavapipe(
        "import package::erf::{erf_accurate, erfc_accurate, erfcx_accurate, normal_quantile};",
        "",
        &[
            "erf_accurate(q.wo.x)",
            "erfc_accurate(q.wo.x)",
            "erfcx_accurate(q.wo.y)",
            "normal_quantile(q.wo.z)",
        ],
        &queries,
    );
    compare(
        "error functions",
        &[
            relative("erf_accurate"),
            relative("erfc_accurate"),
            relative("erfcx_accurate"),
            // Through 0 at u = 1/2, where u's last bit is 1e-7 of it.
            within("normal_quantile", 1e-2),
        ],
        &queries,
        &gpu,
        |q| {
            vec![
                erf_accurate(q.wo.x),
                erfc_accurate(q.wo.x),
                erfcx_accurate(q.wo.y),
                normal_quantile(q.wo.z),
            ]
        },
        |_, _| true,
    );
}

#[test]
fn exact_sums() {
    let queries = Inputs::new(4).queries(|inputs, q| {
        // Near a = sin of b's angle the four terms cancel nearly all.
        let c = inputs.unit();
        let a =
            (1.0 - c * c).sqrt() * (1.0 + inputs.range(-1.0, 1.0) * inputs.log_range(1e-6, 1.0));
        q.wo = [a, c, 0.0];
        q.wi = [inputs.range(-2.0, 2.0), inputs.range(-2.0, 2.0), 0.0];
        q.wi[2] =
            -q.wi[0] * q.wi[1] * (1.0 + inputs.range(-1.0, 1.0) * inputs.log_range(1e-5, 1.0));
    });
    let gpu = on_lavapipe(
        "import package::exact::{squares_minus_one, product_sum};",
        "",
        &[
            "squares_minus_one(q.wo.x, q.wo.y, 0.0)",
            "squares_minus_one(q.wi.x, q.wo.y, q.wi.y)",
            "product_sum(q.wi.x, q.wi.y, q.wi.z)",
        ],
        &queries,
    );
    compare(
        "exact sums",
        &[
            within("squares_minus_one", 1e-7),
            within("squares_minus_one, three", 1e-7),
            within("product_sum", 1e-9),
        ],
        &queries,
        &gpu,
        |q| {
            vec![
                squares_minus_one(q.wo.x, q.wo.y, 0.0),
                squares_minus_one(q.wi.x, q.wo.y, q.wi.y),
                product_sum(q.wi.x, q.wi.y, q.wi.z),
            ]
        },
        |_, _| true,
    );
}

/// The float64 side where the standard library has no such function, against printed values:
/// Abramowitz and Stegun 1964, tables 7.1 and 7.3 (15 decimals there), and inverses.
#[test]
fn error_functions_against_tables() {
    for (x, want) in [
        (0.1, 0.112_462_916_018_285),
        (0.5, 0.520_499_877_813_047),
        (1.0, 0.842_700_792_949_715),
        (2.0, 0.995_322_265_018_953),
        (-1.0, -0.842_700_792_949_715),
    ] {
        assert!((erf_accurate(x) - want).abs() < 2e-15, "erf({x})");
        assert!((erf_accurate(x) + erfc_accurate(x) - 1.0).abs() < 1e-15);
    }
    assert!((erfcx_accurate(10.0) - 0.056_140_992_743_822_6).abs() < 1e-16);
    for i in 1..1000 {
        let u = f64::from(i) / 1000.0;
        assert!((0.5 * erfc_accurate(-normal_quantile(u)) - u).abs() < 1e-15);
    }
}
