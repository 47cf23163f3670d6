//! Constants of the time step.

use crate::contact::ContactParams;
use crate::lcp::step::PyramidParams;
use crate::real::Real;

/// Inertia of the jaw's opening motion, kg.
pub const JAW_MASS_KG: f64 = 0.3;

/// See the module; units as the names say, otherwise dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepParams<R: Real> {
    /// Where bodies touch.
    pub contact: ContactParams<R>,
    /// Friction pyramids, where the model asks for them.
    pub pyramid: PyramidParams<R>,
    /// 0.3 kg: inertia of the jaw's opening motion, of the size of a small gripper's finger and drive. It
    /// only matters while the jaw accelerates. Doubled: the jaw closes on a shrinking object half as fast.
    pub jaw_mass_kg: R,
    /// 1 mm: points farther apart than this and what they approach each other by in the step are not
    /// handed to the solver. Doubled: a few more points, the same forces.
    pub near_m: R,
    /// 2 kN, ten times the range of the fingertip sensors: a body that presses harder contradicts another
    /// one; the springs that stand for rigid contact would be 0.2 mm deep. Doubled: a crushed object is
    /// said to be so a little later.
    pub max_force_n: R,
    /// 0.5 N: an answer that is not solved is followed up to this residual, ...
    pub unsolved_n: R,
    /// ... and 0.05 of the largest normal force of a body: within the error of fingertip sensors. An error of
    /// 0.5 N moves 0.2 kg by 40 um in a step of 4 ms, as much as motion capture errs. Doubled: errors
    /// of 80 um are followed.
    pub unsolved_share: R,
    /// 20 um: adhesion ends at this separation, some asperities' height. Doubled: a pad that lets go pulls
    /// over twice the way.
    pub adhesion_range_m: R,
    /// 0.49 (0.7 squared, 45 degrees): squared cosine between a pusher's plane and the vertical beyond
    /// which it is a platform, which has the support's friction, and between a rod's second tangent and the
    /// vertical beyond which the rod is upright. Doubled: only level planes are, and no rod.
    pub platform_cosine2: R,
    /// 1e-4: least ratio of the tangential stiffnesses of an elliptic cone (a hundredth in friction).
    /// Doubled: friction ratios below 1/70 lose the exact direction of maximum dissipation.
    pub min_stiffness_ratio: R,
    /// 0.9998: share of the squared friction bound from which a point counts as sliding; the rest is the
    /// rounding of `f32`. Nearer to 1, points that slide are taken for sticking.
    pub sliding_share2: R,
    /// (10 nm)^2: least slip in a step that counts. Doubled: slip below 3.5 um/s is not seen.
    pub min_slip_m2: R,
    /// 10 um: points nearer to the patch's centre tell no rotation about its normal. Doubled: no change,
    /// points lie at the centre or millimetres away.
    pub min_arm_m: R,
}

impl<R: Real> Default for StepParams<R> {
    fn default() -> Self {
        Self {
            contact: ContactParams::default(),
            pyramid: PyramidParams::default(),
            jaw_mass_kg: R::of(JAW_MASS_KG),
            near_m: R::of(1.0e-3),
            max_force_n: R::of(2.0e3),
            unsolved_n: R::of(0.5),
            unsolved_share: R::of(0.05),
            adhesion_range_m: R::of(2.0e-5),
            platform_cosine2: R::of(0.49),
            min_stiffness_ratio: R::of(1e-4),
            sliding_share2: R::of(0.9998),
            min_slip_m2: R::of(1e-16),
            min_arm_m: R::of(1e-5),
        }
    }
}
