//! One line: what the effect is. (This one raises friction by a constant share; it compiles and its
//! test passes as it stands. Replace law, words and published value by yours.)
//!
//! `mu' = mu (1 + strength)`, after Author Year.

use super::{FrictionLaw, Info, Law, MAX_PARAMETERS, MEMORY, Parameter, Role, Slip, StepContext};
use crate::real::Real;

/// See the module.
pub struct MyEffect;

/// Description.
pub const INFO: Info = Info {
    id: "my_effect",
    code: 200,
    summary: "what it is, in one line, without a full stop",
    signature: "what it looks like in data, the same way",
    on_robot: "what it changes for a robot that grips, the same way",
    source: "where the law comes from",
    role: Role::Plain,
    parameters: &[Parameter::new("strength", "1", 0.1, 0.0, [0.0, 1.0], "what the parameter is")],
};

impl<R: Real> Law<R> for MyEffect {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        _slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if p[0] == R::zero() {
            return;
        }
        let factor = R::one() + p[0];
        law.mu = law.mu.map(|mu| mu * factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Body;
    use crate::effects::Environment;
    use crate::real::Vec3;
    use nalgebra::UnitQuaternion;

    #[test]
    fn the_law_gives_the_published_value_at_a_known_point() {
        let still = Vec3::zeros();
        let nothing =
            Environment { normal: still, along_y: still, turning_rad_s: still, angular_rad_s: still };
        let context = StepContext {
            time_s: 0.0,
            dt_s: 0.004,
            trial: 0.0,
            grip_cmd_n: 20.0,
            grip_rate_n_s: 0.0,
            position_m: Vec3::zeros(),
            rotation: UnitQuaternion::identity(),
            carrier: UnitQuaternion::identity(),
            slip_m: [0.0; 4],
            slip_speed_m_s: [0.0; 4],
            load_n: [20.0, 20.0, 0.0, 0.0],
            load_rate_n_s: [0.0; 4],
            environment: [nothing; 2],
            stretch_m: [[0.0; 2]; 2],
            fingers: None,
            pusher: None,
            whole_face: false,
            velocity_m_s: Vec3::zeros(),
            angular_rad_s: Vec3::zeros(),
        };
        let slip = Slip {
            share: 1.0,
            body: Body::Finger1,
            patch_m: [0.0; 2],
            object_m: Vec3::zeros(),
            load_n: 20.0,
            patch_load_n: 20.0,
            speed_m_s: 0.01,
            distance_m: 0.0,
            rest_s: 0.0,
        };
        let mut law = FrictionLaw::<f64> { mu: [0.4, 0.4], adhesion_n: 0.0, viscosity_s_m: 0.0 };
        let mut parameters = [0.0; MAX_PARAMETERS];
        parameters[0] = 0.1;
        MyEffect.friction(&parameters, &context, &[0.0; MEMORY], &slip, &mut law);
        // 0.4 raised by a tenth.
        let published: f64 = 0.44;
        assert!((law.mu[0] - published).abs() < 1e-12, "{:?}", law.mu);
    }
}
