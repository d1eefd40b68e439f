//! The comparison of pictures: its tails are right, it says no as rarely as it promises, and it sees
//! what it should.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use snell::compare::map::write_maps;
use snell::compare::statistics::{p_value_student, sidak};
use snell::compare::{relative_within, z_test};
use snell::film::Film;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A small generator of random numbers (Steele, Lea, Flood 2014, "SplitMix64"), uniform in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A noisy film: pixel i has mean i + 1 times `scale`. `tail` 0 is a uniform distribution; else a
/// skewed one, where a share 1 / tail of the samples carries all of the radiance.
fn noisy(random: &mut Random, samples: u32, scale: f64, tail: f64) -> Film {
    let mut film = Film::new(24, 16);
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        let mean = (i + 1) as f64 * scale;
        for _ in 0..samples {
            let mut draw = || {
                let u = random.next();
                if tail == 0.0 {
                    2.0 * mean * u
                } else {
                    f64::from(u8::from(u * tail < 1.0)) * tail * mean
                }
            };
            pixel.add([draw(), draw(), draw()], 1.0);
        }
    }
    film
}

#[test]
fn student_tail_agrees_with_statrs() {
    for freedom in [1.0, 2.0, 5.0, 30.0, 126.0, 2046.0, 1e6] {
        let reference = StudentsT::new(0.0, 1.0, freedom).unwrap();
        for t in [0.0, 1e-3, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0] {
            let expected = 2.0 * reference.cdf(-t);
            let got = p_value_student(t, freedom);
            assert!(
                (got - expected).abs() <= 1e-8 * expected,
                "t {t} freedom {freedom}: {got} {expected}"
            );
            assert_eq!(got, p_value_student(-t, freedom));
        }
    }
    // Cauchy in closed form, and the normal distribution's 5 % point.
    assert!((p_value_student(1.0, 1.0) - 0.5).abs() < 1e-11);
    assert!((p_value_student(1.959_963_984_540_054, 1e6) - 0.05).abs() < 1e-6);
}

#[test]
fn sidak_keeps_the_family_level() {
    for n in [1usize, 10, 3 * 1024 * 768] {
        let each = sidak(0.01, n);
        let family = -(n as f64 * (-each).ln_1p()).exp_m1();
        assert!((family - 0.01).abs() < 1e-12, "{n} {family}");
    }
}

/// Runs the test many times on pairs that are the same and counts how often it says no.
fn false_alarms(samples: [u32; 2], tail: f64, runs: usize) -> usize {
    let mut random = Random(7);
    (0..runs)
        .filter(|_| {
            let a = noisy(&mut random, samples[0], 1.0, tail);
            let b = noisy(&mut random, samples[1], 1.0, tail);
            !z_test(&a, &b, ALPHA).same
        })
        .count()
}

const ALPHA: f64 = 0.05;

#[test]
fn z_test_says_no_as_rarely_as_it_promises() {
    // 200 runs at 5 %: 10 expected, and more than 21 has a chance of 4e-4 (binomial).
    const RUNS: usize = 200;
    const MOST: usize = 21;
    for (samples, tail) in [([16, 16], 0.0), ([8, 64], 0.0), ([64, 64], 8.0)] {
        let alarms = false_alarms(samples, tail, RUNS);
        assert!(alarms <= MOST, "{samples:?} {tail}: {alarms} of {RUNS}");
    }
}

#[test]
fn z_test_is_not_fooled_by_rare_bright_samples() {
    // One in 400 samples carries everything; most pixels of 64 samples see none and have no variance.
    let alarms = false_alarms([64, 64], 400.0, 100);
    assert!(alarms <= 12, "{alarms} of 100");
}

#[test]
fn z_test_sees_a_bias_of_the_whole_picture() {
    // 256 uniform samples have a standard error of 3.6 % a pixel; 384 pixels bring it to 0.18 %, what neighbours
    // may share of it to 0.28 %.
    let mut random = Random(11);
    let a = noisy(&mut random, 256, 1.0, 0.0);
    let b = noisy(&mut random, 256, 1.02, 0.0);
    let verdict = z_test(&a, &b, 0.01);
    assert!(!verdict.same && verdict.rejected == 0, "{verdict:?}");
}

