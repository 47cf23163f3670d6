//! Logs as MCAP files.
//!
//! | topic | messages |
//! |---|---|
//! | `/stickslip/run` | the [`Header`], JSON, once |
//! | `/stickslip/exact` | one byte with the record's kind, then its payload as the device sent it (postcard), as `stickslip.Exact` |
//! | `/stickslip/prediction`, `/telemetry`, `/sample` | the same records as protobuf, schema `stickslip.Prediction`, ... |
//!
//! Only the first two are read again. Logs of before 2026-11-26 have the exact records without a schema, and the others as
//! JSON. `log_time` is that of this machine's clock; the run began at that of `/stickslip/run`.
//!
//! A chunk holds a tenth of a second at most. It is written in one call when it is full: a crash of this program
//! or of the machine cuts the last one at most, and each has a checksum. The reader here takes every intact
//! chunk. The writer adds an index at the end. Without one Foxglove and PlotJuggler 4 read a file through; Rerun opens it after
//! `rerun mcap convert --recover`.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, op};
use mcap::{Compression, McapError, WriteOptions};
use prost::Message as _;
use serde_json::json;
use stickslip_shared::predictor::Prediction;
use stickslip_shared::wire::{Sample, TelemetryReport};

use super::record::{Contents, Header, LogError, MAX_PAYLOAD, Record};
use super::shown;
use crate::records::{PREDICTION_RECORD, SAMPLE_RECORD, TELEMETRY_RECORD};

const RUN: &str = "/stickslip/run";
const EXACT: &str = "/stickslip/exact";
const PROTOBUF: &str = "protobuf";
/// Of a chunk, ns.
const CHUNK_NS: u64 = 100_000_000;
/// The start of a record: operation, length.
const HEAD: usize = 1 + 8;

/// What a log holds.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// One for each tick, in order.
    Prediction(&'a Prediction),
    /// As the board sends it.
    Telemetry(&'a TelemetryReport),
    /// As it was sent to the board.
    Sample(&'a Sample),
}

impl Entry<'_> {
    fn kind(self) -> u8 {
        match self {
            Entry::Prediction(_) => PREDICTION_RECORD,
            Entry::Telemetry(_) => TELEMETRY_RECORD,
            Entry::Sample(_) => SAMPLE_RECORD,
        }
    }

    /// Topic and schema under which it is shown.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Entry::Prediction(_) => ("/stickslip/prediction", "stickslip.Prediction"),
            Entry::Telemetry(_) => ("/stickslip/telemetry", "stickslip.TelemetryReport"),
            Entry::Sample(_) => ("/stickslip/sample", "stickslip.Sample"),
        }
    }

    /// Its kind, and the record as the device sent it.
    fn exact(self) -> io::Result<Vec<u8>> {
        let kind = vec![self.kind()];
        let exact = match self {
            Entry::Prediction(prediction) => postcard::to_extend(prediction, kind),
            Entry::Telemetry(report) => postcard::to_extend(report, kind),
            Entry::Sample(sample) => postcard::to_extend(sample, kind),
        };
        exact.map_err(io::Error::other)
    }

    fn shown(self) -> Vec<u8> {
        match self {
            Entry::Prediction(prediction) => shown::prediction(prediction),
            Entry::Telemetry(report) => shown::report(report),
            Entry::Sample(sample) => shown::sample(sample),
        }
    }
}

/// Writes a log, record by record.
pub struct Writer {
    path: PathBuf,
    file: mcap::Writer<BufWriter<File>>,
    /// When the run began, ns since 1970.
    began_ns: u64,
    exact: u16,
    /// Channels of what is shown, by kind.
    shown: BTreeMap<u8, u16>,
    /// Messages so far.
    sequence: u32,
    /// Host time of the first record of the chunk.
    chunk_from: Option<u64>,
}

