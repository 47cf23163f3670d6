//! The last samples of a quantity, the newest first.

/// Puts `newest` first and drops the last.
// By swaps: `rotate_right` alone would bring 1.5 KB of `memmove`.
pub(crate) fn shift_in<T>(list: &mut [T], mut newest: T) {
    list.iter_mut().for_each(|item| core::mem::swap(item, &mut newest));
}
