//! A trial's table as Parquet: one column a name, of any float or integer type; nulls are empty
//! cells.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescriptor, Type};

use super::Sample;
use super::columns::{COLUMNS, EMPTY, cells, position};
use super::csv_table::filled_columns;
use super::error::{DatasetError, Line, Problem};
use super::table::{TableReader, TableReading};

/// Reads `file`, whose content is `bytes`; the error of the first bad row is kept beside the
/// rows before it.
///
/// # Errors
/// What is no Parquet file, a column of text or of a nested type, `t_s` missing.
pub fn read(bytes: Vec<u8>, file: &Path) -> Result<TableReading, DatasetError> {
    // The Parquet library may panic on a damaged file: that is the file's fault, not a crash.
    catch_unwind(AssertUnwindSafe(|| read_columns(bytes, file))).unwrap_or_else(|_| {
        let text = "the Parquet file is damaged; write it again".to_owned();
        Err(DatasetError::of_file(file, Problem::Parquet(text)))
    })
}

fn read_columns(bytes: Vec<u8>, file: &Path) -> Result<TableReading, DatasetError> {
    let broken = |error: ParquetError| {
        let text = format!("not a Parquet file that can be read: {error}; write it again");
        DatasetError::of_file(file, Problem::Parquet(text))
    };
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(broken)?;
    unpacked(&reader).map_err(|problem| DatasetError::of_file(file, problem))?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut table = TableReader::new(file);
    let mut places = Vec::new();
    let mut unknown = Vec::new();
    for (place, column) in schema.columns().iter().enumerate() {
        let name = column.path().string();
        match position(&name) {
            Some(known) if places.iter().any(|(_, other)| *other == known) => {
                return Err(DatasetError::of_file(file, Problem::DuplicateColumn).column(name));
            }
            Some(known) => {
                if let Some(problem) = no_number(column) {
                    return Err(DatasetError::of_file(file, problem).column(name));
                }
                places.push((place, known));
            }
            None => unknown.push(name),
        }
    }
    if !places.iter().any(|(_, known)| *known == 0) {
        return Err(DatasetError::of_file(file, Problem::MissingColumn).column(COLUMNS[0]));
    }
    table.unknown_columns(unknown.iter().map(String::as_str));
    let mut row_number = 0;
    let groups = reader.num_row_groups();
    for group in 0..groups {
        let group_reader = reader.get_row_group(group).map_err(broken)?;
        let mut columns = Vec::with_capacity(places.len());
        for (place, known) in &places {
            let column = read_column(group_reader.as_ref(), *place).map_err(broken)?;
            columns.push((*known, column));
        }
        let rows = columns.iter().map(|(_, column)| column.len()).min().unwrap_or(0);
        for row in 0..rows {
            row_number += 1;
            let mut line = EMPTY;
            let mut refused = None;
            for (known, column) in &columns {
                match column.get(row) {
                    Some(Some(number)) if number.is_finite() => line[*known] = *number,
                    Some(Some(number)) => refused = refused.or(Some((*known, *number))),
                    Some(None) | None => {}
                }
            }
            let outcome = match refused {
                Some((column, number)) => Err((column, Problem::NonFinite, number)),
                None => table.push(&line).map_err(|bad| (bad.column, bad.problem, line[bad.column])),
            };
            if let Err((column, problem, number)) = outcome {
                let empty = number.is_nan() && problem != Problem::NonFinite;
                let error =
                    DatasetError::of_file(file, problem).at(Line::Row(row_number)).column(COLUMNS[column]);
                let error = if empty { error } else { error.value(number.to_string()) };
                return Ok(table.stop(error, row + 1 == rows && group + 1 == groups));
            }
        }
    }
    Ok(table.finish())
}

/// Columns of a table by name.
pub struct Columns {
    /// Every name of the file.
    pub names: Vec<String>,
    /// Of the wanted names: their cells, NaN where empty; `None` where the file has no such column.
    pub found: Vec<Option<Vec<f64>>>,
    /// The first of these, exact, where it is of whole numbers.
    pub whole: Vec<Option<i64>>,
}

/// The columns `wanted` of `file`, whose content is `bytes`.
///
/// # Errors
/// What is no Parquet file; a wanted column of text or of a nested type.
pub fn columns(bytes: Vec<u8>, file: &Path, wanted: &[&str]) -> Result<Columns, DatasetError> {
    let broken = |error: String| {
        DatasetError::of_file(file, Problem::Parquet(format!("not a Parquet file that can be read: {error}")))
    };
    let read = || -> Result<Columns, DatasetError> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes))
            .map_err(|error| broken(error.to_string()))?;
        unpacked(&reader).map_err(|problem| DatasetError::of_file(file, problem))?;
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        let names: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
        let (mut found, mut whole) = (Vec::with_capacity(wanted.len()), Vec::new());
        for name in wanted {
            let Some(place) = names.iter().position(|known| known == name) else {
                found.push(None);
                continue;
            };
            if let Some(problem) = schema.columns().get(place).and_then(|column| no_number(column)) {
                return Err(DatasetError::of_file(file, problem).column(*name));
            }
            let mut cells = Vec::new();
            for group in 0..reader.num_row_groups() {
                let column = reader.get_row_group(group).and_then(|group| read_column(group.as_ref(), place));
                let column = column.map_err(|error| broken(error.to_string()))?;
                cells.extend(column.into_iter().map(|cell| cell.unwrap_or(f64::NAN)));
                if found.is_empty() {
                    let column = reader.get_row_group(group).and_then(|g| read_whole(g.as_ref(), place));
                    whole.extend(column.map_err(|error| broken(error.to_string()))?);
                }
            }
            found.push(Some(cells));
        }
        Ok(Columns { names, found, whole })
    };
    // As in `read`: the library may panic on a damaged file.
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err(broken("it is damaged".to_owned())))
}

