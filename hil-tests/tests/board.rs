//! Runs on the board itself, one test a start (started by `host/lab/tests/hil.rs`).
#![no_std]
#![no_main]

#[embedded_test::tests]
mod tests {
    use heapless::Vec;
    use stickslip_firmware as _;
    use stickslip_hil_tests::{HOSTILE, REFERENCE};
    use stickslip_selftest::{self as selftest, hostile};
    use stickslip_shared::wire::frame::{FrameError, FrameReader, MAX_LINE, crc32, encode};
    use stickslip_shared::wire::{self, ModelChunk, ModelCommit, Refusal};
    use stickslip_unit::source::WrenchSource;
    use stickslip_unit::source::ft300::{Ft300, TRANSMISSION_US};
    use stickslip_unit::upload::Upload;

    #[test]
    fn predictor_gives_the_bits_of_the_host_without_look_ahead() {
        let [(by, seed, ticks, horizon_s, host), ..] = REFERENCE;
        assert_eq!(selftest::run(by, seed, ticks, horizon_s), host);
    }

    #[test]
    fn predictor_gives_the_bits_of_the_host_with_look_ahead() {
        let [_, (by, seed, ticks, horizon_s, host), _] = REFERENCE;
        assert_eq!(selftest::run(by, seed, ticks, horizon_s), host);
    }

    #[test]
    fn friction_pyramids_in_the_tick_give_the_bits_of_the_host() {
        let [_, _, (by, seed, ticks, horizon_s, host)] = REFERENCE;
        assert_eq!(selftest::run(by, seed, ticks, horizon_s), host);
    }

    #[test]
    fn solvers_give_the_bits_of_the_host_on_hostile_problems() {
        let (seed, rounds, host) = HOSTILE;
        assert_eq!(hostile::run(seed, rounds), host);
    }

    #[test]
    fn a_damaged_frame_is_found_and_the_next_one_read() {
        let mut line = [0; MAX_LINE];
        let key = <wire::SetGrip as postcard_rpc::Endpoint>::REQ_KEY;
        let sent = encode(key, 7, &12.5_f32, &mut line).unwrap();
        let mut reader = FrameReader::new();
        let mut damaged: Vec<u8, MAX_LINE> = Vec::from_slice(sent).unwrap();
        damaged[5] ^= 1;
        let mut errors = 0;
        for byte in &damaged {
            if let Some(result) = reader.push(*byte) {
                assert_eq!(result.unwrap_err(), FrameError::Checksum);
                errors += 1;
            }
        }
        assert_eq!(errors, 1);
        let mut read = None;
        for byte in sent {
            if let Some(result) = reader.push(*byte) {
                read = Some(result.unwrap().decode::<f32>());
            }
        }
        assert_eq!(read, Some(Some(12.5)));
    }

    #[test]
    fn a_model_with_a_missing_piece_or_wrong_checksum_is_refused_and_says_why() {
        let mut upload = Upload::default();
        let piece = |offset| ModelChunk { offset, bytes: Vec::from_slice(&[1; 8]).unwrap() };
        assert_eq!(upload.take(&piece(0)), Ok(()));
        assert_eq!(upload.take(&piece(16)), Err(Refusal::Offset { expected: 8 }));
        let short = ModelCommit { length: 9, crc: 0 };
        assert_eq!(upload.commit(&short, &mut None).err(), Some(Refusal::Length { received: 8 }));
        let crc = crc32(&[1; 8]);
        let wrong = ModelCommit { length: 8, crc: !crc };
        assert_eq!(upload.commit(&wrong, &mut None).err(), Some(Refusal::Crc { received: crc }));
        let garbage = ModelCommit { length: 8, crc };
        assert_eq!(upload.commit(&garbage, &mut None).err(), Some(Refusal::Undecodable));
    }

    #[test]
    fn a_frame_of_the_serial_sensor_is_read_on_the_board() {
        // 1, -1 and 0 N, 1, 0 and -1 N m, with the checksum that a Modbus master of another make gives.
        const FRAME: [u8; 16] =
            [0x20, 0x4e, 0x64, 0x00, 0x9c, 0xff, 0x00, 0x00, 0xe8, 0x03, 0x00, 0x00, 0x18, 0xfc, 0xc9, 0x3f];
        let mut source = Ft300::default();
        let mut readings = FRAME.iter().filter_map(|byte| source.take(*byte, 100_000));
        let reading = readings.next().unwrap();
        assert_eq!(reading.values, [1.0, -1.0, 0.0, 1.0, 0.0, -1.0]);
        assert_eq!(reading.at_us, 100_000 - TRANSMISSION_US);
    }

    #[test]
    #[cfg(feature = "nucleo-g474re")]
    fn every_gauge_channel_is_sampled_for_47_5_cycles_also_after_readings() {
        use stickslip_firmware::board::current::{init, sampling};
        use stickslip_unit::board::Channels;
        // Code of 47.5 cycles in ADC_SMPR1 and ADC_SMPR2.
        const LONG: u8 = 0b100;
        let finger1 = [1, 2, 6, 7, 8, 9].map(|channel| (channel, LONG));
        let finger2 = [17, 3, 4, 12, 14, 5].map(|channel| (channel, LONG));
        let mut gauges = init(false).gauges;
        assert_eq!(sampling(), [finger1, finger2]);
        let scanned = (0..1_000_000).filter(|_| gauges.read().is_some()).take(5).count();
        assert_eq!(scanned, 5);
        assert_eq!(sampling(), [finger1, finger2]);
    }

    #[test]
    #[cfg(feature = "nucleo-g474re")]
    fn a_frame_comes_back_through_the_can_controllers_loopback() {
        use stickslip_firmware::board::current::loopback;
        use stickslip_unit::lines::Bus;
        let mut bus = loopback();
        for sent in [&[1_u8, 2, 3][..], &[7; 24]] {
            let mut data = [0; 64];
            let got = embassy_futures::block_on(async {
                bus.write(0x120, sent).await;
                bus.read(&mut data).await
            });
            assert_eq!(got, Some((0x120, sent.len())));
            assert_eq!(&data[..sent.len()], sent);
        }
    }

    #[test]
    fn a_model_longer_than_the_board_is_refused() {
        let mut upload = Upload::default();
        let limit = wire::MAX_MODEL_BYTES as u16;
        let mut offset = 0;
        let refusal = loop {
            let chunk = ModelChunk { offset, bytes: Vec::from_slice(&[0; wire::CHUNK]).unwrap() };
            match upload.take(&chunk) {
                Ok(()) => offset += wire::CHUNK as u16,
                Err(refusal) => break refusal,
            }
        };
        assert_eq!(refusal, Refusal::TooLarge { limit });
    }
}
