//! The diagnosis as one page: the verdict in plain words, the largest misfits before and after, the next
//! command; then a card for each effect that is named or nearly so, the bench and the traces without and with
//! it, what else was tried, and what these data cannot tell.

use maud::{Markup, html};

use crate::bars::{Bars, multiples, shares};
pub use crate::diagnosis::{credible, explains, percent, sentence, share, structure_words, weaker};
use crate::diagnosis::{has_after, set_words};
use crate::experiment::{drawn_experiment, experiment_file};
use crate::figures::Figure;
use crate::html::{Tone, figure, first_screen, heat, left_out, list, page, swatch, unfold};
use crate::limits;
pub use crate::limits::limits_on_effects;
use crate::overlay::{plot_id, section, trace_figures, worst};
use crate::plot::Chart;
use crate::signature::{Run, bars, over_a_run, signature};
use crate::words::{
    effects_in_words, first_sentence, identifier_words as words, interval, parameter_words, short,
};
use stickslip_analysis::Progress;
use stickslip_analysis::channels::{NAMES, Signals, channel_words};
use stickslip_analysis::compare::document::Comparison;
use stickslip_analysis::compare::{CompareError, Forces, NamedModel, Options, compare};
use stickslip_analysis::diagnose::RELEVANT;
use stickslip_analysis::diagnose::ordinary::Ordinary;
use stickslip_analysis::diagnose::report::{CandidateReport, Place, Report, Verdict};
use stickslip_analysis::diagnose::signature::Mark;
use stickslip_analysis::evidence::phases::PHASES;
use stickslip_analysis::fit::phases::Phase;
use stickslip_data::Index;
use stickslip_shared::model::Model;

/// Places of the first picture.
const DRAWN: usize = 6;
/// Cards of effects that are not named.
const NEAR: usize = 2;
/// Such an effect explains at least this share of what it is added to leaves.
const NEARLY: f64 = 0.5;
/// Effects of which the figures are shown at first.
const AT_FIRST: usize = 5;

/// The page; `next` is the command that comes next, `traces` what [`traces`] gives, or why it gives nothing.
pub fn html(report: &Report, name: &str, next: &str, traces: Result<&Comparison, String>) -> String {
    let (traces, none) = match traces {
        Ok(traces) => (Some(traces), None),
        Err(why) => (None, Some(why)),
    };
    let tone = match report.verdict {
        Verdict::NothingMissing => Tone::Good,
        Verdict::Effect | Verdict::Ambiguous | Verdict::Inconclusive => Tone::Fair,
        Verdict::Unexplained => Tone::Bad,
    };
    let e = &report.error;
    let sentence = sentence(report);
    let (lead, rest) = first_sentence(&sentence);
    let picture = html! {
        (left_out(&report.left_out, &report.refused, report.trials + report.left_out.len()))
        @if !rest.is_empty() { p { (rest) } }
        @if let Some(would_tell) = &report.would_tell { p { b { "What would decide:" } " " (effects_in_words(would_tell)) "." } }
        @if let Some(weaker) = weaker(report) { p { (weaker) } }
        (misfit_bars(report))
    };
    let run = traces.filter(|_| has_after(report)).and_then(|traces| over_a_run(traces, named_marks(report)));
    let body = html! {
        (first_screen(("diagnose", name), (tone, lead), &picture, next))
        div class="facts" {
            span { b { (report.trials) } " trials" }
            span { b { (report.conditions) } " conditions" }
            span { "held-out error before: " b { (format!("{:.2}", e.before)) } " run spreads" }
            @if has_after(report) { span { "after: " b { (format!("{:.2}", e.after)) } } }
            span { "a perfect model: " b { (format!("{:.2}", e.perfect_model)) } }
        }
        (cards(report, run.as_ref()))
        @if let Some(c) = traces {
            (section(&c.traces, &names(c), first_errors(c), last_errors(c)))
        }
        @if let Some(why) = none { p class="soft" { "No traces can be shown: " (why) } }
        (credible_bars(report))
        (tried(report))
        (maps(report, traces))
        (list("Remaining misfit", &report.unexplained.iter().map(structure_words).collect::<Vec<_>>()))
        @if let Some(experiment) = &report.suggested_experiment { (drawn_experiment(report, experiment)) }
        @if !has_after(report) { (limits::section(report)) }
        @if !report.classes.is_empty() {
            h2 { "Effects that these trials do not separate" }
            div class="flow" {
                @for class in &report.classes {
                    div class="card" { @for (k, id) in class.iter().enumerate() { @if k > 0 { " = " } b { (words(id)) } } }
                }
            }
        }
        (parameters(report))
        (list("What cannot be concluded", &report.limits.iter().map(|l| effects_in_words(l)).collect::<Vec<_>>()))
    };
    page(&format!("stickslip diagnose: {name}"), body)
}

