//! The firmware of the real board lies where that board has memory: `make size` builds it and
//! names the file in `STICKSLIP_G474_ELF`. Without it there is nothing to check.

use std::ops::Range;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, elf};

/// STM32G474RE (RM0440, 2.2): main flash; SRAM1 and SRAM2.
const FLASH: Range<u64> = 0x0800_0000..0x0808_0000;
const RAM: Range<u64> = 0x2000_0000..0x2001_8000;

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
        let memory = if sh_flags & u64::from(elf::SHF_WRITE) == 0 { FLASH } else { RAM };
        assert!(within(&memory), "{name} at {from:#x}..{to:#x} is not in {memory:#x?}");
        loaded += 1;
    }
    assert!(loaded >= 4, "vectors, code, constants and variables: {loaded} sections");
    let symbol = |name: &str| {
        let found = file.symbols().find(|s| s.name() == Ok(name));
        found.unwrap_or_else(|| panic!("no symbol {name}")).address()
    };
    assert_eq!(symbol("__vector_table"), FLASH.start);
    assert_eq!(symbol("_stack_start"), RAM.end);
}
