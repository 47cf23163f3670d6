//! Time stamps as exact as a recording has them. A stamp since 1970 in one `f64` is good to 0.24 us in seconds, and one in
//! nanoseconds to 256: differences of such stamps lose the last tick of a trial, or a sample at its end.

/// Nanoseconds in a second.
const NS: i128 = 1_000_000_000;

/// A time in the unit of its column: whole units, and the rest of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Towards zero.
    whole: i64,
    /// Of the same sign, below one.
    part: f64,
}

impl Stamp {
    /// Of whole units.
    #[must_use]
    pub fn whole(units: i64) -> Self {
        Self { whole: units, part: 0.0 }
    }

    /// Of nanoseconds, in seconds.
    #[must_use]
    pub fn of_nanoseconds(ns: i128) -> Self {
        let whole = i64::try_from(ns / NS).unwrap_or(i64::MAX);
        Self { whole, part: (ns % NS) as f64 * 1e-9 }
    }

    /// Of a number as it is; `None`: no time.
    #[must_use]
    pub fn of(units: f64) -> Option<Self> {
        // A larger one has no parts.
        const MOST: f64 = 9e18;
        (units.abs() < MOST).then(|| Self { whole: units.trunc() as i64, part: units.fract() })
    }

    /// Of a decimal number as it is written, with a point; `None` for anything else.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let digits = text.strip_prefix('-').unwrap_or(text);
        let (whole, part) = digits.split_once('.').unwrap_or((digits, "0"));
        let plain = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        if !plain(whole) || !plain(part) {
            return text.parse().ok().and_then(Self::of);
        }
        let sign = if digits.len() < text.len() { -1 } else { 1 };
        let (whole, part) = (whole.parse::<i64>().ok()?, format!("0.{part}").parse::<f64>().ok()?);
        Some(Self { whole: sign * whole, part: sign as f64 * part })
    }

    /// Seconds after `zero`; the unit is of so many nanoseconds.
    #[must_use]
    pub fn since_s(self, zero: Zero, unit_ns: i64) -> f64 {
        let whole_ns = i128::from(self.whole) * i128::from(unit_ns) - zero.0;
        let rest_s = self.part * unit_ns as f64 * 1e-9;
        // Whole seconds apart: of many the nanoseconds would be lost.
        (whole_ns / NS) as f64 + ((whole_ns % NS) as f64 * 1e-9 + rest_s)
    }
}

/// From when on times of a trial count: a whole number of nanoseconds of the clock's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Zero(i128);

impl Zero {
    /// The whole unit at or before `stamp`.
    #[must_use]
    pub fn at(stamp: Stamp, unit_ns: i64) -> Self {
        Self(i128::from(stamp.whole) * i128::from(unit_ns))
    }

    /// How much later than `other`, s.
    #[must_use]
    pub fn after_s(self, other: Zero) -> f64 {
        let ns = self.0 - other.0;
        (ns / NS) as f64 + (ns % NS) as f64 * 1e-9
    }

    /// The clock's own time of this, s, as exact as a number is.
    #[must_use]
    pub fn s(self) -> f64 {
        self.after_s(Zero(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_stamps_since_1970_are_exact_in_every_unit() {
        for (unit_ns, first, last) in [
            (1_000_000_000, "1732732800.000000123", "1732732801.996000123"),
            (1_000_000, "1732732800000.000123", "1732732801996.000123"),
            (1000, "1732732800000000.123", "1732732801996000.123"),
            (1, "1732732800000000123", "1732732801996000123"),
        ] {
            let [first, last] = [first, last].map(|text| Stamp::parse(text).expect("a number"));
            let zero = Zero::at(first, unit_ns);
            let step_s = last.since_s(zero, unit_ns) - first.since_s(zero, unit_ns);
            assert!((step_s - 1.996).abs() < 1e-12, "{unit_ns}: {step_s}");
        }
    }

    #[test]
    fn numbers_of_every_form_are_read() {
        let s = |text| Stamp::parse(text).map(|stamp| stamp.since_s(Zero::default(), 1_000_000_000));
        assert_eq!(["12", "-0.25", "1e3", "2.5e-1", ".5"].map(s), [12.0, -0.25, 1000.0, 0.25, 0.5].map(Some));
        assert_eq!(["", "a", "NaN", "1e300", "99999999999999999999"].map(s), [None; 5]);
        assert_eq!(Stamp::of_nanoseconds(1_500_000_000), Stamp::parse("1.5").expect("a number"));
    }
}
