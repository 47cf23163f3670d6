//! A server to which Foxglove and other viewers connect by WebSocket.
//!
//! | topic | schema | what |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransforms` | world, gripper, object (modelled), object_measured, pusher |
//! | `/poses` | `foxglove.PosesInFrame` | in the world: the object as modelled, then as measured |
//! | `/scene` | `foxglove.SceneUpdate` | object; at each finger the friction limit as a circle, the force along the pad as an arrow |
//! | `/wrench/finger1`, `/wrench/finger2` | `stickslip.Wrench` | measured and modelled, friction limit |
//! | `/prediction` | `stickslip.Outlook` | utilisation, probability to hold, sag, drop, grip, friction, tick |
//! | `/log`, `/alarm` | `foxglove.Log`, `stickslip.Alarm` | flags that rose |
//!
//! Schemas of Foxglove's are those of its SDK (protobuf); ours are JSON with a JSON Schema.

use std::net::SocketAddr;
use std::sync::Arc;

use ::foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, LinePrimitive,
    Log, Point3, Pose, PosesInFrame, Quaternion, SceneEntity, SceneUpdate, Timestamp, Vector3,
    line_primitive, log,
};
use ::foxglove::{Channel, Context, PartialMetadata, RawChannel, Schema, WebSocketServerHandle};
use anyhow::Context as _;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use stickslip_device::clock;
use stickslip_shared::model::{Scene, Shape};
use stickslip_shared::predictor::Prediction;
use stickslip_shared::wire;

use crate::FOXGLOVE_ADDRESS;
use crate::event::Event;
use crate::plain;
use crate::scene::{half_width_m, pad_radius_m};
use crate::state::{Alarm, State, used};

/// Scenes are for eyes: so many a second.
const SCENES_S: f64 = 1.0 / 25.0;
/// How long an arrow or a circle's radius is drawn for each newton, m.
const M_PER_N: f64 = 0.002;

/// A three-vector, axes as its message says.
#[derive(JsonSchema, Serialize)]
struct Xyz {
    /// Along x.
    x: f32,
    /// Along y.
    y: f32,
    /// Along z.
    z: f32,
}

impl From<[f32; 3]> for Xyz {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

/// Force and torque of a finger on the object, gripper axes, about the middle of its pad.
#[derive(JsonSchema, Serialize)]
struct Wrench {
    /// Frame of the axes.
    frame_id: &'static str,
    /// Measured, N; none: no sample.
    force_n: Option<Xyz>,
    /// Measured, N m.
    torque_nm: Option<Xyz>,
    /// Of the contact model, N; none: not sent on a bus.
    modelled_force_n: Option<Xyz>,
    /// Of the contact model, N m.
    modelled_torque_nm: Option<Xyz>,
    /// Largest force along the pad at the present pressure, no torque, N.
    friction_limit_n: Option<f32>,
    /// Share of the friction limit used.
    utilisation: Option<f32>,
}

/// What is foreseen, as numbers to plot; none: not known.
#[derive(JsonSchema, Serialize)]
struct Outlook {
    /// Share of the friction limit used, by the sensors or else the model: fingers 1, 2.
    utilisation: [Option<f32>; 2],
    /// Largest of the look-ahead.
    peak_utilisation: [Option<f32>; 2],
    /// Time until slip, s; 0: now; none: not foreseen.
    slip_in_s: [Option<f32>; 2],
    /// Downward motion in the grasp, m.
    sag_m: Option<f32>,
    /// Expected at the end of the look-ahead, m.
    sag_ahead_m: Option<f32>,
    /// Of the object in the grasp, rad.
    rotation_rad: Option<f32>,
    /// Time until the grasp is lost, s.
    drop_in_s: Option<f32>,
    /// Grip of each finger that holds with reserve (at 80 % of the least friction), N.
    holding_grip_n: Option<f32>,
    /// Grip that the board advises, N.
    advised_grip_n: Option<f32>,
    /// Friction coefficient of the fingers, learnt: as likely more as less.
    friction: Option<f32>,
    /// There is more friction than this with the probability 0.9875; the grip that holds counts on it.
    friction_least: Option<f32>,
    /// Probability that the friction suffices for the load now and within the look-ahead; none: it slips, nothing is
    /// to be held, or no force is measured.
    hold_probability: Option<f32>,
    /// Bits of the flags.
    flags: u32,
    /// Bits of the doubts.
    validity: u32,
    /// Duration of the tick, ms.
    work_ms: Option<f64>,
    /// Samples in the last second.
    samples_per_s: f64,
}

struct Channels {
    transforms: Channel<FrameTransforms>,
    poses: Channel<PosesInFrame>,
    scene: Channel<SceneUpdate>,
    log: Channel<Log>,
    wrench: [Arc<RawChannel>; 2],
    outlook: Arc<RawChannel>,
    alarm: Arc<RawChannel>,
}

/// A running server.
pub struct Server {
    // The channels live as long as it.
    _context: Arc<Context>,
    handle: Option<WebSocketServerHandle>,
    channels: Channels,
    /// When the first event happened, ns since 1970.
    began_ns: Option<u64>,
    drawn_s: Option<f64>,
}

impl Server {
    /// Listens at `address` (`HOST:PORT`; port 0: a free one).
    ///
    /// # Errors
    /// An address that is none or taken.
    pub fn start(address: &str) -> anyhow::Result<Self> {
        let at: SocketAddr = address.parse().with_context(|| {
            format!("`{address}` is no address: give IP:PORT, for example {FOXGLOVE_ADDRESS}")
        })?;
        let context = Context::new();
        let channels = Channels::on(&context)?;
        let server = context.websocket_server().name("stickslip").bind(at.ip().to_string(), at.port());
        let handle = server.start_blocking().with_context(|| {
            format!("cannot listen at {address}: choose another port, or stop the program that uses it")
        })?;
        Ok(Self { _context: context, handle: Some(handle), channels, began_ns: None, drawn_s: None })
    }

