//! The checksum of frames and models against another implementation.

use crc::{CRC_32_ISO_HDLC, Crc};
use proptest::prelude::*;
use stickslip_shared::wire::frame::crc32;

#[test]
fn the_checksum_has_the_catalogues_check_value() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}

proptest! {
    #[test]
    fn the_checksum_is_crc_32_iso_hdlc(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        prop_assert_eq!(crc32(&bytes), Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes));
    }
}
