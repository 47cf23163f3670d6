//! How long a data set takes to read: `cargo run --release --example read_time -- DATA [PARQUET]`.
//! With a second folder the data set is written there as Parquet and read again.

use std::path::Path;
use std::time::Instant;

use stickslip_host::dataset::{TableFormat, read, write_as};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = arguments.first().ok_or("give the folder of a data set")?;
    let dataset = timed(Path::new(folder))?;
    if let Some(parquet) = arguments.get(1).map(Path::new) {
        write_as(&dataset, parquet, TableFormat::Parquet)?;
        drop(dataset);
        timed(parquet)?;
    }
    Ok(())
}

fn timed(folder: &Path) -> Result<stickslip_host::dataset::Dataset, Box<dyn std::error::Error>> {
    let start = Instant::now();
    let dataset = read(folder)?;
    let samples: usize = dataset.trials.iter().map(|trial| trial.samples.len()).sum();
    println!(
        "{}: {} trials, {samples} samples in {:.2} s",
        folder.display(),
        dataset.trials.len(),
        start.elapsed().as_secs_f64()
    );
    Ok(dataset)
}
