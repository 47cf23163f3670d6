//! A record of friction force against position of one contact, and what two laws make of it:
//! rigid Coulomb friction, and a spring in series with the slider.
//!
//! Rigid: `f = -mu N sign(v)`, with the sign from the change of position over eleven samples.
//! Spring and slider (Prandtl's element): the deflection `z` follows the position and is cut
//! back to `|k z| <= mu N`; `f = -k z`. Both are fitted to the whole record by least squares
//! (`mu` and `k` of the second by a search that halves its steps), so their errors say how
//! well the form of a law suits, not how well it predicts.

use serde::Serialize;

use stickslip_data::Trial;

/// Samples with less than this share of the working load do not count.
const LOADED: f64 = 0.5;
/// Half width over which the direction of motion is taken, samples.
const HALF: usize = 5;

/// What was found.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Study {
    /// Samples that count.
    pub samples: usize,
    /// Working load, N.
    pub load_n: f64,
    /// Root mean square of the friction force, N.
    pub signal_n: f64,
    /// Coefficient of the rigid law.
    pub rigid_mu: f64,
    /// Its error, N.
    pub rigid_rms_n: f64,
    /// Coefficient of spring and slider.
    pub slider_mu: f64,
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Error, N.
    pub slider_rms_n: f64,
    /// Median travel after a reversal until friction reaches 90 % of `slider_mu` N, m.
    pub travel_m: f64,
    /// Reversals.
    pub reversals: usize,
}

struct Row {
    x_m: f64,
    load_n: f64,
    friction_n: f64,
    counts: bool,
}

/// Fits both laws. `None` where the trial has no position of the gripper or no force of
/// finger 1.
pub fn study(trial: &Trial) -> Option<Study> {
    let mut rows: Vec<Row> = trial
        .samples
        .iter()
        .filter_map(|s| {
            let (x, w) = (s.gripper?.position_m[0], s.finger[0]?);
            // On the object; the record's law is for the force on the counterface.
            let (friction_n, load_n) = (-w.force_n[0], w.force_n[1].abs());
            let known = x.is_finite() && friction_n.is_finite() && load_n.is_finite();
            known.then_some(Row { x_m: x, load_n, friction_n, counts: false })
        })
        .collect();
    if rows.len() <= 2 * HALF {
        return None;
    }
    let mut loads: Vec<f64> = rows.iter().map(|r| r.load_n).collect();
    loads.sort_by(f64::total_cmp);
    let load_n = loads[loads.len() * 3 / 4];
    for r in &mut rows {
        r.counts = r.load_n > LOADED * load_n;
    }
    let signs: Vec<f64> = (0..rows.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(HALF), (i + HALF).min(rows.len() - 1));
            (rows[b].x_m - rows[a].x_m).signum()
        })
        .collect();
    let counted = || rows.iter().zip(&signs).filter(|(r, _)| r.counts);
    let samples = counted().count();
    let rms = |squares: f64| (squares / samples.max(1) as f64).sqrt();
    let signal_n = rms(counted().map(|(r, _)| r.friction_n * r.friction_n).sum());
    let over: f64 = counted().map(|(r, s)| -r.friction_n * r.load_n * s).sum();
    let under: f64 = counted().map(|(r, _)| r.load_n * r.load_n).sum();
    let rigid_mu = over / under;
    let rigid_rms_n = rms(counted().map(|(r, s)| (r.friction_n + rigid_mu * r.load_n * s).powi(2)).sum());
    let (stiffness_n_m, slider_mu, squares) = slider_fit(&rows);
    let (travel_m, reversals) = travel(&rows, &signs, slider_mu);
    Some(Study {
        samples,
        load_n,
        signal_n,
        rigid_mu,
        rigid_rms_n,
        slider_mu,
        stiffness_n_m,
        slider_rms_n: rms(squares),
        travel_m,
        reversals,
    })
}

/// Sum of squared errors of spring and slider.
fn slider_error(rows: &[Row], stiffness_n_m: f64, mu: f64) -> f64 {
    let (mut deflection, mut last) = (0.0, rows[0].x_m);
    let mut squares = 0.0;
    for r in rows {
        let most = mu * r.load_n / stiffness_n_m;
        deflection = (deflection + r.x_m - last).clamp(-most, most);
        last = r.x_m;
        if r.counts {
            squares += (r.friction_n + stiffness_n_m * deflection).powi(2);
        }
    }
    squares
}

/// Stiffness, coefficient and error of the best spring and slider.
fn slider_fit(rows: &[Row]) -> (f64, f64, f64) {
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for k in 0..24 {
        for m in 0..12 {
            let (stiffness, mu) = (1e3 * 1.35f64.powi(k), 0.1 + 0.08 * f64::from(m));
            let error = slider_error(rows, stiffness, mu);
            if error < best.0 {
                best = (error, stiffness, mu);
            }
        }
    }
    let mut step = 0.15;
    while step > 1e-3 {
        let tries = [(1.0 + step, 1.0), (1.0 - step, 1.0), (1.0, 1.0 + step), (1.0, 1.0 - step)];
        let better = tries
            .map(|(a, b)| (slider_error(rows, best.1 * a, best.2 * b), best.1 * a, best.2 * b))
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some(better) if better.0 < best.0 => best = better,
            _ => step *= 0.5,
        }
    }
    (best.1, best.2, best.0)
}

/// Median travel after a reversal until friction is back at 90 % of its sliding value against
/// the new direction, and the reversals.
fn travel(rows: &[Row], signs: &[f64], mu: f64) -> (f64, usize) {
    let mut all = Vec::new();
    for i in (1..rows.len()).filter(|i| signs[*i] != signs[*i - 1] && rows[*i].counts) {
        let there = (i..rows.len())
            .take_while(|j| signs[*j] == signs[i])
            .find(|j| -rows[*j].friction_n * signs[i] > 0.9 * mu * rows[*j].load_n);
        // The turn is the extreme position near the change of sign.
        let near = i.saturating_sub(HALF)..(i + HALF).min(rows.len());
        let turn = rows[near].iter().map(|r| r.x_m * -signs[i]).fold(f64::NEG_INFINITY, f64::max) * -signs[i];
        all.extend(there.map(|j| (rows[j].x_m - turn).abs()));
    }
    all.sort_by(f64::total_cmp);
    (all.get(all.len() / 2).copied().unwrap_or(f64::NAN), all.len())
}
