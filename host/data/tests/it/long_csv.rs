//! A recording that is longer than one wants in memory. Takes seconds and disk: `cargo test --release -p stickslip-data
//! --test it long_csv -- --ignored --nocapture`, with `STICKSLIP_CSV_MB=2000` for two gigabytes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::time::Instant;

use stickslip_data::import::recording::import;

const MAPPING: &str = concat!(
    r#"format = "stickslip-mapping/1"
[trials]
constants = { object = "obj4", primitive = "lift" }
"#,
    rig!(),
    r#"[[streams]]
name = "ft"
file = "long.csv"
time = { column = "t" }
[streams.finger1]
force = ["c1", "c2", "c3"]
acts_on = "object"
[fixed.gripper]
position_m = [0.0, 0.0, 0.5]
"#
);

/// Columns beside the time.
const COLUMNS: usize = 40;

/// Largest memory of this process so far, MB, where the system tells.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1000.0)
}

#[test]
#[ignore = "writes a file of 100 MB or more: make test-rest"]
fn of_a_long_csv_memory_holds_the_mapped_columns_and_the_trials_not_the_file() {
    let megabytes: f64 =
        std::env::var("STICKSLIP_CSV_MB").ok().and_then(|mb| mb.parse().ok()).unwrap_or(100.0);
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("long.csv");
    let mut file = BufWriter::new(File::create(&path).expect("created"));
    let header: Vec<String> = (1..=COLUMNS).map(|k| format!("c{k}")).collect();
    writeln!(file, "t,{}", header.join(",")).expect("written");
    let rest = ",-0.034512".repeat(COLUMNS - 3);
    let mut rows = 0u64;
    let mut bytes = 0.0;
    while bytes < megabytes * 1e6 {
        let t = rows as f64 * 1e-3;
        let wave = (t * 3.0).sin();
        let line = format!("{t:.3},{:.6},{:.6},{:.6}{rest}\n", wave, -20.0 + 0.1 * wave, 1.0 - wave);
        bytes += line.len() as f64;
        file.write_all(line.as_bytes()).expect("written");
        rows += 1;
    }
    file.flush().expect("written");
    drop(file);
    let mapping = folder.path().join("m.toml");
    std::fs::write(&mapping, MAPPING).expect("written");
    let (before_mb, began) = (peak_mb(), Instant::now());
    let read = import(&mapping).expect("imports");
    let samples = read.dataset.trials[0].samples.len();
    let grown_mb = peak_mb().zip(before_mb).map(|(after, before)| after - before);
    println!(
        "{:.0} MB, {rows} rows of {} cells, {samples} samples: {grown_mb:?} MB of memory, {:.1} s",
        bytes / 1e6,
        COLUMNS + 1,
        began.elapsed().as_secs_f64()
    );
    assert_eq!(samples as u64, (rows - 1) / 4 + 1);
    assert!(read.bad_rows.is_empty());
    // Time stamps and three columns, copied once to be cut into the trial, and half a kilobyte for each sample.
    let most_mb = 30.0 + (rows as f64 * 4.0 * 8.0 * 4.0 + samples as f64 * 1200.0) / 1e6;
    if let Some(grown_mb) = grown_mb {
        assert!(grown_mb < most_mb, "{grown_mb} of {most_mb} MB");
        assert!(grown_mb < megabytes, "{grown_mb} MB for a file of {megabytes}");
    }
}
