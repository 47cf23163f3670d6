//! The grip follows late and loses force while the object slides.
//!
//! With `v` the mean slip speed of the fingers:
//!
//! ```text
//! N = N_late (1 - l),   time dl/dt = drop v / (v + knee) - l
//! time dN_late/dt = N_command - N_late
//! ```
//!
//! A force-controlled gripper of finite bandwidth on an object whose width changes as it
//! slides. Integrated implicitly: stable at any step. It remembers the loss `l`, the error
//! `N_late - N_command` and the last command.

use super::{Info, Law, MAX_PARAMETERS, MEMORY, Parameter, StepContext, text};
use crate::real::{Real, most};

/// Least knee, m/s.
const LEAST_KNEE_M_S: f64 = 1e-5;

/// See the module.
pub struct GripForceLag;

/// Description.
pub const INFO: Info = Info {
    id: "grip_force_lag",
    code: 16,
    summary: text("grip lags its command and falls while the object slides"),
    signature: text(
        "normal finger force that sags after the onset of sliding and recovers at rest, or trails a change of command",
    ),
    source: text("first-order force control; Whitney 1977"),
    parameters: &[
        Parameter::new("drop", "1", 0.12, 0.0, [-0.5, 0.9], "share of the grip lost in steady sliding"),
        Parameter::new("time_s", "s", 0.1, 0.0, [0.0, 5.0], "time constant"),
        Parameter::new(
            "knee_m_s",
            "m/s",
            1e-3,
            1e-3,
            [1e-4, 1e-2],
            "slip speed at which half of the drop is reached",
        ),
    ],
};

impl<R: Real> Law<R> for GripForceLag {
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        let half = R::of(0.5);
        let [loss, error, last] = *memory;
        let speed = (c.slip_speed_m_s[0] + c.slip_speed_m_s[1]) * half;
        let keep = most(p[1], R::zero());
        let keep = keep / (keep + c.dt_s);
        let target = p[0] * speed / (speed + most(p[2], R::of(LEAST_KNEE_M_S)));
        let loss = target + (loss - target) * keep;
        // The first command is met from the start.
        let step = if last > R::zero() { *grip_n - last } else { R::zero() };
        let error = (error - step) * keep;
        *memory = [loss, error, *grip_n];
        *grip_n = (*grip_n + error) * (R::one() - loss);
    }
}
