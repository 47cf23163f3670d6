//! The Cortex-M4F that QEMU emulates as `mps2-an386` (25 MHz clock): the board of every
//! test that runs without hardware.
//!
//! Registers from Arm's CMSDK manual (DDI 0479): two 32-bit down-counting timers, a UART
//! without FIFO, a watchdog. Interrupts that have a handler here arrive through
//! `DefaultHandler`, which saves this board its own vector table.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::poll_fn;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::{Poll, Waker};

use cortex_m::interrupt::InterruptNumber;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug;
use critical_section::{CriticalSection, Mutex};
use defmt_semihosting as _;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embassy_sync::waitqueue::AtomicWaker;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;

use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_storage_async::nor_flash::{self, NorFlash, ReadNorFlash};
use stickslip_unit::alarm::Lines;

use super::{ResetCause, mailbox};
use crate::queues::BETWEEN;
use crate::{post_mortem, stack};
use stickslip_shared::wire::Ending;

/// This board.
pub struct This;

/// Name that the board reports.
pub const NAME: &str = "mps2-an386";
/// Counts a second of [`timer`].
pub const TIMER_HZ: u32 = 25_000_000;
/// Whether strain gauges are wired to this board: where a program simulates them.
pub const HAS_GAUGES: bool = cfg!(feature = "simulated");
/// Whether a sensor with a serial line may be wired to this board: as above.
pub const HAS_SERIAL_SENSOR: bool = cfg!(feature = "simulated");
/// Whether the board has CAN-FD: as above.
pub const HAS_CAN: bool = cfg!(feature = "simulated");
/// Where in its flash settings are stored.
pub const MEMORY: core::ops::Range<u32> = 0..FLASH_BYTES as u32;

/// Interrupts in use. The two highest are free on this board and carry the executors.
#[derive(Clone, Copy)]
#[repr(u16)]
enum Irq {
    UartRx = 0,
    UartTx = 1,
    Timer0 = 8,
    Timer1 = 9,
    Communication = 30,
    Control = 31,
}

// SAFETY: the numbers are the board's interrupt lines.
unsafe impl InterruptNumber for Irq {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Memory-mapped registers, `base + 4 i`.
#[derive(Clone, Copy)]
struct Registers(usize);

impl Registers {
    fn read(self, offset: usize) -> u32 {
        // SAFETY: only this module's fixed peripheral addresses get here.
        unsafe { ((self.0 + offset) as *const u32).read_volatile() }
    }
    fn write(self, offset: usize, value: u32) {
        // SAFETY: as above.
        unsafe { ((self.0 + offset) as *mut u32).write_volatile(value) }
    }
}

const TIMER0: Registers = Registers(0x4000_0000);
const TIMER1: Registers = Registers(0x4000_1000);
const UART0: Registers = Registers(0x4000_4000);
const WATCHDOG: Registers = Registers(0x4000_8000);

/// Both timers: control, counter, reload, interrupt status (write one to clear).
const T_CTRL: usize = 0x0;
const T_VALUE: usize = 0x4;
const T_RELOAD: usize = 0x8;
const T_INT: usize = 0xc;
const T_ENABLE: u32 = 1;
const T_IRQ_ENABLE: u32 = 1 << 3;

/// UART: data, state (bit 0 transmit full, bit 1 receive full), control, interrupt status.
const U_DATA: usize = 0x0;
const U_STATE: usize = 0x4;
const U_CTRL: usize = 0x8;
const U_INT: usize = 0xc;
const U_BAUD_DIVIDER: usize = 0x10;
const U_TX_FULL: u32 = 1;
const U_RX_FULL: u32 = 2;
/// Transmit, receive and receive interrupt enabled.
const U_RUN: u32 = 0b1011;
const U_TX_IRQ: u32 = 1 << 2;

/// Time since reset: Timer0 counts down from all ones, wraps every 171.8 s; Timer1 is the
/// alarm.
struct Clock {
    /// Finished wraps of Timer0.
    wraps: AtomicU32,
    queue: Mutex<RefCell<Queue>>,
}

time_driver_impl!(static CLOCK: Clock = Clock {
    wraps: AtomicU32::new(0),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

impl Clock {
    fn counts(&self) -> u64 {
        critical_section::with(|_| {
            let mut low = !TIMER0.read(T_VALUE);
            let mut high = self.wraps.load(Ordering::Relaxed);
            if TIMER0.read(T_INT) != 0 {
                // Wrapped and not yet served: read again, after the wrap.
                low = !TIMER0.read(T_VALUE);
                high = high.wrapping_add(1);
            }
            (u64::from(high) << 32) | u64::from(low)
        })
    }

    fn arm(&self, at: u64) -> bool {
        const COUNTS: u64 = TIMER_HZ as u64 / embassy_time_driver::TICK_HZ;
        TIMER1.write(T_CTRL, 0);
        TIMER1.write(T_INT, 1);
        if at == u64::MAX {
            return true;
        }
        let Some(wait) = at.saturating_mul(COUNTS).checked_sub(self.counts()) else {
            return false;
        };
        // A far alarm fires early and is armed again.
        let wait = wait.clamp(1, u64::from(u32::MAX)) as u32;
        TIMER1.write(T_RELOAD, wait);
        TIMER1.write(T_VALUE, wait);
        TIMER1.write(T_CTRL, T_ENABLE | T_IRQ_ENABLE);
        true
    }

    fn alarm(&self, cs: CriticalSection) {
        let mut queue = self.queue.borrow(cs).borrow_mut();
        loop {
            let next = queue.next_expiration(self.now());
            if self.arm(next) {
                break;
            }
        }
    }
}

impl Driver for Clock {
    fn now(&self) -> u64 {
        self.counts() / (u64::from(TIMER_HZ) / embassy_time_driver::TICK_HZ)
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            if self.queue.borrow(cs).borrow_mut().schedule_wake(at, waker) {
                self.alarm(cs);
            }
        });
    }
}

/// Free-running count at [`TIMER_HZ`], for the cost of a tick. Under `-icount` it counts
/// instructions, not cycles.
pub fn timer() -> u32 {
    !TIMER0.read(T_VALUE)
}

/// Room for every sample that the host keeps ahead.
static RECEIVED: Pipe<CriticalSectionRawMutex, 8192> = Pipe::new();
static SENT: AtomicWaker = AtomicWaker::new();

/// What carries the link: memory shared with the host where it offers that, else UART0.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Carrier {
    Memory,
    Uart,
}

