//! The scalar of every computation: `f32` on the board, `f32` or `f64` on the host.
//!
//! All elementary functions go through `libm` (nalgebra's `libm-force`), so that the
//! same source gives the same bits on x86 and on a Cortex-M4F. `sqrt` is the one
//! exception in form, not in bits: IEEE 754 requires it to be correctly rounded.

use crate::cone::ConeOptions;
use crate::contact::{Contacts, SLOTS, find};
use crate::effects::Law;
use crate::model::{Model, Scene};
use crate::step::{Drive, State, StepSummary, Workspace, step_in};
use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3};

/// Three components, in the axes that the field's name says.
pub type Vec3<R> = Vector3<R>;
/// 3 x 3, row by column.
pub type Mat3<R> = Matrix3<R>;
/// Unit quaternion, rotating local axes into the parent's.
pub type Rotation<R> = UnitQuaternion<R>;

/// Length of a vector by [`Real::root`]: nalgebra's `norm` has the same bits, from a square root in
/// software.
pub trait Length<R> {
    /// Square root of the sum of squares.
    fn length(&self) -> R;
}

impl<R: Real> Length<R> for Vec3<R> {
    #[inline(never)]
    fn length(&self) -> R {
        self.norm_squared().root()
    }
}

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
    fn root(self) -> Self;
    /// [`crate::step::step_in`] with room for any scene. Generic code is compiled, and optimised,
    /// with the program that uses it; this is compiled here, whatever the program is optimised for.
    fn step(
        scene: &Scene<Self>,
        model: &Model<Self>,
        state: &mut State<Self, SLOTS>,
        drive: &Drive<Self>,
        options: &ConeOptions<Self>,
        work: &mut Workspace<Self, SLOTS>,
    ) -> StepSummary<Self>;
    /// [`crate::contact::find`] likewise.
    fn find_contacts(
        scene: &Scene<Self>,
        model: &Model<Self>,
        state: &State<Self, SLOTS>,
        drive: &Drive<Self>,
        out: &mut Contacts<Self, SLOTS>,
    ) -> usize;
    /// [`crate::effects::law`] likewise: a second copy of every effect would take 5 KB.
    fn law(code: u8) -> Option<&'static dyn Law<Self>>;
}

/// The same for both precisions, but no default: a default is compiled with the program that uses it.
macro_rules! contact_code {
    () => {
        fn step(
            scene: &Scene<Self>,
            model: &Model<Self>,
            state: &mut State<Self, SLOTS>,
            drive: &Drive<Self>,
            options: &ConeOptions<Self>,
            work: &mut Workspace<Self, SLOTS>,
        ) -> StepSummary<Self> {
            step_in(scene, model, state, drive, options, work)
        }
        fn find_contacts(
            scene: &Scene<Self>,
            model: &Model<Self>,
            state: &State<Self, SLOTS>,
            drive: &Drive<Self>,
            out: &mut Contacts<Self, SLOTS>,
        ) -> usize {
            find(scene, model, state, drive, out)
        }
        fn law(code: u8) -> Option<&'static dyn Law<Self>> {
            crate::effects::law(code)
        }
    };
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
    fn root(self) -> Self {
        stickslip_root::sqrtf(self)
    }
    fn sine_cosine(self) -> (Self, Self) {
        crate::angle::sine_cosine(self)
    }
    contact_code!();
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
    fn root(self) -> Self {
        libm::sqrt(self)
    }
    fn sine_cosine(self) -> (Self, Self) {
        libm::sincos(self)
    }
    contact_code!();
}

/// Smaller of two; the second where the first is NaN.
pub fn least<R: Real>(a: R, b: R) -> R {
    if a < b { a } else { b }
}

/// Larger of two; the second where the first is NaN.
pub fn most<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

/// `x` limited to `[low, high]`; `low` where `x` is NaN.
pub fn clamp<R: Real>(x: R, low: R, high: R) -> R {
    least(most(x, low), high)
}
