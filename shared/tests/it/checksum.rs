//! The checksum of frames and models against its definition: the polynomial's division, bit by bit.

use proptest::prelude::*;
use stickslip_shared::wire::frame::crc32;

/// CRC-32 (ISO-HDLC): bits of a byte from the lowest on, the polynomial 0x04c11db7 reflected, all ones before and the
/// complement after.
fn bit_by_bit(bytes: &[u8]) -> u32 {
    let mut rest = u32::MAX;
    for byte in bytes {
        rest ^= u32::from(*byte);
        for _ in 0..8 {
            let divide = rest & 1 == 1;
            rest >>= 1;
            if divide {
                rest ^= 0xedb8_8320;
            }
        }
    }
    !rest
}

#[test]
fn the_checksum_has_the_catalogues_check_value() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}

proptest! {
    #[test]
    fn the_checksum_is_the_rest_of_the_division_bit_by_bit(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        prop_assert_eq!(crc32(&bytes), bit_by_bit(&bytes));
    }
}