/// Receiving half of the link.
pub struct Rx(Carrier);

impl embedded_io_async::ErrorType for Rx {
    type Error = Infallible;
}

impl embedded_io_async::Read for Rx {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(match self.0 {
            Carrier::Memory => mailbox::read(buffer).await,
            Carrier::Uart => RECEIVED.read(buffer).await,
        })
    }
}

/// Sending half of the link.
pub struct Tx(Carrier);

impl embedded_io_async::ErrorType for Tx {
    type Error = Infallible;
}

impl embedded_io_async::Write for Tx {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if self.0 == Carrier::Memory {
            return Ok(mailbox::write(bytes).await);
        }
        for byte in bytes {
            // Waits on the transmit interrupt only where the line is busy: a host that
            // stops reading stops this task and nothing else.
            poll_fn(|context| {
                if UART0.read(U_STATE) & U_TX_FULL == 0 {
                    return Poll::Ready(());
                }
                SENT.register(context.waker());
                UART0.write(U_CTRL, U_RUN | U_TX_IRQ);
                if UART0.read(U_STATE) & U_TX_FULL == 0 { Poll::Ready(()) } else { Poll::Pending }
            })
            .await;
            UART0.write(U_DATA, u32::from(*byte));
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// What the converters read; none where no program simulates them.
pub static COUNTS: Mutex<Cell<Option<[u16; 12]>>> = Mutex::new(Cell::new(None));

/// The converters.
pub struct Channels;

impl stickslip_unit::board::Channels for Channels {
    fn read(&mut self) -> Option<[u16; 12]> {
        critical_section::with(|cs| COUNTS.borrow(cs).get())
    }
}

/// A line that is a bit in memory: QEMU's board has no pins.
pub struct MemoryPin(u32);

/// The lines as they were last set, bit 0 slip, 1 drop, 2 sure.
pub static ALARM_BITS: AtomicU32 = AtomicU32::new(0);

impl ErrorType for MemoryPin {
    type Error = Infallible;
}

impl OutputPin for MemoryPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        ALARM_BITS.fetch_and(!self.0, Ordering::Relaxed);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        ALARM_BITS.fetch_or(self.0, Ordering::Relaxed);
        Ok(())
    }
}

/// Alarm lines.
pub type AlarmLines = Lines<MemoryPin, MemoryPin, MemoryPin>;

const FLASH_PAGE: usize = 2048;
const FLASH_BYTES: usize = 8 * FLASH_PAGE;
/// It is flash once it was erased: a mark stands before it.
const FLASH_MARK: u32 = 0x464c_4153;

