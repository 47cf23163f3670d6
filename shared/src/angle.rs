//! Sine and cosine in single precision alone.
//!
//! `libm` computes those of `f32` in double precision, which a Cortex-M4F does in software: 9 KB of
//! flash and a hundred times the time. Here the argument is brought within an eighth of a turn by
//! quarter turns in three parts, of which the first two have few digits (Cody and Waite 1980),
//! and polynomials of the Cephes library (Moshier 1992) follow. The same operations in the same
//! order everywhere, so the same bits.

use core::f32::consts::{FRAC_2_PI, TAU};

/// Quarter turn in parts that multiply small integers without rounding.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// Arguments beyond this lose their whole turns first; their own rounding is 0.0005 there.
const LARGE: f32 = 8192.0;

/// Sine and cosine of `x`, rad, each within 2e-7 of the exact one up to 8,192 rad; NaN where `x`
/// is not finite.
pub fn sine_cosine(x: f32) -> (f32, f32) {
    let x = if x.abs() < LARGE { x } else { within_a_turn(x) };
    let turns = x * FRAC_2_PI;
    // The conversion saturates; NaN, which becomes zero, stays in `rest`.
    let count = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
    let k = count as f32;
    let [first, second, third] = QUARTER;
    let rest = ((x - k * first) - k * second) - k * third;
    let z = rest * rest;
    let sine = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * rest + rest;
    let cosine = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    match count & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// `x` less its whole turns, as far as `f32` knows them; zero where neighbouring numbers are more
/// than a turn apart.
fn within_a_turn(x: f32) -> f32 {
    let turns = x / TAU;
    if turns.abs() < 8_388_608.0 { x - turns as i32 as f32 * TAU } else { x * 0.0 }
}
