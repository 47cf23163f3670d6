//! The grip follows late and loses force while the object slides.
//!
//! With `v` the mean slip speed of the fingers and `d` the distance that they slipped so far:
//!
//! ```text
//! N = N_late (1 - l),   time dl/dt = drop v^s / (v^s + knee^s) + drop_1_m d - l
//! time dN_late/dt = N_command - N_late
//! ```
//!
//! A force-controlled gripper of finite bandwidth on an object whose width changes as it
//! slides. The sharpness s tells whether it loses force the more the faster the object slides (1),
//! or all of it once it slides (Hill's curve). What goes with the speed comes back at rest; what goes with
//! the distance (a jaw that backs off and is not driven again) stays lost. Integrated implicitly: stable at any step. It remembers the loss `l`, the error
//! `N_late - N_command` and the last command.

use super::law::{Law, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// Least knee, m/s.
const LEAST_KNEE_M_S: f64 = 1e-5;

/// Slower than this nothing slides, m/s.
const LEAST_SPEED_M_S: f64 = 1e-9;

/// See the module.
pub struct GripForceLag;

/// Description.
pub const INFO: Info = Info {
    id: "grip_force_lag",
    code: 16,
    summary: "grip lags its command and falls while the object slides",
    signature: "normal finger force that sags while sliding and recovers at rest or stays low, or trails a change of command",
    on_robot: "while the object slides or the command changes, less grip acts than was commanded: a slip that begins feeds itself",
    source: "first-order force control; Whitney 1977",
    role: Role::Plain,
    parameters: &[
        Parameter::new("drop", "1", 0.12, 0.0, [-0.5, 0.9], "share of the grip lost in steady sliding"),
        Parameter::new("time_s", "s", 0.1, 0.0, [0.0, 5.0], "time constant"),
        Parameter::new(
            "knee_m_s",
            "m/s",
            1e-3,
            1e-3,
            [1e-4, 0.5],
            "slip speed at which half of the drop is reached",
        )
        // Far above the speeds of a slide the drop goes in proportion to them.
        .tried_at(&[1e-3, 3e-2]),
        Parameter::new(
            "sharpness",
            "1",
            1.0,
            1.0,
            [1.0, 8.0],
            "exponent of the speed: gradual (1) or a threshold (8)",
        )
        .tried_at(&[1.0, 4.0]),
        Parameter::new(
            "drop_1_m",
            "1/m",
            5.0,
            0.0,
            [-60.0, 60.0],
            "share of the grip lost for each metre of slip, also at rest",
        )
        .added(0.0),
    ],
};

impl<R: Real> Law<R> for GripForceLag {
    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        let half = R::of(0.5);
        let [loss, error, last, _] = *memory;
        let speed = (c.slip_speed_m_s[0] + c.slip_speed_m_s[1]) * half;
        let keep = max(p[1], R::zero());
        let keep = keep / (keep + c.dt_s);
        let ratio = max(p[2], R::of(LEAST_KNEE_M_S)) / max(speed, R::of(LEAST_SPEED_M_S));
        let distance_m = (c.slip_m[0] + c.slip_m[1]) * half;
        let target = p[0] / (R::one() + (ratio.ln() * max(p[3], R::one())).exp()) + p[4] * distance_m;
        let loss = target + (loss - target) * keep;
        // The first command is met from the start.
        let step = if last > R::zero() { *grip_n - last } else { R::zero() };
        let error = (error - step) * keep;
        *memory = [loss, error, *grip_n, R::zero()];
        *grip_n = (*grip_n + error) * max(R::one() - loss, R::zero());
    }
}
