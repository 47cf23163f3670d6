//! What a replay says in one document: flags over time, largest values, the solver's work, the plan.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::predictor::{Intent, Plan, Prediction, Slip, Testimony, validity};

use crate::tuning::Changed;

use super::replay::{Difference, FLAGS, Replayed, Span, VALIDITY, spans};

/// The JSON document `stickslip-replay/1`.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Document {
    /// Always `stickslip-replay/1`.
    pub schema: &'static str,
    /// Id.
    pub trial: String,
    /// Ticks run.
    pub ticks: usize,
    /// Hash of every output word, hexadecimal.
    pub hash: String,
    /// When each flag was up.
    pub flags: Vec<Span>,
    /// When each doubt was up.
    pub doubts: Vec<Span>,
    /// Largest values.
    pub prediction: Summary,
    /// How the solver fared.
    pub solver: Solver,
    /// Plan derived from the trial.
    pub plan: Vec<PlanRow>,
    /// Where `--against` was given.
    pub against: Option<Against>,
    /// Numbers of the predictor that are not the defaults, as the file of `--predictor` sets them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tuned: Vec<Changed>,
}

/// Largest predicted values.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Summary {
    /// By the model, either finger, while measured or predicted.
    pub peak_utilisation: f32,
    /// By the measured wrenches; `null`: not measured.
    pub peak_measured_utilisation: Option<f32>,
    /// m/s
    pub peak_slip_m_s: f32,
    /// m
    pub peak_sag_m: f32,
    /// rad
    pub peak_rotation_rad: f32,
    /// First time at which a slip was announced before it came, s.
    pub first_warning_s: Option<f64>,
    /// First time at which a finger slips, s.
    pub first_slip_s: Option<f64>,
}

/// Ticks by the solver's status, and the cost.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Solver {
    /// By name of the status.
    pub ticks: BTreeMap<&'static str, usize>,
    /// Share of the ticks in which a step asked for friction pyramids and was solved with the cone.
    pub cone_instead_share: f64,
    /// What the other formulation said; `null`: the model asks for no witness.
    pub witness: Option<Witness>,
    /// Largest momentum error, N.
    pub worst_residual_n: f32,
    /// Newton steps, mean over the ticks.
    pub mean_iterations: f64,
    /// Newton steps, most in a tick.
    pub most_iterations: u16,
}

/// The other formulation as a witness of the steps from sample to sample.
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
pub struct Witness {
    /// Steps for which it was asked.
    pub asked: u32,
    /// Those that both solved within the work of a tick.
    pub compared: u32,
    /// Of those the ones in which every loaded point sticks or slides in both alike.
    pub alike: u32,
}

/// A segment of the plan.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct PlanRow {
    /// s
    pub from_s: f32,
    /// s
    pub duration_s: f32,
    /// World axes.
    pub velocity_m_s: [f32; 3],
    /// World axes.
    pub angular_rad_s: [f32; 3],
    /// N
    pub grip_n: f32,
    /// `hold`, `slide`, `pivot`, `free`.
    pub intent: &'static str,
}

/// Agreement with a log.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Against {
    /// The log.
    pub file: String,
    /// Predictions in it.
    pub predictions: usize,
    /// Ticks of the replay for which the log has none.
    pub missing: usize,
    /// Hash over the logged predictions, hexadecimal.
    pub hash: String,
    /// Every logged prediction equals the replay's, bit for bit.
    pub equal: bool,
    /// The first that differs.
    pub first_difference: Option<Difference>,
    /// Damage of the log.
    pub lost: Option<String>,
}

impl Document {
    /// Of a replayed trial; `t_s` has one time for each prediction.
    #[must_use]
    pub fn new(trial: &str, t_s: &[f64], plan: &Plan, replayed: &Replayed, against: Option<Against>) -> Self {
        let predictions = &replayed.predictions;
        Document {
            schema: "stickslip-replay/1",
            trial: trial.to_owned(),
            ticks: predictions.len(),
            hash: format!("{:08x}", replayed.hash),
            flags: spans(t_s, predictions, &FLAGS, |p| p.flags),
            doubts: spans(t_s, predictions, &VALIDITY, |p| p.validity),
            prediction: summary(t_s, predictions),
            solver: solver(predictions, replayed.testimony),
            plan: plan_rows(plan),
            against,
            tuned: Vec::new(),
        }
    }
}

fn summary(t_s: &[f64], predictions: &[Prediction]) -> Summary {
    let fingers = || predictions.iter().flat_map(|p| p.finger.iter());
    let peak =
        |values: &mut dyn Iterator<Item = f32>| values.filter(|x| x.is_finite()).fold(0.0f32, f32::max);
    let measured =
        fingers().filter_map(|f| f.measured_utilisation).filter(|u| u.is_finite()).reduce(f32::max);
    let slips = |p: &Prediction| p.finger.iter().any(|f| f.slip == Slip::Now);
    let warns = |p: &Prediction| p.finger.iter().any(|f| matches!(f.slip, Slip::In(_)));
    let when = |test: &dyn Fn(&Prediction) -> bool| {
        t_s.iter().zip(predictions).find(|(_, p)| test(p)).map(|(t, _)| *t)
    };
    Summary {
        peak_utilisation: peak(&mut fingers().map(|f| f.peak_utilisation)),
        peak_measured_utilisation: measured,
        peak_slip_m_s: peak(&mut fingers().map(|f| f.slip_speed_m_s)),
        peak_sag_m: peak(&mut predictions.iter().map(|p| p.sag_m)),
        peak_rotation_rad: peak(&mut predictions.iter().map(|p| p.rotation_rad)),
        first_warning_s: when(&warns),
        first_slip_s: when(&slips),
    }
}

fn solver(predictions: &[Prediction], said: Option<Testimony>) -> Solver {
    let mut ticks = BTreeMap::new();
    for p in predictions {
        *ticks.entry(p.solver_status.name()).or_insert(0) += 1;
    }
    let sum: f64 = predictions.iter().map(|p| f64::from(p.solver_iterations)).sum();
    let instead = predictions.iter().filter(|p| p.validity & validity::CONE_INSTEAD != 0).count();
    Solver {
        ticks,
        cone_instead_share: instead as f64 / predictions.len().max(1) as f64,
        witness: said.map(|Testimony { asked, compared, alike }| Witness { asked, compared, alike }),
        worst_residual_n: predictions.iter().map(|p| p.solver_residual_n).fold(0.0, f32::max),
        mean_iterations: sum / predictions.len().max(1) as f64,
        most_iterations: predictions.iter().map(|p| p.solver_iterations).max().unwrap_or(0),
    }
}

fn plan_rows(plan: &Plan) -> Vec<PlanRow> {
    let mut from_s = plan.start_s;
    plan.segments
        .iter()
        .map(|s| {
            let row = PlanRow {
                from_s,
                duration_s: s.duration_s,
                velocity_m_s: s.velocity_m_s,
                angular_rad_s: s.angular_rad_s,
                grip_n: s.grip_n,
                intent: match s.intent {
                    Intent::Hold => "hold",
                    Intent::Slide => "slide",
                    Intent::Pivot => "pivot",
                    Intent::Free => "free",
                },
            };
            from_s += s.duration_s;
            row
        })
        .collect()
}
