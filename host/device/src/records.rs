//! What the records of a run's log hold, and the predictions read back from them.

use stickslip_shared::predictor::Prediction;
use stickslip_shared::wire;

use crate::log::record::Record;

/// Kind of a log's record whose payload is `postcard(Prediction)`: one for each tick, in order.
pub const PREDICTION_RECORD: u8 = 1;
/// Kind of a log's record whose payload is `postcard(TelemetryReport)`, as the board sends it.
pub const TELEMETRY_RECORD: u8 = 2;
/// Kind of a log record: a `wire::Sample` as it was sent.
pub const SAMPLE_RECORD: u8 = 3;

/// The predictions in a log, each with its tick. Telemetry is placed by the number of its
/// sample; reports that repeat one (no new sample) are passed over.
///
/// # Errors
/// A payload that does not decode.
pub fn read_predictions(records: &[Record]) -> Result<Vec<(usize, Prediction)>, postcard::Error> {
    let mut out: Vec<(usize, Prediction)> = Vec::new();
    for r in records {
        match r.kind {
            PREDICTION_RECORD => out.push((out.len(), postcard::from_bytes(&r.payload)?)),
            TELEMETRY_RECORD => {
                let report: wire::TelemetryReport = postcard::from_bytes(&r.payload)?;
                if let Some(tick) = report.sample_seq.and_then(|s| usize::try_from(s).ok())
                    && out.last().is_none_or(|l| l.0 != tick)
                {
                    out.push((tick, report.prediction));
                }
            }
            _ => {}
        }
    }
    Ok(out)
}
