//! ST's Nucleo-G474RE (Cortex-M4F, 170 MHz) with embassy-stm32.
//!
//! The link is LPUART1 on PA2 and PA3, which the board's ST-LINK shows as a serial port.
//! Twelve gauge amplifiers go to ADC1 and ADC2 (`docs/boards.md` has the pins). This
//! module has been type-checked and linked, not run: no such board was at hand.

use core::mem::MaybeUninit;

use cortex_m::peripheral::DWT;
use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, AnyAdcChannel, Exten, Rovsm, SampleTime, Trovs};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::{ADC1, ADC2, IWDG};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{MasterMode, RoundTo, Timer};
use embassy_stm32::triggers::TIM3_TRGO;
use embassy_stm32::usart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, bind_interrupts, dma, pac, peripherals};
use static_cell::StaticCell;

use super::{Gauges, ResetCause};

/// Name that the board reports.
pub const NAME: &str = "nucleo-g474re";
/// Counts a second of [`timer`]: the core clock.
pub const TIMER_HZ: u32 = 170_000_000;
/// Whether strain gauges are wired to this board.
pub const HAS_GAUGES: bool = true;

bind_interrupts!(struct Irqs {
    LPUART1 => usart::BufferedInterruptHandler<peripherals::LPUART1>;
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
});

/// Core cycles since reset.
pub fn timer() -> u32 {
    DWT::cycle_count()
}

/// Receiving half of the link.
pub type Rx = BufferedUartRx<'static>;
/// Sending half of the link.
pub type Tx = BufferedUartTx<'static>;

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

impl Gauges for Channels {
    fn read(&mut self) -> Option<[u16; 12]> {
        for adc in [pac::ADC1, pac::ADC2] {
            let state = adc.isr().read();
            // Written as one: cleared. A scan has ended since the last tick, and none was lost.
            adc.isr().write(|w| w.set_eos(true));
            if !state.eos() || state.ovr() {
                return None;
            }
        }
        let mut counts = [0; 12];
        for (k, count) in counts.iter_mut().enumerate() {
            // SAFETY: twelve counts lie there; DMA writes each as a whole.
            *count = unsafe { (&raw const COUNTS).cast::<u16>().add(k).read_volatile() };
        }
        Some(counts)
    }
}

/// Fed by the control task only.
pub struct Watchdog(IndependentWatchdog<'static, IWDG>);

impl Watchdog {
    /// Starts it with [`crate::WATCHDOG_MS`].
    pub fn start() -> Self {
        // SAFETY: the watchdog is used here only.
        let iwdg = unsafe { IWDG::steal() };
        let mut watchdog = IndependentWatchdog::new(iwdg, crate::WATCHDOG_MS * 1000);
        watchdog.unleash();
        Self(watchdog)
    }

    /// Restarts its count.
    pub fn feed(&mut self) {
        self.0.pet();
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
    /// Why the processor started.
    pub reset_cause: ResetCause,
    /// Starts since power-on, as far as memory kept.
    pub boots: u32,
}

/// Survives a reset, not a loss of power: a mark, and the starts since it was set.
#[unsafe(link_section = ".uninit.BOOTS")]
static mut BOOTS: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();
const MARK: u32 = 0x57_1c_51_1b;

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
    config
}

/// Brings up clocks, link and converters.
pub fn init() -> Board {
    let reset_cause = reset_cause();
    // SAFETY: runs once, before any interrupt is enabled; every bit pattern is a `u32`.
    let boots = unsafe {
        let kept = (&raw mut BOOTS).cast::<[u32; 2]>();
        let [mark, boots] = kept.read_volatile();
        let boots = if mark == MARK { boots.wrapping_add(1) } else { 1 };
        kept.write_volatile([MARK, boots]);
        boots
    };
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    let p = embassy_stm32::init(clocks());
    let mut config = usart::Config::default();
    config.baudrate = crate::BAUD;
    static TX: StaticCell<[u8; 512]> = StaticCell::new();
    // What comes during the dearest tick (4 ms, 400 bytes), twice over.
    static RX: StaticCell<[u8; 1024]> = StaticCell::new();
    let uart =
        BufferedUart::new(p.LPUART1, p.PA3, p.PA2, TX.init([0; 512]), RX.init([0; 1024]), Irqs, config);
    let Ok(uart) = uart else {
        defmt::error!("LPUART1 does not take {=u32} baud", crate::BAUD);
        halt();
    };
    let (tx, rx) = uart.split();
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
    // The link's interrupt must not wait for a tick: one byte comes every 10 µs.
    interrupt::LPUART1.set_priority(Priority::P1);
    interrupt::UART4.set_priority(Priority::P4);
    interrupt::UART5.set_priority(Priority::P8);
    Board { rx, tx, gauges, reset_cause, boots }
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

/// After a panic: restarts into the safe state, which says so.
pub fn halt() -> ! {
    reset()
}

/// Restarts the processor.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
