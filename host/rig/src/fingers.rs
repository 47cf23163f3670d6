//! The parallel jaw: two flat pads whose centre follows the gripper and whose opening
//! follows the grip force.
//!
//! Both normal forces together are twice the grip force. The centre is held in position,
//! so a force F across the object (gripper Y) makes them N + F/2 and N - F/2.

use nalgebra::{Matrix3, Vector3};

use super::body::Body;
use super::drive::Carrier;
use super::law::FrictionLaw;
use super::patch::{Patch, RelativeTwist, Resultant};
use super::shape::Side;
use super::truth::{GRIP_LAG_S, JAW_STIFFNESS_N_M, STRIPE_M, Truth, WAVE_LENGTH_M};

const WAVE_RAD_M: f64 = std::f64::consts::TAU / WAVE_LENGTH_M;

/// Time in which the jaw reaches its force, s.
const JAW_TIME_S: f64 = 1e-3;
/// Resistance of the fingers to moving within their play, N s/m.
const PLAY_DAMPING_N_S_M: f64 = 200.0;
/// Least half opening of the jaw, m.
const LEAST_OPENING_M: f64 = 5e-4;
/// Sliding speed from which a lagging jaw loses force, m/s.
const LAG_SPEED_M_S: f64 = 1e-3;

/// Force and torque on the object.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loading {
    /// World axes, N.
    pub force_n: Vector3<f64>,
    /// About the centre of mass, world axes, N m.
    pub torque_nm: Vector3<f64>,
}

impl std::ops::AddAssign for Loading {
    fn add_assign(&mut self, other: Self) {
        self.force_n += other.force_n;
        self.torque_nm += other.torque_nm;
    }
}

/// State of the jaw.
#[derive(Clone, Debug)]
pub struct Jaw {
    side: Side,
    radius_m: f64,
    patches: [Patch; 2],
    /// Parameters along the line contact on a round side, -1 to 1.
    line: Vec<f64>,
    /// Half opening, m.
    opening_m: f64,
    /// The same when the jaw had closed.
    rest_opening_m: Option<f64>,
    lost: f64,
    /// How far each pad has given way, gripper X and Z, m: creep, then play.
    crept_m: [[f64; 2]; 2],
    play_m: [f64; 2],
    /// How fast each pad gives way, gripper X and Z, m/s.
    giving_m_s: [[f64; 2]; 2],
}

impl Jaw {
    /// A jaw closed on the object's sides with `grip_n`, pads of `radius_m`.
    pub fn closed(side: Side, radius_m: f64, grip_n: f64, rest_s: f64, truth: &Truth) -> Self {
        let radius_m = radius_m * truth.patch_scale;
        let (half, pad) = match side {
            Side::Flat { half, .. } => (half, Patch::disc(radius_m)),
            Side::Round { radius, .. } => (radius, Patch::line(2.0 * radius_m, 12)),
        };
        let line = match side {
            Side::Flat { .. } => Vec::new(),
            Side::Round { .. } => (0..12).map(|i| (i as f64 + 0.5) / 6.0 - 1.0).collect(),
        };
        let patches = [0, 1].map(|i| {
            let mut pad = pad.clone();
            let [x, z] = truth.pressure_offset_m[i];
            // The second tangent axis is +Z for finger 1 and -Z for finger 2.
            pad.shift_pressure(x, if i == 0 { z } else { -z });
            pad.memory.age_s = rest_s;
            pad.memory.normal_n = grip_n;
            pad
        });
        let opening_m = half - grip_n / truth.finger_stiffness.normal;
        Self {
            side,
            radius_m,
            patches,
            line,
            opening_m,
            rest_opening_m: None,
            lost: 0.0,
            crept_m: [[0.0; 2]; 2],
            play_m: [0.0; 2],
            giving_m_s: [[0.0; 2]; 2],
        }
    }

