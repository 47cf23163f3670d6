//! What a unit keeps over a loss of power: settings (sensors, calibrations, tare, grip limits, grasp, unit number, and
//! whether it begins a run by itself) and the model.
//!
//! This is one copy of it; a unit has two ([`crate::stored`]). sequential-storage writes each value behind the old one,
//! with a checksum, and takes the newest that is whole. Each value begins with a version; one of another version is
//! refused and left alone until something is stored.

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::{Deserialize, Serialize};
use stickslip_shared::wire::frame::crc32;
use stickslip_shared::wire::{
    Calibration, Grasp, GripLimits, MAX_MODEL_BYTES, PROTOCOL, Refusal, Sensors, StartRequest, check,
};

use crate::fingers::{check_all_fingers, check_sensors, port_of};

/// Of what is stored: the protocol's, whose messages it consists of.
pub const VERSION: u16 = PROTOCOL;
/// Version before the value.
const HEAD: usize = 2;
/// Room for the largest value with its key and version, in whole words of any flash.
const ROOM: usize = (1 + HEAD + MAX_MODEL_BYTES).next_multiple_of(32);

/// Keys of the values.
const SETTINGS: u8 = 1;
const MODEL: u8 = 2;

/// Of settings in flash.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stamp {
    /// Counts stores: of two copies the one with the higher is newer.
    pub generation: u32,
    /// CRC-32 of the model that they were stored with; 0: with none.
    pub model: u32,
}

impl Stamp {
    /// Bytes in flash.
    const BYTES: usize = 8;

    fn of(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (generation, rest) = bytes.split_first_chunk()?;
        let (model, rest) = rest.split_first_chunk()?;
        let [generation, model] = [generation, model].map(|bytes| u32::from_le_bytes(*bytes));
        Some((Self { generation, model }, rest))
    }
}

/// What was set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// When they were stored, and with what; beside the rest in flash, so that it is read alone.
    #[serde(skip)]
    pub stamp: Stamp,
    /// Number of the unit; 0: none.
    pub unit: u32,
    /// Which sensor measures which finger.
    pub sensors: Sensors,
    /// Matrix of each finger.
    pub matrix: [Option<[[f32; 6]; 6]>; 2],
    /// No load, by the sensors' numbers.
    pub offsets: [[f32; 6]; 2],
    /// Poses without a host.
    pub grasp: Option<Grasp>,
    /// Grip force of each finger while no host commands one, N.
    pub grip_cmd_n: Option<f32>,
    /// Within what the grip is advised.
    pub grip: Option<GripLimits>,
    /// The run that begins by itself after a start.
    pub start: Option<StartRequest>,
}

impl Settings {
    /// Other sensors; a finger that has another than before has no matrix.
    ///
    /// # Errors
    /// As [`check_sensors`]; nothing has changed then.
    pub fn assign(&mut self, sensors: &Sensors) -> Result<(), Refusal> {
        check_sensors(sensors)?;
        for (matrix, finger) in self.matrix.iter_mut().zip(0..) {
            if port_of(sensors, finger) != port_of(&self.sensors, finger) {
                *matrix = None;
            }
        }
        self.sensors.clone_from(sensors);
        Ok(())
    }

    /// # Errors
    /// The first finger without a sensor, or whose sensor has no matrix.
    pub fn check_ready(&self) -> Result<(), Refusal> {
        check_all_fingers(&self.sensors)?;
        let missing = self.matrix.iter().zip(0..).find(|(matrix, _)| matrix.is_none());
        missing.map_or(Ok(()), |(_, finger)| Err(Refusal::NotCalibrated { finger }))
    }

    /// # Errors
    /// The first that a command would be refused for: memory may be anyone's.
    pub fn check(&self) -> Result<(), Refusal> {
        check_sensors(&self.sensors)?;
        for (matrix, finger) in self.matrix.iter().zip(0..) {
            if let Some(matrix) = matrix {
                check::calibration(&Calibration { finger, matrix: *matrix })?;
            }
        }
        for offset in self.offsets.iter().flatten() {
            check::range(stickslip_shared::wire::Field::Calibration, *offset, -1e6, 1e6)?;
        }
        self.grasp.as_ref().map_or(Ok(()), check::grasp)?;
        self.grip_cmd_n.map_or(Ok(()), check::grip)?;
        self.grip.as_ref().map_or(Ok(()), check::grip_limits)?;
        self.start.as_ref().map_or(Ok(()), check::start)
    }
}

/// Why something is not remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryFault {
    /// Flash, or what is in it, cannot be read or written.
    Storage,
    /// Another version wrote it.
    OtherVersion {
        /// That it has.
        found: u16,
    },
    /// The bytes are not settings, or settings that the checks refuse.
    Unusable,
    /// Larger than any value.
    TooLarge,
}

/// Values in flash.
pub struct Memory<F: NorFlash> {
    storage: MapStorage<u8, F, Cache<Uncached, Uncached, Uncached, u8>>,
}

/// A model's bytes.
pub type ModelBytes = heapless::Vec<u8, MAX_MODEL_BYTES>;

impl<F: NorFlash> Memory<F> {
    /// In `range` of the flash, bytes.
    ///
    /// # Errors
    /// The range is not two whole pages or more.
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, MemoryFault> {
        let config = MapConfig::try_new(range).map_err(|_| MemoryFault::Storage)?;
        Ok(Self { storage: MapStorage::new(flash, config, Cache::new_uncached()) })
    }

