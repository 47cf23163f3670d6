//! Numbers that were chosen, not derived: each is described once, with its default, its bounds and its documentation, and
//! whoever reads, prints or checks them goes through that description.
//!
//! `tuned!` makes of a list a struct, its [`Default`], and [`Tuned`], which shows every number to a [`Visitor`] together
//! with what is said of it. The firmware runs the defaults and links nothing of the rest.

use crate::real::Real;

/// What is said of a number, or of a few of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// Its field.
    pub name: &'static str,
    /// The field's documentation, one line for each of it: what it is, its unit, why it has its value, what it changes if it is
    /// doubled.
    pub doc: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

/// Where a number lies, whatever its type.
pub trait Slot {
    /// How many there are.
    fn count(&self) -> usize;
    /// They are whole numbers.
    fn is_whole(&self) -> bool;
    /// The one at a place; `None`: there are fewer.
    fn get(&self, at: usize) -> Option<f64>;
    /// Sets the one at a place, to the nearest value that its type has.
    fn set(&mut self, at: usize, value: f64);
}

impl<R: Real> Slot for R {
    fn count(&self) -> usize {
        1
    }
    fn is_whole(&self) -> bool {
        false
    }
    fn get(&self, at: usize) -> Option<f64> {
        (at == 0).then(|| self.to_f64())
    }
    fn set(&mut self, _: usize, value: f64) {
        *self = R::of(value);
    }
}

impl<R: Real> Slot for [R; 2] {
    fn count(&self) -> usize {
        2
    }
    fn is_whole(&self) -> bool {
        false
    }
    fn get(&self, at: usize) -> Option<f64> {
        <[R]>::get(self, at).map(|x| x.to_f64())
    }
    fn set(&mut self, at: usize, value: f64) {
        if let Some(place) = self.get_mut(at) {
            *place = R::of(value);
        }
    }
}

macro_rules! whole {
    ($($type:ty),+) => {
        $(impl Slot for $type {
            fn count(&self) -> usize {
                1
            }
            fn is_whole(&self) -> bool {
                true
            }
            fn get(&self, at: usize) -> Option<f64> {
                (at == 0).then(|| f64::from(*self))
            }
            fn set(&mut self, _: usize, value: f64) {
                *self = value as $type;
            }
        })+
    };
}

whole!(u8, u16);

/// Sees every number of a [`Tuned`], table by table.
pub trait Visitor {
    /// A table begins, in the one that has begun and not ended.
    fn enter(&mut self, name: &'static str, doc: &'static str);
    /// The last one that began has ended.
    fn leave(&mut self);
    /// A number of the table.
    fn number(&mut self, about: &About, slot: &mut dyn Slot);
}

/// Shows its numbers.
pub trait Tuned {
    /// All of them, in order.
    fn visit(&mut self, visitor: &mut dyn Visitor);
}

/// Tables in one another, at most.
pub const DEEPEST: usize = 3;

/// A number beyond its bounds, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfBounds {
    /// The tables that it is in, the outermost first; those that are not are empty.
    pub tables: [&'static str; DEEPEST],
    /// The field.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl core::fmt::Display for OutOfBounds {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for table in self.tables.iter().filter(|t| !t.is_empty()) {
            write!(f, "{table}.")?;
        }
        write!(f, "{} = {} must lie between {} and {}", self.name, self.value, self.low, self.high)
    }
}

impl core::error::Error for OutOfBounds {}

/// Refuses the first number that is not within its bounds; NaN is within none.
///
/// # Errors
/// Which, and the bounds.
pub fn check(of: &mut impl Tuned) -> Result<(), OutOfBounds> {
    struct Check {
        tables: [&'static str; DEEPEST],
        depth: usize,
        found: Result<(), OutOfBounds>,
    }
    impl Visitor for Check {
        fn enter(&mut self, name: &'static str, _: &'static str) {
            if let Some(place) = self.tables.get_mut(self.depth) {
                *place = name;
            }
            self.depth = self.depth.saturating_add(1);
        }
        fn leave(&mut self) {
            self.depth = self.depth.saturating_sub(1);
            if let Some(place) = self.tables.get_mut(self.depth) {
                *place = "";
            }
        }
        fn number(&mut self, about: &About, slot: &mut dyn Slot) {
            let About { name, low, high, .. } = *about;
            let values = (0..slot.count()).filter_map(|at| slot.get(at));
            // A bound of a number that is kept in single precision is rounded as the number is.
            let least = f64::from(low as f32).min(low);
            let most = f64::from(high as f32).max(high);
            for value in values {
                if self.found.is_ok() && !(value >= least && value <= most) {
                    self.found = Err(OutOfBounds { tables: self.tables, name, value, low, high });
                }
            }
        }
    }
    let mut check = Check { tables: [""; DEEPEST], depth: 0, found: Ok(()) };
    of.visit(&mut check);
    check.found
}

/// A struct of numbers that were chosen. A field is its documentation, its type, its default, and its bounds; one without bounds
/// is a struct of this kind itself.
macro_rules! tuned {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident $(<$r:ident>)? {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr $(, $low:literal to $high:literal)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name $(<$r: $crate::real::Real>)? {
            $(
                $(#[doc = $doc])+
                $(#[doc = concat!("\n\nDefault `", stringify!($default), "`; from ", $low, " to ", $high, ".")])?
                pub $field: $type,
            )+
        }

        impl $(<$r: $crate::real::Real>)? Default for $name $(<$r>)? {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $(<$r: $crate::real::Real>)? $crate::tuning::Tuned for $name $(<$r>)? {
            fn visit(&mut self, visitor: &mut dyn $crate::tuning::Visitor) {
                $($crate::tuning::tuned!(
                    @show visitor, self.$field, stringify!($field), concat!($($doc, "\n"),+) $(, $low, $high)?
                );)+
            }
        }
    };
    (@show $visitor:ident, $place:expr, $name:expr, $doc:expr, $low:literal, $high:literal) => {
        $visitor.number(
            &$crate::tuning::About { name: $name, doc: $doc, low: $low, high: $high },
            &mut $place,
        )
    };
    (@show $visitor:ident, $place:expr, $name:expr, $doc:expr) => {
        $visitor.enter($name, $doc);
        $crate::tuning::Tuned::visit(&mut $place, $visitor);
        $visitor.leave()
    };
}
pub(crate) use tuned;
