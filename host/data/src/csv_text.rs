//! CSV with a header line, read by column names; bad rows are refused one by one.
//!
//! The separator is the comma, or, where the header line has more of them, the semicolon or
//! the tabulator, as spreadsheets of many countries write it. With those a number may have a
//! decimal comma; between commas it cannot.

use std::collections::VecDeque;
use std::io::Read;
use std::path::Path;

use csv::ByteRecord;

use super::error::{DatasetError, Line, Problem};
use super::stamp::Stamp;

/// Read ahead of the row in hand, bytes: of a file of any length no more than this is in memory.
const BLOCK: usize = 1 << 16;
/// The header line is not longer, bytes.
const HEADER: u64 = 1 << 20;

/// A CSV text being read, from bytes or block by block from a stream.
pub struct CsvText<'a, R = &'a [u8]> {
    file: &'a Path,
    reader: csv::Reader<Lines<R>>,
    header: Vec<String>,
    separator: u8,
    columns: &'a [&'a str],
    /// By column of `columns`: its place in the header.
    places: Vec<Option<usize>>,
    record: ByteRecord,
    /// Of the current row.
    line: u64,
    /// The stream cannot be read further.
    failed: bool,
}

impl<'a> CsvText<'a> {
    /// Reads the header of `bytes`.
    ///
    /// # Errors
    /// As [`CsvText::over`].
    pub fn open(bytes: &'a [u8], file: &'a Path, columns: &'a [&'a str]) -> Result<Self, DatasetError> {
        Self::over(bytes, file, columns)
    }
}

impl<'a, R: Read> CsvText<'a, R> {
    /// Reads the header; the known `columns` may be in any order, others may stand between.
    ///
    /// # Errors
    /// An empty file, a known column twice, or what reading answers.
    pub fn over(stream: R, file: &'a Path, columns: &'a [&'a str]) -> Result<Self, DatasetError> {
        let refuse = |problem| DatasetError::of_file(file, problem).at(Line::Text(1));
        let lines = Lines::begin(stream).map_err(|error| refuse(Problem::Csv(error.to_string())))?;
        let separator = separator(&lines.head);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator)
            .buffer_capacity(BLOCK)
            .from_reader(lines);
        let mut record = ByteRecord::new();
        if !reader.read_byte_record(&mut record).unwrap_or(false) {
            return Err(refuse(Problem::Csv("the file is empty; write a header line".to_owned())));
        }
        // A file of another kind would be shown byte by byte in what follows.
        let control = |byte: &u8| *byte < b' ' && !b"\t\r\n".contains(byte);
        if record.as_slice().iter().any(control) {
            return Err(refuse(Problem::Csv("this is no text; is it a file of another kind?".to_owned())));
        }
        let header: Vec<String> =
            record.iter().map(|cell| String::from_utf8_lossy(cell).trim().to_owned()).collect();
        let mut places = Vec::with_capacity(columns.len());
        for column in columns {
            let mut found = header.iter().enumerate().filter(|(_, name)| name == column).map(|(at, _)| at);
            places.push(found.next());
            if found.next().is_some() {
                return Err(refuse(Problem::DuplicateColumn).column(*column));
            }
        }
        let text =
            CsvText { file, reader, header, separator, columns, places, record, line: 1, failed: false };
        Ok(text)
    }

    /// Refuses a header without `column` (index into the known columns).
    ///
    /// # Errors
    /// [`Problem::MissingColumn`] on the header line.
    pub fn require(&self, column: usize) -> Result<(), DatasetError> {
        if self.places[column].is_some() {
            return Ok(());
        }
        Err(DatasetError::of_file(self.file, Problem::MissingColumn)
            .at(Line::Text(1))
            .column(self.columns[column]))
    }

    /// Is the known `column` in the header?
    #[must_use]
    pub fn has(&self, column: usize) -> bool {
        self.places[column].is_some()
    }

    /// Names of the header that are no known columns.
    pub fn unknown(&self) -> impl Iterator<Item = &str> {
        self.header.iter().map(String::as_str).filter(|name| !self.columns.contains(name))
    }

    /// The next row that is not blank; `None` at the end.
    ///
    /// # Errors
    /// A row whose number of cells is not the header's. Reading can go on.
    pub fn next_row(&mut self) -> Option<Result<(), DatasetError>> {
        if self.failed {
            return None;
        }
        let read = self.reader.read_byte_record(&mut self.record);
        if let Some(position) = self.record.position() {
            let start = position.byte();
            self.line = self.reader.get_mut().line_at(start).unwrap_or(self.line);
        }
        match read {
            Ok(false) => None,
            Ok(true) if self.record.len() == self.header.len() => Some(Ok(())),
            Ok(true) => {
                let (cells, columns) = (self.record.len(), self.header.len());
                let cause = if cells > columns && self.separator == b',' {
                    "with decimal commas, separate the cells by semicolons or write decimal points"
                } else {
                    "was the file cut here?"
                };
                let text = format!("the row has {cells} cells, the header has {columns}; {cause}");
                Some(Err(self.refuse(Problem::Csv(text))))
            }
            Err(error) => {
                // The next try would fail the same way, without end.
                self.failed = error.is_io_error();
                Some(Err(self.refuse(Problem::Csv(error.to_string()))))
            }
        }
    }