    /// The same flash, another range of it.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn within(self, range: Range<u32>) -> Result<Self, MemoryFault> {
        Self::new(self.into_flash(), range)
    }

    async fn fetch<'b>(
        &mut self,
        key: u8,
        room: &'b mut [u8; ROOM],
    ) -> Result<Option<&'b [u8]>, MemoryFault> {
        let found = self.storage.fetch_item::<&[u8]>(room, &key).await;
        let Some(bytes) = found.map_err(|_| MemoryFault::Storage)? else { return Ok(None) };
        let (head, value) = bytes.split_first_chunk::<HEAD>().ok_or(MemoryFault::Unusable)?;
        match u16::from_le_bytes(*head) {
            VERSION => Ok(Some(value)),
            found => Err(MemoryFault::OtherVersion { found }),
        }
    }

    async fn store(&mut self, key: u8, value: &[u8]) -> Result<(), MemoryFault> {
        if value.len() > MAX_MODEL_BYTES {
            return Err(MemoryFault::TooLarge);
        }
        let mut bytes = heapless::Vec::<u8, { HEAD + MAX_MODEL_BYTES }>::new();
        let fits =
            bytes.extend_from_slice(&VERSION.to_le_bytes()).and_then(|()| bytes.extend_from_slice(value));
        fits.map_err(|_| MemoryFault::TooLarge)?;
        let mut room = [0; ROOM];
        let stored = self.storage.store_item(&mut room, &key, &bytes.as_slice()).await;
        // Worn flash may take a write and not keep it.
        let kept = self.storage.fetch_item::<&[u8]>(&mut room, &key).await;
        if stored.is_ok() && kept.is_ok_and(|kept| kept == Some(bytes.as_slice())) {
            Ok(())
        } else {
            Err(MemoryFault::Storage)
        }
    }

    /// The stamp of the settings; `None` where none are stored.
    ///
    /// # Errors
    /// As [`Self::settings`], but they may be refused.
    pub async fn stamp(&mut self) -> Result<Option<Stamp>, MemoryFault> {
        let mut room = [0; ROOM];
        let Some(bytes) = self.fetch(SETTINGS, &mut room).await? else { return Ok(None) };
        Stamp::of(bytes).map(|(stamp, _)| Some(stamp)).ok_or(MemoryFault::Unusable)
    }

    /// The settings; `None` where none are stored.
    ///
    /// # Errors
    /// Not readable, of another version, or refused by the checks.
    pub async fn settings(&mut self) -> Result<Option<Settings>, MemoryFault> {
        let mut room = [0; ROOM];
        let Some(bytes) = self.fetch(SETTINGS, &mut room).await? else { return Ok(None) };
        let (stamp, bytes) = Stamp::of(bytes).ok_or(MemoryFault::Unusable)?;
        match postcard::take_from_bytes::<Settings>(bytes) {
            Ok((mut settings, [])) if settings.check().is_ok() => {
                settings.stamp = stamp;
                Ok(Some(settings))
            }
            _ => Err(MemoryFault::Unusable),
        }
    }

    /// The model's bytes, as they were committed; `None` where none is stored. They are to be checked as
    /// those from the line.
    ///
    /// # Errors
    /// Not readable, or of another version.
    pub async fn model(&mut self) -> Result<Option<ModelBytes>, MemoryFault> {
        let mut room = [0; ROOM];
        let found = self.fetch(MODEL, &mut room).await?;
        found.map(|bytes| ModelBytes::from_slice(bytes).map_err(|_| MemoryFault::TooLarge)).transpose()
    }

    /// CRC-32 of the stored model's bytes; `None` where none can be read.
    pub async fn model_crc(&mut self) -> Option<u32> {
        let mut room = [0; ROOM];
        self.fetch(MODEL, &mut room).await.ok().flatten().map(crc32)
    }

    /// Stores the settings.
    ///
    /// # Errors
    /// The flash fails, or holds something else: what was stored before stands then, or the copy has to be erased.
    pub async fn store_settings(&mut self, settings: &Settings) -> Result<(), MemoryFault> {
        let mut bytes = [0; 768];
        let Stamp { generation, model } = settings.stamp;
        let (head, rest) = bytes.split_at_mut(Stamp::BYTES);
        head[..4].copy_from_slice(&generation.to_le_bytes());
        head[4..].copy_from_slice(&model.to_le_bytes());
        let used = postcard::to_slice(settings, rest).map_err(|_| MemoryFault::TooLarge)?.len();
        self.store(SETTINGS, bytes.get(..Stamp::BYTES + used).unwrap_or_default()).await
    }

    /// Stores a model's bytes.
    ///
    /// # Errors
    /// Too long, or as [`Self::store_settings`].
    pub async fn store_model(&mut self, bytes: &[u8]) -> Result<(), MemoryFault> {
        self.store(MODEL, bytes).await
    }

    /// Forgets everything.
    ///
    /// # Errors
    /// The flash fails.
    pub async fn erase(&mut self) -> Result<(), MemoryFault> {
        self.storage.erase_all().await.map_err(|_| MemoryFault::Storage)
    }

    /// The flash.
    pub fn into_flash(self) -> F {
        self.storage.destroy().0
    }
}