impl Writer {
    /// Creates the file; an existing one is not overwritten.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        let io = |error| LogError::Io { file: path.to_owned(), error };
        let file = File::create_new(path).map_err(io)?;
        let mut options = WriteOptions::new().library(concat!("stickslip ", env!("CARGO_PKG_VERSION")));
        // In one call when it is full, instead of a head that is corrected later.
        options = options.disable_seeking(true).compression(Some(Compression::Zstd)).chunk_size(None);
        let mcap = |error| io(answer(error));
        let mut file = options.create(BufWriter::new(file)).map_err(mcap)?;
        let schema = run_schema().to_string();
        let schema = file.add_schema("stickslip.Run", "jsonschema", schema.as_bytes()).map_err(mcap)?;
        let run = file.add_channel(schema, RUN, "json", &BTreeMap::new()).map_err(mcap)?;
        let schema = file.add_schema("stickslip.Exact", PROTOBUF, shown::DESCRIPTORS).map_err(mcap)?;
        let exact = file.add_channel(schema, EXACT, PROTOBUF, &BTreeMap::new()).map_err(mcap)?;
        let began_ns = crate::clock::now_ns();
        let (path, shown) = (path.to_owned(), BTreeMap::new());
        let mut writer = Writer { path, file, began_ns, exact, shown, sequence: 0, chunk_from: None };
        let text = serde_json::to_vec(header).map_err(|error| writer.fail(error.into()))?;
        writer.message(run, 0, &text)?;
        writer.close_chunk()?;
        Ok(writer)
    }

    /// Appends a record at `host_ns` since the run began; from a tenth of a second later on it outlives a crash of
    /// this program.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn record(&mut self, host_ns: u64, entry: Entry<'_>) -> Result<(), LogError> {
        if self.chunk_from.is_some_and(|from| host_ns.saturating_sub(from) >= CHUNK_NS) {
            self.close_chunk()?;
        }
        self.chunk_from.get_or_insert(host_ns);
        let record = entry.exact().map_err(|error| self.fail(error))?;
        self.message(self.exact, host_ns, &shown::Exact { record }.encode_to_vec())?;
        let channel = self.channel(entry)?;
        self.message(channel, host_ns, &entry.shown())
    }

    /// Waits until all records are on the disk: they outlive a crash of the machine.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn sync(&mut self) -> Result<(), LogError> {
        self.close_chunk()?;
        let file = File::open(&self.path).and_then(|file| file.sync_data());
        file.map_err(|error| self.fail(error))
    }

    /// The channel on which it is shown.
    fn channel(&mut self, entry: Entry<'_>) -> Result<u16, LogError> {
        if let Some(channel) = self.shown.get(&entry.kind()) {
            return Ok(*channel);
        }
        let (topic, name) = entry.names();
        let schema = self.file.add_schema(name, PROTOBUF, shown::DESCRIPTORS);
        let channel = schema.and_then(|id| self.file.add_channel(id, topic, PROTOBUF, &BTreeMap::new()));
        let channel = channel.map_err(|error| self.fail(answer(error)))?;
        self.shown.insert(entry.kind(), channel);
        Ok(channel)
    }

    fn message(&mut self, channel_id: u16, host_ns: u64, data: &[u8]) -> Result<(), LogError> {
        let time = self.began_ns.saturating_add(host_ns);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.sequence = self.sequence.wrapping_add(1);
        self.file.write_to_known_channel(&header, data).map_err(|error| self.fail(answer(error)))
    }

    fn close_chunk(&mut self) -> Result<(), LogError> {
        self.chunk_from = None;
        self.file.flush().map_err(|error| self.fail(answer(error)))
    }

    fn fail(&self, error: io::Error) -> LogError {
        LogError::Io { file: self.path.clone(), error }
    }
}

/// Adds the index. What fails here was told or costs the index alone.
impl Drop for Writer {
    fn drop(&mut self) {
        let _ = self.file.finish();
    }
}

