//! ST's Nucleo-G474RE (Cortex-M4F, 170 MHz) with embassy-stm32.
//!
//! The link is LPUART1 on PA2 and PA3, which the board's ST-LINK shows as a serial port.
//! Twelve gauge amplifiers go to ADC1 and ADC2 (`docs/boards.md` has the pins). This
//! module has been type-checked and linked, not run: no such board was at hand.

use core::num::{NonZeroU8, NonZeroU16};
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, AnyAdcChannel, Exten, Rovsm, SampleTime, Trovs};
use embassy_stm32::can::{self, CanConfigurator};
use embassy_stm32::flash::{self as stm32_flash, Blocking};
use embassy_stm32::gpio::{AnyPin, Level, Output, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{ADC1, ADC2, IWDG};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{MasterMode, RoundTo, Timer};
use embassy_stm32::triggers::TIM3_TRGO;
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, bind_interrupts, dma, pac, peripherals};
use static_cell::StaticCell;

use cortex_m_rt::{ExceptionFrame, exception};
use embedded_io_async::{ErrorType, Read};
use embedded_storage_async::nor_flash::{self, NorFlash, ReadNorFlash};
use stickslip_shared::wire::Ending;
use stickslip_unit::alarm::Lines;
use stickslip_unit::lines::Bus;
use stickslip_unit::source::ft300;

use super::ResetCause;
use crate::queues::BETWEEN;
use crate::{post_mortem, stack};

/// This board.
pub struct This;

/// Name that the board reports.
pub const NAME: &str = "nucleo-g474re";
/// Counts a second of [`timer`]: the core clock.
pub const TIMER_HZ: u32 = 170_000_000;
/// Whether strain gauges are wired to this board.
pub const HAS_GAUGES: bool = true;
/// Whether a sensor with a serial line may be wired to this board.
pub const HAS_SERIAL_SENSOR: bool = true;
/// Whether the board has CAN-FD.
pub const HAS_CAN: bool = true;
/// Where in its flash settings are stored: the last 16 KiB of the second bank, so that the first, with the
/// firmware, can be read while they are written.
pub const MEMORY: core::ops::Range<u32> = 0x7_c000..0x8_0000;

bind_interrupts!(struct Irqs {
    LPUART1 => usart::InterruptHandler<peripherals::LPUART1>;
    USART1 => usart::InterruptHandler<peripherals::USART1>;
    FDCAN1_IT0 => can::IT0InterruptHandler<peripherals::FDCAN1>;
    FDCAN1_IT1 => can::IT1InterruptHandler<peripherals::FDCAN1>;
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
    DMA1_CHANNEL3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
    DMA1_CHANNEL4 => dma::InterruptHandler<peripherals::DMA1_CH4>;
    DMA1_CHANNEL5 => dma::InterruptHandler<peripherals::DMA1_CH5>;
    DMA1_CHANNEL6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
});

/// Core cycles since reset.
pub fn timer() -> u32 {
    DWT::cycle_count()
}

