//! How the fingers' pads give way before they slide, read off the measurements without any model.
//!
//! While an object is held between two pads and loaded, it moves in the grasp by the load over the
//! stiffness of both: `u = F c / 2` across, `turn = T c / (2 r^2)` about the closing direction, with `c`
//! the compliance of one whole pad and `r^2` its torsional stiffness over the tangential one, which is not known well: 0.5 to
//! 1.1 of a disc's squared radius (Johnson 1985, 3.7 and 7.2). Where loads along the face show it, and turns agree within that, these do not count.
//! Both sides are measured, so the slope of displacement against load is the compliance,
//! whatever friction, pusher or plan are. Loads up to half of a trial's largest count: beyond it the
//! rim slides. The answer is the weighted median of all slopes: a pad that slides early or a wrong contact
//! decides nothing. Pads that are loaded within a sample cannot be read off: how far the object is driven in
//! that time counts for their compliance, as the clocks of pose and wrench agree no better.

use nalgebra::Vector3;
use stickslip_shared::effects::contact_compliance::{HERTZ, TORSION, compliance_at};
use stickslip_shared::effects::{Expected, Parameter};
use stickslip_shared::model::{Base, FingerContact, RIGID_N_M};

use crate::channels::Signals;
use crate::evidence::contact;
use crate::evidence::statistics::{quantile, weighted_median};
use crate::evidence::tolerance::RIGID;
use crate::run::simulate::{Prepared, TURN_ARM_M};

/// Share of a trial's largest load up to which pads stick as a whole, about: chosen from 0.3, 0.5 and 0.7 looking
/// at 20 data sets of the second rig (docs/lab/pads.md).
const LOADED: f64 = 0.5;
/// Time before contact that tells where the object rests, s.
const REST_S: f64 = 0.05;
/// Fewest trials.
const FEWEST: usize = 4;
/// A compliance of fewer standard deviations is not told from none.
const TOLD: f64 = 3.0;
/// Loads below this many standard deviations of their noise tell nothing.
const LOUD: f64 = 10.0;

/// Compliance of one pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pads {
    /// Tangential displacement of one whole pad for each newton on it, m/N.
    pub tangential_m_n: f64,
    /// Standard deviation of that, m/N.
    pub sd_m_n: f64,
    /// What one sample between the clocks of pose and wrench makes of it, alike in all loadings, m/N.
    pub clock_m_n: f64,
    /// Largest force on both pads together, N.
    pub largest_n: f64,
    /// Loadings that it was found from: of a trial, one for each direction that is loaded.
    pub loadings: usize,
    /// Where the compliance does not show, but is what is usual of hard contacts or what the loadings leave open: what it may be
    /// at most, m/N.
    pub at_most_m_n: Option<f64>,
    /// Grip at which it is, N.
    pub grip_n: f64,
}

/// Factor by which a pad's springs may differ from what was read off: on the same 20 data
/// sets all whose clocks agree within a sample are within 1.6.
pub const SPRINGS: f64 = 2.0;
/// Standard deviation of a parameter over the range that is expected of it.
pub const SD_OF_RANGE: f64 = 0.25;
/// Compliance of a contact of hard bodies, m/N.
const ORDINARY_M_N: f64 = 1e-6;

/// What to expect of a parameter of pads of which nothing is read off: value and range.
#[must_use]
pub fn unread(of: &Parameter) -> Option<(f64, [f64; 2])> {
    matches!(of.expected, Some(Expected::UsualBesideReadOff(..))).then_some((of.neutral, [of.neutral; 2]))
}

impl Pads {
    /// What to expect of a parameter: value and range; `None` of what is no property of pads and plate.
    #[must_use]
    pub fn expected(&self, of: &Parameter) -> Option<(f64, [f64; 2])> {
        let own = self.tangential_m_n;
        // The law has them at another grip: by what pads make of that which do not stiffen, or as rough faces do.
        let rough = compliance_at(self.grip_n, 1.0);
        let range = |[low, high]: [f64; 2]| {
            let [low, high] = self.at_most_m_n.map_or([low, high], |most| [0.0, most]);
            [low / rough.max(1.0), high / rough.min(1.0)]
        };
        let c = own / compliance_at(self.grip_n, HERTZ);
        match of.expected? {
            Expected::ReadOff => Some((c, range([own / SPRINGS, own * SPRINGS]))),
            Expected::Share(share, shares) => Some((share * c, range(shares.map(|share| share * own)))),
            Expected::UsualBesideReadOff(..) if self.assumed() => unread(of),
            Expected::Usual(value, range) | Expected::UsualBesideReadOff(value, range) => {
                Some((value, range))
            }
        }
    }

    /// Whether the pads give way by more than chance, and move the object by more than a rigid model may be off.
    #[must_use]
    pub fn matter(&self) -> bool {
        self.give_way() && self.moves_m() > RIGID.position_m
    }

