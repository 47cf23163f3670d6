//! How far a computation is.

/// Told of the stages of a computation and their steps, from any thread. `()` keeps silent.
pub trait Progress: Sync {
    /// A stage of about `steps` steps begins; the one before is done.
    fn begin(&self, stage: &'static str, steps: usize);
    /// Further steps of the stage are done.
    fn step(&self, steps: usize);
}

impl Progress for () {
    fn begin(&self, _: &'static str, _: usize) {}
    fn step(&self, _: usize) {}
}
