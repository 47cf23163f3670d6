//! The comparison in words: one sentence, and the notes without which the figures mislead.

use super::document::{Change, DataSummary, ErrorRow, Fate, ModelReport, Place, Skipped};
use super::noise::Source;
use super::rows::many_primitives;
use super::tare::Tare;
use super::{Forces, Options, SIGNIFICANCE};
use crate::channels::channel_words;
use crate::evidence::conditions::HeldOut;

/// A value in the unit that people read: mm, mrad, N, N mm.
pub fn readable(value: f64, unit: &str) -> String {
    let (factor, shown) = scale(unit);
    // Below a thousandth of the unit (a micronewton in a band's edge) is nothing to a reader.
    let value = if (value * factor).abs() < 1e-3 { 0.0 } else { value * factor };
    format!("{} {shown}", crate::evidence::conditions::trimmed(value, 3))
}

/// Factor from SI, and the unit that people read.
pub fn scale(unit: &str) -> (f64, &'static str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1e3, "mrad"),
        "N" => (1.0, "N"),
        _ => (1e3, "N mm"),
    }
}

/// 'finger 1 force x while sliding', with the primitive where there are several.
pub fn place_words(place: &Place, with_primitive: bool) -> String {
    let words = format!("{} {}", channel_words(place.channel), place.phase.during());
    if with_primitive { format!("{words} ({})", place.primitive.replace('_', " ")) } else { words }
}

fn factor(multiples: f64) -> String {
    if multiples >= 10.0 { format!("{multiples:.0}") } else { format!("{multiples:.1}") }
}

/// The one sentence.
pub fn summary(data: &DataSummary, reports: &[ModelReport], changes: &[Change], single: bool) -> String {
    let (Some(first), Some(last)) = (reports.first(), reports.last()) else {
        return "Nothing was compared.".into();
    };
    let state = of_one(data, last, single);
    if reports.len() < 2 {
        return state;
    }
    let count = |fate| changes.iter().filter(|c| c.fate == fate).count();
    let before = count(Fate::Gone) + count(Fate::Smaller) + count(Fate::Remains);
    let trials = if data.held_out { "held-out trials" } else { "trials" };
    let mut words = format!("From {} to {} the error of the {trials}", first.name, last.name);
    // Where both agree with the measurement there is nothing to tell them apart.
    let failing: Vec<&Change> = changes.iter().filter(|c| c.fate != Fate::Fits).collect();
    let (some, of): (Vec<&Change>, &str) = if failing.is_empty() {
        (changes.iter().collect(), "")
    } else {
        (failing, " where either of them fails")
    };
    let overall = |side: fn(&Change) -> Option<f64>| {
        let known: Vec<f64> = some.iter().filter_map(|c| side(c)).collect();
        (known.iter().map(|m| m * m).sum::<f64>() / known.len().max(1) as f64).sqrt()
    };
    words += &format!(
        " goes from {} to {} times the noise floor{of}",
        factor(overall(|c| c.multiples_before)),
        factor(overall(|c| c.multiples_after)),
    );
    let sizes = changes.iter().filter_map(|c| Some((c, c.multiples_before?, c.multiples_after?)));
    let change = |(_, before, after): &(&Change, f64, f64)| (before * before - after * after).abs();
    if let Some((c, from, to)) = sizes.max_by(|a, b| change(a).total_cmp(&change(b))) {
        words += &format!(
            ", most in {} from {} to {}",
            place_words(&c.place, many_primitives(&first.errors)),
            factor(from),
            factor(to),
        );
    }
    if data.noise_floor == Source::Repetitions && !single {
        words += &format!("; {} of {before} failures are removed", count(Fate::Gone));
        match count(Fate::New) {
            0 => {}
            1 => words += ", 1 is new",
            n => words += &format!(", {n} are new"),
        }
    }
    format!("{words}. {state}")
}

