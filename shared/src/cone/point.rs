//! The contact law at one point: its force at a relative velocity, and what it does there.

use crate::real::{Real, max, sqrt};
use crate::solve::{Answer, Before};

/// What friction does at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Friction {
    None,
    Stick,
    Slip,
}

/// A point in the axes of its patch, and its answer to the last velocity it was shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<R> {
    pub(super) at: [R; 3],
    pub(super) bias: [R; 3],
    pub(super) normal_stiffness: R,
    pub(super) stiffness: [R; 2],
    pub(super) mu: [R; 2],
    pub(super) adhesion: R,
    /// `c / (k + c)`: share of friction that goes on as if stuck, with a viscosity `c`.
    pub(super) viscous: R,
    /// `k / mu` along the tangents; zero without friction.
    pub(super) gain: [R; 2],
    /// `mu_1 / mu_2` and `mu_2 / mu_1`: turn a direction of friction across.
    pub(super) across: [R; 2],
    /// `k_1 / mu_1^2`.
    pub(super) weight: R,
    /// Largest force of the bias alone along the normal, and along the tangents.
    pub(super) bias_force: [R; 2],
    /// -1 where the second tangent was turned round to make the axes right-handed.
    pub(super) side: R,
    /// What is expected of it, and the normal force of then.
    pub(super) expected: (bool, Friction),
    pub(super) load: R,
    pub(super) touching: bool,
    pub(super) friction: Friction,
    /// Force of friction per bound, and bound over the unbounded force, while slipping.
    pub(super) q: [R; 2],
    pub(super) s: R,
    /// Relative velocity along the tangents, with the bias.
    pub(super) slip: [R; 2],
    /// Force along the axes.
    pub(super) force: [R; 3],
}

impl<R: Real> Local<R> {
    /// Before a point is placed.
    pub(super) fn nothing() -> Self {
        let zero = R::zero();
        Self {
            at: [zero; 3],
            bias: [zero; 3],
            normal_stiffness: zero,
            stiffness: [zero; 2],
            mu: [zero; 2],
            adhesion: zero,
            viscous: zero,
            gain: [zero; 2],
            across: [zero; 2],
            weight: zero,
            bias_force: [zero; 2],
            side: zero,
            expected: (false, Friction::None),
            load: zero,
            touching: false,
            friction: Friction::None,
            q: [zero; 2],
            s: zero,
            slip: [zero; 2],
            force: [zero; 3],
        }
    }

    /// The point's answer along the axes as they were given.
    #[inline(always)]
    pub(super) fn given(&self) -> Answer<R> {
        Answer {
            force_n: [self.force[0], self.force[1], self.force[2] * self.side],
            biased_slip_m_s: [self.slip[0], self.slip[1] * self.side],
            stiffness_n_s_m: self.stiffness,
            mu: self.raised_mu(),
            adhesion_n: self.adhesion,
        }
    }
}

impl<R: Real> Local<R> {
    /// The coefficients, with the rise that viscosity gives them at the slip speed found.
    #[inline(always)]
    fn raised_mu(&self) -> [R; 2] {
        if !(self.viscous > R::zero() && self.friction == Friction::Slip) {
            return self.mu;
        }
        let rest = R::one() - self.viscous;
        let raised = rest + self.viscous / (self.s * rest);
        self.mu.map(|mu| mu * raised)
    }

    /// Slip with viscosity. The force `f` over the slip speed `v` is `mu N + c v`, and the point's
    /// spring and damper take the rest of the relative velocity, `v = |u| - f / k`: so
    /// `f = (1 - b) mu N + b k |u|` with `b = c / (k + c)`, a mixture of the bounded and the
    /// unbounded force, implicit in the speed and hence stable at any step.
    #[inline(always)]
    fn add_viscosity(&mut self, bound: R, y: [R; 2]) {
        if !(self.viscous > R::zero()) {
            return;
        }
        let rest = R::one() - self.viscous;
        self.q = self.q.map(|q| q * rest);
        // The part across the slip goes with `s q^2`.
        self.s /= rest;
        for k in 0..2 {
            self.force[k + 1] = bound * self.q[k] + self.viscous * self.mu[k] * y[k];
        }
    }