    /// The port it listens at.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.handle.as_ref().map_or(0, WebSocketServerHandle::port)
    }

    /// How many viewers are connected.
    #[must_use]
    pub fn viewers(&self) -> usize {
        self.handle.as_ref().map_or(0, WebSocketServerHandle::client_count)
    }

    /// Sends what `event` brought: `state` after it, and the alarms that rose with it.
    ///
    /// # Errors
    /// Never in practice: every message can be serialised.
    pub fn publish(&mut self, event: &Event, state: &State, raised: &[Alarm]) -> anyhow::Result<()> {
        let since_ns = (event.at_s.max(0.0) * 1e9) as u64;
        let began_ns = *self.began_ns.get_or_insert_with(|| clock::now_ns().saturating_sub(since_ns));
        let ns = began_ns.saturating_add(since_ns);
        let stamp = Stamp::of(ns);
        for alarm in raised {
            self.channels.log.log_with_meta(&message(alarm, stamp), stamp.meta());
            put(&self.channels.alarm, stamp, alarm)?;
        }
        if !event.what.predicts() {
            return Ok(());
        }
        let Some(prediction) = &state.prediction else { return Ok(()) };
        // A bus tells of no poses.
        if prediction.position_m.iter().all(|x| x.is_finite()) {
            let frames = Frames::of(prediction, state);
            let transforms = FrameTransforms { transforms: frames.transforms(stamp) };
            self.channels.transforms.log_with_meta(&transforms, stamp.meta());
            let poses = frames.poses(stamp);
            self.channels.poses.log_with_meta(&poses, stamp.meta());
        }
        for (finger, channel) in self.channels.wrench.iter().enumerate() {
            put(channel, stamp, &wrench(finger, prediction, state))?;
        }
        put(&self.channels.outlook, stamp, &outlook(prediction, state))?;
        if let Some(scene) = &state.scene
            && self.drawn_s.is_none_or(|drawn| event.at_s - drawn >= SCENES_S || event.at_s < drawn)
        {
            self.drawn_s = Some(event.at_s);
            self.channels.scene.log_with_meta(&drawn(scene, prediction, state, stamp), stamp.meta());
        }
        Ok(())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(handle) = self.handle.take() {
            handle.stop().wait_blocking();
        }
    }
}