/// Receiving half of the link: DMA writes what comes into a ring, whatever the processor does.
pub struct Rx(RingBufferedUartRx<'static>);
/// Sending half of the link, by DMA.
pub type Tx = UartTx<'static, Async>;
/// A sensor's line, receiving and sending, by DMA.
pub type SensorRx = RingBufferedUartRx<'static>;
/// See [`SensorRx`].
pub type SensorTx = UartTx<'static, Async>;

impl ErrorType for Rx {
    type Error = usart::Error;
}

impl Read for Rx {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, usart::Error> {
        let read = self.0.read(bytes).await;
        if read.is_err() {
            // The ring was full, or a byte was not fetched in time or came damaged: the driver stops, and what was not read is
            // gone. How many were lost nobody knows.
            BETWEEN.counters.bytes_lost.add(1);
        }
        read
    }
}

/// Scans of all gauge channels a second: four a tick.
const SCANS_HZ: u32 = 1000;
/// Each count is the mean of 16 conversions that the converter makes one after the other (code of the
/// ratio, and the shift that divides by it). A scan takes 6 x 16 x 60 converter clocks: 0.14 ms at 42.5 MHz.
const OVERSAMPLING: (u8, u8) = (0b011, 4);

/// Where DMA writes the newest scan of each converter, for ever.
static mut COUNTS: [[u16; 6]; 2] = [[0; 6]; 2];

/// Six gauge channels of each finger: a timer starts a scan of each converter, DMA puts it into
/// memory, and a tick reads what is there.
pub struct Channels(());

impl Channels {
    /// Starts the scans. One sequence is set up once, with every channel's sampling time: each of embassy's
    /// single readings would rewrite the sampling times of all channels.
    fn start<'a>(
        converters: (Peri<'static, ADC1>, Peri<'static, ADC2>),
        dma: (Peri<'static, peripherals::DMA1_CH1>, Peri<'static, peripherals::DMA1_CH2>),
        timer: Peri<'static, peripherals::TIM3>,
        finger1: [AnyAdcChannel<'a, ADC1>; 6],
        finger2: [AnyAdcChannel<'a, ADC2>; 6],
    ) -> Self {
        let config = || {
            let (ratio, shift) = OVERSAMPLING;
            AdcConfig {
                oversampling_ratio: Some(ratio),
                oversampling_shift: Some(shift),
                oversampling_mode: Some((Rovsm::CONTINUED, Trovs::AUTOMATIC, true)),
                ..AdcConfig::default()
            }
        };
        let counts = &raw mut COUNTS;
        // SAFETY: called once; afterwards only DMA writes there, and readings are volatile.
        let [first, second] = unsafe { &mut *counts };
        let timed = |pin| (pin, SampleTime::CYCLES47_5);
        let mut first = Adc::new(converters.0, config()).into_ring_buffered(
            dma.0,
            first,
            Irqs,
            finger1.into_iter().map(timed),
            TIM3_TRGO,
            Exten::RISING_EDGE,
        );
        let timed = |pin| (pin, SampleTime::CYCLES47_5);
        let mut second = Adc::new(converters.1, config()).into_ring_buffered(
            dma.1,
            second,
            Irqs,
            finger2.into_iter().map(timed),
            TIM3_TRGO,
            Exten::RISING_EDGE,
        );
        first.start();
        second.start();
        let timer = Timer::new(timer);
        timer.set_frequency(Hertz(SCANS_HZ), RoundTo::Slower);
        timer.set_master_mode(MasterMode::UPDATE);
        timer.start();
        // They run for ever.
        core::mem::forget((first, second, timer));
        Self(())
    }
}

impl stickslip_unit::board::Channels for Channels {
    fn read(&mut self) -> Option<[u16; 12]> {
        let mut sound = true;
        for (adc, channel) in [pac::ADC1, pac::ADC2].into_iter().zip(0..) {
            let state = adc.isr().read();
            // Written as one: cleared. A scan has ended since the last tick, and none was lost.
            adc.isr().write(|w| w.set_eos(true));
            sound &= state.eos() && !state.ovr();
            if state.ovr() {
                overrun(adc, channel);
            }
        }
        if !sound {
            return None;
        }
        let mut counts = [0; 12];
        for (k, count) in counts.iter_mut().enumerate() {
            // SAFETY: twelve counts lie there; DMA writes each as a whole.
            *count = unsafe { (&raw const COUNTS).cast::<u16>().add(k).read_volatile() };
        }
        Some(counts)
    }
}

/// DMA did not fetch a count in time. The converter gives none to it from then on (RM0440, 21.4.26), and which of the six is
/// next nobody knows: both are stopped, and in a later tick, once the converter has come to rest, begin anew with
/// the first.
#[cold]
fn overrun(adc: pac::adc::Adc, channel: usize) {
    let dma = pac::DMA1.ch(channel);
    if adc.cr().read().adstart() {
        adc.cr().modify(|w| w.set_adstp(pac::adc::vals::Adstp::STOP));
        dma.cr().modify(|w| w.set_en(false));
    } else {
        dma.ndtr().write(|w| w.set_ndt(6));
        dma.cr().modify(|w| w.set_en(true));
        adc.isr().write(|w| w.set_ovr(true));
        adc.cr().modify(|w| w.set_adstart(true));
    }
}

/// Channel and code of its sampling time (ADC_SMPR1, ADC_SMPR2), in the order of each converter's sequence: for tests on a
/// board.
pub fn sampling() -> [[(u8, u8); 6]; 2] {
    [pac::ADC1, pac::ADC2].map(|adc| {
        core::array::from_fn(|k| {
            let channel = if k < 4 { adc.sqr1().read().sq(k) } else { adc.sqr2().read().sq(k - 4) };
            let place = usize::from(channel);
            let code =
                if place < 10 { adc.smpr().read().smp(place) } else { adc.smpr2().read().smp(place - 10) };
            (channel, code.to_bits())
        })
    })
}

/// Alarm lines: PC6 slip, PC8 drop, PC9 sure.
pub type AlarmLines = Lines<Output<'static>, Output<'static>, Output<'static>>;

/// The processor's flash. Embassy's driver blocks; so does this.
pub struct Flash(stm32_flash::Flash<'static, Blocking>);

/// The driver's fault as the storage's.
#[derive(Debug)]
pub struct FlashFault;

impl nor_flash::NorFlashError for FlashFault {
    fn kind(&self) -> nor_flash::NorFlashErrorKind {
        nor_flash::NorFlashErrorKind::Other
    }
}

impl nor_flash::ErrorType for Flash {
    type Error = FlashFault;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        READS_MEMORY.store(true, Ordering::Relaxed);
        cortex_m::asm::dsb();
        let read = self.0.blocking_read(offset, bytes);
        // What its last word raises comes before this ends.
        cortex_m::asm::dsb();
        READS_MEMORY.store(false, Ordering::Relaxed);
        read.map_err(|_| FlashFault)
    }
    fn capacity(&self) -> usize {
        stm32_flash::FLASH_SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = stm32_flash::WRITE_SIZE;
    const ERASE_SIZE: usize = stm32_flash::MAX_ERASE_SIZE;
    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        self.0.blocking_erase(from, to).map_err(|_| FlashFault)
    }
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashFault> {
        self.0.blocking_write(offset, bytes).map_err(|_| FlashFault)
    }
}

/// Whether the memory for settings is read: a word that lost power while it was written or erased may hold two wrong bits
/// or more by its ECC, and reading it then raises an NMI (RM0440, 3.3.8).
static READS_MEMORY: AtomicBool = AtomicBool::new(false);

/// Takes note of such a word and goes on: what was read is anything, and the checksums refuse it. Any other memory that is
/// damaged, as the flash with the firmware, is the end. (The clock's and the SRAM's checks, which raise it too, are off.)
// All code runs on the main stack, on which the processor put where it was.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn NonMaskableInt() {
    core::arch::naked_asm!("mrs r0, msp", "b {damaged}", damaged = sym damaged)
}

unsafe extern "C" fn damaged(stacked: *const u32) {
    // The register's own address and bank are not asked: after a reset in a write they may be wrong.
    if READS_MEMORY.load(Ordering::Relaxed) {
        // Written as one: cleared.
        pac::FLASH.eccr().modify(|w| w.set_eccd(true));
        cortex_m::asm::dsb();
        return;
    }
    // SAFETY: as the processor left it.
    unsafe { post_mortem::interrupted(Ending::MemoryDamaged, stacked) };
    reset()
}

/// CAN-FD on PA11 and PA12.
pub struct CanBus(can::Can<'static>);

impl Bus for CanBus {
    async fn read(&mut self, data: &mut [u8; 64]) -> Option<(u16, usize)> {
        let (frame, _) = self.0.read_fd().await.ok()?.parts();
        let embedded_can::Id::Standard(id) = frame.id() else { return None };
        let bytes = frame.data();
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some((id.as_raw(), bytes.len()))
    }

    async fn write(&mut self, id: u16, data: &[u8]) {
        let Some(id) = embedded_can::StandardId::new(id) else { return };
        // ATI's sensors know classic frames only.
        if data.len() <= 8 {
            if let Ok(frame) = can::Frame::new_data(id, data) {
                let _ = self.0.write(&frame).await;
            }
        } else if let Ok(frame) = can::frame::FdFrame::new_standard(id.as_raw(), data) {
            let _ = self.0.write_fd(&frame).await;
        }
    }
}

/// Counts of the window watchdog from feeding to its reset, each 4096 times 128 clocks of 170 MHz (3.1 ms): 83 ms, so that it
/// warns and bites before the independent one, whose oscillator errs by 8 %. Its warning comes one count before.
const WINDOW_COUNTS: u8 = 27;
/// Below this its counter bites.
const WINDOW_END: u8 = 0x40;

/// Fed by the control task only, and so started with it: reading the settings before ends of itself, but repairing both
/// copies of them after a power cut may take longer than the watchdogs wait. The independent watchdog cannot warn; the window
/// watchdog can, but its clock is the processor's. So both run: the one that warns bites first.
pub struct Watchdog(IndependentWatchdog<'static, IWDG>);

impl Watchdog {
    /// Starts them; the independent one with [`crate::WATCHDOG_MS`].
    pub fn start() -> Self {
        // A processor that a debugger holds does not feed them.
        pac::DBGMCU.apb1lfzr().modify(|w| {
            w.set_iwdg(true);
            w.set_wwdg(true);
        });
        pac::RCC.apb1enr1().modify(|w| w.set_wwdgen(true));
        pac::WWDG.cfr().write(|w| {
            w.set_wdgtb(pac::wwdg::vals::Wdgtb::DIV128);
            w.set_ewi(true);
            // It may be fed at any time.
            w.set_w(0x7f);
        });
        feed_window();
        interrupt::WWDG.set_priority(Priority::P0);
        // SAFETY: its handler shares nothing.
        unsafe { interrupt::WWDG.enable() };
        // SAFETY: the watchdog is used here only.
        let iwdg = unsafe { IWDG::steal() };
        let mut watchdog = IndependentWatchdog::new(iwdg, crate::WATCHDOG_MS * 1000);
        watchdog.unleash();
        Self(watchdog)
    }

    /// Restarts their counts.
    pub fn feed(&mut self) {
        self.0.pet();
        feed_window();
    }
}

/// Restarts the window watchdog's count, and at the first time the watchdog.
fn feed_window() {
    pac::WWDG.cr().write(|w| {
        w.set_t(WINDOW_END + WINDOW_COUNTS - 1);
        w.set_wdga(true);
    });
}

/// The window watchdog's warning: notes what ran, and lets it bite.
// All code runs on the main stack, on which the processor put where it was.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn WWDG() {
    core::arch::naked_asm!("mrs r0, msp", "b {noted}", noted = sym warned)
}

unsafe extern "C" fn warned(stacked: *const u32) -> ! {
    // SAFETY: as the processor left it.
    unsafe { post_mortem::interrupted(Ending::Watchdog, stacked) };
    loop {
        cortex_m::asm::nop();
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
    /// Line of a sensor.
    pub sensor: (SensorRx, SensorTx),
    /// Bus of sensors and of the unit's state.
    pub can: CanBus,
    /// Why the processor started.
    pub reset_cause: ResetCause,
}

fn reset_cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    let cause = if flags.iwdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if flags.borrstf() {
        ResetCause::PowerOn
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.pinrstf() {
        ResetCause::Pin
    } else {
        ResetCause::Unknown
    };
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    cause
}

fn clocks() -> embassy_stm32::Config {
    use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllQDiv, PllRDiv, PllSource, Sysclk, mux};
    let mut config = embassy_stm32::Config::default();
    // 16 MHz / 4 * 85 / 2 = 170 MHz.
    config.rcc.pll = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL85,
        divp: None,
        divq: Some(PllQDiv::DIV8),
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.mux.adc12sel = mux::Adcsel::SYS;
    config.rcc.mux.lpuart1sel = mux::Uartsel::HSI;
    config.rcc.mux.fdcansel = mux::Fdcansel::PCLK1;
    config
}

/// Prescaler of the CAN controller's clock of 170 MHz: quanta of 1/34 us.
const CAN_PRESCALER: NonZeroU16 = NonZeroU16::new(5).unwrap();
/// Quanta before and after the sampling point, the first one apart: 34 a bit (1 Mbit/s), sampled at 79 %; of the data of
/// CAN-FD frames 17 a bit (2 Mbit/s), at 76 %.
const CAN_BIT: [NonZeroU8; 2] = [NonZeroU8::new(26).unwrap(), NonZeroU8::new(7).unwrap()];
const CAN_DATA_BIT: [NonZeroU8; 2] = [NonZeroU8::new(12).unwrap(), NonZeroU8::new(4).unwrap()];

fn can_timing(config: can::config::FdCanConfig) -> can::config::FdCanConfig {
    use can::config::{DataBitTiming, FrameTransmissionConfig, NominalBitTiming};
    let [seg1, seg2] = CAN_BIT;
    let bit = NominalBitTiming { prescaler: CAN_PRESCALER, seg1, seg2, sync_jump_width: seg2 };
    let [seg1, seg2] = CAN_DATA_BIT;
    let data = DataBitTiming {
        transceiver_delay_compensation: true,
        prescaler: CAN_PRESCALER,
        seg1,
        seg2,
        // Less than the second segment.
        sync_jump_width: seg1.min(NonZeroU8::new(3).unwrap_or(seg2)),
    };
    config
        .set_nominal_bit_timing(bit)
        .set_data_bit_timing(data)
        .set_frame_transmit(FrameTransmissionConfig::AllowFdCanAndBRS)
}

/// Brings up clocks, link and converters.
pub fn init(_restarted: bool) -> Board {
    let reset_cause = reset_cause();
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    let p = embassy_stm32::init(clocks());
    // Off after a reset, and embassy leaves it so: flash has four wait states at this clock (RM0440, 3.3.4).
    pac::FLASH.acr().modify(|w| w.set_prften(true));
    let mut config = usart::Config::default();
    config.baudrate = crate::BAUD;
    // What comes during the dearest tick (4 ms, 400 bytes), twice over.
    static RX: StaticCell<[u8; 1024]> = StaticCell::new();
    let uart = Uart::new(p.LPUART1, p.PA3, p.PA2, p.DMA1_CH3, p.DMA1_CH4, Irqs, config);
    let Ok(uart) = uart else {
        defmt::error!("LPUART1 does not take {=u32} baud", crate::BAUD);
        halt();
    };
    let (tx, rx) = uart.split();
    let rx = Rx(rx.into_ring_buffered(RX.init([0; 1024])));
    let mut config = usart::Config::default();
    config.baudrate = ft300::BAUD;
    // 33 ms of 1,920 bytes a second.
    static SENSOR_RX: StaticCell<[u8; 64]> = StaticCell::new();
    let sensor = Uart::new(p.USART1, p.PA10, p.PA9, p.DMA1_CH5, p.DMA1_CH6, Irqs, config);
    let Ok(sensor) = sensor else {
        defmt::error!("USART1 does not take {=u32} baud", ft300::BAUD);
        halt();
    };
    let (sensor_tx, sensor_rx) = sensor.split();
    let sensor_rx = sensor_rx.into_ring_buffered(SENSOR_RX.init([0; 64]));
    let mut can = CanConfigurator::new(p.FDCAN1, p.PA11, p.PA12, Irqs);
    can.set_config(can_timing(can.config()));
    let can = CanBus(can.into_normal_mode());
    let line = |pin: Peri<'static, AnyPin>| Output::new(pin, Level::Low, Speed::Low);
    let alarms = Lines { slip: line(p.PC6.into()), drop: line(p.PC8.into()), sure: line(p.PC9.into()) };
    // With one bank, pages are twice as long, and the processor stands still while one is erased.
    let banks = pac::FLASH.optr().read().dbank();
    if !banks {
        defmt::error!("the flash is one bank (option bit DBANK): nothing is stored");
    }
    let flash = banks.then(|| Flash(stm32_flash::Flash::new_blocking(p.FLASH)));
    let finger1 = [
        p.PA0.degrade_adc(),
        p.PA1.degrade_adc(),
        p.PC0.degrade_adc(),
        p.PC1.degrade_adc(),
        p.PC2.degrade_adc(),
        p.PC3.degrade_adc(),
    ];
    let finger2 = [
        p.PA4.degrade_adc(),
        p.PA6.degrade_adc(),
        p.PA7.degrade_adc(),
        p.PB2.degrade_adc(),
        p.PB11.degrade_adc(),
        p.PC4.degrade_adc(),
    ];
    let gauges = Channels::start((p.ADC1, p.ADC2), (p.DMA1_CH1, p.DMA1_CH2), p.TIM3, finger1, finger2);
    // They wake tasks below the tick: what comes meanwhile, DMA takes.
    interrupt::LPUART1.set_priority(Priority::P1);
    interrupt::USART1.set_priority(Priority::P2);
    interrupt::DMA1_CHANNEL3.set_priority(Priority::P1);
    interrupt::DMA1_CHANNEL4.set_priority(Priority::P1);
    interrupt::DMA1_CHANNEL5.set_priority(Priority::P2);
    interrupt::DMA1_CHANNEL6.set_priority(Priority::P2);
    interrupt::FDCAN1_IT0.set_priority(Priority::P2);
    interrupt::UART4.set_priority(Priority::P4);
    interrupt::UART5.set_priority(Priority::P8);
    Board { rx, tx, gauges, alarms, flash, sensor: (sensor_rx, sensor_tx), can, reset_cause }
}

/// The CAN controller connected to itself, nothing else brought up: for tests on a board.
pub fn loopback() -> CanBus {
    let p = embassy_stm32::init(clocks());
    let mut can = CanConfigurator::new(p.FDCAN1, p.PA11, p.PA12, Irqs);
    can.set_config(can_timing(can.config()));
    CanBus(can.into_internal_loopback_mode())
}

/// Waits for an interrupt.
pub fn idle() {
    cortex_m::asm::wfi();
}

// Two interrupts that nothing else uses carry the executors.
static CONTROL: InterruptExecutor = InterruptExecutor::new();
static COMMUNICATION: InterruptExecutor = InterruptExecutor::new();

/// Spawner of the upper priority.
pub fn control_executor() -> SendSpawner {
    CONTROL.start(interrupt::UART4)
}

/// Spawner of the lower priority.
pub fn communication_executor() -> SendSpawner {
    COMMUNICATION.start(interrupt::UART5)
}

#[embassy_stm32::interrupt]
unsafe fn UART4() {
    // SAFETY: pended by its executor only.
    unsafe { CONTROL.on_interrupt() }
}

#[embassy_stm32::interrupt]
unsafe fn UART5() {
    // SAFETY: pended by its executor only.
    unsafe { COMMUNICATION.on_interrupt() }
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    let how = if stack::met_guard() { Ending::StackOverflow } else { Ending::HardFault };
    post_mortem::end(how, frame.pc(), stack::call_before(frame.lr()), 0);
    reset()
}

/// After a panic: restarts into the safe state, which says so.
pub fn halt() -> ! {
    reset()
}

/// Restarts the processor.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