    /// Presses for one step with the commanded `grip_n`. Returns what acts on the object
    /// and the two fingers' wrenches in gripper axes about their patch centres.
    pub fn press(
        &mut self,
        body: &Body,
        gripper: &Carrier,
        grip_n: f64,
        friction_factor: f64,
        truth: &Truth,
        dt_s: f64,
    ) -> (Loading, [[f64; 6]; 2]) {
        let axes = gripper.attitude().to_rotation_matrix().into_inner();
        let [x, y, z] = [0, 1, 2].map(|i| axes.column(i).into_owned());
        let spin = Vector3::new(0.0, gripper.pitch_rate_rad_s, 0.0);
        let object_axes = body.attitude.to_rotation_matrix().into_inner();
        let origin = body.origin_m();
        let mut total = Loading::default();
        let mut wrenches = [[0.0; 6]; 2];
        let mut normal_sum = 0.0;
        let mut fastest = 0.0_f64;
        if self.rest_opening_m.is_none() {
            // The jaw closes with the commanded force wherever it grips.
            let x_m = object_axes.column(0).dot(&(gripper.origin_m - origin));
            self.opening_m += bulge_m(truth, x_m);
        }
        let rest_opening_m = *self.rest_opening_m.get_or_insert(self.opening_m);
        for (i, sign) in [(0, 1.0), (1, -1.0)] {
            let frame = Matrix3::from_columns(&[-sign * y, x, sign * z]);
            let centre = gripper.origin_m + y * (sign * self.opening_m);
            let [cx, cz] = self.crept_m[i];
            let pad = centre + x * (cx + self.play_m[i]) + z * cz;
            let [gx, gz] = self.giving_m_s[i];
            let velocity = gripper.velocity_m_s + x * gx + z * gz;
            let twist = relative_twist(body, &frame, &pad, &velocity, &spin, &gripper.origin_m);
            let placed = self.place(i, sign, &frame, &pad, &origin, &object_axes, truth);
            let law = self.law(i, &placed, truth, friction_factor);
            let mut sum = self.patches[i].press(&twist, &truth.finger_stiffness, &law, dt_s);
            let normal = sum.force[0];
            let slope = placed.slope * normal;
            sum.force[1] += slope * placed.along[0] - truth.finger_bend_rad_n * normal * normal;
            sum.force[2] += slope * placed.along[1];
            let loading = to_world(&sum, &frame, &pad, &body.com_m);
            total += loading;
            let about_centre = frame * Vector3::from(sum.torque) + (pad - centre).cross(&loading.force_n);
            let (f, t) = (axes.tr_mul(&loading.force_n), axes.tr_mul(&about_centre));
            wrenches[i] = [f.x, f.y, f.z, t.x, t.y, t.z];
            normal_sum += normal;
            let [_, va, vb] = twist.velocity;
            fastest = fastest.max(va.hypot(vb) + twist.spin[0].abs() * self.radius_m * 0.5);
            self.give_way(i, [f.x, f.z], truth, dt_s);
        }
        let opened_m = self.opening_m - rest_opening_m;
        self.follow(grip_n, opened_m, normal_sum, fastest, truth, dt_s);
        (total, wrenches)
    }

    /// The jaw opens or closes until both pads together carry twice the grip force.
    fn follow(
        &mut self,
        grip_n: f64,
        opened_m: f64,
        normal_sum: f64,
        sliding_m_s: f64,
        truth: &Truth,
        dt_s: f64,
    ) {
        let losing = if sliding_m_s > LAG_SPEED_M_S { truth.grip_lag } else { 0.0 };
        self.lost += (losing - self.lost) * dt_s / GRIP_LAG_S;
        let mut grip = grip_n * (1.0 - truth.grip_loss) * (1.0 - self.lost);
        if truth.wedge_rad != 0.0 || truth.waviness_m != 0.0 {
            grip += JAW_STIFFNESS_N_M * opened_m;
        }
        let damping = 2.0 * truth.finger_stiffness.normal * JAW_TIME_S;
        self.opening_m += (normal_sum - 2.0 * grip.max(0.0)) / damping * dt_s;
        self.opening_m = self.opening_m.max(LEAST_OPENING_M);
    }

    /// The pad yields to what the object exerts on it: creep, and play along gripper X.
    fn give_way(&mut self, i: usize, on_object: [f64; 2], truth: &Truth, dt_s: f64) {
        let creep = on_object.map(|f| -f * truth.creep_m_n_s);
        for (place, rate) in self.crept_m[i].iter_mut().zip(creep) {
            *place += rate * dt_s;
        }
        let half = truth.backlash_m / 2.0;
        let moved = (self.play_m[i] - on_object[0] / PLAY_DAMPING_N_S_M * dt_s).clamp(-half, half);
        let play = (moved - self.play_m[i]) / dt_s;
        self.play_m[i] = moved;
        self.giving_m_s[i] = [creep[0] + play, creep[1]];
    }

    fn law(&self, i: usize, placed: &Placed, truth: &Truth, factor: f64) -> FrictionLaw {
        let mut law = truth.finger[i];
        law.mu *= factor;
        law.lay_axis = placed.along;
        law.stripe_span_m = STRIPE_M.map(|x| x - placed.centre_x_m);
        law
    }