/// Memory that a reset leaves alone, in the place of flash: pages of 2 KiB and words of 8 bytes as of the real board.
#[unsafe(link_section = ".uninit.FLASH")]
static mut FLASH: MaybeUninit<(u32, [u8; FLASH_BYTES])> = MaybeUninit::uninit();

/// One erasure in so many fails, as of pages at the end of their life; none but where that is simulated.
const WEAR: u32 = if cfg!(feature = "simulated") { 3 } else { u32::MAX };
static ERASURES: AtomicU32 = AtomicU32::new(0);

/// Erasures that were asked for, and those that failed.
pub fn erasures() -> [u32; 2] {
    let all = ERASURES.load(Ordering::Relaxed);
    [all, all / WEAR]
}

/// Emulated flash.
pub struct Flash(&'static mut [u8; FLASH_BYTES]);

impl Flash {
    /// To be called once.
    fn take() -> Self {
        // SAFETY: called once; every bit pattern is a number or a byte.
        let (mark, bytes) = unsafe { &mut *(&raw mut FLASH).cast::<(u32, [u8; FLASH_BYTES])>() };
        if *mark != FLASH_MARK {
            (*mark, *bytes) = (FLASH_MARK, [0xff; FLASH_BYTES]);
        }
        Self(bytes)
    }

    fn part(&mut self, from: u32, length: usize) -> Result<&mut [u8], nor_flash::NorFlashErrorKind> {
        let from = from as usize;
        self.0.get_mut(from..from.saturating_add(length)).ok_or(nor_flash::NorFlashErrorKind::OutOfBounds)
    }
}

impl nor_flash::ErrorType for Flash {
    type Error = nor_flash::NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        bytes.copy_from_slice(self.part(offset, bytes.len())?);
        Ok(())
    }
    fn capacity(&self) -> usize {
        FLASH_BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = FLASH_PAGE;
    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        if (ERASURES.fetch_add(1, Ordering::Relaxed) + 1).is_multiple_of(WEAR) {
            return Err(nor_flash::NorFlashErrorKind::Other);
        }
        self.part(from, to.saturating_sub(from) as usize)?.fill(0xff);
        Ok(())
    }
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        // Flash only clears bits.
        for (old, new) in self.part(offset, bytes.len())?.iter_mut().zip(bytes) {
            *old &= new;
        }
        Ok(())
    }
}

/// From the watchdog's warning to its reset.
const WARNING_MS: u32 = 10;

/// Fed by the control task only.
pub struct Watchdog;

impl Watchdog {
    /// Starts it with [`crate::WATCHDOG_MS`]. The first expiry is an interrupt that cannot be masked: the warning; the second
    /// is the reset, and the handler shortens its time to what is left.
    pub fn start() -> Self {
        WATCHDOG.write(0xc00, 0x1acc_e551);
        WATCHDOG.write(0x0, TIMER_HZ / 1000 * (crate::WATCHDOG_MS - WARNING_MS));
        WATCHDOG.write(0x8, 0b11);
        Self
    }

    /// Restarts its count.
    pub fn feed(&mut self) {
        WATCHDOG.write(0xc, 1);
    }
}

/// What the application gets from the board.
pub struct Board {
    /// Link, receiving.
    pub rx: Rx,
    /// Link, sending.
    pub tx: Tx,
    /// Strain gauges.
    pub gauges: Channels,
    /// Alarm lines.
    pub alarms: AlarmLines,
    /// For settings.
    pub flash: Option<Flash>,
    /// Why the processor started.
    pub reset_cause: ResetCause,
}

/// Brings up clock and link; `restarted`: memory survived the start.
pub fn init(restarted: bool) -> Board {
    let reset_cause = if restarted { ResetCause::WatchdogOrSoftware } else { ResetCause::PowerOn };
    TIMER0.write(T_RELOAD, u32::MAX);
    // A simulation begins 20 s before the low 32 bits of the microseconds wrap around, which 25 wraps of the timer make.
    let (first, wraps) = if cfg!(feature = "simulated") { (20 * TIMER_HZ, 24) } else { (u32::MAX, 0) };
    CLOCK.wraps.store(wraps, Ordering::Relaxed);
    TIMER0.write(T_VALUE, first);
    TIMER0.write(T_CTRL, T_ENABLE | T_IRQ_ENABLE);
    UART0.write(U_BAUD_DIVIDER, TIMER_HZ / crate::BAUD);
    UART0.write(U_CTRL, U_RUN);
    for (irq, priority) in [
        (Irq::UartRx, 0x00),
        (Irq::UartTx, 0x00),
        (Irq::Timer0, 0x20),
        (Irq::Timer1, 0x20),
        (Irq::Control, 0x40),
        (Irq::Communication, 0x80),
    ] {
        enable(irq, priority);
    }
    let carrier = if mailbox::offered() { Carrier::Memory } else { Carrier::Uart };
    if carrier == Carrier::Memory {
        mailbox::take();
    }
    let alarms = Lines { slip: MemoryPin(1), drop: MemoryPin(2), sure: MemoryPin(4) };
    Board {
        rx: Rx(carrier),
        tx: Tx(carrier),
        gauges: Channels,
        alarms,
        flash: Some(Flash::take()),
        reset_cause,
    }
}

