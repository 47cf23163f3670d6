//! The comparison in words: one sentence, and the notes without which the figures mislead.

use super::document::{Change, DataSummary, ErrorRow, ModelReport, Place, Tally};
use super::inputs::{Forces, Options, SIGNIFICANCE};
use super::noise::Source;
use super::rows::{SUSTAINED_S, many_primitives};
use super::tare::Tare;
use crate::channels::channel_words;
use crate::evidence::conditions::HeldOut;
use crate::evidence::statistics::{critical_f, median};

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

/// The sentences at the top; `changes` with their tallies, within the first model's tolerance and
/// without any, where there are two models.
pub fn summary(
    data: &DataSummary,
    reports: &[ModelReport],
    (changes, tallies): (&[Change], &[Tally]),
    single: bool,
) -> String {
    let (Some(first), Some(last)) = (reports.first(), reports.last()) else {
        return "Nothing was compared.".into();
    };
    let state = of_one(data, last, single);
    let (2.., Some(tally)) = (reports.len(), tallies.first()) else {
        return state;
    };
    let trials = if data.held_out { "held-out trials" } else { "trials" };
    let mut words = format!("From {} to {} the error of the {trials}", first.name, last.name);
    if data.noise_floor != Source::Repetitions {
        let by =
            |c: &Change| (c.before.rms.powi(2) - c.after.rms.powi(2)).abs() / c.residual_before.rms.powi(2);
        if let Some(c) = changes.iter().max_by(|a, b| by(a).total_cmp(&by(b))) {
            words += &format!(
                " changes most in {}, from {} to {} RMS",
                place_words(&c.place, many_primitives(&first.errors)),
                readable(c.before.rms, c.unit),
                readable(c.after.rms, c.unit),
            );
        }
        return format!("{words}. {state}");
    }
    let of = if tally.failures + tally.new > 0 { " where either of them fails" } else { "" };
    words +=
        &format!(" goes from {} to {} times the noise floor{of}", factor(tally.before), factor(tally.after));
    words += &largest_changes(changes, tally.after <= tally.before, many_primitives(&first.errors));
    if !single {
        words += &format!("; {}", counted(tally));
        if let Some(without) = tallies.get(1).filter(|_| first.open_force_n.is_some()) {
            words += &format!(
                ". Without any tolerance: from {} to {}; {}",
                factor(without.before),
                factor(without.after),
                counted(without)
            );
        }
    }
    format!("{words}. {state}")
}

/// Where the error changes most as all of it does (whether that `falls`), and where it changes by more against that.
fn largest_changes(changes: &[Change], falls: bool, many: bool) -> String {
    let sizes: Vec<(&Change, f64, f64)> =
        changes.iter().filter_map(|c| Some((c, c.before.multiples?, c.after.multiples?))).collect();
    let change = |(_, before, after): &(&Change, f64, f64)| {
        if falls { before * before - after * after } else { after * after - before * before }
    };
    let words = |(c, from, to): &(&Change, f64, f64)| {
        format!("{} from {} to {}", place_words(&c.place, many), factor(*from), factor(*to))
    };
    let most = sizes.iter().max_by(|a, b| change(a).total_cmp(&change(b))).filter(|c| change(c) > 0.0);
    let against = sizes.iter().min_by(|a, b| change(a).total_cmp(&change(b)));
    let against = against.filter(|c| -change(c) > most.map_or(0.0, change));
    let way = if falls { "rises" } else { "falls" };
    let mut out = most.map_or(String::new(), |c| format!(", most in {}", words(c)));
    if let Some(c) = against {
        out += &format!(", while it {way} in {}", words(c));
    }
    out
}

/// '12 of 24 failures are removed, 2 are larger, 1 is new'.
fn counted(tally: &Tally) -> String {
    let mut words = format!("{} of {} failures are removed", tally.removed, tally.failures);
    for (count, what) in [(tally.larger, "larger"), (tally.new, "new")] {
        match count {
            0 => {}
            1 => words += &format!(", 1 is {what}"),
            n => words += &format!(", {n} are {what}"),
        }
    }
    words
}

