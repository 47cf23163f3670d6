//! ROS 2 bags through a mapping file.

use std::fs;
use std::path::Path;

use nalgebra::Vector3;
use stickslip_data::import::recording::{Import, bag, guess, import};
use stickslip_data::{Pose, Sample};

use crate::recordings::{mapping, write};

/// A bag that Foxglove's own library wrote (`recorded/make_ros2_bag.py`).
const BAG: &[u8] = include_bytes!("recorded/ros2.mcap");

const BAG_STREAMS: &str = r#"
[[streams]]
name = "left"
file = "push.mcap"
topic = "/ft/left"
time = { column = "header.stamp" }
[streams.finger1]
force = ["force.x", "force.y", "force.z"]
torque = ["torque.x", "torque.y", "torque.z"]
acts_on = "object"

[[streams]]
name = "block"
file = "push.mcap"
topic = "/tf"
child_frame = "block"
time = { column = "header.stamp" }
[streams.object]
position = ["translation.x", "translation.y", "translation.z"]
quaternion_wxyz = ["rotation.w", "rotation.x", "rotation.y", "rotation.z"]

[[streams]]
name = "jaw"
file = "push.mcap"
topic = "/joint_states"
time = { column = "header.stamp" }
[streams.grip]
column = "effort.jaw"

[fixed.gripper]
position_m = [0.0, 0.0, 0.5]
"#;

const BAG_TRIALS: &str = "constants = { object = \"obj4\", primitive = \"linear_push\" }";

#[test]
fn a_ros_2_bag_of_another_library_is_read_to_the_numbers_that_were_written() {
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("push.mcap"), BAG).expect("written");
    let path = write(folder.path(), "m.toml", &mapping(BAG_TRIALS, BAG_STREAMS));
    let Import { dataset, refused, bad_rows, .. } = import(&path).expect("imports");
    assert!(refused.is_empty() && bad_rows.is_empty(), "{refused:?} {bad_rows:?}");
    let samples = &dataset.trials[0].samples;
    assert_eq!(samples.len(), 50);
    for (k, sample) in (0..50).map(f64::from).zip(samples) {
        let close = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm() < 1e-5;
        let wrench = sample.finger[0].expect("measured");
        assert!(close(wrench.force_n, [0.01 * k, -20.0, 0.5]), "{k}: {wrench:?}");
        assert!(close(wrench.torque_nm, [0.001 * k, 0.0, -0.002]), "{k}: {wrench:?}");
        let object = sample.object.expect("measured");
        assert!(close(object.position_m, [1.0 + 1e-4 * k, 0.0, 0.5]), "{k}: {object:?}");
        assert!(
            (object.quaternion[0] - 0.8).abs() < 1e-9 && (object.quaternion[3] - 0.6).abs() < 1e-9,
            "{object:?}"
        );
        assert!((sample.grip_cmd_n.expect("measured") - (20.0 + k)).abs() < 1e-3, "{k}");
    }
}

#[test]
fn a_bag_that_lacks_a_topic_or_frame_says_so_and_what_it_has() {
    let folder = tempfile::tempdir().expect("folder");
    let bag = folder.path().join("push.mcap");
    fs::write(&bag, BAG).expect("written");
    let refusal = |from: &str, to: &str| -> String {
        let text = mapping(BAG_TRIALS, BAG_STREAMS);
        assert!(text.contains(from), "{from}");
        let path = write(folder.path(), "wrong.toml", &text.replace(from, to));
        import(&path).expect_err("refused").to_string()
    };
    for (from, to, words) in [
        ("topic = \"/ft/left\"", "topic = \"/ft/lefft\"", vec!["/ft/lefft", "did you mean \"/ft/left\""]),
        (
            "topic = \"/ft/left\"",
            "topic = \"/camera\"",
            vec!["/camera", "/ft/left, /tf, /joint_states, /grip"],
        ),
        ("child_frame = \"block\"", "child_frame = \"blok\"", vec!["blok", "block, hand"]),
        ("child_frame = \"block\"\n", "", vec!["block, hand", "child_frame"]),
        ("\"force.y\"", "\"force_y\"", vec!["force_y", "force.y"]),
        ("topic = \"/joint_states\"\n", "", vec!["streams.jaw", "needs a topic"]),
    ] {
        let refused = refusal(from, to);
        for word in words {
            assert!(refused.contains(word), "{from} -> {to}: {word:?} is not in: {refused}");
        }
    }
}