impl Channels {
    fn on(context: &Arc<Context>) -> anyhow::Result<Self> {
        fn json<T: JsonSchema>(
            context: &Arc<Context>,
            topic: &str,
            name: &str,
        ) -> anyhow::Result<Arc<RawChannel>> {
            // Foxglove follows no references.
            let settings = schemars::generate::SchemaSettings::draft07().with(|s| s.inline_subschemas = true);
            let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
            one_type_each(&mut schema);
            let schema = Schema::new(name, "jsonschema", serde_json::to_vec(&schema)?);
            Ok(context.channel_builder(topic).message_encoding("json").schema(schema).build_raw()?)
        }
        Ok(Self {
            transforms: context.channel_builder("/tf").build(),
            poses: context.channel_builder("/poses").build(),
            scene: context.channel_builder("/scene").build(),
            log: context.channel_builder("/log").build(),
            wrench: [
                json::<Wrench>(context, "/wrench/finger1", "stickslip.Wrench")?,
                json::<Wrench>(context, "/wrench/finger2", "stickslip.Wrench")?,
            ],
            outlook: json::<Outlook>(context, "/prediction", "stickslip.Outlook")?,
            alarm: json::<Alarm>(context, "/alarm", "stickslip.Alarm")?,
        })
    }
}

/// A time, ns since 1970.
#[derive(Clone, Copy)]
struct Stamp(u64);

impl Stamp {
    fn of(ns: u64) -> Self {
        Self(ns)
    }

    fn meta(self) -> PartialMetadata {
        PartialMetadata::with_log_time(self.0)
    }

    fn message(self) -> Option<Timestamp> {
        let sec = u32::try_from(self.0 / 1_000_000_000).ok()?;
        Timestamp::new_checked(sec, (self.0 % 1_000_000_000) as u32)
    }
}

fn put<T: Serialize>(channel: &RawChannel, stamp: Stamp, what: &T) -> anyhow::Result<()> {
    let mut what = serde_json::to_value(what)?;
    drop_nulls(&mut what);
    channel.log_with_meta(&serde_json::to_vec(&what)?, stamp.meta());
    Ok(())
}

/// Foxglove takes no schema in which something is of one type or null: a field that would be null is left out
/// ([`drop_nulls`]). Of two fingers' numbers one may be null: it keeps its place.
fn one_type_each(schema: &mut Value) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(one_type_each),
        Value::Object(keys) => {
            if let Some(Value::Array(types)) = keys.get("type") {
                let one = types.iter().find(|one| *one != "null").cloned();
                keys.extend(one.map(|one| ("type".to_owned(), one)));
            }
            keys.values_mut().for_each(one_type_each);
        }
        _ => {}
    }
}

fn drop_nulls(what: &mut Value) {
    match what {
        Value::Array(items) => items.iter_mut().for_each(drop_nulls),
        Value::Object(keys) => {
            keys.retain(|_, value| !value.is_null());
            keys.values_mut().for_each(drop_nulls);
        }
        _ => {}
    }
}

fn message(alarm: &Alarm, stamp: Stamp) -> Log {
    let level = if alarm.unsure { log::Level::Info } else { log::Level::Warning };
    Log {
        timestamp: stamp.message(),
        level: level as i32,
        message: plain::alarm(alarm).trim().to_owned(),
        name: "stickslip".to_owned(),
        ..Log::default()
    }
}

/// Largest force along a pad that presses the object by `normal_n`.
fn friction_limit_n(normal_n: f32, prediction: &Prediction) -> f32 {
    prediction.friction * normal_n.abs()
}

/// Measured wrench of a finger, or the modelled one.
fn shown_wrench(finger: usize, prediction: &Prediction, state: &State) -> [f32; 6] {
    state.wrench(finger).unwrap_or(prediction.finger_wrench[finger])
}

fn wrench(finger: usize, prediction: &Prediction, state: &State) -> Wrench {
    let modelled =
        Some(prediction.finger_wrench[finger]).filter(|w| w.iter().all(|x| x.is_finite())).map(halves);
    let measured = state.wrench(finger).map(halves);
    Wrench {
        frame_id: "gripper",
        force_n: measured.map(|[force, _]| force.into()),
        torque_nm: measured.map(|[_, torque]| torque.into()),
        modelled_force_n: modelled.map(|[force, _]| force.into()),
        modelled_torque_nm: modelled.map(|[_, torque]| torque.into()),
        friction_limit_n: known(friction_limit_n(shown_wrench(finger, prediction, state)[1], prediction)),
        utilisation: known(used(&prediction.finger[finger])),
    }
}

/// JSON has no other numbers.
fn known(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}