#[test]
fn z_test_sees_one_wrong_pixel_and_names_it() {
    let mut random = Random(13);
    let a = noisy(&mut random, 256, 1.0, 0.0);
    let mut b = noisy(&mut random, 256, 1.0, 0.0);
    let wrong = b.pixel_mut(5, 3);
    wrong.sum = wrong.sum.map(|s| s * 1.4);
    wrong.spread = wrong.spread.map(|s| s * 1.96);
    let verdict = z_test(&a, &b, 0.01);
    assert!(!verdict.same);
    assert_eq!(verdict.rejected, 1);
    assert_eq!((verdict.worst[0].x, verdict.worst[0].y), (5, 3));
    assert!(verdict.p_pixel < verdict.alpha_pixel);
}

#[test]
fn z_test_sees_another_variance_at_the_same_mean() {
    let mut random = Random(17);
    let a = noisy(&mut random, 64, 1.0, 0.0);
    let mut b = noisy(&mut random, 64, 1.0, 0.0);
    for pixel in &mut b.pixels {
        pixel.spread = pixel.spread.map(|s| s * 1.2);
    }
    let verdict = z_test(&a, &b, 0.01);
    assert!(!verdict.same);
    assert!(verdict.p_mean.iter().all(|&p| p >= verdict.alpha_average));
    assert!(
        verdict
            .p_variance
            .iter()
            .all(|&p| p < verdict.alpha_average)
    );
}

#[test]
fn equal_films_are_the_same_and_constant_ones_differ_exactly() {
    let a = noisy(&mut Random(19), 4, 1.0, 0.0);
    assert!(z_test(&a, &a, 0.5).same);
    let mut one = Film::new(2, 2);
    let mut two = Film::new(2, 2);
    for i in 0..4 {
        for _ in 0..2 {
            one.pixels[i].add([1.0; 3], 1.0);
            two.pixels[i].add([if i == 2 { 1.001 } else { 1.0 }; 3], 1.0);
        }
    }
    let verdict = z_test(&one, &two, 0.01);
    assert_eq!((verdict.same, verdict.rejected), (false, 1));
}

#[test]
fn relative_within_counts_pixels_and_knows_the_floor() {
    let mut a = Film::new(5, 1);
    let mut b = Film::new(5, 1);
    let pairs = [
        ([1.0; 3], [1.0; 3]),
        ([1.0; 3], [1.0, 1.0009, 1.0]),
        ([1.0; 3], [1.0, 1.0, 1.01]),
        ([1e-9, 0.0, 0.0], [2e-9, 0.0, 0.0]),
        ([1.0; 3], [f64::NAN; 3]),
    ];
    for (i, (x, y)) in pairs.into_iter().enumerate() {
        a.pixels[i].add(x, 1.0);
        b.pixels[i].add(y, 1.0);
    }
    let within = relative_within(&a, &b, 1e-3, 1e-4);
    assert_eq!(within.fraction, 3.0 / 5.0);
    assert_eq!(
        within.worst.iter().map(|w| w.x).collect::<Vec<_>>(),
        [4, 2],
        "worst first"
    );
    let strict = relative_within(&a, &b, 1e-3, 0.0);
    assert_eq!(
        strict.fraction,
        2.0 / 5.0,
        "without a floor the dark pixel counts"
    );
}

#[test]
fn maps_show_which_side_is_brighter() {
    let folder = tempfile::tempdir().unwrap();
    let mut a = Film::new(3, 1);
    let mut b = Film::new(3, 1);
    for (i, (x, y)) in [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)].into_iter().enumerate() {
        a.pixels[i].add([x; 3], 1.0);
        b.pixels[i].add([y; 3], 1.0);
    }
    write_maps(folder.path(), "case", &a, &b).unwrap();
    let map = image::open(folder.path().join("case-error.png"))
        .unwrap()
        .to_rgb8();
    let pixel = |x| map.get_pixel(x, 0).0;
    assert_eq!(pixel(0), [0; 3]);
    assert!(pixel(1)[0] > 100 && pixel(1)[2] == 0);
    assert!(pixel(2)[2] > 100 && pixel(2)[0] == 0);
    assert!(folder.path().join("case-a.png").exists());
}
