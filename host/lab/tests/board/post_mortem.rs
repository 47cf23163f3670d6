//! Ends that are provoked in QEMU, and what the unit tells of them after its reset: where, of what, and the last ticks.
//! `make hil` builds the program (`firmware/src/bin/rehearsal.rs`) and names it in `STICKSLIP_REHEARSAL`.

use std::time::{Duration, Instant};

use object::{Object, ObjectSymbol, SymbolKind};
use stickslip_device::{Device, DeviceError};
use stickslip_shared::wire::{self, Ending, Info};

// No unit knows it: the program takes it for the word to end.
postcard_rpc::endpoint!(Provoke, (), (), "stickslip/no/such/request");

/// The function of the program in which an address lies.
fn function_at(address: u32) -> String {
    let bytes = std::fs::read(super::named("STICKSLIP_REHEARSAL", "hil")).expect("the program");
    let file = object::File::parse(&*bytes).expect("an ELF file");
    let at = u64::from(address);
    let holds = |s: &object::Symbol<'_, '_>| {
        let start = s.address() & !1;
        s.kind() == SymbolKind::Text && (start..start + s.size()).contains(&at)
    };
    let mut names = file.symbols().filter(holds).filter_map(|s| Some(s.name().ok()?.to_owned()));
    names.next().unwrap_or_else(|| format!("nothing at {address:#010x}"))
}

/// Ends the run and waits for the next start.
fn end(device: &mut Device, starts: u32) -> Info {
    let error = device.request::<Provoke>(&()).expect_err("unknown");
    assert!(matches!(error, DeviceError::UnknownRequest { .. }), "{error}");
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(20) {
        if let Ok(info) = device.request::<wire::GetInfo>(&())
            && info.boots > starts
        {
            return info;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("no start number {}", starts + 1);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_panic_a_fault_and_a_watchdog_are_told_after_the_reset_with_where_they_were_and_the_last_ticks() {
    let program = super::named("STICKSLIP_REHEARSAL", "hil");
    let mut device = Device::open(&format!("qemu:{}", program.to_string_lossy())).unwrap();
    assert_eq!((device.info().boots, device.info().post_mortem), (1, None));
    let mut failed = Vec::new();
    let ends = [
        (Ending::Panic, "ends_by_index"),
        (Ending::Panic, "ends_by_panic"),
        (Ending::HardFault, "ends_by_fault"),
        (Ending::Watchdog, "ends_by_hanging"),
    ];
    for ((ending, function), starts) in ends.into_iter().zip(1..) {
        let info = end(&mut device, starts);
        let told = info.post_mortem.expect("kept over the reset");
        let (at, from) = (function_at(told.pc), function_at(told.lr));
        println!("{ending:?}: at {at}, from {from}: {told:?}");
        let panics = ending == Ending::Panic;
        // A check of the core library may stand between a panic and its function.
        let found = at.contains(function) || (panics && from.contains(function));
        let caller = from.contains(function) || from.contains("provoke") || from.contains("poll");
        let ticks = told.last.windows(2).all(|two| two[0].tick + 1 == two[1].tick && two[0].cost > 0);
        if told.ending != ending || !found || !caller || (told.line > 0) != panics || !ticks {
            failed.push(format!("{function}: {told:?}, at {at}, from {from}"));
        }
        assert_eq!(info.boots, starts + 1);
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    // What was provoked is over, and it is the product's application: a model runs.
    assert_eq!(device.request::<wire::GetInfo>(&()).unwrap().mode, wire::Mode::Safe);
}
