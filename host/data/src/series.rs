//! Time series as one table, CSV or Parquet by the file's ending: a row for each sample, the trial's
//! name first, then named columns of numbers (SI units, the unit as suffix) or of words.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::error::{DatasetError, Problem};
use super::stage::Partial;

/// Values of a column; all columns of a trial are equally long.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// NaN: an empty cell.
    Numbers(Vec<f64>),
    /// Empty: an empty cell.
    Words(Vec<String>),
}

/// The series of one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Id of the trial.
    pub trial: String,
    /// Names and values.
    pub columns: Vec<(String, Values)>,
}

impl Series {
    fn rows(&self) -> usize {
        let length = |values: &Values| match values {
            Values::Numbers(x) => x.len(),
            Values::Words(x) => x.len(),
        };
        self.columns.iter().map(|(_, values)| length(values)).max().unwrap_or(0)
    }
}

/// Writes the series of one trial after the other. The columns are those of the first trial.
pub struct SeriesWriter {
    path: PathBuf,
    partial: Partial,
    columns: Vec<(String, bool)>,
    sink: Sink,
}

enum Sink {
    Csv(Box<csv::Writer<BufWriter<File>>>),
    #[cfg(feature = "parquet")]
    Parquet(Option<parquet_sink::Writer>, Option<File>),
}

impl SeriesWriter {
    /// Makes the file, which appears with [`Self::finish`]; its ending (`.csv` or `.parquet`) says the format.
    ///
    /// # Errors
    /// Another ending; a file that cannot be made.
    pub fn create(path: &Path) -> Result<Self, DatasetError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let make =
            || Partial::begin(path).map_err(|e| DatasetError::of_file(path, Problem::Io(e.to_string())));
        let (partial, sink) = match ending {
            "csv" => {
                let (partial, file) = make()?;
                (partial, Sink::Csv(Box::new(csv::Writer::from_writer(BufWriter::new(file)))))
            }
            #[cfg(feature = "parquet")]
            "parquet" => {
                let (partial, file) = make()?;
                (partial, Sink::Parquet(None, Some(file)))
            }
            _ => {
                let text = "a time series is written as .csv or .parquet; give the file one of these endings";
                return Err(DatasetError::of_file(path, Problem::Io(text.into())));
            }
        };
        Ok(Self { path: path.to_owned(), partial, columns: Vec::new(), sink })
    }

    /// Writes a trial. A column that it lacks stays empty, one that the first trial lacked is left out.
    ///
    /// # Errors
    /// What the file system or the library answers.
    pub fn write(&mut self, series: &Series) -> Result<(), DatasetError> {
        let first = self.columns.is_empty();
        if first {
            let numbers = |values: &Values| matches!(values, Values::Numbers(_));
            self.columns = series.columns.iter().map(|(name, v)| (name.clone(), numbers(v))).collect();
        }
        let rows = series.rows();
        let columns: Vec<Option<&Values>> = self
            .columns
            .iter()
            .map(|(name, _)| series.columns.iter().find(|(n, _)| n == name).map(|(_, values)| values))
            .collect();
        let result = match &mut self.sink {
            Sink::Csv(writer) => {
                let header =
                    std::iter::once("trial").chain(self.columns.iter().map(|(name, _)| name.as_str()));
                let head = if first { writer.write_record(header) } else { Ok(()) };
                head.and_then(|()| {
                    (0..rows).try_for_each(|row| {
                        let cells = columns.iter().map(|values| cell(*values, row));
                        writer.write_record(std::iter::once(series.trial.clone()).chain(cells))
                    })
                })
                .map_err(|e| e.to_string())
            }
            #[cfg(feature = "parquet")]
            Sink::Parquet(writer, file) => {
                parquet_sink::write(writer, file, (&self.columns, &columns), (&series.trial, rows))
                    .map_err(|e| e.to_string())
            }
        };
        result.map_err(|text| DatasetError::of_file(&self.path, Problem::Io(text)))
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What the file system or the library answers.
    pub fn finish(self) -> Result<(), DatasetError> {
        let result = match self.sink {
            Sink::Csv(writer) => writer
                .into_inner()
                .map_err(|e| e.to_string())
                .and_then(|mut stream| stream.flush().map_err(|e| e.to_string())),
            #[cfg(feature = "parquet")]
            Sink::Parquet(writer, _) => {
                writer.map_or(Ok(()), |w| w.close().map(|_| ()).map_err(|e| e.to_string()))
            }
        };
        let moved = result.and_then(|()| self.partial.finish().map_err(|e| e.to_string()));
        moved.map_err(|text| DatasetError::of_file(&self.path, Problem::Io(text)))
    }
}

