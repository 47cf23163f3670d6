//! Flash that refuses what real flash refuses, and loses power at any word or page.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Of the STM32G474 with two banks (RM0440, 3.3): pages of 2 KiB, words of 8 bytes.
pub const PAGE: usize = 2048;
pub const WORD: usize = 8;
pub const PAGES: usize = 8;
pub const RANGE: core::ops::Range<u32> = 0..(PAGES * PAGE) as u32;

/// How the word or page looks at which the power went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// As before.
    Before,
    /// So many eighths of it are done, from its beginning.
    Part(usize),
    /// By its ECC it has more wrong bits than can be mended: each read gives something else.
    Torn,
    /// Done, but the caller never knew.
    After,
}

/// All of them.
pub fn cuts() -> impl Iterator<Item = Cut> {
    [Cut::Before, Cut::Torn, Cut::After].into_iter().chain((1..8).map(Cut::Part))
}

/// Flash that loses power after a number of words and pages.
#[derive(Clone)]
pub struct Flash {
    pub bytes: Vec<u8>,
    pub left: Option<(usize, Cut)>,
    pub done: usize,
    pub erasures: usize,
    /// Numbers of words that read as anything.
    torn: BTreeSet<usize>,
    /// Without power nothing is done.
    off: bool,
    noise: u32,
}

/// Power is off, or the word is not blank.
#[derive(Debug)]
pub struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Flash {
    pub fn new() -> Self {
        Self::holding(vec![0xff; PAGES * PAGE])
    }

    pub fn holding(bytes: Vec<u8>) -> Self {
        Self { bytes, left: None, done: 0, erasures: 0, torn: BTreeSet::new(), off: false, noise: 1 }
    }

    /// With power again, as long as for so many operations.
    pub fn powered(&self, left: Option<(usize, Cut)>) -> Self {
        Self { left, done: 0, off: false, ..self.clone() }
    }

    /// Counts an operation; how much of it is done where the power goes.
    fn step(&mut self) -> Result<Option<Cut>, Failed> {
        if self.off {
            return Err(Failed);
        }
        self.done += 1;
        match &mut self.left {
            Some((0, cut)) => {
                self.off = true;
                Ok(Some(*cut))
            }
            Some((left, _)) => {
                *left -= 1;
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

impl ErrorType for Flash {
    type Error = Failed;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        if self.off {
            return Err(Failed);
        }
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        if self.torn.is_empty() {
            return Ok(());
        }
        for (byte, at) in bytes.iter_mut().zip(offset as usize..) {
            if self.torn.contains(&(at / WORD)) {
                self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *byte = (self.noise >> 24) as u8;
            }
        }
        Ok(())
    }
    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;
    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        assert!((from as usize).is_multiple_of(PAGE) && (to as usize).is_multiple_of(PAGE));
        for start in (from as usize..to as usize).step_by(PAGE) {
            let words = start / WORD..(start + PAGE) / WORD;
            let cut = self.step()?;
            let done = match cut {
                Some(Cut::Before) => 0,
                Some(Cut::Part(eighths)) => eighths * PAGE / 8,
                Some(Cut::Torn) => {
                    self.torn.extend(words);
                    return Err(Failed);
                }
                None | Some(Cut::After) => PAGE,
            };
            self.erasures += 1;
            self.bytes[start..start + done].fill(0xff);
            self.torn.retain(|word| !(start / WORD..(start + done) / WORD).contains(word));
            if cut.is_some() {
                return Err(Failed);
            }
        }
        Ok(())
    }
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        assert!((offset as usize).is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        for (k, word) in bytes.chunks(WORD).enumerate() {
            let at = offset as usize + k * WORD;
            let cleared = word.iter().all(|b| *b == 0);
            // A word is written once (it has a checksum of its own in hardware), or cleared altogether.
            if self.torn.contains(&(at / WORD)) && !cleared {
                return Err(Failed);
            }
            let old = &self.bytes[at..at + WORD];
            let blank = old.iter().all(|b| *b == 0xff);
            assert!(blank || cleared || self.off, "{at}: {old:?} {word:?}");
            let cut = self.step()?;
            let done = match cut {
                Some(Cut::Before) => 0,
                Some(Cut::Part(eighths)) => eighths * WORD / 8,
                Some(Cut::Torn) => {
                    self.torn.insert(at / WORD);
                    return Err(Failed);
                }
                None | Some(Cut::After) => WORD,
            };
            self.bytes[at..at + done].copy_from_slice(&word[..done]);
            if done == WORD {
                self.torn.remove(&(at / WORD));
            }
            if cut.is_some() {
                return Err(Failed);
            }
        }
        Ok(())
    }
}

/// Flash that outlives a unit: the next one starts with it.
#[derive(Clone)]
pub struct SharedFlash(pub Rc<RefCell<Flash>>);

impl SharedFlash {
    pub fn new() -> Self {
        Self::of(Flash::new())
    }

    pub fn of(flash: Flash) -> Self {
        Self(Rc::new(RefCell::new(flash)))
    }
}

impl ErrorType for SharedFlash {
    type Error = Failed;
}

impl ReadNorFlash for SharedFlash {
    const READ_SIZE: usize = Flash::READ_SIZE;
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        block_on(self.0.borrow_mut().read(offset, bytes))
    }
    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

impl NorFlash for SharedFlash {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;
    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        block_on(self.0.borrow_mut().erase(from, to))
    }
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        block_on(self.0.borrow_mut().write(offset, bytes))
    }
}