/// Of the codecs only Snappy is built in: each further one is one more library to build.
fn unpacked(reader: &SerializedFileReader<bytes::Bytes>) -> Result<(), Problem> {
    let chunks = reader.metadata().row_groups().iter().flat_map(|group| group.columns());
    let mut codecs = chunks.map(|chunk| chunk.compression());
    let other = codecs.find(|codec| !matches!(codec, Compression::UNCOMPRESSED | Compression::SNAPPY));
    other.map_or(Ok(()), |codec| {
        let name = codec.to_string();
        let name = name.split('(').next().unwrap_or_default().to_lowercase();
        Err(Problem::Parquet(format!(
            "compressed with {name}, which this program cannot read; write it with compression=\"snappy\" (polars, \
             pandas, pyarrow)"
        )))
    })
}

/// Why a column holds no plain number; `None` where it does.
fn no_number(column: &ColumnDescriptor) -> Option<Problem> {
    let plain = matches!(
        column.physical_type(),
        Physical::DOUBLE | Physical::FLOAT | Physical::INT32 | Physical::INT64
    );
    let counted = !matches!(
        column.converted_type(),
        ConvertedType::NONE
            | ConvertedType::INT_8
            | ConvertedType::INT_16
            | ConvertedType::INT_32
            | ConvertedType::INT_64
            | ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64
    );
    (!plain || counted || column.max_rep_level() > 0).then(|| {
        Problem::Parquet(format!(
            "the column is of type {} ({}), no plain number; write it as a float column in SI units",
            column.physical_type(),
            column.converted_type()
        ))
    })
}

fn read_column(group: &dyn RowGroupReader, place: usize) -> Result<Vec<Option<f64>>, ParquetError> {
    let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    match group.get_column_reader(place)? {
        ColumnReader::DoubleColumnReader(reader) => numbers(reader, rows, |number| number),
        ColumnReader::FloatColumnReader(reader) => numbers(reader, rows, f64::from),
        ColumnReader::Int32ColumnReader(reader) => numbers(reader, rows, f64::from),
        ColumnReader::Int64ColumnReader(reader) => numbers(reader, rows, |number| number as f64),
        _ => Err(ParquetError::General("a column of another type than its schema".to_owned())),
    }
}

/// The cells of a column of 64-bit whole numbers, which an `f64` may not hold; nothing of any other.
fn read_whole(group: &dyn RowGroupReader, place: usize) -> Result<Vec<Option<i64>>, ParquetError> {
    let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    match group.get_column_reader(place)? {
        ColumnReader::Int64ColumnReader(reader) => numbers(reader, rows, |number| number),
        _ => Ok(Vec::new()),
    }
}

/// `rows` is what the file claims: it bounds a request, it allocates nothing by itself.
fn numbers<T: DataType, N>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    convert: impl Fn(T::T) -> N,
) -> Result<Vec<Option<N>>, ParquetError> {
    let mut cells = Vec::new();
    while cells.len() < rows {
        let mut levels = Vec::new();
        let mut values = Vec::new();
        let batch = (rows - cells.len()).min(4096);
        let (records, _, _) = reader.read_records(batch, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            break;
        }
        let mut values = values.into_iter().map(&convert);
        if levels.is_empty() {
            cells.extend(values.map(Some));
        } else {
            // Level 1 of an optional column: there is a value.
            cells.extend(levels.iter().map(|level| if *level > 0 { values.next() } else { None }));
        }
    }
    Ok(cells)
}

/// Writes the columns that any sample fills, as optional doubles.
///
/// # Errors
/// What the file system or the library answers.
pub fn write(samples: &[Sample], file: File) -> Result<(), ParquetError> {
    let filled = filled_columns(samples);
    let rows: Vec<_> = samples.iter().map(cells).collect();
    let fields = filled
        .iter()
        .map(|column| {
            let repetition = if *column == 0 { Repetition::REQUIRED } else { Repetition::OPTIONAL };
            Type::primitive_type_builder(COLUMNS[*column], Physical::DOUBLE)
                .with_repetition(repetition)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("trial").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))?;
    let mut group = writer.next_row_group()?;
    for column in &filled {
        let Some(mut column_writer) = group.next_column()? else {
            break;
        };
        let column_cells = rows.iter().filter_map(|row| row.get(*column));
        let values: Vec<f64> = column_cells.clone().copied().filter(|cell| !cell.is_nan()).collect();
        let levels: Vec<i16> = column_cells.map(|cell| i16::from(!cell.is_nan())).collect();
        let levels = (*column != 0).then_some(levels.as_slice());
        column_writer.typed::<DoubleType>().write_batch(&values, levels, None)?;
        column_writer.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}
