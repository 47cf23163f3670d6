//! The manual's page of the format, the reader's list and the reader itself are one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use stickslip_data::schema::{self, expand, markdown};
use stickslip_data::{
    ContactSpec, Description, FORMAT, ObjectSpec, PoseSensor, Sensors, WrenchSensor, read_lenient,
};

/// A description in which every key is given.
fn full() -> Description {
    let contact = ContactSpec {
        contact: "line".into(),
        diameter_m: Some(0.02),
        length_m: Some(0.02),
        tip_radius_m: Some(0.001),
        points_m: Some(vec![[0.0, 0.0]]),
    };
    let wrench = WrenchSensor {
        force_noise_n: 0.1,
        force_uncertainty_n: 0.1,
        torque_noise_nm: 0.1,
        torque_uncertainty_nm: 0.1,
    };
    Description {
        format: FORMAT.into(),
        name: "full".into(),
        sample_rate_hz: 250.0,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: vec![ObjectSpec {
            id: "o".into(),
            shape: "prism".into(),
            length_m: Some(0.1),
            side_m: Some(0.1),
            across_flats_m: Some(0.1),
            vertices_m: Some(vec![[0.0, 0.0]]),
            height_m: Some(0.1),
            mass_kg: 0.1,
            inertia_kg_m2: Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        }],
        fingers: Some(contact.clone()),
        pushers: BTreeMap::from([("<primitive>".to_owned(), contact.clone())]),
        supports: BTreeMap::from([("<primitive>".to_owned(), contact)]),
        sensors: Sensors {
            finger: wrench,
            pusher: wrench,
            pose: PoseSensor { position_noise_m: 0.1, rotation_noise_rad: 0.1 },
        },
    }
}

fn keys(value: &toml::Value, prefix: &str, found: &mut BTreeSet<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                let dot = if prefix.is_empty() { "" } else { "." };
                keys(value, &format!("{prefix}{dot}{key}"), found);
            }
        }
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            items.iter().for_each(|item| keys(item, prefix, found));
        }
        _ => {
            found.insert(prefix.to_owned());
        }
    }
}

#[test]
fn the_list_of_columns_is_what_the_reader_reads() {
    assert!(schema::is_what_the_reader_reads());
}

/// A contact's sizes belong to some contacts only, so the list has fewer keys than the struct
/// could hold: those of its kinds.
#[test]
fn the_list_of_keys_is_what_the_reader_reads() {
    let mut read = BTreeSet::new();
    keys(&toml::Value::try_from(full()).expect("a table"), "", &mut read);
    let listed: BTreeSet<String> = schema::KEYS.iter().flat_map(|entry| expand(entry.name)).collect();
    let strangers: Vec<_> = listed.difference(&read).collect();
    assert!(strangers.is_empty(), "not read: {strangers:?}");
    let of_contacts =
        |key: &str| ["fingers.", "pushers.", "supports."].iter().any(|table| key.starts_with(table));
    let forgotten: Vec<_> = read.difference(&listed).filter(|key| !of_contacts(key)).collect();
    assert!(forgotten.is_empty(), "not listed: {forgotten:?}");
}

#[test]
fn the_manual_has_the_tables_of_the_readers_list() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/dataset.md");
    let page = fs::read_to_string(page).expect("the manual");
    for (what, entries) in [("key", schema::KEYS), ("column", schema::TRIALS), ("column", schema::TABLE)] {
        let table = markdown(what, entries);
        assert!(page.contains(&table), "docs/dataset.md lacks this table as it stands:\n{table}");
    }
}

#[test]
fn a_name_that_is_nearly_right_is_named_with_what_was_meant() {
    let folder = tempfile::tempdir().expect("folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    let toml = "format = \"stickslip-dataset/1\"\nname = \"x\"\nsample_rate_hz = 250\n\
        gravity_m_s2 = [0, 0, -9.81]\n[[objects]]\nid = \"o\"\nshape = \"prism\"\nlength_m = 0.1\n\
        side_m = 0.1\nmass_kg = 0.2\n[sensors.finger]\nforce_noise_N = 0.02\n";
    fs::create_dir(folder.path().join("trials")).expect("folder");
    write("dataset.toml", toml);
    write("trials.csv", "trial,object,primitive,grip_N,operator\na,o,push,20,Ann\n");
    write("trials/a.csv", "t_s,gripper_x_mm,finger1_fy_N,temperature\n0,1,1,21\n0.004,1,1,21\n");
    let reading = read_lenient(folder.path()).expect("readable");
    let text: Vec<String> = reading.warnings.iter().map(ToString::to_string).collect();
    let text = text.join("\n");
    for hint in [
        "sensors.finger.force_noise_N (did you mean force_noise_n?)",
        "did you mean grip_n?",
        "gripper_x_mm (did you mean gripper_x_m?)",
        "finger1_fy_N (did you mean finger1_fy_n?)",
    ] {
        assert!(text.contains(hint), "{hint} not in\n{text}");
    }
    assert!(!text.contains("operator") && !text.contains("temperature ("), "{text}");
    write("dataset.toml", &toml.replace("mass_kg", "mas_kg"));
    let error = read_lenient(folder.path()).expect_err("a mass is needed").to_string();
    assert!(error.contains("the file has `mas_kg`: did you mean `mass_kg`?"), "{error}");
}
