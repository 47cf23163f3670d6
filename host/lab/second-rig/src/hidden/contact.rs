//! Effects of pads, pushers and their friction.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value};

use super::scale::{Scale, named};
use crate::physics::friction::{Grain, Kind, Law};
use crate::physics::layout::Profile;
use crate::random::{chance, log_uniform, sign, uniform};
use crate::reality::Reality;

type Out = Map<String, Value>;

/// The law in question: that of the fingers, or of the table where nothing is grasped.
fn law<'a>(r: &'a mut Reality, s: &Scale) -> &'a mut Law {
    if s.grasped { &mut r.finger } else { &mut r.table.law }
}

pub fn mismatch(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.mismatch = (0.15 * s.level).min(0.6) * sign(rng);
    named([("mismatch", r.mismatch)])
}

pub fn pressure_offset(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let size = (0.002 * s.level).min(0.4 * r.pad.radius_m);
    let angle = uniform(rng, -PI, PI);
    let offset = [size * angle.cos(), size * angle.sin()];
    r.pad.offset_m = [offset; 2];
    named([("offset_x_m", offset[0]), ("offset_z_m", offset[1])])
}

pub fn waviness(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.wave = [(0.1 * s.level).min(0.5), uniform(rng, 0.004, 0.012), uniform(rng, -PI, PI)];
    named([("amplitude", r.wave[0]), ("wavelength_m", r.wave[1]), ("phase_rad", r.wave[2])])
}

pub fn plate_tilt(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let size = (0.015 * s.level).min(0.08);
    let angle = uniform(rng, -PI, PI);
    r.plate_tilt = [size * angle.cos(), size * angle.sin()];
    named([("pitch_or_lean_rad", r.plate_tilt[0]), ("yaw_rad", r.plate_tilt[1])])
}

pub fn compliance(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    r.pad.shear_n_m = (25e3 / s.level).clamp(5e3, 1e5);
    let shear = r.pad.shear_n_m;
    named([("tangential_m_n", 1.0 / shear), ("normal_m_n", 1.0 / (shear * r.pad.normal_ratio))])
}

pub fn wear(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.wear = (0.12 * s.level).min(0.5) * if chance(rng, 0.8) { 1.0 } else { -1.0 };
    named([("share_lost_to_the_last_trial", r.wear)])
}

pub fn load_exponent(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.finger.load_exponent = (0.2 * s.level).min(0.6) * if chance(rng, 0.7) { 1.0 } else { -1.0 };
    named([("exponent", r.finger.load_exponent), ("reference_n", r.finger.load_reference_n)])
}

pub fn viscous(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    let rise = 0.12 * s.level / s.speed_m_s;
    law(r, &s).viscous_s_m = rise;
    named([("relative_s_m", rise)])
}

pub fn static_friction(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let (ratio, speed) = (1.0 + 0.18 * s.level, log_uniform(rng, 3e-4, 4e-3));
    let law = law(r, &s);
    law.static_ratio = ratio;
    law.stribeck_m_s = speed;
    if law.kind == Kind::Dahl {
        law.kind = Kind::LuGre;
    }
    named([("static_over_kinetic", ratio), ("stribeck_m_s", speed)])
}

pub fn dwell(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let (rise, cutoff) = (0.05 * s.level, log_uniform(rng, 0.02, 0.2));
    let law = law(r, &s);
    law.dwell = rise;
    law.dwell_cutoff_s = cutoff;
    named([("strengthening", rise), ("cutoff_s", cutoff)])
}

pub fn adhesion(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    let pull = if s.grasped { 1.5 * s.level } else { 0.5 * s.level };
    law(r, &s).adhesion_n = pull;
    named([("pull_off_n", pull)])
}

pub fn anisotropic(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let ratio = 1.0 + 0.35 * s.level;
    let ratio = if chance(rng, 0.7) { ratio } else { 1.0 / ratio };
    law(r, &s).anisotropy = ratio;
    named([("ratio", ratio)])
}

pub fn grained(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let (ratio, angle) = (1.0 + 0.35 * s.level, uniform(rng, -0.5 * PI, 0.5 * PI));
    let of_table = chance(rng, 0.5);
    let law = law(r, &s);
    law.anisotropy = ratio;
    law.grain = if of_table { Grain::OfTable(angle) } else { Grain::OfObject(angle) };
    let mut out = named([("ratio", ratio), ("angle_rad", angle)]);
    out.insert("of_table".to_owned(), Value::from(of_table));
    out
}

pub fn torsional(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let change = (0.2 * s.level).min(0.6);
    // A pad can not grow over the face; with uniform pressure there is room.
    let room = r.pad.profile == Profile::Uniform;
    r.pad.radius_factor = if room && chance(rng, 0.4) { 1.0 + change.min(0.25) } else { 1.0 - change };
    named([("radius_factor", r.pad.radius_factor)])
}

pub fn rolling(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    r.rolling_arm_m = (1e-3 * s.level).min(4e-3);
    named([("arm_m", r.rolling_arm_m)])
}

pub fn flow(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    // Typical: half a millimetre in a second under a quarter of the grip's friction.
    let force = 0.25 * r.finger.mu * r.pad.reference_n;
    let elastic = force / r.pad.shear_n_m;
    r.finger.creep_1_s = (5e-4 * s.level / elastic).min(500.0);
    named([("relaxation_1_s", r.finger.creep_1_s)])
}
