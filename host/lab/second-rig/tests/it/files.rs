//! What is written: the format of the data set, the key apart, the same bytes for the same seed.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use stickslip_second_rig::dataset::{DataSet, Wish};
use stickslip_second_rig::families::{FAMILIES, Family};
use stickslip_second_rig::{Error, write};

fn make(family: &str, seed: u64, trials: usize, folder: &Path) -> DataSet {
    let wish = Wish { effects: None, trials: Some(trials) };
    let set = DataSet::draw(Family::named(family).expect("a family"), seed, &wish).expect("drawn");
    let runs = set.run();
    write::write(&set, &runs, &folder.join("data"), &folder.join("key.json")).expect("written");
    set
}

fn all_files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            out.extend(all_files(&path));
        } else {
            out.insert(path.file_name().unwrap().to_string_lossy().into(), fs::read(&path).unwrap());
        }
    }
    out
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_one_thread_or_many() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    make("bench-wide", 12, 4, a.path());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| make("bench-wide", 12, 4, b.path()));
    assert_eq!(all_files(a.path()), all_files(b.path()));
    let c = tempfile::tempdir().unwrap();
    make("bench-wide", 13, 4, c.path());
    assert_ne!(all_files(a.path()), all_files(c.path()));
}

#[test]
fn columns_header_and_rows_are_those_of_the_format() {
    for (family, seed) in
        [("bench-hard", 1), ("bench-planar", 2), ("grasp-soft", 3), ("bench-poor-sensors", 4)]
    {
        let dir = tempfile::tempdir().unwrap();
        let set = make(family, seed, 4, dir.path());
        let data = dir.path().join("data");
        let header: toml::Table = fs::read_to_string(data.join("dataset.toml")).unwrap().parse().unwrap();
        assert_eq!(header["format"].as_str(), Some("stickslip-dataset/1"));
        assert_eq!(header["gravity_m_s2"].as_array().map(Vec::len), Some(3));
        let index = fs::read_to_string(data.join("trials.csv")).unwrap();
        assert!(index.starts_with(
            "trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,\
             pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz"
        ));
        let allowed: Vec<String> = columns();
        let mut index = csv::Reader::from_reader(index.as_bytes());
        let rows: Vec<BTreeMap<String, String>> = index.deserialize().map(Result::unwrap).collect();
        assert_eq!(rows.len(), set.trials.len());
        for row in rows {
            assert!(
                header["objects"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|o| o["id"].as_str() == Some(&row["object"]))
            );
            let mut table = csv::Reader::from_path(data.join(&row["file"])).unwrap();
            let head: Vec<String> = table.headers().unwrap().iter().map(String::from).collect();
            assert!(head.iter().all(|c| allowed.contains(c)), "{head:?}");
            let mut last = -1.0;
            for record in table.records().map(Result::unwrap) {
                let cell: BTreeMap<&str, f64> = head
                    .iter()
                    .zip(record.iter())
                    .filter(|(_, v)| !v.is_empty())
                    .map(|(k, v)| (k.as_str(), v.parse().unwrap()))
                    .collect();
                assert!(cell.values().all(|v: &f64| v.is_finite()));
                assert!(cell["t_s"] > last);
                last = cell["t_s"];
                if let Some(w) = cell.get("object_qw") {
                    let rest = ["object_qx", "object_qy", "object_qz"].map(|k| cell[k] * cell[k]);
                    assert!((w * w + rest.iter().sum::<f64>() - 1.0).abs() < 1e-6);
                }
            }
            assert!(last > 0.2, "{family} {}: {last} s", row["trial"]);
        }
    }
}

fn columns() -> Vec<String> {
    let mut out = vec!["t_s".to_owned(), "grip_cmd_n".to_owned()];
    for body in ["gripper", "object", "pusher"] {
        out.extend(["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(|c| format!("{body}_{c}")));
    }
    for body in ["finger1", "finger2", "pusher"] {
        out.extend(["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"].map(|c| format!("{body}_{c}")));
    }
    out
}

#[test]
fn a_key_inside_the_data_set_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let wish = Wish { effects: None, trials: Some(1) };
    let set = DataSet::draw(&FAMILIES[0], 1, &wish).unwrap();
    let data = dir.path().join("data");
    let result = write::write(&set, &[], &data, &data.join("key.json"));
    assert!(matches!(result, Err(Error::KeyInside(_))), "{result:?}");
}

#[test]
fn nothing_in_the_data_set_names_what_is_hidden() {
    let dir = tempfile::tempdir().unwrap();
    let wish = Wish { effects: Some(vec![("plate_tilt".into(), None)]), trials: Some(2) };
    let set = DataSet::draw(Family::named("bench-hard").unwrap(), 5, &wish).unwrap();
    let runs = set.run();
    write::write(&set, &runs, &dir.path().join("data"), &dir.path().join("key.json")).unwrap();
    for (name, bytes) in all_files(&dir.path().join("data")) {
        assert!(!String::from_utf8_lossy(&bytes).contains("tilt"), "{name}");
    }
    assert!(fs::read_to_string(dir.path().join("key.json")).unwrap().contains("plate_tilt"));
}