    /// What bounds friction.
    pub(super) fn bound(&self) -> R {
        max(self.force[0] + self.adhesion, R::zero())
    }

    /// Expects the point to do what it did before: the answer that [`Local::as_expected`] goes by.
    #[inline(always)]
    pub(super) fn expect(&mut self, before: Before<R>) {
        let rubs = self.gain[0] > R::zero();
        (self.expected, self.load) = match before {
            Before::Open => ((false, Friction::None), R::zero()),
            Before::Stuck { load_n } if rubs => ((true, Friction::Stick), load_n),
            Before::Slid { load_n } if rubs => ((true, Friction::Slip), load_n),
            Before::Stuck { load_n } | Before::Slid { load_n } => ((true, Friction::None), load_n),
        };
    }

    /// Whether it touches, or does not, as expected.
    pub(super) fn touches_as_before(&self) -> bool {
        self.touching == self.expected.0
    }

    /// Force at relative velocity `u` in the mode that is expected, whether it holds there or not:
    /// linear in `u` but for the direction of slip.
    #[inline(always)]
    pub(super) fn as_expected(&mut self, u: [R; 3]) {
        let zero = R::zero();
        (self.touching, self.friction) = self.expected;
        let normal = if self.touching { -self.normal_stiffness * u[0] } else { -self.adhesion };
        self.force = [normal, zero, zero];
        let y1 = -self.gain[0] * u[1];
        let y2 = -self.gain[1] * u[2];
        match self.friction {
            Friction::None => {}
            Friction::Stick => self.force = [normal, self.mu[0] * y1, self.mu[1] * y2],
            Friction::Slip => {
                let inverse = R::one() / max(sqrt(y1 * y1 + y2 * y2), R::of(1e-12));
                self.q = [self.mu[0] * y1 * inverse, self.mu[1] * y2 * inverse];
                self.s = (self.load + self.adhesion) * inverse;
                let bound = normal + self.adhesion;
                self.force = [normal, bound * self.q[0], bound * self.q[1]];
                self.add_viscosity(bound, [y1, y2]);
            }
        }
    }

    /// The contact law: force at relative velocity `u`.
    #[inline(always)]
    pub(super) fn answer(&mut self, u: [R; 3], frozen: Option<R>) {
        let zero = R::zero();
        let pressed = -self.normal_stiffness * u[0];
        self.touching = pressed > -self.adhesion;
        let normal = if self.touching { pressed } else { -self.adhesion };
        let bound = match frozen {
            Some(given) => given,
            None => normal + self.adhesion,
        };
        self.friction = Friction::None;
        self.slip = [u[1], u[2]];
        self.force = [normal, zero, zero];
        if !(bound > zero && self.gain[0] > zero) {
            return;
        }
        // In tangents scaled by mu the cone is a disc of radius `bound`.
        let y1 = -self.gain[0] * u[1];
        let y2 = -self.gain[1] * u[2];
        let square = y1 * y1 + y2 * y2;
        if square <= bound * bound {
            self.friction = Friction::Stick;
            self.force = [normal, self.mu[0] * y1, self.mu[1] * y2];
            return;
        }
        let inverse = R::one() / sqrt(square);
        self.friction = Friction::Slip;
        self.q = [self.mu[0] * y1 * inverse, self.mu[1] * y2 * inverse];
        self.s = bound * inverse;
        self.force = [normal, bound * self.q[0], bound * self.q[1]];
        self.add_viscosity(bound, [y1, y2]);
    }
}

/// A number for what all points do.
pub(super) fn modes<R: Real>(points: &[Local<R>]) -> u32 {
    points.iter().fold(points.len() as u32, |code, p| {
        let mode = (p.friction as u32) << 1 | u32::from(p.touching);
        code.wrapping_mul(0x0100_0193) ^ mode
    })
}