fn cell(values: Option<&Values>, row: usize) -> String {
    match values {
        Some(Values::Numbers(x)) => {
            x.get(row).filter(|x| !x.is_nan()).map_or_else(String::new, ToString::to_string)
        }
        Some(Values::Words(x)) => x.get(row).cloned().unwrap_or_default(),
        None => String::new(),
    }
}

#[cfg(feature = "parquet")]
mod parquet_sink {
    //! One row group a trial; all columns but the trial's name are optional.

    use std::fs::File;
    use std::sync::Arc;

    use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
    use parquet::errors::ParquetError;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;

    use super::Values;

    pub type Writer = SerializedFileWriter<File>;

    pub fn write(
        writer: &mut Option<Writer>,
        file: &mut Option<File>,
        (names, columns): (&[(String, bool)], &[Option<&Values>]),
        (trial, rows): (&str, usize),
    ) -> Result<(), ParquetError> {
        if let (None, Some(file)) = (&writer, file.take()) {
            *writer = Some(begin(names, file)?);
        }
        let Some(writer) = writer else { return Ok(()) };
        let mut group = writer.next_row_group()?;
        if let Some(mut column) = group.next_column()? {
            let name = ByteArray::from(trial);
            column.typed::<ByteArrayType>().write_batch(&vec![name; rows], None, None)?;
            column.close()?;
        }
        for ((_, numbers), values) in names.iter().zip(columns) {
            let Some(mut column) = group.next_column()? else { break };
            if *numbers {
                let all: &[f64] = if let Some(Values::Numbers(x)) = values { x } else { &[] };
                let at = |row: usize| all.get(row).copied().filter(|x| !x.is_nan());
                let levels: Vec<i16> = (0..rows).map(|row| i16::from(at(row).is_some())).collect();
                let known: Vec<f64> = (0..rows).filter_map(at).collect();
                column.typed::<DoubleType>().write_batch(&known, Some(&levels), None)?;
            } else {
                let all: &[String] = if let Some(Values::Words(x)) = values { x } else { &[] };
                let at = |row: usize| all.get(row).filter(|x| !x.is_empty());
                let levels: Vec<i16> = (0..rows).map(|row| i16::from(at(row).is_some())).collect();
                let known: Vec<ByteArray> =
                    (0..rows).filter_map(at).map(|x| ByteArray::from(x.as_str())).collect();
                column.typed::<ByteArrayType>().write_batch(&known, Some(&levels), None)?;
            }
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    fn begin(names: &[(String, bool)], file: File) -> Result<Writer, ParquetError> {
        let words = |name: &str, repetition| {
            Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
                .with_converted_type(ConvertedType::UTF8)
                .with_repetition(repetition)
                .build()
        };
        let mut fields = vec![Arc::new(words("trial", Repetition::REQUIRED)?)];
        for (name, numbers) in names {
            let field = match numbers {
                true => Type::primitive_type_builder(name, Physical::DOUBLE)
                    .with_repetition(Repetition::OPTIONAL)
                    .build(),
                false => words(name, Repetition::OPTIONAL),
            };
            fields.push(Arc::new(field?));
        }
        let schema = Type::group_type_builder("series").with_fields(fields).build()?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
    }
}
