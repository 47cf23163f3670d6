//! One copy of what a unit keeps over a loss of power.

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use proptest::prelude::*;
use stickslip_shared::wire::frame::crc32;
use stickslip_shared::wire::{
    GripLimits, MAX_MODEL_BYTES, Port, Pose, Refusal, Sensor, Source, StartRequest,
};
use stickslip_unit::memory::{Memory, MemoryFault, Settings, VERSION};

use super::flash::{Failed, Flash, PAGE, PAGES, RANGE, WORD};

fn memory(flash: Flash) -> Memory<Flash> {
    Memory::new(flash, RANGE).unwrap()
}

pub fn settings(unit: u32) -> Settings {
    let mut settings = Settings { unit, ..Settings::default() };
    settings.sensors.push(Sensor { port: Port::Ft300, finger: 0 }).unwrap();
    settings.sensors.push(Sensor { port: Port::Ati { base: 3 }, finger: 1 }).unwrap();
    let mut matrix = [[0.0; 6]; 6];
    for (k, row) in matrix.iter_mut().enumerate() {
        row[k] = 1.0 + unit as f32;
    }
    settings.matrix = [Some(matrix); 2];
    settings.offsets = [[unit as f32; 6]; 2];
    settings.grip_cmd_n = Some(20.0);
    settings.grip = Some(GripLimits::default());
    settings.start = Some(StartRequest { source: Source::Unit, trial: 0.0, prefill: 0, length: None });
    settings
}

#[test]
fn what_is_stored_is_there_after_a_restart_and_a_fresh_flash_is_empty() {
    let mut fresh = memory(Flash::new());
    assert_eq!(block_on(fresh.settings()), Ok(None));
    assert_eq!((block_on(fresh.model()), block_on(fresh.model_crc())), (Ok(None), None));
    block_on(fresh.store_settings(&settings(1))).unwrap();
    let model: Vec<u8> = (0..MAX_MODEL_BYTES).map(|k| k as u8).collect();
    block_on(fresh.store_model(&model)).unwrap();
    block_on(fresh.store_settings(&settings(2))).unwrap();
    let mut again = memory(fresh.into_flash());
    assert_eq!(block_on(again.settings()), Ok(Some(settings(2))));
    assert_eq!(block_on(again.model()), Ok(Some(model.iter().copied().collect())));
    assert_eq!(block_on(again.model_crc()), Some(crc32(&model)));
    block_on(again.erase()).unwrap();
    assert_eq!(block_on(again.settings()), Ok(None));
}

#[test]
fn an_image_of_another_version_is_refused_kept_and_replaced_by_what_is_stored_next() {
    use sequential_storage::cache::Cache;
    use sequential_storage::map::{MapConfig, MapStorage};
    let mut foreign = MapStorage::<u8, _, _>::new(Flash::new(), MapConfig::new(RANGE), Cache::new_uncached());
    let mut value = (VERSION + 1).to_le_bytes().to_vec();
    value.extend([1, 2, 3, 4]);
    for key in [1u8, 2] {
        block_on(foreign.store_item(&mut [0; 256], &key, &value.as_slice())).unwrap();
    }
    let mut memory = memory(foreign.destroy().0);
    let refused = MemoryFault::OtherVersion { found: VERSION + 1 };
    assert_eq!(block_on(memory.settings()), Err(refused));
    assert_eq!(block_on(memory.model()), Err(refused));
    block_on(memory.store_settings(&settings(2))).unwrap();
    assert_eq!(block_on(memory.settings()), Ok(Some(settings(2))));
    assert_eq!(block_on(memory.model()), Err(refused));
}

#[test]
fn settings_that_a_command_would_be_refused_for_are_not_taken_from_memory_either() {
    for spoil in [
        (|s: &mut Settings| s.matrix[1] = Some([[0.0; 6]; 6])) as fn(&mut Settings),
        |s| s.offsets[0][3] = f32::NAN,
        |s| s.grip_cmd_n = Some(f32::NAN),
        |s| s.grip = Some(GripLimits { most_n: f32::NAN, ..GripLimits::default() }),
        |s| s.sensors.push(Sensor { port: Port::Can, finger: 0 }).unwrap(),
        |s| s.start = Some(StartRequest { source: Source::Unit, trial: f32::NAN, prefill: 0, length: None }),
        |s| {
            let pose = Pose { position_m: [0.0; 3], quaternion: [0.0; 4] };
            s.grasp = Some(stickslip_shared::wire::Grasp { gripper: pose, object: pose });
        },
    ] {
        let mut bad = settings(1);
        spoil(&mut bad);
        let mut memory = memory(Flash::new());
        block_on(memory.store_settings(&bad)).unwrap();
        assert_eq!(block_on(memory.settings()), Err(MemoryFault::Unusable));
    }
}

