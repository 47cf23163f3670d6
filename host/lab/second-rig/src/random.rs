//! Random numbers: everything follows from a seed and the name of what is drawn.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A stream of its own for each name.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    // FNV-1a.
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(hash);
    rng
}

/// Uniform.
pub fn uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    if high > low { rng.random_range(low..high) } else { low }
}

/// Uniform in the logarithm.
pub fn log_uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    uniform(rng, low.ln(), high.ln()).exp()
}

/// Standard normal.
pub fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// With probability `p`.
pub fn chance(rng: &mut impl Rng, p: f64) -> bool {
    rng.random_bool(p)
}

/// 1 or -1.
pub fn sign(rng: &mut impl Rng) -> f64 {
    if chance(rng, 0.5) { 1.0 } else { -1.0 }
}

/// One of a list that is not empty.
pub fn pick<T: Clone>(rng: &mut impl Rng, from: &[T]) -> T {
    from[rng.random_range(0..from.len())].clone()
}