fn halves([fx, fy, fz, tx, ty, tz]: [f32; 6]) -> [[f32; 3]; 2] {
    [[fx, fy, fz], [tx, ty, tz]]
}

fn outlook(p: &Prediction, state: &State) -> Outlook {
    let line = state.line();
    Outlook {
        utilisation: p.finger.each_ref().map(|f| known(used(f))),
        peak_utilisation: p.finger.each_ref().map(|f| known(f.peak_utilisation)),
        slip_in_s: p.finger.each_ref().map(|f| f.slip.in_s().and_then(known)),
        sag_m: known(p.sag_m),
        sag_ahead_m: known(p.sag_ahead_m),
        rotation_rad: known(p.rotation_rad),
        drop_in_s: p.drop_in_s,
        holding_grip_n: p.holding_grip_n,
        advised_grip_n: state.advised_grip_n,
        friction: known(p.friction),
        friction_least: known(p.friction_least),
        hold_probability: p.hold_probability,
        flags: p.flags,
        validity: p.validity,
        work_ms: line.work_ms,
        samples_per_s: line.samples_per_s,
    }
}

/// Position (m) and quaternion `w, x, y, z`.
type At = ([f64; 3], [f64; 4]);

/// Where things are.
struct Frames {
    /// In the world; the origin where no sample tells.
    gripper: At,
    /// In the gripper, by the model.
    object: At,
    /// In the world.
    measured: Option<At>,
    /// In the world.
    pusher: Option<At>,
}

impl Frames {
    fn of(prediction: &Prediction, state: &State) -> Self {
        let at = |pose: &wire::Pose| (pose.position_m.map(f64::from), pose.quaternion.map(f64::from));
        let sample = state.sample.as_ref();
        Self {
            gripper: sample.and_then(|s| s.gripper.as_ref()).map_or(([0.0; 3], [1.0, 0.0, 0.0, 0.0]), at),
            object: (prediction.position_m.map(f64::from), prediction.quaternion.map(f64::from)),
            measured: sample.and_then(|s| s.object.as_ref()).map(at),
            pusher: sample.and_then(|s| s.pusher.as_ref()).map(at),
        }
    }

    fn transforms(&self, stamp: Stamp) -> Vec<FrameTransform> {
        let one = |parent: &str, child: &str, at: At| FrameTransform {
            timestamp: stamp.message(),
            parent_frame_id: parent.to_owned(),
            child_frame_id: child.to_owned(),
            translation: Some(vector(at.0)),
            rotation: Some(quaternion(at.1)),
        };
        let known = [
            Some(("world", "gripper", self.gripper)),
            Some(("gripper", "object", self.object)),
            self.measured.map(|at| ("world", "object_measured", at)),
            self.pusher.map(|at| ("world", "pusher", at)),
        ];
        known.into_iter().flatten().map(|(parent, child, at)| one(parent, child, at)).collect()
    }

    fn poses(&self, stamp: Stamp) -> PosesInFrame {
        let pose = |at: At| Pose { position: Some(vector(at.0)), orientation: Some(quaternion(at.1)) };
        let poses = [Some(then(self.gripper, self.object)), self.measured];
        PosesInFrame {
            timestamp: stamp.message(),
            frame_id: "world".to_owned(),
            poses: poses.into_iter().flatten().map(pose).collect(),
        }
    }
}

/// `inner` of the frame `outer`, where `outer` is given.
fn then((p, q): At, (inner_p, inner_q): At) -> At {
    let turned = turn(q, inner_p);
    (std::array::from_fn(|k| p[k] + turned[k]), times(q, inner_q))
}