/// Most trials whose traces a page shows.
const TRACES: usize = 12;

/// The data with the model as `given` and with that of the diagnosis: what the page draws over time.
///
/// # Errors
/// As [`compare`].
pub fn traces(
    data: &Index,
    given: Model<f64>,
    report: &Report,
    progress: &dyn Progress,
) -> Result<Comparison, CompareError> {
    let after = if has_after(report) { "with the named effects" } else { "friction refitted" };
    let models = [
        NamedModel::own("as given", "before the diagnosis", given),
        NamedModel::own(after, "by the diagnosis", report.model.clone()),
    ];
    // As recorded forces go without intervals: the page shows lines, not a verdict.
    let options = Options { drawn: TRACES, forces: Forces::AsReturned, ..Options::default() };
    compare(data, &models, &options, progress)
}

fn names(c: &Comparison) -> Vec<&str> {
    c.models.iter().map(|m| m.name.as_str()).collect()
}

/// Errors of the first model: what fails before decides what is shown.
fn first_errors(c: &Comparison) -> &[stickslip_analysis::compare::document::ErrorRow] {
    c.models.first().map_or(&[], |m| &m.errors)
}

/// Errors of a second model.
fn last_errors(c: &Comparison) -> Option<&[stickslip_analysis::compare::document::ErrorRow]> {
    c.models.get(1..)?.last().map(|m| m.errors.as_slice())
}

fn place_words(p: &Place) -> String {
    format!("{}, {}", channel_words(&p.channel), p.phase)
}

/// Probabilities of the credible sets, and of none of them, as bars.
fn credible_chart(report: &Report) -> Option<Bars> {
    let d = report.discrepancy.as_ref().filter(|_| has_after(report))?;
    let mut rows: Vec<(String, f64, bool)> =
        report.credible_sets.iter().map(|s| (words(&set_words(s)), s.probability, true)).collect();
    rows.push(("none of the sets tried".into(), d.probability, false));
    shares(rows, "probability")
}

fn credible_bars(report: &Report) -> Markup {
    let Some((chart, d)) = credible_chart(report).zip(report.discrepancy.as_ref()) else { return html! {} };
    html! {
        h2 { "How probable" }
        (figure("Sets of effects that were fitted", "", &credible(report).join("; "), &chart.markup().0))
        p class="soft" {
            (report.conditions) " conditions count as " (format!("{:.1}", d.effective_conditions)) " independent ones."
        }
    }
}

/// What the bars of the misfits are of.
fn series(report: &Report) -> [String; 2] {
    let beside = |k: usize| match report.ordinary[k] {
        Ordinary { pads: false, mounting: false } => "",
        Ordinary { pads: true, mounting: false } => ", ordinary pads beside it",
        Ordinary { pads: false, mounting: true } => ", parts that are not mounted exactly beside it",
        Ordinary { pads: true, mounting: true } => {
            ", ordinary pads and parts that are not mounted exactly beside it"
        }
    };
    [
        format!("the model as given, friction refitted{}", beside(0)),
        format!("with the named effects{}", beside(1)),
    ]
}

/// The largest misfits, before and after.
fn misfit_chart(report: &Report) -> Option<Bars> {
    let after = has_after(report);
    let rows: Vec<(String, Vec<f64>)> = report
        .places
        .iter()
        .take(DRAWN)
        .map(|p| (place_words(p), if after { vec![p.before, p.after] } else { vec![p.before] }))
        .collect();
    let bars = multiples(rows, "systematic misfit in run spreads", RELEVANT);
    bars.map(|bars| bars.of_series(series(report).into_iter().take(if after { 2 } else { 0 })))
}

fn misfit_bars(report: &Report) -> Markup {
    let Some(chart) = misfit_chart(report) else { return html! {} };
    let [before, after] = series(report);
    html! {
        div class="legend" {
            (swatch("m0", &before))
            @if has_after(report) { (swatch("m1", &after)) }
            (swatch("line measured", &format!("{RELEVANT} run spreads: beyond, one channel is enough to look for an effect")))
        }
        (figure("Where the model misses most", "", "largest systematic misfits by channel and phase", &chart.markup().0))
    }
}

