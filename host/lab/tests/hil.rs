//! Runs the tests of `hil-tests` one by one, each in a fresh QEMU; `make hil` builds them
//! and names the file in `STICKSLIP_HIL_ELF`. Without it one test stands for them, which is
//! ignored, and fails where it is asked for. With the feature `probe` (`make hil-probe`)
//! they run on the board behind a debug probe instead.
//!
//! embedded-test lists its tests in the section `.embedded_test`: one symbol a test, whose
//! name is JSON and whose first word is the address to call. Exit code 0 is a pass.

use std::path::{Path, PathBuf};
#[cfg(not(feature = "probe"))]
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;
#[cfg(not(feature = "probe"))]
use std::time::Instant;

use libtest_mimic::{Arguments, Failed, Trial};
use object::{Object, ObjectSection, ObjectSymbol};
use stickslip_selftest::{self as selftest, hostile};
use stickslip_shared::model::Formulation;

/// A test that takes longer hangs: emulation is slow, not endless.
const PATIENCE: Duration = Duration::from_secs(400);

fn main() {
    let arguments = Arguments::from_args();
    let tests = match std::env::var_os("STICKSLIP_HIL_ELF") {
        None => {
            let missing = || Err("STICKSLIP_HIL_ELF names no file: run `make hil`".into());
            vec![Trial::test("needs `make hil`", missing).with_ignored_flag(true)]
        }
        Some(elf) => {
            let elf = PathBuf::from(elf);
            let mut tests = list(&elf);
            tests
                .push(Trial::test("this_build_gives_the_bits_of_the_optimised_one", move || same_bits(&elf)));
            tests
        }
    };
    libtest_mimic::run(&arguments, tests).exit();
}

/// The build script of `hil-tests` wrote what the firmware's profile gives on this machine
/// (optimised, without assertions); the board's tests hold the board against the same.
fn same_bits(elf: &Path) -> Result<(), Failed> {
    let built = elf.parent().and_then(Path::parent).ok_or("the ELF file lies in a target folder")?;
    let path = built.join("reference.txt");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut compared = 0;
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let own = match words.as_slice() {
            ["predictor", by, seed, ticks, horizon, ..] => {
                let formulation = if *by == "Lcp" { Formulation::Lcp } else { Formulation::Cone };
                let digest = selftest::run(formulation, seed.parse()?, ticks.parse()?, horizon.parse()?);
                format!("predictor {by} {seed} {ticks} {horizon} {digest:?}")
            }
            ["hostile", seed, rounds, ..] => {
                format!("hostile {seed} {rounds} {:?}", hostile::run(seed.parse()?, rounds.parse()?))
            }
            _ => return Err(format!("{}: `{line}` is not understood", path.display()).into()),
        };
        if own != line {
            return Err(format!("optimised: {line}\nthis build: {own}").into());
        }
        compared += 1;
    }
    if compared < 4 {
        return Err(format!("{} compares nothing", path.display()).into());
    }
    Ok(())
}

fn list(elf: &Path) -> Vec<Trial> {
    let bytes = std::fs::read(elf).unwrap_or_else(|error| panic!("{}: {error}", elf.display()));
    let file = object::File::parse(&*bytes).expect("STICKSLIP_HIL_ELF is an ELF file");
    let section = file.section_by_name(".embedded_test").expect("built with embedded-test");
    let data = section.data().expect("section data");
    let elf: Arc<Path> = elf.into();
    let mut tests = Vec::new();
    for symbol in file.symbols().filter(|symbol| symbol.section_index() == Some(section.index())) {
        let Ok(label) = symbol.name() else { continue };
        let Ok(label) = serde_json::from_str::<serde_json::Value>(label) else { continue };
        let Some(name) = label["name"].as_str() else { continue };
        let offset = (symbol.address() - section.address()) as usize;
        let Some(word) = data.get(offset..offset + 4) else { continue };
        let address = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let elf = Arc::clone(&elf);
        tests.push(Trial::test(name, move || run(&elf, address)).with_kind(KIND));
    }
    assert!(!tests.is_empty(), "{} lists no tests", elf.display());
    tests
}

#[cfg(feature = "probe")]
const KIND: &str = "probe";
#[cfg(not(feature = "probe"))]
const KIND: &str = "qemu";

/// One board, one test at a time; flashed at the first.
#[cfg(feature = "probe")]
fn run(elf: &Path, address: u32) -> Result<(), Failed> {
    use std::sync::Mutex;
    use stickslip_lab::probe::Board;
    static BOARD: Mutex<Option<Board>> = Mutex::new(None);
    let chip = std::env::var("STICKSLIP_HIL_CHIP").unwrap_or_else(|_| "STM32G474RETx".into());
    let mut board = BOARD.lock().map_err(|_| "another test broke off")?;
    let board = match &mut *board {
        Some(board) => board,
        none => none.insert(Board::flash(&chip, elf).map_err(|error| format!("{error:#}"))?),
    };
    board.run(address, PATIENCE).map_err(|error| format!("{error:#}").into())
}

#[cfg(not(feature = "probe"))]
fn run(elf: &Path, address: u32) -> Result<(), Failed> {
    let semihosting = format!("enable=on,target=native,arg=run_addr,arg={address}");
    let mut child = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "null"])
        .args(["-semihosting-config", &semihosting, "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::inherit())
        .spawn()
        .map_err(|error| format!("qemu-system-arm: {error}; `make setup` installs it"))?;
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return if status.success() { Ok(()) } else { Err(format!("on the board: {status}").into()) };
        }
        if began.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            return Err("no end after 400 s".into());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