fn of_one(data: &DataSummary, report: &ModelReport, single: bool) -> String {
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let model = &report.name;
    let worst = |rows: &mut dyn Iterator<Item = &ErrorRow>| {
        rows.filter_map(|r| r.multiples.map(|m| (m, r.clone()))).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let Some((largest, row)) = worst(&mut report.errors.iter()) else {
        return format!("Model {model} cannot be tested: neither repetitions nor sensor noise are known.");
    };
    let error = |row: &ErrorRow| readable(row.rms, row.unit);
    if single || data.noise_floor != Source::Repetitions {
        let floor =
            if data.noise_floor == Source::Repetitions { "the noise floor" } else { "the sensor noise" };
        let verdict = if largest < 2.0 { "agrees with" } else { "does not agree with" };
        let what = if single { "the trial" } else { "the measurement" };
        return format!(
            "Model {model} {verdict} {what}: its worst error is {} ({} RMS, {} times {floor}).",
            place_words(&row.place, many),
            error(&row),
            factor(largest),
        );
    }
    let tested = report.errors.iter().filter(|r| r.lack_of_fit.is_some()).count();
    let failing = report.errors.iter().filter(|r| r.fails).count();
    match worst(&mut report.errors.iter().filter(|r| r.fails)) {
        None if largest >= 2.0 => format!(
            "Model {model} shows no lack of fit in its mean errors ({tested} channels and phases), but its error in \
             {} varies over time: {} RMS, {} times the noise floor.",
            place_words(&row.place, many),
            error(&row),
            factor(largest),
        ),
        None => format!(
            "Model {model} agrees with the measurement: none of {tested} channels and phases shows lack of fit \
             (family-wise level {}).",
            data.significance,
        ),
        Some((m, row)) if m < 1.5 => format!(
            "Model {model} agrees within the noise floor; {failing} of {tested} channels and phases show small \
             systematic differences, the largest in {} (mean {}).",
            place_words(&row.place, many),
            readable(row.bias, row.unit),
        ),
        Some((m, row)) => format!(
            "Model {model} does not agree with the measurement: it fails in {failing} of {tested} channels and \
             phases, worst in {} ({} RMS, {} times the noise floor).",
            place_words(&row.place, many),
            error(&row),
            factor(m),
        ),
    }
}

/// What one should know to read the figures.
pub fn notes(
    data: &DataSummary,
    reports: &[ModelReport],
    skipped: &[Skipped],
    options: &Options,
    single: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    match data.noise_floor {
        Source::Repetitions if single => notes.push(
            "One trial: lack of fit is not tested. The noise floor is the scatter of its repetitions.".into(),
        ),
        Source::Repetitions => notes.push(format!(
            "Noise floor: scatter of repetitions ({} of {} conditions were run more than once), of the measurement or of \
             a model's errors, whichever is less; the same for all models. Lack of fit: F test \
             of the conditions' mean errors against that scatter, corrected for multiple tests (Holm), family-wise level \
             {SIGNIFICANCE}.",
            data.repeated_conditions, data.conditions,
        )),
        Source::SensorNoise => notes.push(
            "No condition was run more than once: whether the model fits cannot be tested. Multiples are of the \
             sensors' noise alone, without run-to-run variation; multiples of several do not \
             prove the model wrong. Repeat some conditions (three runs or more) to get a noise floor."
                .into(),
        ),
        Source::Unknown => notes.push(
            "There are neither repetitions nor stated sensor noise: errors are given in SI units only.".into(),
        ),
    }
    if options.forces == Forces::OutsideBand {
        notes.push(
            "Rigid contact leaves some forces undetermined (pads that stick can share a load in any ratio; a grasp that \
             sticks to a plate amplifies micrometres of the gripper's path): a force counts as an error as far as it lies outside the interval \
             of all force distributions with the same motion, net wrench and grip, for all paths within 5 um of the \
             measured one. The line drawn is the one of least elastic energy. --no-force-bands counts the distance to \
             that line."
                .into(),
        );
        notes.push(
            "Real pads deform. Deviations below 0.05 mm + 1 % of the path, 3 mrad, and half of the weight \
             while bodies rest against each other are within the tolerance of any rigid model and are not counted as errors."
                .into(),
        );
    }
    if let Some(report) = reports.last() {
        notes.extend(offset_notes(report, options.tare));
        if report.unsolved_steps > 0 {
            notes.push(format!(
                "{} step(s) of {} did not reach the solver's tolerance.",
                report.unsolved_steps, report.name
            ));
        }
    }
    if !skipped.is_empty() {
        notes.push(format!(
            "{} trial(s) could not be compared; the first: {}.",
            skipped.len(),
            skipped[0].reason.trim_end_matches('.')
        ));
    }
    if reports.len() > 1 && options.held_out == HeldOut::Nothing && !single {
        notes.push(
            "The models may have been fitted to these trials; --held-out compares on trials that they \
             were not fitted to."
                .into(),
        );
    }
    notes
}

fn offset_notes(report: &ModelReport, tare: Tare) -> Vec<String> {
    let offsets = &report.offsets;
    if tare == Tare::None {
        return vec!["Measurements are used as recorded (--no-tare): sensor offsets count as errors.".into()];
    }
    if offsets.channels.is_empty() {
        return vec!["No force was measured before contact: no sensor offset was removed.".into()];
    }
    let mut notes = vec![
        "Sensor offsets: the mean of measurement minus model before contact is subtracted from each trial's forces and \
         torques; of the fingers' normal forces only their imbalance, so that a wrong grip stays visible. Errors \
         with offset are in the JSON document and in the table of the page."
            .into(),
    ];
    if let Some(grip) = offsets.grip {
        let size = format!("{:+.3} N (from trial to trial {:.3} N)", grip.mean_n, grip.deviation_n);
        notes.push(if grip.taken_out {
            format!(
                "Grip, measured less commanded: {size} on average. That is within the sensors' stated uncertainty \
                 and was removed as their offset; a real grip error of this size would look the same."
            )
        } else {
            format!(
                "Grip, measured less commanded: {size} on average, more than the sensors' stated uncertainty. It is \
                 counted as an error."
            )
        });
    }
    let beyond: Vec<&str> = offsets.channels.iter().filter(|c| c.beyond_bound).map(|c| c.channel).collect();
    if !beyond.is_empty() {
        notes.push(format!(
            "Offsets beyond the uncertainty that dataset.toml states: {}. The part beyond it counts as an error.",
            beyond.join(", ")
        ));
    }
    if offsets.trials_without > 0 {
        notes.push(format!(
            "{} trial(s) have too little data before contact; the mean offset of the others is used.",
            offsets.trials_without
        ));
    }
    notes
}
