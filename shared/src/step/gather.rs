//! What a step leaves behind: wrenches, utilisation and the memory of the contact points.

use super::output::{StepSummary, Workspace};
use crate::contact::Body;
use crate::real::{Real, Vec3, max, sqrt};
use crate::state::{Drive, State};

/// Wrenches, utilisation and the memory of the contact points at the end of a step.
pub(super) fn gather<R: Real, const NC: usize>(
    state: &mut State<R, NC>,
    drive: &Drive<R>,
    work: &Workspace<R, NC>,
    out: &mut StepSummary<R>,
) {
    let zero = R::zero();
    let dt = drive.dt_s;
    let mut pusher_force = Vec3::zeros();
    let mut pusher_torque = Vec3::zeros();
    // Per finger: greatest tangential force and torsion, those acting, loads.
    let mut limit = [[zero; 2]; 2];
    let mut weight = [zero; 2];
    let by_dt = R::one() / dt;
    let sides = sides(state, work);
    for (answer, c) in work.answers().zip(&work.contacts) {
        let f = answer.force_n;
        let force = c.axes[0] * f[0] + c.axes[1] * f[1] + c.axes[2] * f[2];
        let Some(slot) = state.slots.get_mut(c.slot) else { continue };
        let ratio = R::one() / (dt + c.damping_s);
        let bound = f[0] + answer.adhesion_n;
        let [m1, m2] = answer.mu;
        let sliding = if bound > zero && m1 > zero && m2 > zero {
            let (a, b) = (f[1] / m1, f[2] / m2);
            a * a + b * b > work.params.sliding_share2 * bound * bound
        } else {
            true
        };
        let had_m = c.stretch_m(slot.spring_m);
        // The bias was spring memory over step and damper, and the other body's motion.
        let speed: [R; 2] = core::array::from_fn(|k| answer.biased_slip_m_s[k] - had_m[k] * ratio);
        // Beforehand the distance was not known: with that of the last step, a spring whose object slows down would lose
        // force that nothing takes from it.
        let kept = if c.reach_m > zero && !sliding {
            c.reach_m / (c.reach_m + sqrt(speed[0] * speed[0] + speed[1] * speed[1]) * dt)
        } else {
            c.kept
        };
        let mut slipped = [zero; 2];
        for k in 0..2 {
            let moved = speed[k] * dt;
            let stiffness = answer.stiffness_n_s_m[k];
            let damper = c.damping_s * ratio * stiffness;
            let spring = (-f[k + 1] - damper * speed[k]) * dt / (stiffness - damper) * kept;
            slipped[k] = had_m[k] + moved - spring;
            slot.spring_m[k] = spring;
        }
        let square = slipped[0] * slipped[0] + slipped[1] * slipped[1];
        slot.load_n = max(f[0], zero);
        if !(bound > zero) {
            slot.spring_m = [zero; 2];
            slot.speed_m_s = zero;
        } else if (sliding || kept < R::one()) && square > work.params.min_slip_m2 {
            let travel = sqrt(square);
            slot.slip_m += travel;
            slot.speed_m_s = travel * by_dt;
            slot.rest_s = zero;
        } else {
            slot.speed_m_s = zero;
            slot.rest_s += dt;
        }
        match c.body {
            Body::Finger1 | Body::Finger2 => {
                let k = usize::from(c.body == Body::Finger2);
                let centre = Vec3::new(zero, sides[k], zero);
                let at = state.position_m + c.lever_m;
                add_wrench(&mut out.reading.finger[k], &force, &(at - centre));
                let arm = sqrt(c.patch_m[0] * c.patch_m[0] + c.patch_m[1] * c.patch_m[1]);
                let held = max(bound, zero);
                let most_n = (m1 + m2) * R::of(0.5) * held;
                limit[k][0] += most_n;
                limit[k][1] += most_n * arm;
                weight[k] += held;
                if bound > zero && sliding {
                    let slide = (c.axes[1] * slipped[0] + c.axes[2] * slipped[1]) * by_dt;
                    out.slip_m_s[k] += slide * bound;
                    if arm > work.params.min_arm_m {
                        let turned = c.patch_m[0] * slipped[1] - c.patch_m[1] * slipped[0];
                        out.spin_rad_s[k] += turned * by_dt / (arm * arm) * bound;
                    }
                }
            }
            Body::Pusher => {
                let at = state.position_m + c.lever_m;
                let reference = drive.pusher.map_or(at, |p| p.reference_m);
                pusher_force += force;
                pusher_torque += (at - reference).cross(&force);
            }
            Body::Support => {}
        }
    }
    for k in 0..2 {
        if weight[k] > zero {
            out.slip_m_s[k] /= weight[k];
            out.spin_rad_s[k] /= weight[k];
        }
        let w = &out.reading.finger[k];
        let tangential = sqrt(w[0] * w[0] + w[2] * w[2]);
        let a = if limit[k][0] > zero { tangential / limit[k][0] } else { zero };
        let b = if limit[k][1] > zero { w[4] / limit[k][1] } else { zero };
        out.utilisation[k] = sqrt(a * a + b * b);
    }
    let force = drive.carrier.transform_vector(&pusher_force);
    let torque = drive.carrier.transform_vector(&pusher_torque);
    out.reading.pusher = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
}

/// Where the object's sides are under the pads' centres, carrier Y: the points about which a finger's torque is
/// taken. A pad that is pressed in by a millimetre stands inside of the object's side by that: about the pad
/// itself, shear would seem to twist it.
fn sides<R: Real, const NC: usize>(state: &State<R, NC>, work: &Workspace<R, NC>) -> [R; 2] {
    let mut sum = [R::zero(); 2];
    let mut count = [R::zero(); 2];
    for c in &work.contacts {
        let k = match c.body {
            Body::Finger1 => 0,
            Body::Finger2 => 1,
            Body::Pusher | Body::Support => continue,
        };
        sum[k] += c.lever_m.y;
        count[k] += R::one();
    }
    [0, 1].map(|k| state.position_m.y + if count[k] > R::zero() { sum[k] / count[k] } else { R::zero() })
}

fn add_wrench<R: Real>(to: &mut [R; 6], force: &Vec3<R>, arm: &Vec3<R>) {
    let torque = arm.cross(force);
    for k in 0..3 {
        to[k] += force[k];
        to[3 + k] += torque[k];
    }
}
