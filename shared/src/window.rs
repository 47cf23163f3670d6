//! The last samples of a quantity, the newest first.

/// Puts `newest` first and drops the last.
// One by one: `rotate_right` alone would bring `memmove` (firmware/src/moves.rs), and swaps take some 200 bytes each.
pub(crate) fn shift_in<T>(list: &mut [T], mut newest: T) {
    for item in list {
        newest = core::mem::replace(item, newest);
    }
}
