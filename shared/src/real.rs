//! The scalar of every computation: `f32` on the board, `f32` or `f64` on the host.
//!
//! All elementary functions go through `libm` (nalgebra's `libm-force`), so that the
//! same source gives the same bits on x86 and on a Cortex-M4F. `sqrt` is the one
//! exception in form, not in bits: IEEE 754 requires it to be correctly rounded.

use nalgebra::{RealField, UnitQuaternion, Vector3};

/// Three components, in the axes that the field's name says.
pub type Vec3<R> = Vector3<R>;
/// Unit quaternion, rotating local axes into the parent's.
pub type Rotation<R> = UnitQuaternion<R>;

/// A scalar for which every operation is the same on every platform.
pub trait Real:
    RealField + Copy + Default + serde::Serialize + serde::de::DeserializeOwned + 'static
{
    /// Relative rounding error (distance from 1 to the next number).
    const EPSILON: Self;
    /// The nearest representable number.
    fn of(x: f64) -> Self;
    /// Widened without loss.
    fn to_f64(self) -> f64;
    /// The bit pattern, with every NaN mapped to one (platforms differ in NaN signs).
    fn canonical_bits(self) -> u64;
    /// `true` for neither NaN nor an infinity.
    fn finite(self) -> bool;
    /// Sine and cosine of an angle in rad, of `f32` without double precision.
    fn sine_cosine(self) -> (Self, Self);
    /// Square root, correctly rounded: the same bits everywhere; one instruction on an FPU.
    fn square_root(self) -> Self;
}

impl Real for f32 {
    const EPSILON: Self = f32::EPSILON;
    fn of(x: f64) -> Self {
        x as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn canonical_bits(self) -> u64 {
        if self.is_nan() { 0x7fc0_0000 } else { u64::from(self.to_bits()) }
    }
    fn finite(self) -> bool {
        f32::is_finite(self)
    }
    #[inline(always)]
    fn square_root(self) -> Self {
        stickslip_sqrt::sqrtf(self)
    }
    fn sine_cosine(self) -> (Self, Self) {
        crate::angle::sine_cosine(self)
    }
}

impl Real for f64 {
    const EPSILON: Self = f64::EPSILON;
    fn of(x: f64) -> Self {
        x
    }
    fn to_f64(self) -> f64 {
        self
    }
    fn canonical_bits(self) -> u64 {
        if self.is_nan() { 0x7ff8_0000_0000_0000 } else { self.to_bits() }
    }
    fn finite(self) -> bool {
        f64::is_finite(self)
    }
    fn square_root(self) -> Self {
        libm::sqrt(self)
    }
    fn sine_cosine(self) -> (Self, Self) {
        libm::sincos(self)
    }
}

/// Square root, correctly rounded: the same bits everywhere; one instruction on an FPU, unlike
/// the one of [`RealField`].
#[inline(always)]
pub fn sqrt<R: Real>(x: R) -> R {
    x.square_root()
}

/// Length of a vector by [`sqrt`]: nalgebra's `norm` has the same bits, from a square root in software.
#[inline(always)]
pub fn norm<R: Real>(v: &Vec3<R>) -> R {
    sqrt(v.norm_squared())
}

/// Magnitude; NaN stays NaN.
#[inline(always)]
pub fn abs<R: Real>(x: R) -> R {
    if x < R::zero() { -x } else { x }
}

/// Smaller of two; the second where the first is NaN.
#[inline(always)]
pub fn min<R: Real>(a: R, b: R) -> R {
    if a < b { a } else { b }
}

/// Larger of two; the second where the first is NaN.
#[inline(always)]
pub fn max<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

/// `x` limited to `[low, high]`; `low` where `x` is NaN.
#[inline(always)]
pub fn clamp<R: Real>(x: R, low: R, high: R) -> R {
    min(max(x, low), high)
}
