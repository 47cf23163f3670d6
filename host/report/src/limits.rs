//! What may still be there although it is not named: how strong each effect may be all the same.

use std::collections::BTreeMap;

use maud::{Markup, html};
use stickslip_analysis::diagnose::detection::UpperLimit;
use stickslip_analysis::diagnose::report::Report;

use crate::bars::{Bars, multiples};
use crate::html::{figure, unfold};
use crate::words::{identifier_words as words, parameter_words, short};

/// Effects that are drawn: those of which the data say least.
const DRAWN: usize = 8;

/// How strong each effect may be although it is not named: effect, parameter, upper limit, typical size.
#[must_use]
pub fn limits_on_effects(report: &Report) -> Vec<[String; 4]> {
    let with_unit = |x: f64, unit: &str| match unit {
        "1" => short(x),
        unit => format!("{} {unit}", short(x)),
    };
    let each = |(id, strengths): (&&'static str, &BTreeMap<&'static str, UpperLimit>)| {
        let row = |(name, l): (&&'static str, &UpperLimit)| {
            let upper = l
                .upper
                .map_or("not limited by these data".into(), |x| format!("at most {}", with_unit(x, l.unit)));
            [(*id).to_owned(), (*name).to_owned(), upper, with_unit(l.plausible, l.unit)]
        };
        strengths.iter().map(row).collect::<Vec<_>>()
    };
    report.limits_on_effects.iter().flat_map(each).collect()
}

/// Of each effect that the data limit, the limit over a typical strength: of the strength that they limit least.
fn over_typical(report: &Report) -> Vec<(String, f64)> {
    let of = |(id, strengths): (&&'static str, &BTreeMap<&'static str, UpperLimit>)| {
        let ratio = |l: &UpperLimit| Some(l.upper? / l.plausible).filter(|ratio| ratio.is_finite());
        Some((words(id), strengths.values().filter_map(ratio).reduce(f64::max)?))
    };
    let mut all: Vec<(String, f64)> = report.limits_on_effects.iter().filter_map(of).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

/// The largest strengths that the data allow, as bars.
pub(crate) fn limit_chart(report: &Report) -> Option<Bars> {
    let rows = over_typical(report).into_iter().take(DRAWN).map(|(effect, ratio)| (effect, vec![ratio]));
    multiples(rows.collect(), "largest possible strength over a typical one", 1.0)
}

/// The section of a page: as bars, the effects that the data say nothing of, and all strengths folded.
#[must_use]
pub fn section(report: &Report) -> Markup {
    let limits = limits_on_effects(report);
    if limits.is_empty() {
        return html! {};
    }
    let open: Vec<String> = report.not_excluded.iter().map(|id| words(id)).collect();
    html! {
        h2 { "Upper limits on effects" }
        p class="soft" {
            "Left of the line an effect of typical strength is excluded; right of it, it cannot be excluded."
        }
        @if let Some(chart) = limit_chart(report) {
            (figure("Largest strength that these data allow (95 %)", "", "limits on effects", &chart.markup().0))
        }
        @if !open.is_empty() { p { "Not excluded at typical strength: " (open.join(", ")) "." } }
        (unfold(&format!("All {} limits", limits.len()), &limit_table(&limits)))
    }
}

fn limit_table(limits: &[[String; 4]]) -> Markup {
    html! {
        div class="scroll" {
            table {
                caption { "Largest possible strengths (95 %)" }
                thead { tr { @for h in ["effect", "strength", "limit", "typical"] { th scope="col" { (h) } } } }
                tbody {
                    @for [effect, name, upper, typical] in limits {
                        tr {
                            th scope="row" { (words(effect)) }
                            td { (parameter_words(name)) }
                            td { (upper) }
                            td { (typical) }
                        }
                    }
                }
            }
        }
    }
}