/// Effects that have a card: that are named, that explain the data as well, some that nearly do; with what each is.
fn carded(report: &Report) -> Vec<(&CandidateReport, &'static str)> {
    let named = |c: &&CandidateReport| has_after(report) && report.effects.contains(&c.id);
    let equal = |c: &&CandidateReport| report.ambiguous_with.iter().flatten().any(|id| *id == c.id);
    let near = |c: &&CandidateReport| !named(c) && !equal(c) && c.own_share().0 > NEARLY;
    let all = || report.candidates.iter();
    if report.verdict == Verdict::NothingMissing {
        return Vec::new();
    }
    let named_ones = all().filter(named).map(|c| (c, NAMED));
    let as_well = match report.verdict {
        Verdict::Inconclusive => "would explain it: not named",
        _ => "explains the data as well",
    };
    let as_well = all().filter(|c| equal(c) && !named(c)).map(|c| (c, as_well));
    let near = all().filter(near).take(NEAR).map(|c| (c, "not named"));
    named_ones.chain(as_well).chain(near).collect()
}

/// What a card says of an effect that is named.
const NAMED: &str = "named: the model lacks it";

fn cards(report: &Report, run: Option<&Run>) -> Markup {
    let cards = carded(report);
    html! {
        @if !cards.is_empty() {
            h2 { "What it is" }
            div class="cards" {
                @for (c, what) in cards {
                    @let class = if what == "not named" { "card" } else { "card named" };
                    (card(c, class, &role(c, what), run.filter(|_| what == NAMED)))
                }
            }
        }
    }
}

fn role(c: &CandidateReport, what: &str) -> String {
    let left = format!("leaves {:.2} run spreads", c.held_out_error);
    match (c.explained_beyond, c.beside.as_slice()) {
        (Some(beyond), held) => format!(
            "{what}; beside {}, found before it, it {} (together {} of the excess error) and {left}",
            joined(held),
            explains(beyond, "of what that leaves"),
            share(c.explained)
        ),
        (None, []) => {
            format!("{what}; on its own it {} and {left}", explains(c.explained, "of the excess error"))
        }
        (None, held) => {
            format!(
                "{what}; with {} it {} and {left}",
                joined(held),
                explains(c.explained, "of the excess error")
            )
        }
    }
}

/// Identifiers as words.
fn joined(ids: &[&str]) -> String {
    ids.iter().map(|id| words(id)).collect::<Vec<_>>().join(" and ")
}

fn card(c: &CandidateReport, class: &str, role: &str, run: Option<&Run>) -> Markup {
    html! {
        article class=(class) {
            h3 { (capital(&words(c.id))) }
            p class="soft" { code { (c.id) } ", " (role) }
            p { (capital(c.info.summary)) "." }
            p { "In data: " (c.info.signature) "." }
            p { "On the robot: " (c.info.on_robot) "." }
            (signature(&c.signature, run))
            @if class == "card" { (unfold("Strength", &strength(c))) } @else { (strength(c)) }
            p class="soft" { "Source: " (c.info.source) "." }
        }
    }
}

