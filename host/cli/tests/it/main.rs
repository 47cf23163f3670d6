//! Tests of the crate from outside, in one program: it links once.

mod balance;
mod bench_bad_input;
mod board_set;
mod calibration;
mod command_line;
mod common;
mod compare;
mod diagnose_command;
mod docs_links;
mod documents;
mod grip_loop;
mod import_clocks;
mod lcp_command;
mod lcp_model;
mod monitor;
mod one_number;
mod pages;
mod readme;
mod recordings;
mod refused;
mod report_parts;
mod shell;
mod words;