#[test]
fn of_a_bag_the_guess_makes_a_stream_of_each_topic_and_frame() {
    let folder = tempfile::tempdir().expect("folder");
    let bag = folder.path().join("push.mcap");
    fs::write(&bag, BAG).expect("written");
    let text = guess::guess(&[(&bag, Path::new("push.mcap"))]).expect("guessed");
    for words in [
        "file = \"push.mcap\"",
        "topic = \"/ft/left\"\ntime = { column = \"header.stamp\", unit = \"s\" }",
        "topic = \"/tf\"\nchild_frame = \"block\"",
        "[streams.finger1]   # CHECK: from the columns \"/ft/left\"\nforce = [\"force.x\", \"force.y\", \"force.z\"]",
        "[streams.object]   # CHECK: from the columns \"block\"\nposition = [\"translation.x\"",
        "[streams.gripper]   # CHECK: from the columns \"hand\"",
        "quaternion_wxyz = [\"rotation.w\", \"rotation.x\", \"rotation.y\", \"rotation.z\"]",
        "[streams.grip]   # CHECK: the commanded normal force of each finger?\ncolumn = \"data\"",
        "# No signal was found in this stream: it is left out.\n# [[streams]]\n# name = \"/joint_states\"",
    ] {
        assert!(text.contains(words), "{words} is not in:\n{text}");
    }
    // It reads as it is.
    assert_eq!(import(&write(folder.path(), "m.toml", &text)).expect("imports").dataset.trials.len(), 1);
}

#[test]
fn a_bag_as_ros_2_writes_it_a_folder_is_read_and_one_in_a_database_says_how_to_convert_it() {
    let folder = tempfile::tempdir().expect("folder");
    let bag = folder.path().join("push.mcap");
    fs::create_dir(&bag).expect("a folder");
    fs::write(bag.join("metadata.yaml"), "rosbag2_bagfile_information:").expect("written");
    let path = write(folder.path(), "m.toml", &mapping(BAG_TRIALS, BAG_STREAMS));
    let refused = |words: &str| {
        let named = guess::guess(&[(&bag, Path::new("push.mcap"))]).expect_err("refused").to_string();
        let imported = import(&path).expect_err("refused").to_string();
        assert!(named.contains(words) && imported.contains(words), "{named}\n{imported}");
    };
    refused("a folder without an MCAP file");
    fs::write(bag.join("push_0.db3"), "SQLite format 3\0").expect("written");
    refused("ros2 bag convert");
    fs::write(bag.join("push_0.mcap"), BAG).expect("written");
    assert_eq!(import(&path).expect("imports").dataset.trials[0].samples.len(), 50);
    assert!(guess::guess(&[(&bag, Path::new("push"))]).expect("guessed").contains("topic = \"/ft/left\""));
    fs::write(bag.join("push_1.mcap"), BAG).expect("written");
    refused("a folder with 2 MCAP files");
}

/// Wrench, Pose, PoseStamped and TransformStamped on topics of their own, in chunks of a few messages.
const KINDS: &[u8] = include_bytes!("recorded/ros2_kinds.mcap");

const KINDS_STREAMS: &str = r#"
[[streams]]
name = "ft"
file = "kinds.mcap"
topic = "/ft"
time = { column = "log_time" }
[streams.finger1]
force = ["force.x", "force.y", "force.z"]
torque = ["torque.x", "torque.y", "torque.z"]
acts_on = "object"

[[streams]]
name = "block"
file = "kinds.mcap"
topic = "/block"
time = { column = "header.stamp" }
[streams.object]
position = ["position.x", "position.y", "position.z"]
quaternion_wxyz = ["orientation.w", "orientation.x", "orientation.y", "orientation.z"]

[[streams]]
name = "hand"
file = "kinds.mcap"
topic = "/hand"
time = { column = "publish_time" }
[streams.gripper]
position = ["position.x", "position.y", "position.z"]
quaternion_wxyz = ["orientation.w", "orientation.x", "orientation.y", "orientation.z"]

[[streams]]
name = "rod"
file = "kinds.mcap"
topic = "/rod"
time = { column = "header.stamp" }
[streams.pusher_pose]
position = ["translation.x", "translation.y", "translation.z"]
quaternion_wxyz = ["rotation.w", "rotation.x", "rotation.y", "rotation.z"]
"#;

/// Largest errors of force (N), torque (N m), positions (m), quaternions against what `make_ros2_bag.py` wrote.
fn errors(samples: &[Sample]) -> [f64; 4] {
    let mut worst = [0.0_f64; 4];
    for sample in samples {
        let k = sample.t_s / 0.004;
        let off = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm();
        if let Some(measured) = sample.finger[0] {
            worst[0] = worst[0].max(off(measured.force_n, [0.25 * k, -20.0, 0.5]));
            worst[1] = worst[1].max(off(measured.torque_nm, [0.0, 0.125, -0.001 * k]));
        }
        for (pose, position, rotation) in [
            (sample.object, [1.0 + 1e-4 * k, 0.0, 0.5], [0.8, 0.0, 0.0, 0.6]),
            (sample.gripper, [0.5, 2e-4 * k, 0.25], [0.8, 0.6, 0.0, 0.0]),
            (sample.pusher, [-0.125, 0.0, 3e-4 * k], [0.96, 0.0, 0.28, 0.0]),
        ] {
            let Some(Pose { position_m, quaternion }) = pose else { continue };
            worst[2] = worst[2].max(off(position_m, position));
            let turned = quaternion.iter().zip(rotation).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            worst[3] = worst[3].max(turned);
        }
    }
    worst
}