    /// Text of a known column in the current row, trimmed; empty where the column is absent.
    #[must_use]
    pub fn cell(&self, column: usize) -> &[u8] {
        self.places[column]
            .and_then(|place| self.record.get(place))
            .map(<[u8]>::trim_ascii)
            .unwrap_or_default()
    }

    /// Text of a column by its name.
    #[must_use]
    pub fn text(&self, name: &str) -> String {
        let place = self.header.iter().position(|header| header == name);
        let cell = place.and_then(|place| self.record.get(place)).unwrap_or_default();
        String::from_utf8_lossy(cell).trim().to_owned()
    }

    /// Number of a known column in the current row; NaN where the cell is empty.
    ///
    /// # Errors
    /// What does not parse or is not finite.
    pub fn number(&self, column: usize) -> Result<f64, DatasetError> {
        parse_number(self.cell(column), self.separator != b',')
            .map_err(|problem| self.refuse_cell(column, problem))
    }

    /// Time stamp in a known column of the current row, as exact as it is written.
    #[must_use]
    pub fn stamp(&self, column: usize) -> Option<Stamp> {
        let text = std::str::from_utf8(self.cell(column)).ok()?;
        match self.separator != b',' && !text.contains('.') {
            true => Stamp::parse(&text.replacen(',', ".", 1)),
            false => Stamp::parse(text),
        }
    }

    /// A refusal of the current row.
    #[must_use]
    pub fn refuse(&self, problem: Problem) -> DatasetError {
        DatasetError::of_file(self.file, problem).at(Line::Text(self.line()))
    }

    /// A refusal of a cell of the current row.
    #[must_use]
    pub fn refuse_cell(&self, column: usize, problem: Problem) -> DatasetError {
        let value = String::from_utf8_lossy(self.cell(column)).into_owned();
        let refusal = self.refuse(problem).column(self.columns[column]);
        if value.is_empty() { refusal } else { refusal.value(value) }
    }

    /// Does the text end within a line? Its last number may be cut then.
    #[must_use]
    pub fn ends_within_line(&self) -> bool {
        !matches!(self.reader.get_ref().last, b'\n' | b'\r')
    }

    /// Line of the current row, from 1.
    #[must_use]
    pub fn line(&self) -> u64 {
        self.line
    }
}

/// Bytes on their way to the CSV reader. Counts lines: the reader's own count starts before blank lines and the second
/// half of CRLF.
struct Lines<R> {
    stream: R,
    /// What was read to see the header line.
    head: Vec<u8>,
    /// Bytes of `head` that were handed on.
    handed: usize,
    /// Offset of the next byte.
    at: u64,
    /// Line that it is on.
    line: u64,
    /// Is the line blank so far?
    blank: bool,
    /// Offset of the first byte, and number, of lines that are not blank and are not passed yet.
    starts: VecDeque<(u64, u64)>,
    last: u8,
}

impl<R: Read> Lines<R> {
    fn begin(mut stream: R) -> std::io::Result<Self> {
        let mut head = Vec::new();
        let ended = |head: &[u8]| {
            let line = head.iter().skip_while(|byte| matches!(byte, b'\r' | b'\n'));
            line.clone().any(|byte| matches!(byte, b'\r' | b'\n'))
        };
        while !ended(&head) && (head.len() as u64) < HEADER {
            if stream.by_ref().take(BLOCK as u64).read_to_end(&mut head)? == 0 {
                break;
            }
        }
        if head.starts_with(b"\xef\xbb\xbf") {
            head.drain(..3);
        }
        let starts = VecDeque::new();
        Ok(Lines { stream, head, handed: 0, at: 0, line: 1, blank: true, starts, last: b'\n' })
    }
}

impl<R> Lines<R> {
    /// Line of the first row that begins at offset `start` or, after blank lines, later.
    fn line_at(&mut self, start: u64) -> Option<u64> {
        while self.starts.front().is_some_and(|(at, _)| *at < start) {
            self.starts.pop_front();
        }
        self.starts.front().map(|(_, line)| *line)
    }

