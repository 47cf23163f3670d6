//! The user's own effect, given as a formula and tried without compiling.
//!
//! The host's parser makes a [`Program`] of an expression in `model.toml`; the board runs the same
//! program, once for each contact point (friction) or once a step (grip, added force). Comparisons
//! give 1 or 0. A second expression may give the formula a memory, one number: it is evaluated once
//! a step, before the first, from what the last step left, and its value is what both read as
//! `state` from then on (a low-pass: `state + (load_n - state)*dt_s/0.1`).
//!
//! Where an expression has no value the formula gives NaN, which the time step refuses as
//! `BadInput`, and [`Formula::fault`] says why: a broken formula cannot pass for physics.

use super::law::{FrictionLaw, Law, Loads, Slip, StepContext};
use crate::contact::Body;
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::Real;

pub use crate::formula::{Formula, Target};
pub use crate::program::{
    FORMULA_PARAMETERS, Fault, FormulaError, MAX_OPS, MAX_STACK, Op, Program, Variable, Variables,
};

/// Code of an effect that is a formula.
pub const CODE: u8 = 0;
/// Both fingers, as bits of [`Formula::bodies`].
const FINGERS: u8 = 0b11;

/// Description shared by all formulas; the user's names and intervals stay on the host.
pub const INFO: Info = Info {
    id: "formula",
    code: CODE,
    summary: "the user's own formula",
    signature: "what the formula says",
    on_robot: "what the formula says",
    source: "the user's model.toml",
    role: Role::Plain,
    parameters: &[
        Parameter::new("p0", "1", 1.0, 0.0, [-1e9, 1e9], "first parameter of the formula"),
        Parameter::new("p1", "1", 1.0, 0.0, [-1e9, 1e9], "second parameter of the formula"),
        Parameter::new("p2", "1", 1.0, 0.0, [-1e9, 1e9], "third parameter of the formula"),
        Parameter::new("p3", "1", 1.0, 0.0, [-1e9, 1e9], "fourth parameter of the formula"),
    ],
};

impl<R: Real> Formula<R> {
    /// Variables of what is evaluated once a step, with the memory `state`.
    fn whole(&self, c: &StepContext<R>, state: R) -> Variables<R> {
        let zero = R::zero();
        let bodies = if self.target == Target::Friction { self.bodies } else { FINGERS };
        let (mut speed, mut distance, mut load, mut rate, mut count) = (zero, zero, zero, zero, zero);
        for k in 0..4 {
            if bodies & (1 << k) != 0 && c.load_n[k] > zero {
                speed += c.slip_speed_m_s[k];
                distance += c.slip_m[k];
                load += c.load_n[k];
                rate += c.load_rate_n_s[k];
                count += R::one();
            }
        }
        if count > zero {
            speed /= count;
            distance /= count;
        }
        [
            speed,
            distance,
            load,
            zero,
            c.position_m.x,
            c.position_m.y,
            c.position_m.z,
            c.time_s,
            c.trial,
            c.grip_cmd_n,
            c.grip_rate_n_s,
            rate,
            c.dt_s,
            state,
        ]
    }

    /// Variables at a contact point, with the memory `state`.
    fn at_point(c: &StepContext<R>, slip: &Slip<R>, state: R) -> Variables<R> {
        let rate = c.load_rate_n_s.get(slip.body.index()).copied().unwrap_or(R::zero());
        [
            slip.speed_m_s,
            slip.distance_m,
            slip.patch_load_n,
            slip.rest_s,
            slip.object_m.x,
            slip.object_m.y,
            slip.object_m.z,
            c.time_s,
            c.trial,
            c.grip_cmd_n,
            c.grip_rate_n_s,
            rate,
            c.dt_s,
            state,
        ]
    }

    /// The memory during the step that begins, after `state`.
    fn next_state(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, state: R) -> Result<R, Fault> {
        if self.remembers() { self.state.evaluate(p, &self.whole(c, state)) } else { Ok(state) }
    }

    /// Why the formula has no value in the step that begins with the memory `memory`; `slips` are the
    /// step's contact points.
    pub fn fault(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &[R; MEMORY],
        mut slips: impl Iterator<Item = Slip<R>>,
    ) -> Option<Fault> {
        let state = match self.next_state(p, c, memory[0]) {
            Ok(state) => state,
            Err(fault) => return Some(fault),
        };
        if self.target != Target::Friction {
            return self.program.evaluate(p, &self.whole(c, state)).err();
        }
        slips.find_map(|slip| {
            let applies = applies(self.bodies, slip.body);
            applies.then(|| self.program.evaluate(p, &Self::at_point(c, &slip, state)).err()).flatten()
        })
    }

    fn once_a_step(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &[R; MEMORY]) -> R {
        number(self.program.evaluate(p, &self.whole(c, memory[0])))
    }
}

/// Not a number where there is none: the time step refuses it.
fn number<R: Real>(value: Result<R, Fault>) -> R {
    value.unwrap_or(R::of(f64::NAN))
}

impl<R: Real> Law<R> for Formula<R> {
    fn loads(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &mut [R; MEMORY],
        loads: &mut Loads<R>,
    ) {
        // The first hook of a step.
        memory[0] = number(self.next_state(p, c, memory[0]));
        if !memory[0].finite() {
            // Refused also where nothing reads it in this step.
            loads.force_n.x = memory[0];
        }
        match self.target {
            Target::ForceX => loads.force_n.x += self.once_a_step(p, c, memory),
            Target::ForceY => loads.force_n.y += self.once_a_step(p, c, memory),
            Target::ForceZ => loads.force_n.z += self.once_a_step(p, c, memory),
            Target::Friction | Target::Grip => {}
        }
    }

    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        if self.target == Target::Grip {
            *grip_n *= self.once_a_step(p, c, memory);
        }
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if self.target == Target::Friction && applies(self.bodies, slip.body) {
            let factor = number(self.program.evaluate(p, &Self::at_point(c, slip, memory[0])));
            law.mu = law.mu.map(|mu| mu * factor);
        }
    }
}

/// Whether the mask holds the body.
fn applies(bodies: u8, body: Body) -> bool {
    bodies & (1 << (body.index() & 7)) != 0
}