#[test]
fn wrenches_poses_and_transforms_with_and_without_a_head_are_read_to_the_numbers_that_were_written() {
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("kinds.mcap"), KINDS).expect("written");
    let path = write(folder.path(), "m.toml", &mapping(BAG_TRIALS, KINDS_STREAMS));
    let Import { dataset, refused, bad_rows, .. } = import(&path).expect("imports");
    assert!(refused.is_empty() && bad_rows.is_empty(), "{refused:?} {bad_rows:?}");
    let samples = &dataset.trials[0].samples;
    // The streams begin and end within 2 us of each other.
    assert!((49..=50).contains(&samples.len()), "{}", samples.len());
    let whole = |sample: &&Sample| {
        sample.finger[0].is_some()
            && sample.object.is_some()
            && sample.gripper.is_some()
            && sample.pusher.is_some()
    };
    assert_eq!(samples.iter().filter(whole).count(), samples.len());
    // Time stamps since 1970 as numbers of 64 bits are good to 0.2 us.
    let worst = errors(samples);
    assert!(worst[0] < 1e-3 && worst[1] < 1e-5 && worst[2] < 1e-6 && worst[3] < 1e-9, "{worst:?}");
}

/// Ends of the chunks of an MCAP file in bytes, with the log time of the last message in each, ns.
fn chunks(file: &[u8]) -> Vec<(usize, u64)> {
    let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().expect("eight bytes"));
    let mut found = Vec::new();
    // After the magic bytes: records of a code, a length and a content; 6 is a chunk: its first time, its last.
    let mut at = 8;
    while at + 9 < file.len() {
        let end = at + 9 + usize::try_from(word(at + 1)).expect("fits");
        if file[at] == 6 {
            found.push((end, word(at + 17)));
        }
        at = end;
    }
    found
}

#[test]
fn of_a_bag_that_was_cut_all_whole_chunks_are_kept_and_the_cut_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("kinds.mcap");
    let stream = KINDS_STREAMS.split("[[streams]]").take(2).collect::<Vec<_>>().join("[[streams]]");
    let path = write(folder.path(), "m.toml", &mapping(BAG_TRIALS, &stream));
    let chunks = chunks(KINDS);
    assert!(chunks.len() > 8, "{}", chunks.len());
    // A message on /ft each 4 ms from this time on.
    let written =
        |last: u64| usize::try_from((last - 1_700_000_000_000_000_000) / 4_000_000 + 1).expect("few");
    for (pair, (end, last)) in chunks.windows(2).zip(&chunks) {
        for cut in [end + 1, end + 300, pair[1].0 - 1] {
            fs::write(&file, &KINDS[..cut]).expect("written");
            let table = bag::read(&file, "/ft", None).expect("reads");
            assert!(table.cut.is_some(), "{cut}");
            assert!((written(*last)..50).contains(&table.rows.len()), "{cut}: {}", table.rows.len());
            for (k, row) in (0..).map(f64::from).zip(&table.rows) {
                let force = table.names.iter().position(|name| name == "force.x").expect("a column");
                assert_eq!(row[force], 0.25 * k, "{cut}");
            }
            if table.rows.len() < 2 {
                continue;
            }
            let import = import(&path).expect("imports");
            let why: Vec<&str> = import.bad_rows.iter().map(|(_, row)| row.reason.as_str()).collect();
            assert!(why.len() == 1 && why[0].contains("cannot be read further"), "{why:?}");
            let samples = &import.dataset.trials[0].samples;
            assert!(samples.len() + 1 >= table.rows.len(), "{cut}: {}", samples.len());
            assert!(errors(samples)[0] < 1e-3, "{cut}");
        }
    }
    // Behind the last chunk only the index is missing; before the first there is nothing.
    let (end, _) = chunks[chunks.len() - 1];
    for cut in [end + 1, KINDS.len() - 9] {
        fs::write(&file, &KINDS[..cut]).expect("written");
        assert_eq!(bag::read(&file, "/ft", None).expect("reads").rows.len(), 50, "{cut}");
    }
    for cut in [0, 7, 50] {
        fs::write(&file, &KINDS[..cut]).expect("written");
        let why = import(&path).expect_err("refused").to_string();
        assert!(why.contains("kinds.mcap"), "{cut}: {why}");
    }
}
