//! Numbers for a page's script in few characters: sixteen bits between the smallest and the largest one.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Steps between the smallest and the largest number; the code above them is 'none'.
const STEPS: f64 = 65534.0;
const NONE: u16 = u16::MAX;

/// `a + s * code`, codes little-endian in base64.
#[derive(Clone, Debug, Serialize)]
pub struct Packed {
    a: f64,
    s: f64,
    b: String,
}

impl Packed {
    /// Of numbers; those that are not finite are none.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            let none = STANDARD.encode(vec![0xff; 2 * values.len()]);
            return Packed { a: 0.0, s: 0.0, b: none };
        }
        let step = (high - low) / STEPS;
        let code = |x: &f64| match x.is_finite() {
            true if step > 0.0 => ((x - low) / step).round().clamp(0.0, STEPS) as u16,
            true => 0,
            false => NONE,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|x| code(x).to_le_bytes()).collect();
        Packed { a: low, s: step, b: STANDARD.encode(bytes) }
    }
}