#[test]
fn a_model_too_long_is_refused_and_the_old_one_stays() {
    let mut memory = memory(Flash::new());
    block_on(memory.store_model(&[5; 10])).unwrap();
    assert_eq!(block_on(memory.store_model(&[6; MAX_MODEL_BYTES + 1])), Err(MemoryFault::TooLarge));
    assert_eq!(block_on(memory.model()), Ok(Some([5u8; 10].into_iter().collect())));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn flash_full_of_anything_is_survived_and_can_be_used(seed in prop::collection::vec(any::<u8>(), 1..600)) {
        let bytes = seed.iter().copied().cycle().take(PAGES * PAGE).collect();
        let mut memory = memory(Flash::holding(bytes));
        prop_assert!(!matches!(block_on(memory.settings()), Ok(Some(_))));
        if block_on(memory.store_settings(&settings(3))).is_err() {
            block_on(memory.erase()).unwrap();
            block_on(memory.store_settings(&settings(3))).unwrap();
        }
        prop_assert_eq!(block_on(memory.settings()), Ok(Some(settings(3))));
    }
}

#[test]
fn a_run_on_the_units_sensors_is_refused_for_the_first_finger_without_sensor_or_matrix() {
    let whole = settings(1);
    assert_eq!(whole.check_ready(), Ok(()));
    for finger in 0..2u8 {
        let mut bare = whole.clone();
        bare.matrix[usize::from(finger)] = None;
        assert_eq!(bare.check_ready(), Err(Refusal::NotCalibrated { finger }));
        bare.sensors.retain(|s| s.finger != finger);
        assert_eq!(bare.check_ready(), Err(Refusal::NoSensor { finger }));
        // Another sensor than before: its matrix is no longer the finger's.
        let mut other = whole.clone();
        let mut sensors = other.sensors.clone();
        sensors.iter_mut().filter(|s| s.finger == finger).for_each(|s| s.port = Port::Gauges);
        other.assign(&sensors).unwrap();
        assert_eq!(other.check_ready(), Err(Refusal::NotCalibrated { finger }));
    }
}

/// Flash whose pages wear out: from then on one operation in `one_in` fails, silently or not.
struct Worn {
    flash: Flash,
    erasures: [u32; PAGES],
    endures: u32,
    one_in: u32,
    silent: bool,
    looks: u32,
}

impl Worn {
    fn fails(&mut self, page: usize) -> bool {
        self.looks += 1;
        self.erasures[page] >= self.endures && self.looks.is_multiple_of(self.one_in)
    }
}

impl ErrorType for Worn {
    type Error = Failed;
}

impl ReadNorFlash for Worn {
    const READ_SIZE: usize = 1;
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        self.flash.read(offset, bytes).await
    }
    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for Worn {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;
    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        for start in (from..to).step_by(PAGE) {
            let page = start as usize / PAGE;
            if !self.silent && self.fails(page) {
                return Err(Failed);
            }
            self.erasures[page] += 1;
            self.flash.erase(start, start + PAGE as u32).await?;
        }
        Ok(())
    }
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        let fails = self.fails(offset as usize / PAGE);
        if fails && !self.silent {
            return Err(Failed);
        }
        self.flash.write(offset, bytes).await?;
        if fails && let Some(bit) = bytes.iter().position(|byte| *byte != 0xff) {
            // A bit that was to be cleared stays.
            let byte = &mut self.flash.bytes[offset as usize + bit];
            *byte |= *byte + 1;
        }
        Ok(())
    }
}

#[test]
fn on_worn_flash_a_store_stands_or_is_refused_and_nothing_that_was_never_stored_is_read() {
    for silent in [false, true] {
        let (flash, erasures) = (Flash::new(), [0; PAGES]);
        let worn = Worn { flash, erasures, endures: 5, one_in: 40, silent, looks: 0 };
        let mut memory = Memory::new(worn, RANGE).unwrap();
        let (mut stood, mut refused) = (0, 0);
        for unit in 1..600 {
            let stored = block_on(memory.store_settings(&settings(unit)));
            // A start anew: nothing is known but what the flash holds.
            memory = Memory::new(memory.into_flash(), RANGE).unwrap();
            let read = block_on(memory.settings());
            match stored {
                Ok(()) => {
                    stood += 1;
                    assert_eq!(read, Ok(Some(settings(unit))), "silent {silent}, store {unit}");
                }
                Err(_) => {
                    refused += 1;
                    // The one before, this one (only its end was not written), or nothing that can be used.
                    if let Ok(Some(read)) = read {
                        assert!((1..=unit).contains(&read.unit) && read == settings(read.unit), "{read:?}");
                    }
                }
            }
        }
        assert!(stood > 100 && refused > 3, "silent {silent}: {stood} stood, {refused} refused");
    }
}

#[test]
fn a_store_takes_less_than_half_a_page_of_life() {
    // 10,000 erasures of each page (DS12288): at eight pages and half a page a store 160,000 of them.
    let (flash, erasures) = (Flash::new(), [0; PAGES]);
    let worn = Worn { flash, erasures, endures: u32::MAX, one_in: u32::MAX, silent: false, looks: 0 };
    let mut memory = Memory::new(worn, RANGE).unwrap();
    for unit in 0..400 {
        block_on(memory.store_settings(&settings(unit))).unwrap();
    }
    let all: u32 = memory.into_flash().erasures.iter().sum();
    assert!(all < 200, "{all} erasures of a page in 400 stores");
}
