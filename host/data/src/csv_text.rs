//! CSV with a header line, read by column names; bad rows are refused one by one.
//!
//! The separator is the comma, or, where the header line has more of them, the semicolon or
//! the tabulator, as spreadsheets of many countries write it. With those a number may have a
//! decimal comma; between commas it cannot.

use std::path::Path;

use csv::ByteRecord;

use super::error::{DatasetError, Line, Problem};

/// A CSV text being read.
pub struct CsvText<'a> {
    bytes: &'a [u8],
    file: &'a Path,
    reader: csv::Reader<&'a [u8]>,
    header: Vec<String>,
    separator: u8,
    columns: &'a [&'a str],
    /// By column of `columns`: its place in the header.
    places: Vec<Option<usize>>,
    record: ByteRecord,
}

impl<'a> CsvText<'a> {
    /// Reads the header; the known `columns` may be in any order, others may stand between.
    ///
    /// # Errors
    /// An empty file, or a known column twice.
    pub fn open(bytes: &'a [u8], file: &'a Path, columns: &'a [&'a str]) -> Result<Self, DatasetError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let separator = separator(bytes);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator)
            .from_reader(bytes);
        let mut record = ByteRecord::new();
        let refuse = |problem| DatasetError::of_file(file, problem).at(Line::Text(1));
        if !reader.read_byte_record(&mut record).unwrap_or(false) {
            return Err(refuse(Problem::Csv("the file is empty; write a header line".to_owned())));
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
        Ok(CsvText { bytes, file, reader, header, separator, columns, places, record })
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
        match self.reader.read_byte_record(&mut self.record) {
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
            Err(error) => Some(Err(self.refuse(Problem::Csv(error.to_string())))),
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
        !self.bytes.ends_with(b"\n") && !self.bytes.ends_with(b"\r")
    }

    /// Line of the current row, from 1. Counted here because the reader's own count starts
    /// before blank lines and the second half of CRLF.
    #[must_use]
    pub fn line(&self) -> u64 {
        let start = self.record.position().map_or(0, csv::Position::byte) as usize;
        let blank = self.bytes.get(start..).unwrap_or_default();
        let start = start + blank.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        let before = self.bytes.get(..start).unwrap_or(self.bytes);
        before.iter().filter(|byte| **byte == b'\n').count() as u64 + 1
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
    let with_point = match decimal_comma && !text.contains('.') {
        true => text.replacen(',', ".", 1),
        false => text.to_owned(),
    };
    let number: f64 = with_point.parse().map_err(|_| Problem::NotANumber)?;
    if number.is_finite() { Ok(number) } else { Err(Problem::NonFinite) }
}
