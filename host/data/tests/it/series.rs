//! Time series as CSV and Parquet: what is written stands in the file, by name.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use stickslip_data::series::{Series, SeriesWriter, Values};

fn trial(name: &str, rows: usize) -> Series {
    let numbers = |from: f64| Values::Numbers((0..rows).map(|i| from + i as f64).collect());
    let mut gaps = vec![f64::NAN; rows];
    gaps[0] = 0.1 + 0.2;
    let words = Values::Words(
        (0..rows).map(|i| if i == 1 { "slip, \"now\"".into() } else { String::new() }).collect(),
    );
    let columns = [("t_s", numbers(0.0)), ("measured_fx_n", Values::Numbers(gaps)), ("status", words)];
    Series { trial: name.into(), columns: columns.into_iter().map(|(n, v)| (n.to_owned(), v)).collect() }
}

fn written(ending: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("series.{ending}"));
    let mut writer = SeriesWriter::create(&path).unwrap();
    writer.write(&trial("a", 2)).unwrap();
    // A trial without one of the columns.
    let mut second = trial("b", 3);
    second.columns.remove(1);
    writer.write(&second).unwrap();
    writer.finish().unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn csv_has_a_row_for_each_sample_and_empty_cells_for_what_is_not_known() {
    let text = String::from_utf8(written("csv")).unwrap();
    let expected = "trial,t_s,measured_fx_n,status\n\
                    a,0,0.30000000000000004,\n\
                    a,1,,\"slip, \"\"now\"\"\"\n\
                    b,0,,\n\
                    b,1,,\"slip, \"\"now\"\"\"\n\
                    b,2,,\n";
    assert_eq!(text, expected);
}

#[test]
fn parquet_holds_the_same_numbers_to_the_bit() {
    let reader = SerializedFileReader::new(bytes::Bytes::from(written("parquet"))).unwrap();
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 5);
    assert_eq!(rows[0].get_string(0).unwrap(), "a");
    assert_eq!(rows[0].get_double(2).unwrap().to_bits(), (0.1_f64 + 0.2).to_bits());
    assert!(rows[1].get_double(2).is_err(), "null");
    assert_eq!(rows[3].get_string(3).unwrap(), "slip, \"now\"");
    assert_eq!((rows[4].get_string(0).unwrap().as_str(), rows[4].get_double(1).unwrap()), ("b", 2.0));
}

#[test]
fn another_ending_is_refused_with_those_that_are_written() {
    let error = SeriesWriter::create("series.xlsx".as_ref()).err().unwrap().to_string();
    assert!(error.contains("series.xlsx") && error.contains(".csv or .parquet"), "{error}");
}
