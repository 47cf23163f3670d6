//! A bench without scatter and noise.

use stickslip_second_rig::dataset::{DataSet, Wish};
use stickslip_second_rig::families::Family;
use stickslip_second_rig::reality::Scatter;
use stickslip_second_rig::sensors::Sensors;

/// A data set of a family in which every run is the same and sensors are perfect.
pub fn clean(family: &str, seed: u64, effects: &[(&str, f64)], trials: usize) -> DataSet {
    let effects = effects.iter().map(|(id, level)| ((*id).to_owned(), Some(*level))).collect();
    let wish = Wish { effects: Some(effects), trials: Some(trials) };
    let family = Family::named(family).expect("a family");
    let mut set = DataSet::draw(family, seed, &wish).expect("a data set");
    set.reality.scatter = Scatter::none();
    let faults = set.reality.sensors.faults.clone();
    set.reality.sensors = Sensors { latency_s: set.reality.sensors.latency_s, ..Sensors::perfect(250.0) };
    for (now, before) in set.reality.sensors.faults.iter_mut().zip(faults) {
        now.gain = before.gain;
        now.misaligned = before.misaligned;
        now.crosstalk = before.crosstalk;
        // Biases within what is stated are nuisances; beyond it they are the effect.
        if effects_bias(&set.effects) {
            now.bias = before.bias;
        }
    }
    set
}

fn effects_bias(effects: &[stickslip_second_rig::hidden::Applied]) -> bool {
    effects.iter().any(|e| e.id == "sensor_bias")
}