    fn count(&mut self, bytes: &[u8]) {
        let mut rest = bytes;
        while let Some(first) = rest.first() {
            let run = if *first == b'\n' {
                self.line += 1;
                self.blank = true;
                1
            } else if self.blank && *first == b'\r' {
                1
            } else {
                if self.blank {
                    self.starts.push_back((self.at, self.line));
                    self.blank = false;
                }
                rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len())
            };
            self.at += run as u64;
            rest = rest.get(run..).unwrap_or_default();
        }
        self.last = bytes.last().copied().unwrap_or(self.last);
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let waiting = self.head.get(self.handed..).unwrap_or_default();
        let count = if waiting.is_empty() {
            self.head = Vec::new();
            self.handed = 0;
            self.stream.read(buffer)?
        } else {
            let count = waiting.len().min(buffer.len());
            buffer[..count].copy_from_slice(&waiting[..count]);
            self.handed += count;
            count
        };
        self.count(&buffer[..count]);
        Ok(count)
    }
}

/// The separator that occurs most often in the header line; the comma where none does.
fn separator(bytes: &[u8]) -> u8 {
    let header = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).find(|line| !line.is_empty());
    let count = |wanted: u8| header.unwrap_or_default().iter().filter(|byte| **byte == wanted).count();
    [b';', b'\t']
        .into_iter()
        .filter(|other| count(*other) > count(b','))
        .max_by_key(|s| count(*s))
        .unwrap_or(b',')
}

fn parse_number(cell: &[u8], decimal_comma: bool) -> Result<f64, Problem> {
    if cell.is_empty() {
        return Ok(f64::NAN);
    }
    let text = std::str::from_utf8(cell).map_err(|_| Problem::NotANumber)?;
    let number: f64 = match decimal_comma && text.contains(',') && !text.contains('.') {
        true => text.replacen(',', ".", 1).parse(),
        false => text.parse(),
    }
    .map_err(|_| Problem::NotANumber)?;
    if number.is_finite() { Ok(number) } else { Err(Problem::NonFinite) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Rows made as they are read: a file of any length.
    struct Rows<'c> {
        left: u64,
        made: Vec<u8>,
        read: &'c Cell<u64>,
    }

    impl Read for Rows<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            while self.made.len() < buffer.len() && self.left > 0 {
                self.left -= 1;
                self.made.extend_from_slice(b"0.004,1.25,-3.5e-2,7\n");
            }
            let count = self.made.len().min(buffer.len());
            buffer[..count].copy_from_slice(&self.made[..count]);
            self.made.drain(..count);
            self.read.set(self.read.get() + count as u64);
            Ok(count)
        }
    }

    #[test]
    fn of_a_long_file_no_more_than_two_blocks_are_in_memory() {
        let (rows, read) = (400_000, Cell::new(0));
        let header = b"t,a,b,c\n".to_vec();
        let stream = Rows { left: rows, made: header, read: &read };
        let mut text = CsvText::over(stream, Path::new("long.csv"), &["t", "b"]).expect("a header");
        let mut used = 8;
        for row in 0..rows {
            text.next_row().expect("a row").expect("sound");
            used += 21;
            assert!(read.get() - used <= 2 * BLOCK as u64, "row {row}: {} bytes ahead", read.get() - used);
            assert!(text.reader.get_ref().starts.len() <= 2 * BLOCK / 21 + 2);
        }
        assert_eq!((text.line(), text.number(1).ok()), (rows + 1, Some(-3.5e-2)));
        assert!(text.next_row().is_none());
    }

    /// Fails after some blocks, as a disk does.
    struct Broken(usize);

    impl Read for Broken {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            if self.0 > 4 * BLOCK {
                return Err(std::io::Error::other("the disk is gone"));
            }
            let count = (buffer.len() / 4 * 4).min(20_000);
            buffer[..count].copy_from_slice(&b"1,2\n".repeat(count / 4));
            self.0 += count;
            Ok(count)
        }
    }

    #[test]
    fn a_stream_that_fails_is_told_once_and_ends() {
        let mut text = CsvText::over(Broken(0), Path::new("a.csv"), &["1"]).expect("a header");
        let rows: Vec<Result<(), DatasetError>> = std::iter::from_fn(|| text.next_row()).collect();
        let errors: Vec<String> =
            rows.iter().filter_map(|row| Some(row.as_ref().err()?.to_string())).collect();
        assert!(rows.len() > BLOCK, "{}", rows.len());
        assert!(errors.len() == 1 && errors[0].contains("the disk is gone"), "{errors:?}");
    }

    #[test]
    fn lines_are_those_of_an_editor_whatever_is_blank_quoted_or_crlf() {
        let text = "\u{feff}\r\n\nt,a\r\n1,2\r\n\r\n3,\"x\ny\"\r\n\n\n5,6";
        let mut rows = CsvText::open(text.as_bytes(), Path::new("a.csv"), &["t"]).expect("a header");
        let mut lines = Vec::new();
        while let Some(row) = rows.next_row() {
            row.expect("sound");
            lines.push((rows.number(0).expect("a number"), rows.line()));
        }
        assert_eq!(lines, [(1.0, 4), (3.0, 6), (5.0, 10)]);
        assert!(rows.ends_within_line());
    }
}
