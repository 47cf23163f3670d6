//! What is written reads back to the same bits, as CSV and as Parquet; no damage makes the
//! reader panic.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use proptest::prelude::*;
use stickslip_data::{
    ContactSpec, Dataset, Description, FORMAT, ObjectSpec, Pose, Sample, Sensors, TableFormat, Trial,
    TrialInfo, Wrench, read, read_lenient, write, write_as,
};
use tempfile::TempDir;

fn description() -> Description {
    Description {
        format: FORMAT.to_owned(),
        name: "round trip".to_owned(),
        sample_rate_hz: 250.0,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: vec![ObjectSpec {
            id: "obj4".to_owned(),
            shape: "prism".to_owned(),
            length_m: Some(0.1),
            side_m: Some(0.025),
            across_flats_m: None,
            vertices_m: None,
            height_m: None,
            mass_kg: 0.2005,
            inertia_kg_m2: None,
        }],
        fingers: Some(ContactSpec {
            contact: "disc".to_owned(),
            diameter_m: Some(0.02),
            ..ContactSpec::default()
        }),
        pushers: BTreeMap::new(),
        supports: BTreeMap::new(),
        sensors: Sensors::default(),
    }
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, Just(0.0), Just(-0.0), Just(1e-300), Just(f64::MAX)]
}

fn pose() -> impl Strategy<Value = Option<Pose>> {
    let angle = -3.0..3.0f64;
    proptest::option::of(([number(), number(), number()], angle).prop_map(|(position_m, angle)| {
        let quaternion = [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()];
        Pose { position_m, quaternion }
    }))
}

fn wrench() -> impl Strategy<Value = Option<Wrench>> {
    proptest::option::of(
        ([number(), number(), number()], [number(), number(), number()])
            .prop_map(|(force_n, torque_nm)| Wrench { force_n, torque_nm }),
    )
}

fn samples() -> impl Strategy<Value = Vec<Sample>> {
    let sample = (0.001..0.1f64, proptest::option::of(0.0..40.0f64), pose(), pose(), wrench(), wrench());
    proptest::collection::vec(sample, 1..8).prop_map(|rows| {
        let mut t_s = 0.0;
        rows.into_iter()
            .map(|(step, grip_cmd_n, gripper, object, finger, pusher_wrench)| {
                t_s += step;
                Sample {
                    t_s,
                    grip_cmd_n,
                    gripper,
                    object,
                    pusher: None,
                    finger: [finger, None],
                    pusher_wrench,
                }
            })
            .collect()
    })
}

fn dataset(samples: Vec<Sample>, folder: &Path) -> Dataset {
    let info = TrialInfo {
        trial: "a".to_owned(),
        file: "trials/a.csv".to_owned(),
        object: "obj4".to_owned(),
        primitive: "linear_push".to_owned(),
        grip_n: Some(20.0),
        run: Some(1),
        pusher: Some(Pose { position_m: [0.1, 0.0, 0.0], quaternion: [0.0, 0.0, 0.0, 1.0] }),
        extra: BTreeMap::from([("note".to_owned(), "with, comma and \"quotes\"".to_owned())]),
        ..TrialInfo::default()
    };
    Dataset { folder: folder.to_owned(), description: description(), trials: vec![Trial { info, samples }] }
}

/// Shortest form with `-0` kept: equality of bits, not of values.
fn bits(dataset: &Dataset) -> String {
    format!("{:?}", dataset.trials.iter().map(|trial| &trial.samples).collect::<Vec<_>>())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn csv_and_parquet_give_back_what_was_written(samples in samples()) {
        let folder = TempDir::new().expect("folder");
        let written = dataset(samples, folder.path());
        write(&written, folder.path()).expect("written");
        let csv = read(folder.path()).expect("read");
        prop_assert_eq!(&csv, &written);
        prop_assert_eq!(bits(&csv), bits(&written));

        let folder = TempDir::new().expect("folder");
        write_as(&written, folder.path(), TableFormat::Parquet).expect("written");
        let parquet = read(folder.path()).expect("read");
        prop_assert_eq!(bits(&parquet), bits(&csv));
        prop_assert_eq!(parquet.trials[0].info.file.as_str(), "trials/a.parquet");
        prop_assert_eq!(&parquet.trials[0].info.extra, &csv.trials[0].info.extra);
    }

    #[test]
    fn no_damage_to_any_file_makes_the_reader_panic(
        file in 0..4usize,
        at in 0.0..1.0f64,
        damage in prop_oneof![
            any::<u8>().prop_map(Damage::Byte),
            Just(Damage::Cut),
            proptest::collection::vec(any::<u8>(), 1..6).prop_map(Damage::Insert),
        ],
    ) {
        let folder = TempDir::new().expect("folder");
        let sample = Sample { t_s: 0.0, grip_cmd_n: Some(20.0), ..Sample::default() };
        let samples = vec![sample, Sample { t_s: 0.004, ..sample }];
        let format = if file == 3 { TableFormat::Parquet } else { TableFormat::Csv };
        write_as(&dataset(samples, folder.path()), folder.path(), format).expect("written");
        let name = ["dataset.toml", "trials.csv", "trials/a.csv", "trials/a.parquet"][file];
        let path = folder.path().join(name);
        let mut bytes = fs::read(&path).expect("read");
        let at = (at * bytes.len() as f64) as usize;
        match damage {
            Damage::Byte(byte) => bytes[at] = byte,
            Damage::Cut => bytes.truncate(at),
            Damage::Insert(insert) => { bytes.splice(at..at, insert); }
        }
        fs::write(&path, bytes).expect("written");
        // Whatever comes back, it comes back; and strict agrees with lenient on what is good.
        let strict = read(folder.path());
        if let (Ok(strict), Ok(lenient)) = (strict, read_lenient(folder.path())) {
            prop_assert_eq!(lenient.errors, vec![]);
            prop_assert_eq!(bits(&strict), bits(&lenient.dataset));
        }
    }
}

#[derive(Clone, Debug)]
enum Damage {
    Byte(u8),
    Cut,
    Insert(Vec<u8>),
}

#[test]
fn what_the_reader_would_refuse_is_not_written() {
    let folder = TempDir::new().expect("folder");
    let good = Sample { t_s: 0.0, ..Sample::default() };
    let same_time = dataset(vec![good, good], folder.path());
    let error = write(&same_time, folder.path()).expect_err("time stands still");
    assert!(error.to_string().contains("t_s"), "{error}");
    let infinite = Sample { grip_cmd_n: Some(f64::INFINITY), ..good };
    let error = write(&dataset(vec![infinite], folder.path()), folder.path()).expect_err("inf");
    assert!(error.to_string().contains("grip_cmd_n"), "{error}");
    let pose = Pose { position_m: [f64::NAN, 0.0, 0.0], quaternion: [1.0, 0.0, 0.0, 0.0] };
    let unknown = Sample { object: Some(pose), ..good };
    let error = write(&dataset(vec![unknown], folder.path()), folder.path()).expect_err("NaN");
    assert!(error.to_string().contains("object_x_m"), "{error}");
    assert!(!folder.path().join("dataset.toml").exists(), "nothing half written");
}
