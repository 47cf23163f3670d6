//! Sine and cosine in single precision.

use stickslip_shared::angle::sine_cosine;

#[test]
fn sine_and_cosine_are_those_of_double_precision_to_two_tenths_of_a_millionth() {
    for k in -200_000..200_000 {
        let x = k as f32 * 0.037;
        let (sine, cosine) = sine_cosine(x);
        let (s, c) = libm::sincos(f64::from(x));
        assert!((f64::from(sine) - s).abs() < 2e-7, "{x}: {sine} {s}");
        assert!((f64::from(cosine) - c).abs() < 2e-7, "{x}: {cosine} {c}");
    }
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(sine_cosine(x).0.is_nan() && sine_cosine(x).1.is_nan());
    }
    for x in [1e4, -3e6, 4.7e7, 1e30] {
        let (sine, cosine) = sine_cosine(x);
        assert!((sine * sine + cosine * cosine - 1.0).abs() < 1e-6, "{x}: {sine} {cosine}");
    }
}