fn of_one(data: &DataSummary, report: &ModelReport, single: bool) -> String {
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let model = named(&report.name);
    let worst = |rows: &mut dyn Iterator<Item = &ErrorRow>| {
        rows.filter_map(|r| r.error.multiples.map(|m| (m, r.clone()))).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let Some((largest, row)) = worst(&mut report.errors.iter()) else {
        return format!("{model} cannot be tested: neither repetitions nor sensor noise are known.");
    };
    let error = |row: &ErrorRow| readable(row.error.rms, row.unit);
    if data.noise_floor != Source::Repetitions {
        return without_repetitions(report, many);
    }
    if single {
        let verdict = if largest < 2.0 { "agrees with" } else { "does not agree with" };
        return format!(
            "{model} {verdict} the trial: its worst error is {} ({} RMS, {} times the noise floor).",
            place_words(&row.place, many),
            error(&row),
            factor(largest),
        );
    }
    let tested = report.errors.iter().filter(|r| r.lack_of_fit.is_some()).count();
    let failing = report.errors.iter().filter(|r| r.fails).count();
    // A touch or an onset of a few samples is a matter of timing.
    let lasting = worst(&mut report.errors.iter().filter(|r| r.duration_s >= SUSTAINED_S));
    match worst(&mut report.errors.iter().filter(|r| r.fails)) {
        None => {
            let brief = worst(&mut report.errors.iter().filter(|r| r.duration_s < SUSTAINED_S));
            let brief = brief.filter(|b| b.0 >= lasting.as_ref().map_or(2.0, |l| l.0.max(2.0)));
            let mut words = match lasting.filter(|l| l.0 >= 2.0) {
                Some((m, row)) => format!(
                    "{model} shows no lack of fit in its mean errors ({tested} channels and phases), but its \
                     error in {} varies over time: {} RMS, {} times the noise floor.",
                    place_words(&row.place, many),
                    error(&row),
                    factor(m),
                ),
                None => format!(
                    "{model} agrees with the measurement: none of {tested} channels and phases shows lack of \
                     fit (family-wise level {}).",
                    data.significance,
                ),
            };
            if let Some((m, row)) = brief {
                words += &format!(
                    " Where a phase lasts less than 0.1 s, and a few samples of timing decide, the error reaches {} \
                     times the noise floor: {} for {:.0} ms.",
                    factor(m),
                    place_words(&row.place, many),
                    1e3 * row.duration_s,
                );
            }
            if let Some(least) = least_seen(data, report, tested).filter(|m| *m >= 2.0) {
                words += &format!(
                    " With so few repetitions the test sees only mean errors beyond about {} times the noise floor.",
                    factor(least)
                );
            }
            words
        }
        Some((m, row)) if m < 1.5 => format!(
            "{model} agrees within the noise floor; {failing} of {tested} channels and phases show small \
             systematic differences, the largest in {} (mean {}).",
            place_words(&row.place, many),
            readable(row.error.mean, row.unit),
        ),
        Some((m, row)) => format!(
            "{model} does not agree with the measurement: it fails in {failing} of {tested} channels and \
             phases, worst in {} ({} RMS, {} times the noise floor).",
            place_words(&row.place, many),
            error(&row),
            factor(m),
        ),
    }
}

/// The mean error that the test for lack of fit would notice, in noise floors: the median over the `tested` channels
/// and phases. It grows with their number and falls with that of the repetitions.
fn least_seen(data: &DataSummary, report: &ModelReport, tested: usize) -> Option<f64> {
    let runs = data.trials as f64 / data.conditions.max(1) as f64;
    let of = |r: &ErrorRow| {
        let (test, floor) = r.lack_of_fit.zip(r.noise_floor)?;
        let f = critical_f(test.df_fit, test.df_error, data.significance / tested.max(1) as f64)?;
        Some(test.pure_error * (f / runs).sqrt() / floor)
    };
    median(report.errors.iter().filter_map(of))
}

/// A model at the beginning of a sentence: one in `model.toml` has no other name.
fn named(name: &str) -> String {
    if name == "model" { "The model".to_owned() } else { format!("Model {name}") }
}

fn first_small(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// What data without repetitions can show: errors that last and are beyond what the sensors may be
/// off by. Nothing about chance, and nothing about a few samples of an onset.
fn without_repetitions(report: &ModelReport, many: bool) -> String {
    let model = named(&report.name);
    let judged: Vec<&ErrorRow> = report.errors.iter().filter(|r| r.sustained.is_some()).collect();
    let beyond: Vec<&&ErrorRow> = judged.iter().filter(|r| r.sustained == Some(true)).collect();
    let size = |r: &ErrorRow| r.error.mean.abs() / r.noise_floor.unwrap_or(f64::INFINITY);
    let worst = beyond.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    match worst {
        _ if judged.is_empty() => format!(
            "{model} cannot be tested: no condition was run more than once, and dataset.toml states no sensor \
             uncertainty."
        ),
        None => format!(
            "Nothing in these unrepeated trials contradicts {}: in none of {} channels and phases of 0.1 s \
             or longer is its mean error beyond the tolerance and the stated sensor uncertainty. Run-to-run \
             variation is unknown: no condition was run more than once.",
            first_small(&model),
            judged.len(),
        ),
        Some(row) => format!(
            "{model} does not agree with the measurement: in {} of {} channels and phases of 0.1 s or longer its \
             mean error is beyond the tolerance and the stated sensor uncertainty, the largest in {} (mean {}). \
             No condition was run more than once: part of it may be run-to-run variation.",
            beyond.len(),
            judged.len(),
            place_words(&row.place, many),
            readable(row.error.mean, row.unit),
        ),
    }
}

/// What one should know to read the figures.
pub fn notes(data: &DataSummary, reports: &[ModelReport], options: &Options, single: bool) -> Vec<String> {
    let mut notes = Vec::new();
    match data.noise_floor {
        Source::Repetitions if single => notes.push(
            "One trial: lack of fit is not tested. The noise floor is the scatter of its repetitions.".into(),
        ),
        Source::Repetitions => notes.push(format!(
            "Noise floor: scatter of the measurement between repetitions ({} of {} conditions were run more than once). \
             It depends on the data alone and is the same for all models. A perfect model has a residual of 1.0 times the \
             noise floor. Lack of fit: F test of the conditions' mean errors against the scatter of the \
             measurement or of the model's residuals, whichever is less, corrected for multiple tests (Holm), \
             family-wise level {SIGNIFICANCE}.",
            data.repeated_conditions, data.conditions,
        )),
        Source::SensorNoise => notes.push(
            "No condition was run more than once: there is no noise floor, and whether the model fits cannot be tested. \
             Multiples are of the sensors' noise alone, without run-to-run variation, and do not prove the model \
             wrong, least of all in the few samples of an onset. What counts is a mean error over 0.1 s or longer \
             beyond the stated sensor uncertainty. Repeat some conditions (three runs or more)."
                .into(),
        ),
        Source::Unknown => notes.push(
            "There are neither repetitions nor stated sensor noise: errors are given in SI units only.".into(),
        ),
    }
    // Only a rigid model leaves something open; recorded signals of another engine have no intervals.
    let open: Vec<String> = reports
        .iter()
        .filter_map(|r| r.open_force_n.map(|n| format!("{} {}", r.name, readable(n, "N"))))
        .collect();
    if options.forces == Forces::OutsideBand && open.is_empty() {
        notes.push("No tolerance is applied: error and residual are the same for these models.".into());
    }
    if !open.is_empty() {
        notes.push(
            "Rigid contact leaves some forces undetermined (pads that stick can share a load in any ratio; a grasp that \
             sticks to a plate amplifies micrometres of the gripper's path): a force counts as an error as far as it lies outside the interval \
             of all force distributions with the same motion, net wrench and grip, for all paths within 5 um of the \
             measured one. The line drawn is the one of least elastic energy. Without these force bands the whole \
             residual counts."
                .into(),
        );
        notes.push(
            "Real pads deform. Deviations below 0.05 mm + 1 % of the path, 3 mrad, and half of the weight \
             while bodies rest against each other are within the tolerance of any rigid model and are not counted as errors."
                .into(),
        );
        let mut width = format!(
            "Mean width of these intervals while the object is pushed: {}. The wider, the less a small error proves.",
            open.join(", ")
        );
        if let (2.., Some(first)) = (reports.len(), reports.first()) {
            width += &format!(
                " Before and after are both judged by the tolerance of {}, so that a model gains nothing by leaving \
                 more open; each model's own errors are judged by its own.",
                first.name
            );
        }
        notes.push(width);
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
    if reports.len() > 1 && options.held_out == HeldOut::Nothing && !single {
        notes.push(
            "The models may have been fitted to these trials: hold some out to compare on trials that they were \
             not fitted to."
                .into(),
        );
    }
    notes
}

fn offset_notes(report: &ModelReport, tare: Tare) -> Vec<String> {
    let offsets = &report.offsets;
    if tare == Tare::None {
        return vec!["Measurements are used as recorded (no tare): sensor offsets count as errors.".into()];
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