fn times([aw, ax, ay, az]: [f64; 4], [bw, bx, by, bz]: [f64; 4]) -> [f64; 4] {
    [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
}

fn turn(q: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [w, i, j, k] = q;
    let [_, x, y, z] = times(times(q, [0.0, x, y, z]), [w, -i, -j, -k]);
    [x, y, z]
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> Quaternion {
    Quaternion { x, y, z, w }
}

fn colour(r: f64, g: f64, b: f64, a: f64) -> Option<Color> {
    Some(Color { r, g, b, a })
}

/// The object; friction limit and force along the pad of each finger.
fn drawn(scene: &Scene<f32>, prediction: &Prediction, state: &State, stamp: Stamp) -> SceneUpdate {
    let mut entities = vec![entity("object", "object", stamp)];
    solid(&scene.object.shape, &mut entities[0]);
    let half_width = f64::from(half_width_m(scene));
    let pad = f64::from(pad_radius_m(scene));
    for finger in 0..2 {
        let name = format!("finger{}", finger + 1);
        let mut drawing = entity(&name, "gripper", stamp);
        let y = if finger == 0 { half_width } else { -half_width };
        let force = shown_wrench(finger, prediction, state);
        let limit = f64::from(friction_limit_n(force[1], prediction)) * M_PER_N;
        let beyond = used(&prediction.finger[finger]) >= 1.0;
        drawing.lines.push(circle(y, limit, colour(0.9, 0.2, 0.2, 1.0)));
        if pad > 0.0 {
            drawing.lines.push(circle(y, pad, colour(0.5, 0.5, 0.5, 0.6)));
        }
        let along = [f64::from(force[0]), f64::from(force[2])];
        let red = if beyond { colour(0.9, 0.1, 0.1, 1.0) } else { colour(0.1, 0.6, 0.2, 1.0) };
        drawing.arrows.extend(arrow(y, along, red));
        entities.push(drawing);
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

fn entity(id: &str, frame: &str, stamp: Stamp) -> SceneEntity {
    SceneEntity {
        timestamp: stamp.message(),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

fn solid(shape: &Shape<f32>, entity: &mut SceneEntity) {
    let grey = colour(0.6, 0.6, 0.65, 0.7);
    let at = |orientation| Some(Pose { position: Some(vector([0.0; 3])), orientation: Some(orientation) });
    match shape {
        Shape::Prism { length_m, side_m } => entity.cubes.push(CubePrimitive {
            pose: at(quaternion([1.0, 0.0, 0.0, 0.0])),
            size: Some(vector([f64::from(*length_m), f64::from(*side_m), f64::from(*side_m)])),
            color: grey,
        }),
        Shape::Cylinder { length_m, diameter_m, .. } => {
            // Foxglove's cylinders stand along z, ours lie along x.
            let half = std::f64::consts::FRAC_1_SQRT_2;
            let d = f64::from(*diameter_m);
            entity.cylinders.push(CylinderPrimitive {
                pose: at(quaternion([half, 0.0, half, 0.0])),
                size: Some(vector([d, d, f64::from(*length_m)])),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color: grey,
            });
        }
        Shape::Polygon { vertices_m, height_m } => {
            for z in [-0.5, 0.5].map(|end| end * f64::from(*height_m)) {
                let corner = |v: &[f32; 2]| Point3 { x: f64::from(v[0]), y: f64::from(v[1]), z };
                entity.lines.push(line(vertices_m.iter().map(corner).collect(), grey));
            }
        }
    }
}

/// A closed line through `points`.
fn line(points: Vec<Point3>, color: Option<Color>) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineLoop as i32,
        pose: Some(Pose {
            position: Some(vector([0.0; 3])),
            orientation: Some(quaternion([1.0, 0.0, 0.0, 0.0])),
        }),
        thickness: 2.0,
        scale_invariant: true,
        points,
        color,
        ..LinePrimitive::default()
    }
}

/// About gripper Y at height `y`.
fn circle(y: f64, radius: f64, color: Option<Color>) -> LinePrimitive {
    let corners = 48;
    let point = |k: i32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(corners)).sin_cos();
        Point3 { x: radius * cos, y, z: radius * sin }
    };
    line((0..corners).map(point).collect(), color)
}

/// A force `[x, z]` along the pad at `y`; none where there is no force.
fn arrow(y: f64, [x, z]: [f64; 2], color: Option<Color>) -> Option<ArrowPrimitive> {
    let size = x.hypot(z);
    // A turn about y takes x to the force's direction.
    let half = -z.atan2(x) / 2.0;
    (size.is_finite() && size > 0.0).then(|| ArrowPrimitive {
        pose: Some(Pose {
            position: Some(vector([0.0, y, 0.0])),
            orientation: Some(quaternion([half.cos(), 0.0, half.sin(), 0.0])),
        }),
        shaft_length: 0.8 * size * M_PER_N,
        shaft_diameter: 0.001,
        head_length: 0.2 * size * M_PER_N,
        head_diameter: 0.003,
        color,
    })
}
