//! What a viewer receives, by a WebSocket client of its own.

use std::collections::BTreeMap;
use std::net::TcpStream;
use std::time::Duration;

use foxglove::Decode;
use foxglove::messages::{FrameTransforms, Log, PosesInFrame, SceneUpdate};
use serde_json::{Value, json};
use stickslip_live::event::Happened;
use stickslip_live::foxglove::Server;
use stickslip_live::state::State;
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::recorded::events;

type Viewer = WebSocket<MaybeTlsStream<TcpStream>>;

fn connect(server: &Server) -> Viewer {
    let mut request = format!("ws://127.0.0.1:{}", server.port()).into_client_request().expect("a request");
    request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().expect("a header"));
    let (viewer, _) = tungstenite::connect(request).expect("connected");
    if let MaybeTlsStream::Plain(stream) = viewer.get_ref() {
        // What never comes fails the test instead of stopping it.
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    }
    viewer
}

/// The next JSON message of this operation.
fn next(viewer: &mut Viewer, operation: &str) -> Value {
    loop {
        if let Message::Text(text) = viewer.read().expect("a message") {
            let message: Value = serde_json::from_str(&text).expect("JSON");
            if message["op"] == operation {
                return message;
            }
        }
    }
}

/// Topic, log time and body of the next message of a channel.
fn data(viewer: &mut Viewer, topics: &BTreeMap<u32, String>) -> (String, u64, Vec<u8>) {
    loop {
        if let Message::Binary(bytes) = viewer.read().expect("a message")
            && bytes[0] == 1
        {
            let subscription = u32::from_le_bytes(bytes[1..5].try_into().expect("four"));
            let time = u64::from_le_bytes(bytes[5..13].try_into().expect("eight"));
            return (topics[&subscription].clone(), time, bytes[13..].to_vec());
        }
    }
}

/// Foxglove refuses the whole channel where a type is a list, as that of what may be null, or is not given.
fn assert_one_type_each(at: &str, schema: &Value) {
    assert!(schema["type"].is_string(), "{at}: {schema}");
    for (key, value) in schema["properties"].as_object().into_iter().flatten() {
        assert_one_type_each(&format!("{at}.{key}"), value);
    }
    if let Some(items) = schema.get("items") {
        assert_one_type_each(at, items);
    }
}

