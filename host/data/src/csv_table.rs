//! A trial's table as CSV.

use std::io::Write;
use std::path::Path;

use super::Sample;
use super::columns::{COLUMNS, Cells, EMPTY, cells};
use super::csv_text::CsvText;
use super::error::DatasetError;
use super::table::{TableReader, TableReading};

/// Reads the bytes of `file`; the error of the first bad row is kept beside the rows before it.
///
/// # Errors
/// A header without `t_s`, or with a column twice.
pub fn read(bytes: &[u8], file: &Path) -> Result<TableReading, DatasetError> {
    let mut text = CsvText::open(bytes, file, &COLUMNS)?;
    text.require(0)?;
    let mut table = TableReader::new(file);
    table.unknown_columns(text.unknown());
    // A line of a wide table has some 300 bytes.
    table.reserve(bytes.len() / 300);
    let present: Vec<usize> = (0..COLUMNS.len()).filter(|column| text.has(*column)).collect();
    while let Some(next) = text.next_row() {
        let mut row: Cells = EMPTY;
        let read = next.and_then(|()| {
            for column in &present {
                row[*column] = text.number(*column)?;
            }
            table.push(&row).map_err(|bad| text.refuse_cell(bad.column, bad.problem))
        });
        if let Err(error) = read {
            let last = text.next_row().is_none();
            return Ok(table.stop(error, last));
        }
    }
    if text.ends_within_line() {
        table.warn("the file ends within a line: its last number may be cut");
    }
    Ok(table.finish())
}

/// Writes the columns that any sample fills.
///
/// # Errors
/// What the stream answers.
pub fn write(samples: &[Sample], stream: &mut impl Write) -> std::io::Result<()> {
    let filled = filled_columns(samples);
    let header: Vec<&str> = filled.iter().map(|column| COLUMNS[*column]).collect();
    writeln!(stream, "{}", header.join(","))?;
    for sample in samples {
        let row = cells(sample);
        for (place, column) in filled.iter().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            match row[*column] {
                cell if cell.is_nan() => write!(stream, "{comma}")?,
                // The shortest text that reads back to the same bits.
                cell => write!(stream, "{comma}{cell}")?,
            }
        }
        writeln!(stream)?;
    }
    Ok(())
}

/// `t_s` and every column that some sample fills.
pub(super) fn filled_columns(samples: &[Sample]) -> Vec<usize> {
    let mut filled = [false; COLUMNS.len()];
    filled[0] = true;
    for sample in samples {
        for (filled, cell) in filled.iter_mut().zip(cells(sample)) {
            *filled |= !cell.is_nan();
        }
    }
    (0..COLUMNS.len()).filter(|column| filled[*column]).collect()
}
