//! True slip: when all bristles of both pads slide, when only some do, and when the object is lost.

use serde::Serialize;

/// An interval of gross slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Episode {
    /// When all bristles of both pads began to slide, s.
    pub start_s: f64,
    /// When they no longer did, s.
    pub end_s: f64,
    /// Slip of the pads' mean, m.
    pub slip_m: f64,
}

/// An interval in which a part of the pads slid, without gross slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Partial {
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
    /// Greatest share of a pad's load that slid.
    pub share: f64,
    /// Irreversible displacement, mean over the load of the pad where it is greater, m.
    pub plastic_m: f64,
}

/// What happened to the grasp.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Truth {
    /// Gross slips longer than 3 ms and 0.3 mm.
    pub episodes: Vec<Episode>,
    /// Partial slips of more than 20 um that are not part of a gross slip.
    pub partial: Vec<Partial>,
    /// When the object was lost, s.
    pub drop_s: Option<f64>,
}

/// Gross slip: less than this share of the load still sticks.
const ALL: f64 = 0.97;
/// Partial slip: at least this share of a pad's load slides.
const SOME: f64 = 0.05;
/// Gaps shorter than this do not end an interval, s.
const GAP_S: f64 = 2e-3;
const LEAST_GROSS_S: f64 = 3e-3;
const LEAST_GROSS_M: f64 = 3e-4;
const LEAST_PARTIAL_M: f64 = 2e-5;

/// Watches both pads.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    truth: Truth,
    gross: Option<Episode>,
    partial: Option<(Partial, [f64; 2])>,
}

impl Watch {
    /// One step: share that slides, slip speed and irreversible displacement of each pad.
    pub fn step(&mut self, t: f64, sliding: [f64; 2], slip_m_s: [f64; 2], plastic_m: [f64; 2], dt: f64) {
        let all = sliding[0].min(sliding[1]) >= ALL;
        if all {
            let e = self.gross.get_or_insert(Episode { start_s: t, end_s: t, slip_m: 0.0 });
            e.end_s = t;
            e.slip_m += 0.5 * (slip_m_s[0] + slip_m_s[1]) * dt;
        } else if self.gross.is_some_and(|e| t - e.end_s > GAP_S) {
            self.close_gross();
        }
        let most = sliding[0].max(sliding[1]);
        if most >= SOME && !all {
            let fresh = Partial { start_s: t, end_s: t, share: 0.0, plastic_m: 0.0 };
            let (p, moved) = self.partial.get_or_insert((fresh, [0.0; 2]));
            p.end_s = t;
            p.share = p.share.max(most);
            for k in 0..2 {
                moved[k] += plastic_m[k];
            }
        } else if self.partial.is_some_and(|(p, _)| all || t - p.end_s > 10.0 * GAP_S) {
            self.close_partial();
        }
    }

    /// The object is lost.
    pub fn lost(&mut self, t: f64) {
        self.truth.drop_s.get_or_insert(t);
    }

    /// When it was lost, s.
    pub fn drop_s(&self) -> Option<f64> {
        self.truth.drop_s
    }

    /// The end of the record.
    pub fn finish(mut self) -> Truth {
        self.close_gross();
        self.close_partial();
        self.truth
    }

    fn close_gross(&mut self) {
        if let Some(e) = self.gross.take()
            && e.end_s - e.start_s > LEAST_GROSS_S
            && e.slip_m > LEAST_GROSS_M
        {
            self.truth.episodes.push(e);
        }
    }

    fn close_partial(&mut self) {
        if let Some((mut p, moved)) = self.partial.take() {
            p.plastic_m = moved[0].max(moved[1]);
            if p.plastic_m > LEAST_PARTIAL_M {
                self.truth.partial.push(p);
            }
        }
    }
}
