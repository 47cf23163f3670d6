//! `stickslip lcp` and its file formats.

use assert_cmd::Command;
use predicates::str::contains;
use stickslip_lcp::files::{
    Answer, DenseSet, FactorSet, ProblemFile, encode_answers, encode_dense, encode_factors, parse,
};
use stickslip_lcp::generate::{DenseFamily, Family, contact_problem, dense_problem};

fn dense_set() -> DenseSet {
    let problems = (0..3).map(|seed| dense_problem(DenseFamily::Spd, 4, seed)).collect();
    DenseSet { n: 4, contacts: 0, symmetric: true, problems }
}

fn factor_set() -> FactorSet {
    let problems = (0..3).map(|seed| contact_problem(Family::Approach, 6, seed)).collect();
    FactorSet { contacts: 6, freedoms: 6, problems }
}

#[test]
fn what_is_encoded_is_parsed_without_loss() {
    let (dense, factors) = (dense_set(), factor_set());
    assert_eq!(parse("a", &encode_dense(&dense)).unwrap(), ProblemFile::Dense(dense));
    assert_eq!(parse("b", &encode_factors(&factors)).unwrap(), ProblemFile::Factors(factors));
}

#[test]
fn malformed_files_are_refused_with_offset_and_reason() {
    let good = encode_dense(&dense_set());
    let check = |bytes: &[u8], words: &[&str]| {
        let message = parse("x.lcp", bytes).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{message}: {word} is missing");
        }
    };
    check(&[], &["byte 0", "magic"]);
    check(&[1, 2, 3, 4], &["byte 0", "0x04030201"]);
    check(&good[..good.len() - 1], &["problem 2", "the file ends"]);
    check(&[good.clone(), vec![0]].concat(), &["1 bytes follow"]);
    let mut negative = good.clone();
    negative[4..8].copy_from_slice(&(-1_i32).to_le_bytes());
    check(&negative, &["byte 4", "number of problems is -1"]);
    let mut flag = good;
    flag[16..20].copy_from_slice(&7_i32.to_le_bytes());
    check(&flag, &["byte 16", "symmetry"]);
}

#[test]
fn answers_are_written_in_the_published_layout() {
    let answer = Answer { status: 0, pivots: 7, times_us: vec![1.5; 9], z: vec![0.25, 0.5] };
    let bytes = encode_answers(2, &[answer]);
    assert_eq!(bytes.len(), 8 + 16 + 8 * 9 + 8 * 2);
    let int = |k: usize| i32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
    assert_eq!([int(0), int(1), int(2), int(3), int(4), int(5)], [1, 2, 0, 7, 9, 0]);
    assert_eq!(bytes[bytes.len() - 8..], 0.5_f64.to_le_bytes());
}

#[test]
fn the_command_solves_both_kinds_of_file_and_writes_every_answer() {
    let directory = tempfile::tempdir().unwrap();
    let (lcp, fac) = (directory.path().join("a.lcp"), directory.path().join("a.fac"));
    std::fs::write(&lcp, encode_dense(&dense_set())).unwrap();
    std::fs::write(&fac, encode_factors(&factor_set())).unwrap();
    for (file, solver, n) in [(&lcp, "dense", 4), (&fac, "contact", 36), (&fac, "dense", 36)] {
        let out = directory.path().join("a.res");
        Command::cargo_bin("stickslip")
            .unwrap()
            .args(["lcp", "--solver", solver, "--out"])
            .args([&out, file])
            .assert()
            .success()
            .stdout(contains("solved 3/3  false 0"));
        assert_eq!(std::fs::read(&out).unwrap().len(), 8 + 3 * (16 + 8 * 9 + 8 * n));
    }
    Command::cargo_bin("stickslip")
        .unwrap()
        .args(["lcp", "--solver", "contact"])
        .arg(&lcp)
        .assert()
        .failure()
        .stderr(contains("--solver dense"));
}