/// Waits for an interrupt. With the host at the line instructions go on, so that time is
/// instructions only: while a processor sleeps, QEMU lets its time follow this machine's, and
/// a late machine would make it wake late.
pub fn idle() {
    if mailbox::offered() {
        // A long block without branches costs QEMU next to nothing; `yield` would leave its loop.
        // SAFETY: does nothing.
        unsafe { core::arch::asm!(".rept 256", "nop", ".endr", options(nomem, nostack, preserves_flags)) };
    } else {
        cortex_m::asm::wfi();
    }
}

fn enable(irq: Irq, priority: u8) {
    // SAFETY: the handlers exist and share state only through critical sections.
    unsafe {
        let mut core = cortex_m::Peripherals::steal();
        core.NVIC.set_priority(irq, priority);
        if !matches!(irq, Irq::Control | Irq::Communication) {
            cortex_m::peripheral::NVIC::unmask(irq);
        }
    }
}

static CONTROL: InterruptExecutor = InterruptExecutor::new();
static COMMUNICATION: InterruptExecutor = InterruptExecutor::new();

/// Spawner of the upper priority.
pub fn control_executor() -> SendSpawner {
    CONTROL.start(Irq::Control)
}

/// Spawner of the lower priority.
pub fn communication_executor() -> SendSpawner {
    COMMUNICATION.start(Irq::Communication)
}

#[exception]
unsafe fn DefaultHandler(irqn: i16) {
    match irqn {
        0 => {
            UART0.write(U_INT, 2);
            while UART0.read(U_STATE) & U_RX_FULL != 0 {
                let byte = [UART0.read(U_DATA) as u8];
                if RECEIVED.try_write(&byte).is_err() {
                    BETWEEN.counters.bytes_lost.add(1);
                }
            }
        }
        1 => {
            UART0.write(U_INT, 1);
            UART0.write(U_CTRL, U_RUN);
            SENT.wake();
        }
        8 => {
            critical_section::with(|_| {
                TIMER0.write(T_INT, 1);
                CLOCK.wraps.fetch_add(1, Ordering::Relaxed);
            });
        }
        9 => critical_section::with(|cs| CLOCK.alarm(cs)),
        // SAFETY: these lines are pended by their executor only.
        30 => unsafe { COMMUNICATION.on_interrupt() },
        31 => unsafe { CONTROL.on_interrupt() },
        other => {
            defmt::error!("unexpected interrupt {=i16}", other);
            halt();
        }
    }
}

/// The watchdog's warning: notes what ran, and lets it bite.
// All code runs on the main stack, on which the processor put where it was.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn NonMaskableInt() {
    core::arch::naked_asm!("mrs r0, msp", "b {noted}", noted = sym warned)
}

unsafe extern "C" fn warned(stacked: *const u32) -> ! {
    WATCHDOG.write(0x0, TIMER_HZ / 1000 * WARNING_MS);
    // SAFETY: as the processor left it.
    unsafe { post_mortem::interrupted(Ending::Watchdog, stacked) };
    loop {
        cortex_m::asm::nop();
    }
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    let how = if stack::met_guard() { Ending::StackOverflow } else { Ending::HardFault };
    post_mortem::end(how, frame.pc(), stack::call_before(frame.lr()), 0);
    if how == Ending::StackOverflow {
        // A log would want a stack.
        reset()
    }
    defmt::error!("hard fault at pc {=u32:#010x}, lr {=u32:#010x}", frame.pc(), frame.lr());
    halt()
}

/// Ends the emulation with a non-zero exit code; where ends are rehearsed, the reset of a real board.
pub fn halt() -> ! {
    if cfg!(feature = "rehearsed") {
        reset();
    }
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

/// Restarts the processor.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