    /// Stiff contacts where the loadings show no compliance that matters. They move the object by less than a rigid
    /// model may be off, but keep the force that they slid with when the motion ends, which rigid ones do not.
    #[must_use]
    pub fn ordinary(self) -> Self {
        let tolerated_m_n = 2.0 * RIGID.position_m / self.largest_n.max(f64::MIN_POSITIVE);
        Self {
            tangential_m_n: ORDINARY_M_N.min(0.5 * tolerated_m_n),
            at_most_m_n: Some(tolerated_m_n),
            ..self
        }
    }

    /// Soft pads where the loadings could not have shown them: between what moves the object by more than a rigid model may be
    /// off and what the loadings exclude. `None` where they exclude all of it.
    #[must_use]
    pub fn unseen(self) -> Option<Self> {
        let tolerated_m_n = self.ordinary().at_most_m_n?;
        // No pad has less than none.
        let read_off_m_n = self.tangential_m_n.max(0.0);
        let most_m_n = (read_off_m_n + TOLD * self.sd_m_n + self.clock_m_n).min(SOFTEST_M_N);
        let unseen =
            Self { tangential_m_n: (tolerated_m_n * most_m_n).sqrt(), at_most_m_n: Some(most_m_n), ..self };
        (most_m_n > tolerated_m_n).then_some(unseen)
    }

    /// Whether this is what is usual, or what is open, and not read off.
    #[must_use]
    pub fn assumed(&self) -> bool {
        self.at_most_m_n.is_some()
    }

    /// How far the largest force moves the object before it slides, m.
    #[must_use]
    pub fn moves_m(&self) -> f64 {
        0.5 * self.tangential_m_n * self.largest_n
    }

    /// In series with the springs that `base` has already; `None` where these give way by as much.
    #[must_use]
    pub fn beyond(self, base: Base<f64>) -> Option<Self> {
        let stiffness_n_m = match base {
            Base::Hard => RIGID_N_M,
            Base::Soft { tangential_n_m, .. } => tangential_n_m,
        };
        let tangential_m_n = self.tangential_m_n - 1.0 / stiffness_n_m;
        (tangential_m_n > 0.0).then_some(Self { tangential_m_n, ..self })
    }

    /// Whether the pads give way by more than chance and clocks make of rigid ones.
    #[must_use]
    pub fn give_way(&self) -> bool {
        self.tangential_m_n > TOLD * self.sd_m_n + self.clock_m_n
    }
}

/// No fingertip is softer, m/N.
const SOFTEST_M_N: f64 = 2e-4;

/// One loading: compliance of a pad and its variance.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    compliance_m_n: f64,
    variance: f64,
    /// By one sample between pose and wrench, m/N.
    clock_m_n: f64,
    /// Largest load of the trial, N; zero for a torque.
    largest_n: f64,
    /// Its grip, N.
    grip_n: f64,
    /// Of a torque, not of a force.
    turns: bool,
}

/// Compliance of the pads from the loadings of trials: those along the face where they show it and turns agree within what is
/// not known of torsion, all where not. `None` of fewer than four.
#[must_use]
pub fn measured(slopes: &[Slope]) -> Option<Pads> {
    let (turns, straight): (Vec<Slope>, Vec<Slope>) = slopes.iter().partition(|s| s.turns);
    let turned = of(&turns);
    let agrees = |pads: &Pads| {
        let factor = turned.map_or(1.0, |t| t.tangential_m_n / pads.tangential_m_n);
        (1.0 / SPRINGS..SPRINGS).contains(&factor)
    };
    of(&straight).filter(Pads::give_way).filter(agrees).or_else(|| of(slopes))
}

fn of(slopes: &[Slope]) -> Option<Pads> {
    if slopes.len() < FEWEST {
        return None;
    }
    // No loading is known better than a tenth of them: what is common to it (a rim that slides) is no noise.
    let certain = quantile(slopes.iter().map(|s| s.variance).collect(), 0.1)?;
    let weights: Vec<f64> =
        slopes.iter().map(|s| 1.0 / (s.variance + s.clock_m_n.powi(2) + certain)).collect();
    let weighted = |of: &dyn Fn(&Slope) -> f64| {
        weighted_median(slopes.iter().map(of).zip(weights.iter().copied()).collect())
    };
    let tangential_m_n = weighted(&|s| s.compliance_m_n)?;
    // A median's variance is that of the mean of signs over twice the density, which the weighted
    // deviations give: 1.48 for the standard deviation, 1.25 for the median.
    let deviation = weighted(&|s| (s.compliance_m_n - tangential_m_n).abs())?;
    let total: f64 = weights.iter().sum();
    let effective = total * total / weights.iter().map(|w| w * w).sum::<f64>();
    let sd_m_n = 1.25 * 1.48 * deviation / effective.sqrt();
    let clock_m_n = weighted(&|s| s.clock_m_n)?;
    let grip_n = weighted(&|s| s.grip_n)?;
    let largest_n = slopes.iter().map(|s| s.largest_n).fold(0.0, f64::max);
    Some(Pads {
        tangential_m_n,
        sd_m_n,
        clock_m_n,
        largest_n,
        loadings: slopes.len(),
        at_most_m_n: None,
        grip_n,
    })
}

/// Load and displacement of a grasp at one sample: along gripper X, along Z and about Y.
type Loaded = [(f64, f64); 3];
/// The last of them.
const TURNS: usize = 2;

