//! Units of recordings, as factors to SI.

use crate::spelling::did_you_mean;

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// SI: s.
    Time,
    /// SI: m.
    Length,
    /// SI: rad.
    Angle,
    /// SI: N.
    Force,
    /// SI: N m.
    Torque,
    /// SI: m/s.
    Speed,
    /// SI: rad/s.
    AngularSpeed,
}

/// Standard gravity, m/s²: one kgf in N.
const KGF_N: f64 = 9.806_65;
/// One pound-force in N.
const LBF_N: f64 = 4.448_221_615_260_5;
const INCH_M: f64 = 0.0254;
const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

impl Quantity {
    /// Names and factors; the first is SI.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Quantity::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0)],
            Quantity::Length => &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("in", INCH_M)],
            Quantity::Angle => &[("rad", 1.0), ("mrad", 1e-3), ("deg", DEGREE_RAD)],
            Quantity::Force => {
                &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("kgf", KGF_N), ("gf", KGF_N * 1e-3), ("lbf", LBF_N)]
            }
            Quantity::Torque => &[
                ("N m", 1.0),
                ("N mm", 1e-3),
                ("N cm", 1e-2),
                ("mN m", 1e-3),
                ("kgf cm", KGF_N * 1e-2),
                ("lbf in", LBF_N * INCH_M),
            ],
            Quantity::Speed => &[("m/s", 1.0), ("mm/s", 1e-3), ("cm/s", 1e-2)],
            Quantity::AngularSpeed => &[("rad/s", 1.0), ("deg/s", DEGREE_RAD)],
        }
    }

    /// The SI unit's name.
    #[must_use]
    pub fn si(self) -> &'static str {
        self.units().first().map_or("", |(name, _)| name)
    }

    /// Factor from `unit` to SI. `Nmm`, `N*mm`, `N.mm` are `N mm`; `µ` is `u`.
    ///
    /// # Errors
    /// The units there are.
    pub fn factor(self, unit: &str) -> Result<f64, String> {
        let wanted = plain(unit);
        let found = self.units().iter().find(|(name, _)| plain(name) == wanted);
        found.map(|(_, factor)| *factor).ok_or_else(|| {
            let names: Vec<&str> = self.units().iter().map(|(name, _)| *name).collect();
            let plainly: Vec<String> = names.iter().map(|name| plain(name)).collect();
            let plainly: Vec<&str> = plainly.iter().map(String::as_str).collect();
            let meant = did_you_mean(&wanted, &plainly).and_then(|m| plainly.iter().position(|p| *p == m));
            let hint = meant.map_or_else(String::new, |k| format!("; did you mean {:?}?", names[k]));
            format!("unknown unit {unit:?}; one of {}{hint}", names.join(", "))
        })
    }
}

/// Without blanks and signs of multiplication. Case counts: mN is not MN.
fn plain(unit: &str) -> String {
    unit.chars()
        .filter(|letter| !matches!(letter, ' ' | '*' | '.' | '·' | '\u{22c5}'))
        .map(|letter| if matches!(letter, 'µ' | 'μ') { 'u' } else { letter })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_a_unit_have_one_factor_and_an_unknown_one_lists_those_there_are() {
        for spelling in ["N mm", "Nmm", "N*mm", "N·mm"] {
            assert_eq!(Quantity::Torque.factor(spelling), Ok(1e-3));
        }
        assert_eq!(Quantity::Time.factor("µs"), Ok(1e-6));
        assert_eq!(Quantity::Force.factor("kgf"), Ok(9.806_65));
        let refusal = Quantity::Length.factor("ft").expect_err("no feet");
        assert!(refusal.contains("\"ft\"") && refusal.contains("mm"), "{refusal}");
        let refusal = Quantity::Torque.factor("Nnm").expect_err("no such unit");
        assert!(refusal.ends_with("did you mean \"N mm\"?"), "{refusal}");
    }
}