fn answer(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// JSON Schema of a [`Header`]. Foxglove asks every object for its properties.
fn run_schema() -> serde_json::Value {
    let bytes = json!({ "type": "array", "items": { "type": "integer" } });
    let meta = json!({ "type": "object", "properties": {} });
    json!({
        "title": "stickslip.Run",
        "type": "object",
        "properties": { "scene": bytes, "model": bytes, "meta": meta }
    })
}

/// Does it begin as an MCAP file, or is it the beginning of one?
pub(super) fn begins(bytes: &[u8]) -> bool {
    mcap::MAGIC.starts_with(bytes) || bytes.starts_with(mcap::MAGIC)
}

/// Records of intact chunks. Where a record's length leads nowhere, the rest is lost.
pub(super) fn recover(bytes: &[u8]) -> Contents {
    let mut contents = Contents { header: None, records: Vec::new(), lost: Vec::new() };
    let mut channels = Channels::default();
    let mut began_ns = None;
    let mut at = mcap::MAGIC.len();
    let mut ended = false;
    while at < bytes.len() && !ended {
        let rest = bytes.get(at..).unwrap_or_default();
        let Some((operation, body)) = record(rest) else { break };
        let size = HEAD + body.len();
        // What stands outside of chunks (index, statistics) is for viewers.
        if operation == op::CHUNK {
            let found = chunk(body).and_then(|inside| messages(&inside, &mut channels));
            match found {
                None => contents.lose(at, at + size, bytes.len()),
                Some(found) => {
                    for message in found {
                        take(message, &mut contents, &mut began_ns);
                    }
                }
            }
        }
        ended = operation == op::FOOTER;
        at += size;
    }
    if !ended {
        contents.lose(at, bytes.len(), bytes.len());
    }
    contents
}

/// A message of one of the channels that are read.
enum Message {
    Run {
        log_ns: u64,
        data: Vec<u8>,
    },
    /// Kind and payload.
    Exact {
        log_ns: u64,
        record: Vec<u8>,
    },
}

fn take(message: Message, contents: &mut Contents, began_ns: &mut Option<u64>) {
    match message {
        Message::Run { log_ns, data } => {
            began_ns.get_or_insert(log_ns);
            contents.header = contents.header.take().or(serde_json::from_slice(&data).ok());
        }
        Message::Exact { log_ns, record } => {
            let host_ns = log_ns.saturating_sub(began_ns.unwrap_or(log_ns));
            if let Some((kind, payload)) = record.split_first() {
                contents.records.push(Record { kind: *kind, host_ns, payload: payload.to_vec() });
            }
        }
    }
}

/// Operation and body of the record at the beginning of `bytes`.
fn record(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (operation, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let body = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    Some((*operation, body))
}

/// A text or bytes with their length before them, and the rest.
fn counted(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

/// The records of a chunk whose checksum is right.
fn chunk(body: &[u8]) -> Option<Vec<u8>> {
    // Begin and end of its time.
    let rest = body.get(16..)?;
    let (size, rest) = rest.split_first_chunk::<8>()?;
    let size = usize::try_from(u64::from_le_bytes(*size)).ok().filter(|size| *size <= 4 * MAX_PAYLOAD)?;
    let (crc, rest) = rest.split_first_chunk::<4>()?;
    let (compression, rest) = counted(rest)?;
    let packed = rest.get(8..)?;
    let inside = match compression {
        b"zstd" => zstd::bulk::decompress(packed, size).ok()?,
        b"" => packed.to_vec(),
        _ => return None,
    };
    let whole = inside.len() == size && crc32fast::hash(&inside) == u32::from_le_bytes(*crc);
    whole.then_some(inside)
}

/// The two channels that are read.
#[derive(Clone, Copy, Default)]
struct Channels {
    run: Option<u16>,
    exact: Option<u16>,
    /// The exact records stand alone, without a schema.
    bare: bool,
}

/// Messages of `inside` on the channels that are read; `None` where its records do not fit.
fn messages(mut inside: &[u8], channels: &mut Channels) -> Option<Vec<Message>> {
    let mut found = Vec::new();
    while !inside.is_empty() {
        let (operation, body) = record(inside)?;
        inside = inside.get(HEAD + body.len()..)?;
        match operation {
            op::CHANNEL => {
                let (id, rest) = body.split_first_chunk::<2>()?;
                let (topic, rest) = counted(rest.get(2..)?)?;
                let (encoding, _) = counted(rest)?;
                let id = Some(u16::from_le_bytes(*id));
                match topic {
                    _ if topic == RUN.as_bytes() => channels.run = id,
                    _ if topic == EXACT.as_bytes() => {
                        channels.exact = id;
                        channels.bare = encoding != PROTOBUF.as_bytes();
                    }
                    _ => {}
                }
            }
            op::MESSAGE => {
                let (id, rest) = body.split_first_chunk::<2>()?;
                let id = Some(u16::from_le_bytes(*id));
                // Sequence number before, time of publishing after.
                let (time, rest) = rest.get(4..)?.split_first_chunk::<8>()?;
                let (log_ns, data) = (u64::from_le_bytes(*time), rest.get(8..)?.to_vec());
                if id == channels.run {
                    found.push(Message::Run { log_ns, data });
                } else if id == channels.exact {
                    let record = match channels.bare {
                        true => data,
                        false => shown::Exact::decode(data.as_slice()).ok()?.record,
                    };
                    found.push(Message::Exact { log_ns, record });
                }
            }
            _ => {}
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::read;
    use proptest::prelude::*;
    use prost_reflect::{DescriptorPool, DynamicMessage};
    use serde_json::Value;

    fn header() -> Header {
        Header { scene: vec![1, 2], model: vec![3], meta: json!({"trial": "a"}) }
    }

    /// Half a second of reports at 250 Hz; one prediction has a NaN, whose bits JSON would lose.
    fn reports() -> Vec<TelemetryReport> {
        let report = |seq: u32| {
            let mut report = TelemetryReport { seq, tick: seq, sample_seq: Some(seq), ..Default::default() };
            report.prediction.sag_m = if seq == 7 { f32::NAN } else { 1e-5 * seq as f32 };
            report
        };
        (0..125).map(report).collect()
    }

    fn exact(report: &TelemetryReport) -> Vec<u8> {
        postcard::to_allocvec(report).expect("bytes")
    }

    /// A log of the reports, and how many bytes it had after each chunk with how many reports.
    fn written() -> (Vec<u8>, Vec<(usize, usize)>) {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.mcap");
        let mut writer = Writer::create(&path, &header()).expect("created");
        let mut chunks = Vec::new();
        for (at, report) in reports().iter().enumerate() {
            let before = std::fs::metadata(&path).expect("file").len();
            writer.record(at as u64 * 4_000_000, Entry::Telemetry(report)).expect("written");
            let after = std::fs::metadata(&path).expect("file").len();
            if after > before {
                chunks.push((after as usize, at));
            }
        }
        writer.sync().expect("synced");
        // The file is readable while the writer is alive.
        assert_eq!(read(&path).expect("read").records.len(), reports().len());
        drop(writer);
        (std::fs::read(&path).expect("read"), chunks)
    }

    #[test]
    fn a_log_reads_back_bit_for_bit_and_one_is_not_overwritten() {
        let (bytes, _) = written();
        let contents = super::super::recover(&bytes);
        assert_eq!(contents.header, Some(header()));
        assert_eq!((contents.lost.len(), contents.loss()), (0, None));
        assert_eq!(contents.records.len(), reports().len());
        for (at, (record, report)) in contents.records.iter().zip(reports()).enumerate() {
            let expected =
                Record { kind: TELEMETRY_RECORD, host_ns: at as u64 * 4_000_000, payload: exact(&report) };
            assert_eq!(*record, expected);
        }
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.mcap");
        Writer::create(&path, &header()).expect("created");
        assert!(matches!(Writer::create(&path, &header()), Err(LogError::Io { .. })));
    }

    #[test]
    fn any_reader_of_mcap_finds_named_schemas_of_protobuf_and_the_values() {
        let (bytes, _) = written();
        let summary = mcap::Summary::read(&bytes).expect("a summary").expect("an index");
        assert_eq!(summary.stats.expect("statistics").message_count, 1 + 2 * reports().len() as u64);
        let mut values = Vec::new();
        for message in mcap::MessageStream::new(&bytes).expect("MCAP") {
            let message = message.expect("a message");
            let channel = &message.channel;
            let schema = channel.schema.as_ref().expect("a schema");
            let names = (&*channel.topic, &*schema.name, &*schema.encoding, &*channel.message_encoding);
            match names {
                ("/stickslip/run", "stickslip.Run", "jsonschema", "json") => {
                    let schema: Value = serde_json::from_slice(&schema.data).expect("JSON");
                    let run: Value = serde_json::from_slice(&message.data).expect("JSON");
                    let keys =
                        |of: &Value| of.as_object().map(|keys| keys.keys().cloned().collect::<Vec<_>>());
                    assert_eq!(keys(&schema["properties"]), keys(&run));
                }
                ("/stickslip/exact", "stickslip.Exact", "protobuf", "protobuf") => {}
                ("/stickslip/telemetry", "stickslip.TelemetryReport", "protobuf", "protobuf") => {
                    let pool = DescriptorPool::decode(&*schema.data).expect("descriptors");
                    let of = pool.get_message_by_name(&schema.name).expect("its message");
                    values.push(DynamicMessage::decode(of, &*message.data).expect("a message"));
                }
                _ => panic!("{names:?}"),
            }
        }
        assert_eq!(values.len(), reports().len());
        for (value, report) in values.iter().zip(reports()) {
            let prediction = value.get_field_by_name("prediction").expect("a prediction");
            let prediction = prediction.as_message().expect("a message").get_field_by_name("sag_m");
            let sag_m = prediction.and_then(|value| value.as_f32()).expect("a number");
            assert_eq!(sag_m.to_bits(), report.prediction.sag_m.to_bits());
        }
    }

    #[test]
    fn a_log_with_bare_records_as_before_protobuf_is_read() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.mcap");
        let mut file = WriteOptions::new().create(File::create(&path).expect("file")).expect("MCAP");
        let none = BTreeMap::new();
        let run = file.add_channel(0, RUN, "json", &none).expect("a channel");
        let bare = file.add_channel(0, EXACT, "postcard", &none).expect("a channel");
        let text = serde_json::to_vec(&header()).expect("JSON");
        let at =
            |channel_id, time| MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        file.write_to_known_channel(&at(run, 1000), &text).expect("written");
        file.write_to_known_channel(&at(bare, 1004), &[SAMPLE_RECORD, 5, 6]).expect("written");
        file.finish().expect("finished");
        drop(file);
        let contents = read(&path).expect("read");
        assert_eq!(contents.header, Some(header()));
        assert_eq!(contents.records, [Record { kind: SAMPLE_RECORD, host_ns: 4, payload: vec![5, 6] }]);
    }

    #[test]
    fn a_log_cut_at_any_byte_keeps_every_chunk_before_the_cut_and_tells_the_loss() {
        let (bytes, chunks) = written();
        assert!(chunks.len() >= 4, "{chunks:?}");
        let mut boundaries = vec![mcap::MAGIC.len()];
        while let Some((_, body)) = record(&bytes[boundaries[boundaries.len() - 1]..]) {
            boundaries.push(boundaries[boundaries.len() - 1] + HEAD + body.len());
        }
        for cut in (0..bytes.len()).step_by(7).chain(chunks.iter().map(|(end, _)| *end)) {
            let contents = super::super::recover(&bytes[..cut]);
            let whole = chunks.iter().rev().find(|(end, _)| *end <= cut).map_or(0, |(_, reports)| *reports);
            let kept = contents.records.len();
            assert!(kept >= whole, "cut at {cut}: {kept} of {whole}");
            for (record, report) in contents.records.iter().zip(reports()) {
                assert_eq!(record.payload, exact(&report), "cut at {cut}");
            }
            // Between two records nothing shows that more was to come.
            let told = contents.loss().is_some() || boundaries.contains(&cut);
            assert!(told || kept == reports().len(), "cut at {cut}: {kept} kept");
        }
    }

    #[test]
    fn what_is_no_log_or_of_another_version_is_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("other");
        std::fs::write(&path, b"t_s,object_x_m\n0,0\n").expect("written");
        assert!(matches!(read(&path), Err(LogError::NotALog { .. })));
        std::fs::write(&path, b"sslog\r\n\x02whatever").expect("written");
        assert!(matches!(read(&path), Err(LogError::Version { version: 2, .. })));
    }

    proptest! {
        #[test]
        fn a_flipped_bit_invents_nothing(at in 0.0..1.0f64, bit in 0..8u32) {
            let (mut bytes, _) = written();
            let at = (at * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << bit;
            let all: Vec<Vec<u8>> = reports().iter().map(exact).collect();
            for record in super::super::recover(&bytes).records {
                prop_assert!(all.contains(&record.payload));
            }
        }

        #[test]
        fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let all = [mcap::MAGIC, &bytes].concat();
            prop_assert!(super::super::recover(&all).records.is_empty());
        }
    }
}
