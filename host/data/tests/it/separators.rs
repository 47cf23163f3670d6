//! Tables as spreadsheets of other countries write them.

use std::fs;
use std::path::Path;

use stickslip_data::{Dataset, read};

const TOML: &str = "format = \"stickslip-dataset/1\"\nname = \"x\"\nsample_rate_hz = 250\n\
    gravity_m_s2 = [0, 0, -9.81]\n[[objects]]\nid = \"o\"\nshape = \"prism\"\nlength_m = 0.1\n\
    side_m = 0.1\nmass_kg = 0.2\n";
const TRIALS: &str = "trial,object,primitive,grip_n\na,o,push,20.5\n";
const TABLE: &str = "t_s,finger1_fx_n,finger1_fy_n\n0,-1.5,2\n0.004,1.5e-3,\n";

fn read_as(change: impl Fn(&str) -> String, folder: &Path) -> Result<Dataset, stickslip_data::DatasetError> {
    fs::create_dir_all(folder.join("trials")).expect("folder");
    fs::write(folder.join("dataset.toml"), TOML).expect("written");
    fs::write(folder.join("trials.csv"), change(TRIALS)).expect("written");
    fs::write(folder.join("trials/a.csv"), change(TABLE)).expect("written");
    read(folder)
}

#[test]
fn semicolons_and_tabs_with_decimal_commas_read_as_the_same_data() {
    let folder = tempfile::tempdir().expect("folder");
    let plain = read_as(str::to_owned, folder.path()).expect("plain");
    for separator in [";", "\t"] {
        let points = |text: &str| text.replace(',', separator);
        let commas = |text: &str| text.replace(',', separator).replace('.', ",");
        for read in [read_as(points, folder.path()), read_as(commas, folder.path())] {
            let read = read.expect("other separators");
            // A missing cell is NaN, which equals nothing: compare what is printed.
            assert_eq!(format!("{:?}", read.trials), format!("{:?}", plain.trials));
        }
    }
}

#[test]
fn decimal_commas_between_commas_are_refused_with_the_way_out() {
    let folder = tempfile::tempdir().expect("folder");
    let error = read_as(|text| text.replace('.', ","), folder.path()).expect_err("ambiguous").to_string();
    assert!(error.contains("line 2") && error.contains("separate the cells by semicolons"), "{error}");
}