/// Its parameters with intervals.
fn strength(c: &CandidateReport) -> Markup {
    html! {
        table {
            caption { "Strength" }
            thead {
                tr {
                    th scope="col" { "parameter" } th scope="col" { "value" } th scope="col" { "95 % interval" }
                    th scope="col" { "typical" }
                }
            }
            tbody {
                @for p in c.info.parameters {
                    @if let Some(v) = c.parameters.get(p.name) {
                        tr {
                            th scope="row" class="text" { (parameter_words(p.name)) div class="soft" { (p.what) } }
                            td { b { (short(v.value)) } " " (if p.unit == "1" { "" } else { p.unit }) }
                            td { (interval(v.low, v.high)) }
                            td { (short(p.typical)) }
                        }
                    }
                }
            }
        }
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What most candidates are added to: what stands beside them.
fn held(report: &Report) -> &[&'static str] {
    let same = |of: &CandidateReport| report.candidates.iter().filter(|c| c.beside == of.beside).count();
    report.candidates.iter().max_by_key(|c| same(c)).map_or(&[], |c| &c.beside)
}

/// Of what shares are.
fn of_what(report: &Report) -> String {
    match held(report) {
        [] => "of the excess error".into(),
        held => format!("of what {} leaves", joined(held)),
    }
}

/// Behind a share that is of something else.
fn of_else(report: &Report, c: &CandidateReport) -> String {
    match (c.explained_beyond, held(report)) {
        (Some(_), held) if c.beside != held => format!(" (of what {} leaves)", joined(&c.beside)),
        (None, [_, ..]) => " (of all)".into(),
        _ => String::new(),
    }
}

fn added_to(report: &Report) -> String {
    match held(report) {
        [] => String::new(),
        held => format!(" to the model with {}, found beforehand", joined(held)),
    }
}

/// All effects that were refitted, as bars.
fn tried_chart(report: &Report) -> Option<Bars> {
    let named = |id: &str| has_after(report) && report.effects.contains(&id);
    let mut rows: Vec<(String, f64, bool)> = report
        .candidates
        .iter()
        .map(|c| (words(c.id) + &of_else(report, c), c.own_share().0, named(c.id)))
        .collect();
    rows.sort_by(|a, b| b.2.cmp(&a.2).then(b.1.total_cmp(&a.1)));
    shares(rows, &format!("share {} explained", of_what(report)))
}

fn tried(report: &Report) -> Markup {
    let Some(chart) = tried_chart(report) else { return html! {} };
    let row = |c: &CandidateReport| {
        html! {
            tr {
                th scope="row" { (words(c.id)) }
                td { (percent(c.probability)) }
                td { (share(c.own_share().0)) (of_else(report, c)) }
                td { (format!("{:.2}", c.held_out_error)) }
                td { (format!("{:.1e}", c.p_value)) }
                td class="left" {
                    @for (n, v) in &c.parameters {
                        div { (parameter_words(n)) " " (short(v.value)) " (" (interval(v.low, v.high)) ") " (if v.unit == "1" { "" } else { v.unit }) }
                    }
                }
            }
        }
    };
    let table = html! {
        div class="scroll" {
            table {
                caption { "Each added on its own" (added_to(report)) ", judged on held-out conditions" }
                thead {
                    tr {
                        @for h in ["effect", "probability"] { th scope="col" { (h) } }
                        th scope="col" { "explains " (of_what(report)) }
                        @for h in ["held-out error, run spreads", "p"] { th scope="col" { (h) } }
                        th scope="col" class="left" { "parameters (95 % interval)" }
                    }
                }
                tbody { @for c in &report.candidates { (row(c)) } }
            }
        }
    };
    let drawn = figure(
        &format!("Share {} that each explains", of_what(report)),
        "",
        "effects tried",
        &chart.markup().0,
    );
    html! {
        @if report.candidates.len() <= AT_FIRST || has_after(report) {
            h2 { "Effects tried" }
            (drawn)
            (unfold("Figures of all effects tried", &table))
        } @else {
            (unfold("Effects tried", &html! { (drawn) (table) }))
        }
    }
}

/// Misfit of each channel in each phase, before and after: where it is relevant; the rest folded. Where the page
/// has traces, a cell leads to them.
fn maps(report: &Report, traces: Option<&Comparison>) -> Markup {
    let worst = |channel: &str| {
        let of = report.places.iter().filter(|p| p.channel == channel);
        of.map(|p| p.before.max(p.after)).fold(0.0, f64::max)
    };
    let mut channels: Vec<&str> = Vec::new();
    for p in report.places.iter().filter(|p| p.before.max(p.after) > 1.0) {
        if !channels.contains(&p.channel.as_str()) {
            channels.push(&p.channel);
        }
    }
    let (fail, fit): (Vec<&str>, Vec<&str>) = channels.iter().partition(|c| worst(c) > RELEVANT);
    let [before, after] = series(report);
    let pair = |channels: &[&str]| {
        html! {
            div class="flow" {
                (map(report, channels, &before, |p| p.before, traces.map(|c| (c, 0))))
                @if has_after(report) { (map(report, channels, &after, |p| p.after, traces.map(|c| (c, 1)))) }
            }
        }
    };
    html! {
        @if !channels.is_empty() {
            h2 { "Systematic misfit by channel and phase" }
            p class="soft" {
                "Root mean square over the conditions, in run spreads of one run; bold: beyond " (RELEVANT) "."
                @if traces.is_some() { " A cell leads to its traces in the trial where the model misses most." }
            }
            @if fail.is_empty() { p { "No channel is beyond " (RELEVANT) " run spreads." } } @else { (pair(&fail)) }
            @if !fit.is_empty() {
                (unfold(&format!("Channels between one and {RELEVANT} run spreads"), &pair(&fit)))
            }
        }
    }
}

/// `traces` and which of their models it is of.
fn map(
    report: &Report,
    channels: &[&str],
    title: &str,
    size: fn(&Place) -> f64,
    traces: Option<(&Comparison, usize)>,
) -> Markup {
    let phases: Vec<&str> = Phase::ALL
        .iter()
        .map(|p| p.name())
        .filter(|name| report.places.iter().any(|p| p.phase == *name))
        .collect();
    let at =
        |channel: &str, phase: &str| report.places.iter().find(|p| p.channel == channel && p.phase == phase);
    html! {
        div class="scroll" {
            table class="heat" {
                caption { (capital(title)) }
                thead {
                    tr {
                        th scope="col" class="level" { "channel" }
                        @for phase in &phases { th scope="col" { (phase) } }
                    }
                }
                tbody {
                    @for channel in channels {
                        tr {
                            th scope="row" class="level" { (channel_words(channel)) }
                            @for phase in &phases {
                                @match at(channel, phase) {
                                    Some(p) => { (map_cell(p, size(p), traces)) }
                                    None => { td class="soft" { "–" } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn map_cell(place: &Place, size: f64, traces: Option<(&Comparison, usize)>) -> Markup {
    let beyond = size > RELEVANT;
    let number = html! { (format!("{size:.1}")) @if beyond { span class="said" { " fails" } } };
    // Sum and difference of the fingers are seen in the traces of both.
    let name = place.channel.replace("finger_sum", "finger1").replace("finger_difference", "finger1");
    let other = match place.channel.split('_').nth(1) {
        Some("sum") => 1.0,
        Some("difference") => -1.0,
        _ => 0.0,
    };
    let channel = NAMES.iter().position(|n| *n == name);
    let phase = match place.phase {
        "rest before" => "before contact",
        "rest after" => "end",
        "peak of the onset" => "onset",
        // The pause and what follows it are no phases of their own there.
        "pause" | "restart" => "sliding",
        same => same,
    };
    let goto = channel.zip(traces).map(|(c, (traces, model))| {
        let value = |s: &Signals| s[c] + if other == 0.0 { 0.0 } else { other * s[c + 6] };
        let in_phase = PHASES.into_iter().find(|p| p.label() == phase);
        (plot_id(c), in_phase.and_then(|p| worst(&traces.traces, model, p, &value, &|_| true)))
    });
    html! {
        td class=(if beyond { "fails" } else { "fits" }) style=(heat(size)) {
            @match goto {
                Some((plot, run)) => {
                    button type="button" data-run=[run] data-goto=(plot) data-phase=(phase) { (number) }
                }
                None => { (number) }
            }
        }
    }
}

/// Fitted parameters of the model that is judged.
fn parameters(report: &Report) -> Markup {
    unfold(
        "All fitted parameters",
        &html! {
            div class="scroll" { table {
                caption { "Fitted parameters" }
                thead { tr { @for h in ["parameter", "value", "95 % interval", "unit"] { th scope="col" { (h) } } } }
                tbody {
                    @for (name, v) in &report.parameters {
                        tr {
                            th scope="row" { (parameter_words(name)) }
                            td { (short(v.value)) }
                            td { (interval(v.low, v.high)) }
                            td { (if v.unit == "1" { "–" } else { v.unit }) }
                        }
                    }
                }
            } }
        },
    )
}

/// Every plot of the page.
#[must_use]
pub fn figures(report: &Report, traces: Option<&Comparison>) -> Vec<Figure> {
    let mut out = Vec::new();
    let mut add = |name: &str, chart: Option<Chart>| out.extend(chart.map(|c| Figure::of(name, &c)));
    add("misfit", misfit_chart(report).map(|b| b.chart()));
    add("probabilities", credible_chart(report).map(|b| b.chart()));
    add("effects-tried", tried_chart(report).map(|b| b.chart()));
    for (c, _) in carded(report) {
        add(&format!("signature-{}", c.id), bars(&c.signature).map(|b| b.chart()));
    }
    add(
        "signature-in-one-run",
        traces
            .filter(|_| has_after(report))
            .and_then(|traces| over_a_run(traces, named_marks(report)))
            .map(Run::file),
    );
    add("next-experiment", report.suggested_experiment.as_ref().map(|e| experiment_file(report, e)));
    add("limits", limits::limit_chart(report).filter(|_| !has_after(report)).map(|b| b.chart()));
    if let Some(c) = traces {
        out.extend(trace_figures(&c.traces, &names(c)));
    }
    out
}

/// What the first named effect changes.
fn named_marks(report: &Report) -> &[Mark] {
    let named = report.candidates.iter().find(|c| report.effects.contains(&c.id));
    named.map_or(&[], |c| c.signature.as_slice())
}
