//! The board's clock by this machine's: offset and drift from exchanges.
//!
//! Host and board tell when each of them sent and received. The offset of one exchange is known to half the time on
//! the line both ways (Cristian 1989; Mills, RFC 5905); the quickest exchanges are believed. Over time a line through
//! them, by least squares, gives the drift.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

/// This machine's clock, ns since 1970.
#[must_use]
pub fn now_ns() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(now.as_nanos()).unwrap_or_default()
}

/// One exchange: times of this machine and of the board, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// This machine sent.
    pub asked_s: f64,
    /// The board received and sent.
    pub board_s: [f64; 2],
    /// This machine received.
    pub answered_s: f64,
}

impl Exchange {
    /// Board's clock less this machine's, s.
    fn offset_s(&self) -> f64 {
        let [received, sent] = self.board_s;
        ((received - self.asked_s) + (sent - self.answered_s)) / 2.0
    }

    /// On the line, both ways, s.
    fn on_the_line_s(&self) -> f64 {
        let [received, sent] = self.board_s;
        (self.answered_s - self.asked_s) - (sent - received)
    }

    fn middle_s(&self) -> f64 {
        (self.asked_s + self.answered_s) / 2.0
    }
}

/// The board's clock: `board = host + offset + drift (host - at)`.
#[derive(Clone, Copy, Debug, PartialEq, schemars::JsonSchema, Serialize)]
pub struct Clock {
    /// When the offset holds, s of this machine.
    pub at_s: f64,
    /// Board's clock less this machine's, s.
    pub offset_s: f64,
    /// Seconds that the board's clock gains each second; null: the exchanges span too little time to estimate it.
    pub drift: Option<f64>,
    /// What the offset may be wrong by: half the time on the line of the quickest exchange, s.
    pub uncertainty_s: f64,
    /// Exchanges used, of those made.
    pub used: usize,
    /// Made.
    pub made: usize,
}

/// Exchanges whose time on the line exceeds the quickest one's by this factor are left out: their answers waited.
const SLOW: f64 = 1.5;
/// Two crystals differ by 100 ppm at most; a drift is told where the offsets' uncertainty lets tell a tenth of it.
const TELLABLE: f64 = 1e-5;

impl Clock {
    /// From exchanges; `None` where none makes sense: times that are not finite, or an answer before its request.
    #[must_use]
    pub fn of(exchanges: &[Exchange]) -> Option<Self> {
        let sound =
            |e: &&Exchange| e.on_the_line_s() >= 0.0 && e.offset_s().is_finite() && e.middle_s().is_finite();
        let quickest = exchanges.iter().filter(sound).map(Exchange::on_the_line_s).reduce(f64::min)?;
        let used: Vec<_> =
            exchanges.iter().filter(sound).filter(|e| e.on_the_line_s() <= quickest * SLOW + 1e-9).collect();
        let count = used.len() as f64;
        let mean = |of: &dyn Fn(&Exchange) -> f64| used.iter().map(|e| of(e)).sum::<f64>() / count;
        let (at_s, offset_s) = (mean(&Exchange::middle_s), mean(&Exchange::offset_s));
        let (mut spread, mut common) = (0.0, 0.0);
        for e in &used {
            let away = e.middle_s() - at_s;
            spread += away * away;
            common += away * (e.offset_s() - offset_s);
        }
        let uncertainty_s = quickest / 2.0;
        // Standard error of a slope whose offsets err by what the line's time leaves open.
        let tells = spread > 0.0 && uncertainty_s * (SLOW - 1.0) / spread.sqrt() < TELLABLE;
        let drift = tells.then(|| common / spread);
        Some(Self { at_s, offset_s, drift, uncertainty_s, used: used.len(), made: exchanges.len() })
    }

    /// The same, times of this machine counted from `zero_s` of them.
    #[must_use]
    pub fn counted_from(&self, zero_s: f64) -> Self {
        Self { at_s: self.at_s - zero_s, offset_s: self.offset_s + zero_s, ..*self }
    }

    /// The board's time at a time of this machine, s.
    #[must_use]
    pub fn board_s(&self, host_s: f64) -> f64 {
        host_s + self.offset_s + self.drift.unwrap_or(0.0) * (host_s - self.at_s)
    }

    /// This machine's time at a time of the board, s.
    #[must_use]
    pub fn host_s(&self, board_s: f64) -> f64 {
        let drift = self.drift.unwrap_or(0.0);
        (board_s - self.offset_s + drift * self.at_s) / (1.0 + drift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that needs `there` and `back`, s, and a board whose clock runs `drift` too fast from `offset`.
    fn exchanges(
        count: usize,
        apart_s: f64,
        offset: f64,
        drift: f64,
        line: impl Fn(usize) -> [f64; 2],
    ) -> Vec<Exchange> {
        let board = |t: f64| offset + (1.0 + drift) * t;
        let one = |k: usize| {
            let ([there, back], asked_s) = (line(k), k as f64 * apart_s);
            let read = asked_s + there;
            let board_s = [board(read), board(read + 20e-6)];
            Exchange { asked_s, board_s, answered_s: read + 20e-6 + back }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn offset_and_drift_of_a_quiet_line_are_found() {
        let clock = Clock::of(&exchanges(40, 0.5, 12.5, 60e-6, |_| [3e-4, 3e-4])).unwrap();
        assert!((clock.drift.unwrap() - 60e-6).abs() < 1e-8, "{clock:?}");
        assert!((clock.board_s(100.0) - (12.5 + 100.0 * (1.0 + 60e-6))).abs() < 2e-6);
        assert!((clock.host_s(clock.board_s(7.0)) - 7.0).abs() < 1e-9);
    }

    #[test]
    fn counted_from_another_time_it_is_the_same_clock() {
        let clock = Clock::of(&exchanges(40, 0.5, 12.5, 60e-6, |_| [3e-4, 3e-4])).unwrap();
        let shifted = clock.counted_from(3.25);
        for t in [0.0, 7.0, 1e3] {
            assert!((shifted.board_s(t) - clock.board_s(t + 3.25)).abs() < 1e-9, "{t}");
        }
    }

    #[test]
    fn answers_that_waited_on_a_busy_line_do_not_move_the_clock() {
        let busy = |k: usize| if k.is_multiple_of(3) { [2e-2, 3e-4] } else { [3e-4, 3e-4] };
        let clock = Clock::of(&exchanges(40, 0.5, -3.0, 0.0, busy)).unwrap();
        assert!((clock.board_s(10.0) - 7.0).abs() < 1e-6, "{clock:?}");
        assert_eq!((clock.used, clock.made), (26, 40));
    }

    #[test]
    fn an_uneven_line_errs_by_no_more_than_is_told() {
        let clock = Clock::of(&exchanges(10, 0.1, 1.0, 0.0, |_| [1e-3, 1e-4])).unwrap();
        assert!((clock.offset_s - 1.0).abs() <= clock.uncertainty_s, "{clock:?}");
    }

    #[test]
    fn a_short_look_tells_no_drift_and_nonsense_tells_nothing() {
        let clock = Clock::of(&exchanges(5, 0.01, 1.0, 50e-6, |_| [3e-4, 3e-4])).unwrap();
        assert_eq!(clock.drift, None);
        assert_eq!(Clock::of(&[]), None);
        let backwards = Exchange { asked_s: 1.0, board_s: [0.0, 0.0], answered_s: 0.5 };
        let nan = Exchange { asked_s: 0.0, board_s: [f64::NAN; 2], answered_s: 1.0 };
        assert_eq!(Clock::of(&[backwards, nan]), None);
    }
}
