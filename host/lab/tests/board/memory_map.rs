//! The firmware of the real board lies where that board has memory: `make size` builds it and
//! names the file in `STICKSLIP_G474_ELF`. Without it there is nothing to check.

use std::ops::Range;

use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol, SectionFlags, elf};

/// STM32G474RE (RM0440, 2.2): main flash; SRAM1 and SRAM2; CCM SRAM.
const FLASH: Range<u64> = 0x0800_0000..0x0808_0000;
const RAM: Range<u64> = 0x2000_0000..0x2001_8000;
const FAST: Range<u64> = 0x1000_0000..0x1000_8000;
/// The dearest code, which is fetched without wait states.
const HOT: [&str; 4] = ["step7step_in", "9factorise", "8residual", "6search"];

#[test]
#[ignore = "needs the firmware: make size"]
fn the_firmware_lies_in_the_boards_memory_vectors_first() {
    let path = super::named("STICKSLIP_G474_ELF", "size");
    let bytes = std::fs::read(&path).expect("STICKSLIP_G474_ELF can be read");
    let file = object::File::parse(&*bytes).expect("STICKSLIP_G474_ELF is an ELF file");
    let mut loaded = 0;
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { panic!("an ELF section") };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 || section.size() == 0 {
            continue;
        }
        let name = section.name().unwrap_or("?");
        let (from, to) = (section.address(), section.address() + section.size());
        let within = |memory: &Range<u64>| memory.start <= from && to <= memory.end;
        let memory = match sh_flags & u64::from(elf::SHF_WRITE) {
            _ if name == ".fast" => FAST,
            0 => FLASH,
            _ => RAM,
        };
        assert!(within(&memory), "{name} at {from:#x}..{to:#x} is not in {memory:#x?}");
        loaded += 1;
    }
    assert!(loaded >= 4, "vectors, code, constants and variables: {loaded} sections");
    // Code of the fast memory is stored in flash, in one piece, and copied to where it was linked.
    let stored = file.segments().find(|s| FAST.contains(&s.address())).expect("a segment in the fast memory");
    let object::SegmentFlags::Elf { p_flags } = stored.flags() else { panic!("an ELF segment") };
    assert_ne!(p_flags & elf::PF_X, 0, "it is code");
    let length = stored.size();
    let end = file.symbols().find(|s| s.name() == Ok("__efast")).expect("its end").address();
    assert_eq!(end, FAST.start + length, "what is copied is what was linked");
    for hot in HOT {
        let place = file.symbols().find(|s| {
            let name = s.name().unwrap_or_default();
            name.contains("stickslip_shared") && name.contains(hot) && !name.contains("Thunk")
        });
        let place = place.unwrap_or_else(|| panic!("no function {hot}")).address();
        assert!(FAST.contains(&place), "{hot} at {place:#x}");
    }
    println!("code without wait states: {length} of {} bytes", FAST.end - FAST.start);
    let symbol = |name: &str| {
        let found = file.symbols().find(|s| s.name() == Ok(name));
        found.unwrap_or_else(|| panic!("no symbol {name}")).address()
    };
    assert_eq!(symbol("__vector_table"), FLASH.start);
    assert_eq!(symbol("_stack_start"), RAM.end);
}