#[test]
fn a_viewer_receives_wrenches_poses_scene_and_alarms_of_a_recorded_push() {
    let mut server = Server::start("127.0.0.1:0").expect("a server");
    let mut viewer = connect(&server);
    assert_eq!(next(&mut viewer, "serverInfo")["name"], "stickslip");
    let mut channels: BTreeMap<String, Value> = BTreeMap::new();
    while channels.len() < 8 {
        for channel in next(&mut viewer, "advertise")["channels"].as_array().expect("channels") {
            channels.insert(channel["topic"].as_str().expect("a topic").to_owned(), channel.clone());
        }
    }
    for (topic, schema, encoding) in [
        ("/tf", "foxglove.FrameTransforms", "protobuf"),
        ("/poses", "foxglove.PosesInFrame", "protobuf"),
        ("/scene", "foxglove.SceneUpdate", "protobuf"),
        ("/log", "foxglove.Log", "protobuf"),
        ("/wrench/finger1", "stickslip.Wrench", "json"),
        ("/alarm", "stickslip.Alarm", "json"),
        ("/prediction", "stickslip.Outlook", "json"),
    ] {
        assert_eq!(channels[topic]["schemaName"], schema, "{topic}");
        assert_eq!(channels[topic]["encoding"], encoding, "{topic}");
    }
    let layout = include_str!("../../../../docs/foxglove-layout.json");
    let named: Vec<&str> = layout.split('"').filter(|text| text.starts_with('/')).collect();
    assert!(named.len() >= 6, "{named:?}");
    for text in named {
        let (topic, path) = text.split_once('.').unwrap_or((text, ""));
        assert!(channels.contains_key(topic), "the layout in docs has {topic}");
        let field = path.split('[').next().unwrap_or_default();
        let known = || {
            channels[topic]["schema"].as_str().is_some_and(|schema| schema.contains(&format!("\"{field}\"")))
        };
        assert!(field.is_empty() || known(), "the layout in docs has {text}");
    }
    for (topic, channel) in channels.iter().filter(|(_, channel)| channel["encoding"] == "json") {
        let schema = serde_json::from_str(channel["schema"].as_str().expect("text")).expect("JSON");
        assert_one_type_each(topic, &schema);
    }
    let described: Value =
        serde_json::from_str(channels["/wrench/finger1"]["schema"].as_str().expect("text")).expect("JSON");
    assert!(described["properties"]["friction_limit_n"]["description"].is_string(), "{described}");

    let topics: BTreeMap<u32, String> = (0..).zip(channels.keys().cloned()).collect();
    let wanted: Vec<Value> =
        topics.iter().map(|(id, t)| json!({ "id": id, "channelId": channels[t]["id"] })).collect();
    let subscribe = json!({ "op": "subscribe", "subscriptions": wanted }).to_string();
    viewer.send(Message::text(subscribe)).expect("sent");
    // The server has taken the subscriptions when it answers what was sent after them.
    viewer.send(Message::Ping(Vec::new().into())).expect("sent");
    while !matches!(viewer.read().expect("a message"), Message::Pong(_)) {}

    // Up to a sample in the push, and the first alarm.
    let mut state = State::default();
    let mut raised = Vec::new();
    let mut received: BTreeMap<String, (u64, Vec<u8>)> = BTreeMap::new();
    for event in events() {
        let now = state.take(event);
        server.publish(event, &state, &now).expect("published");
        raised.extend(now);
        if !raised.is_empty() && matches!(event.what, Happened::Report(_)) {
            break;
        }
    }
    let at_s = state.now_s;
    let sample = state.sample.expect("a sample");
    let prediction = state.prediction.expect("a prediction");
    // The newest prediction is the last that is published: everything was received when its message is.
    let mut began_ns = None;
    loop {
        let (topic, time, body) = data(&mut viewer, &topics);
        let first = *began_ns.get_or_insert(time);
        received.insert(topic.clone(), (time, body));
        if topic == "/prediction" && (time - first) as f64 * 1e-9 > at_s - 0.002 {
            break;
        }
    }

    let outlook: Value = serde_json::from_slice(&received["/prediction"].1).expect("JSON");
    let number = |key: &str| outlook[key].as_f64().map(|x| x as f32);
    assert!(outlook.as_object().expect("an object").values().all(|value| !value.is_null()), "{outlook}");
    assert_eq!(number("friction_least"), Some(prediction.friction_least));
    assert_eq!(number("hold_probability"), prediction.hold_probability);
    let described = channels["/prediction"]["schema"].as_str().expect("text");
    assert!(described.contains("Probability that the friction suffices"), "{described}");

    let transforms = FrameTransforms::decode(&*received["/tf"].1).expect("transforms").transforms;
    let of = |child: &str| transforms.iter().find(|t| t.child_frame_id == child).expect("a frame");
    let gripper = sample.gripper.expect("measured");
    let there = of("gripper").translation.expect("a place");
    assert_eq!([there.x, there.y, there.z], gripper.position_m.map(f64::from));
    let held = of("object");
    assert_eq!(held.parent_frame_id, "gripper");
    assert_eq!(held.translation.expect("a place").z, f64::from(prediction.position_m[2]));

    let poses = PosesInFrame::decode(&*received["/poses"].1).expect("poses");
    assert_eq!((poses.frame_id.as_str(), poses.poses.len()), ("world", 2));
    let [modelled, measured] = [0, 1].map(|k| poses.poses[k].position.expect("a place"));
    let object = sample.object.expect("measured").position_m.map(f64::from);
    assert_eq!([measured.x, measured.y, measured.z], object);
    // Model and camera see one object: they are not two metres apart, as with a turn the wrong way round.
    let apart = (modelled.x - measured.x).hypot(modelled.y - measured.y).hypot(modelled.z - measured.z);
    assert!(apart < 0.005, "{apart}");

    let wrench: Value = serde_json::from_slice(&received["/wrench/finger1"].1).expect("JSON");
    let [fx, fy, ..] = sample.finger[0].expect("measured");
    assert_eq!(wrench["force_n"]["x"].as_f64().expect("a number") as f32, fx);
    let limit = wrench["friction_limit_n"].as_f64().expect("a number") as f32;
    assert!((limit - prediction.friction * fy.abs()).abs() < 1e-5, "{limit}");

    let scene = SceneUpdate::decode(&*received["/scene"].1).expect("a scene");
    let entity = |id: &str| scene.entities.iter().find(|e| e.id == id).expect("an entity");
    assert_eq!((entity("object").cubes.len(), entity("object").frame_id.as_str()), (1, "object"));
    // The friction limit: a circle whose radius is to the arrow as the limit to the force.
    let finger = entity("finger1");
    let corner = &finger.lines[0].points[0];
    assert!(corner.x > 0.0 && !finger.arrows.is_empty());

    let log = Log::decode(&*received["/log"].1).expect("a line");
    let newest = raised.last().expect("an alarm");
    assert!(log.message.contains(newest.what), "{}", log.message);
    let alarm: Value = serde_json::from_slice(&received["/alarm"].1).expect("JSON");
    assert_eq!(alarm["what"], newest.what);
}

#[test]
fn an_address_that_is_none_or_taken_is_refused_with_a_way_out() {
    let none = Server::start("nowhere").err().expect("no address").to_string();
    assert!(none.contains("127.0.0.1:8765"), "{none}");
    let one = Server::start("127.0.0.1:0").expect("a server");
    let two = Server::start(&format!("127.0.0.1:{}", one.port())).err().expect("taken").to_string();
    assert!(two.contains("another port"), "{two}");
}
