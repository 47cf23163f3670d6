//! A file of any bytes in a sound data set, as a model or as a log: it is read, or refused with
//! its name.

use std::fs;
use std::path::Path;

use stickslip_analysis::model::file::ModelFile;
use stickslip_data::Index;
use stickslip_device::log;
use tempfile::TempDir;

/// Files of the data set: two trials, one in each format.
const NAMES: [&str; 4] = ["dataset.toml", "trials.csv", "trials/a.csv", "trials/b.parquet"];
const SOUND: [&[u8]; 4] = [
    include_bytes!("../sound/dataset.toml"),
    include_bytes!("../sound/trials.csv"),
    include_bytes!("../sound/trials/a.csv"),
    include_bytes!("../sound/trials/b.parquet"),
];

thread_local! {
    static FOLDER: TempDir = sound().expect("a temporary folder");
}

fn sound() -> std::io::Result<TempDir> {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { TempDir::new_in(memory)? } else { TempDir::new()? };
    fs::create_dir(folder.path().join("trials"))?;
    for (name, bytes) in NAMES.iter().zip(SOUND) {
        fs::write(folder.path().join(name), bytes)?;
    }
    Ok(folder)
}

/// The first byte chooses what the rest is: one of the data set's files, a model or a log.
pub fn read(bytes: &[u8]) {
    let Some((choice, bytes)) = bytes.split_first() else { return };
    match usize::from(*choice) % 6 {
        4 => model(bytes),
        5 => {
            let contents = log::recover(bytes);
            let kept: usize = contents.records.iter().map(|record| record.payload.len()).sum();
            let lost: usize = contents.lost.iter().map(|lost| lost.bytes).sum();
            // MCAP packs what it keeps.
            let packed = bytes.starts_with(b"\x89MCAP0\r\n");
            let read = if packed { lost } else { kept + lost };
            assert!(read <= bytes.len(), "{kept} bytes kept and {lost} lost of {}", bytes.len());
            let _ = contents.loss();
        }
        which => FOLDER.with(|folder| data_set(folder.path(), which, bytes)),
    }
}

/// What is read is written and read as the same.
fn model(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match ModelFile::parse(text, "model.toml") {
        Ok(file) => {
            let _ = file.to_model();
            let written = file.write();
            let again = ModelFile::parse(&written, "model.toml").expect("what was written is read");
            assert_eq!(again.write(), written);
        }
        Err(error) => assert!(error.to_string().contains("model.toml"), "{error}"),
    }
}

fn data_set(folder: &Path, which: usize, bytes: &[u8]) {
    let Some((name, sound)) = NAMES.get(which).zip(SOUND.get(which)) else { return };
    let path = folder.join(name);
    fs::write(&path, bytes).expect("the folder can be written");
    let folder_name = folder.display().to_string();
    let refused = |error: String| assert!(error.contains(&folder_name), "no file is named: {error}");
    match Index::open(folder) {
        Err(error) => refused(error.to_string()),
        Ok(index) => {
            for info in index.trials.iter().take(4) {
                let _ = index.read_trial_lenient(info);
                if let Err(error) = index.read_trial(info) {
                    refused(error.to_string());
                }
            }
        }
    }
    fs::write(&path, sound).expect("the folder can be written");
}