/// Torsional stiffness of a pad over its tangential one, m^2: the mean square radius of a layer, of a disc what is usual.
#[must_use]
pub fn mean_square_m2(fingers: &FingerContact<f64>) -> f64 {
    match fingers {
        FingerContact::Disc { diameter_m } => TORSION * 0.25 * diameter_m * diameter_m,
        FingerContact::Line { length_m } => length_m * length_m / 12.0,
        FingerContact::Point => 0.0,
    }
}

/// The loadings of a grasp in a trial: one for each direction that is loaded.
#[must_use]
pub fn loadings(trial: &Prepared) -> Vec<Slope> {
    let Some(fingers) = &trial.scene.fingers else { return Vec::new() };
    let Some(Some(touch)) = contact::measured(&trial.t_s, &trial.measured) else { return Vec::new() };
    let from = trial.t_s.partition_point(|t| *t < trial.t_s[touch] - REST_S);
    let Some(rest) = mean_of(&trial.measured[from.min(touch)..touch]) else { return Vec::new() };
    let loaded: Vec<Option<Loaded>> = trial.measured.iter().map(|s| loaded(s, &rest)).collect();
    // Of one pad: half of the load, and a turn at its radius.
    let scale = [2.0, 2.0, 2.0 * mean_square_m2(fingers)];
    // Driven in one sample: along, along, and turned.
    let driven_m = trial.drive_speed().iter().skip(touch).fold(0.0, |m: f64, v| m.max(*v)) * trial.period_s();
    let driven = [driven_m, driven_m, driven_m / TURN_ARM_M];
    let grip_n = trial.grip_n();
    (0..3)
        .filter(|k| scale[*k] > 0.0)
        .filter_map(|k| {
            let pairs: Vec<Option<(f64, f64)>> = loaded.iter().map(|l| l.map(|l| l[k])).collect();
            let slope = slope(&pairs, (from, touch), scale[k], driven[k])?;
            let turns = k == TURNS;
            Some(Slope { largest_n: if turns { 0.0 } else { slope.largest_n }, grip_n, turns, ..slope })
        })
        .collect()
}

/// Mean of samples in which object and fingers are measured.
fn mean_of(samples: &[Signals]) -> Option<Signals> {
    let known: Vec<&Signals> = samples.iter().filter(|s| s[..18].iter().all(|x| x.is_finite())).collect();
    let count = known.len() as f64;
    let mean = |k: usize| known.iter().map(|s| s[k]).sum::<f64>() / count;
    (known.len() > 2).then(|| std::array::from_fn(mean))
}

/// Load since `rest`, and how far the object's material between the pads has moved since.
fn loaded(sample: &Signals, rest: &Signals) -> Option<Loaded> {
    if sample[..18].iter().any(|x| !x.is_finite()) {
        return None;
    }
    let vector = |s: &Signals, at: usize| Vector3::new(s[at], s[at + 1], s[at + 2]);
    let turn = vector(sample, 3) - vector(rest, 3);
    let moved = vector(sample, 0) - vector(rest, 0) - turn.cross(&vector(rest, 0));
    let both = |at: usize| {
        let sum = |s: &Signals| vector(s, at) + vector(s, at + 6);
        sum(sample) - sum(rest)
    };
    let (force, torque) = (both(6), both(9));
    Some([(force.x, moved.x), (force.z, moved.z), (torque.y, turn.y)])
}

/// Slope of displacement against load from rest to [`LOADED`] of the largest load, times `scale`.
/// `driven`: how far the object is driven in a sample.
fn slope(
    pairs: &[Option<(f64, f64)>],
    (from, touch): (usize, usize),
    scale: f64,
    driven: f64,
) -> Option<Slope> {
    let loads = || pairs.iter().skip(touch).flatten().map(|p| p.0);
    let largest = loads().fold(0.0, |m: f64, x| m.max(x.abs()));
    let noise = crate::evidence::noise::white_noise(loads()).unwrap_or(0.0);
    if largest * LOADED < LOUD * noise || largest <= 0.0 {
        return None;
    }
    let reached = |p: &Option<(f64, f64)>| p.is_some_and(|p| p.0.abs() > LOADED * largest);
    // Without the sample that is beyond: the object may slide there already.
    let end = touch + pairs.iter().skip(touch).position(reached)?;
    let points: Vec<(f64, f64)> = pairs[from..end].iter().flatten().copied().collect();
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (load, moved) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = points.iter().map(|p| (p.0 - load).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.0 - load) * (p.1 - moved)).sum();
    if points.len() < 4 || spread <= 0.0 {
        return None;
    }
    let slope = product / spread;
    let rest: f64 = points.iter().map(|p| (p.1 - moved - slope * (p.0 - load)).powi(2)).sum();
    // The pads push against the displacement.
    let variance = scale * scale * rest / (n - 2.0) / spread;
    let clock_m_n = scale * driven / (LOADED * largest);
    Some(Slope {
        compliance_m_n: -scale * slope,
        variance,
        clock_m_n,
        largest_n: largest,
        grip_n: 0.0,
        turns: false,
    })
}