    /// Where the pad's points touch: fills depths (and positions on a round side).
    #[allow(clippy::too_many_arguments)]
    fn place(
        &mut self,
        i: usize,
        sign: f64,
        frame: &Matrix3<f64>,
        pad: &Vector3<f64>,
        origin: &Vector3<f64>,
        object_axes: &Matrix3<f64>,
        truth: &Truth,
    ) -> Placed {
        let patch = &mut self.patches[i];
        let along = frame.tr_mul(&object_axes.column(0));
        let centre = frame.tr_mul(&(origin - pad));
        // Object X of the pad's centre.
        let centre_x_m = -centre.dot(&along);
        let bulge = bulge_m(truth, centre_x_m);
        let phase = WAVE_RAD_M * centre_x_m + truth.wave_phase_rad;
        let slope = 0.5 * truth.wedge_rad + truth.waviness_m * WAVE_RAD_M * phase.cos();
        match self.side {
            Side::Flat { half, half_x, half_z } => {
                let normal = sign * frame.tr_mul(&object_axes.column(1));
                let across = frame.tr_mul(&object_axes.column(2));
                let face = centre + normal * half;
                for k in 0..patch.a.len() {
                    let (a, b) = (patch.a[k] - face.y, patch.b[k] - face.z);
                    let surface = face.x - (normal.y * a + normal.z * b) / normal.x;
                    let n = surface - face.x;
                    let x = along.x * n + along.y * a + along.z * b;
                    let z = across.x * n + across.y * a + across.z * b;
                    let on_face = x.abs() <= half_x && z.abs() <= half_z && normal.x < -0.5;
                    patch.depth[k] = if on_face { bulge - surface } else { -1.0 };
                }
            }
            Side::Round { radius, half_x } => {
                // The generator nearest to the pad, cut at the pad's rim.
                let middle = centre.z - along.z / along.y * centre.y;
                let half = (self.radius_m * self.radius_m - middle * middle).max(0.0).sqrt();
                for (k, share) in self.line.iter().enumerate() {
                    let a = share * half;
                    let t = (a - centre.y) / along.y;
                    patch.a[k] = a;
                    patch.b[k] = centre.z + along.z * t;
                    let depth = radius - (centre.x + along.x * t);
                    let on_side = half > 0.0 && t.abs() <= half_x;
                    patch.depth[k] = if on_side { depth + bulge } else { -1.0 };
                }
            }
        }
        let size = along.y.hypot(along.z).max(1e-9);
        Placed { along: [along.y / size, along.z / size], centre_x_m, slope }
    }
}

/// Height of a gripped face above the flat one, at object X.
fn bulge_m(truth: &Truth, x_m: f64) -> f64 {
    let phase = WAVE_RAD_M * x_m + truth.wave_phase_rad;
    0.5 * truth.wedge_rad * x_m + truth.waviness_m * (phase.sin() - truth.wave_phase_rad.sin())
}

/// How a pad lies on the object.
struct Placed {
    /// Object X in the tangent plane, unit vector `a, b`.
    along: [f64; 2],
    /// Object X of the pad's centre, m.
    centre_x_m: f64,
    /// Slope of the face along object X.
    slope: f64,
}

/// Motion of the object relative to a frame at `at` that moves as part of a carrier.
pub fn relative_twist(
    body: &Body,
    frame: &Matrix3<f64>,
    at: &Vector3<f64>,
    carrier_velocity: &Vector3<f64>,
    carrier_spin: &Vector3<f64>,
    carrier_origin: &Vector3<f64>,
) -> RelativeTwist {
    let object = body.velocity_m_s + body.spin_rad_s.cross(&(at - body.com_m));
    let carrier = carrier_velocity + carrier_spin.cross(&(at - carrier_origin));
    RelativeTwist {
        velocity: frame.tr_mul(&(object - carrier)).into(),
        spin: frame.tr_mul(&(body.spin_rad_s - carrier_spin)).into(),
    }
}

/// A contact's resultant as a load on the object.
pub fn to_world(sum: &Resultant, frame: &Matrix3<f64>, at: &Vector3<f64>, com: &Vector3<f64>) -> Loading {
    let force_n = frame * Vector3::from(sum.force);
    let torque_nm = frame * Vector3::from(sum.torque) + (at - com).cross(&force_n);
    Loading { force_n, torque_nm }
}
