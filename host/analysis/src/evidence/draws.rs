//! Weights of whole conditions and of whole signals drawn anew: intervals that need no derivative and no noise model.
//!
//! Weights are exponential (the Bayesian bootstrap of Rubin 1981, in both directions as in Owen's of 2007; drawing
//! with replacement would often leave out the one signal that tells). Conditions, because friction varies from run to run and
//! the residuals of a run do not average out. Signals, because what the model lacks returns
//! in the same signal in every condition, and more trials do not make it smaller: where the
//! signals disagree about a coefficient, its interval says so.
//!
//! The cost is tabled along a scan of values ([`scan`]). Each draw has a
//! set of values that fit it equally well ([`fitting`]); the interval reaches from the low quantile of
//! these sets' lower ends to the high quantile of their upper ends. A contact that never
//! slides has sets without an end: the coefficient is only bounded. Conditions are few: the
//! quantiles are those of Student's t, expanded (Hesterberg 2015), and as no draw leaves the
//! range of the few, the interval is at least as wide as the t interval from the draws'
//! standard deviation. Fewer yet may speak against one side of the best value: then its end counts those ([`against`]).

use rand::SeedableRng;
use rand_distr::{Distribution, Exp1};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Draws.
pub const DRAWS: usize = 1000;
/// Coefficients of friction beyond these are not believed.
pub const RANGE: [f64; 2] = [0.02, 5.0];
/// Relative departures of the scan on either side.
const DEPARTURES: [f64; 13] = [0.003, 0.008, 0.015, 0.025, 0.04, 0.065, 0.1, 0.15, 0.22, 0.35, 0.6, 1.2, 2.2];
/// Rise of a draw's cost, as a share of it, that counts as none.
const RISE: f64 = 1e-3;

/// Weight of each condition and of each signal.
pub struct Draw {
    /// One for each condition.
    pub condition: Vec<f64>,
    /// One for each signal.
    pub signal: Vec<f64>,
}

impl Draw {
    /// All weigh the same.
    pub fn even(conditions: usize, signals: usize) -> Self {
        Self { condition: vec![1.0; conditions], signal: vec![1.0; signals] }
    }
}

/// [`DRAWS`] draws, the same at every call.
pub fn draws(conditions: usize, signals: usize) -> Vec<Draw> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut one = || {
        let mut weights = |n: usize| -> Vec<f64> { (0..n).map(|_| Exp1.sample(&mut rng)).collect() };
        Draw { condition: weights(conditions), signal: weights(signals) }
    };
    (0..DRAWS).map(|_| one()).collect()
}

/// Logarithms of coefficients about the `best` one, ascending, with both ends of [`RANGE`].
pub fn scan(best: f64) -> Vec<f64> {
    let [low, high] = RANGE.map(f64::ln);
    let mut scan: Vec<f64> = DEPARTURES.iter().flat_map(|d| [best - d, best + d]).chain([best]).collect();
    scan.extend([low, high]);
    scan.retain(|x| (low..=high).contains(x));
    scan.sort_by(f64::total_cmp);
    scan
}

/// First and last place whose cost is that of the best one; `None` where no cost is a number.
pub fn fitting(costs: &[f64]) -> Option<(usize, usize)> {
    let least = costs.iter().copied().filter(|c| c.is_finite()).min_by(f64::total_cmp)?;
    let fits = |c: &f64| *c <= least * (1.0 + RISE) + 1e-12;
    Some((costs.iter().position(fits)?, costs.iter().rposition(fits)?))
}

/// How many conditions speak against either side of the `best` place of a scan (`costs` by place and condition): of what each adds
/// to the cost at a value, the sum squared over the sum of squares, at the value where that is most. Where two of twenty conditions
/// exclude a value, draws hardly ever leave both of them out, and what these two have in common no draw shows (effective number
/// of clusters; Carter, Schnepel and Steigerwald 2017).
pub fn against(costs: &[Vec<f64>], best: usize) -> [f64; 2] {
    let of = |place: usize| {
        let more = costs[place].iter().zip(&costs[best]).map(|(there, here)| there - here);
        let (sum, squares) = more.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let number: f64 = if sum > 0.0 { sum * sum / squares } else { 1.0 };
        if number.is_finite() { number } else { 1.0 }
    };
    [(0..best), (best + 1..costs.len())].map(|side| side.map(of).fold(1.0, f64::max))
}

/// Ends of an interval.
pub struct Ends {
    /// Places of the scan that the draws reach; `None` where they reach its end.
    pub places: [Option<usize>; 2],
    /// Logarithms of the coefficient; `None`: no bound on that side.
    pub logs: [Option<f64>; 2],
}

/// 95 % interval from the `sets` of values that fit the draws, places of `scan`, from costs by place and condition (all signals
/// alike).
pub fn ends(scan: &[f64], best: f64, sets: &[(usize, usize)], costs: &[Vec<f64>]) -> Ends {
    let conditions = costs.first().map_or(0.0, |at| at.len() as f64);
    let here = scan.iter().position(|x| *x >= best).unwrap_or(0);
    let against = against(costs, here);
    let [lower, upper] = against.map(tail);
    let end = |mut ends: Vec<usize>, share: f64| {
        ends.sort_unstable();
        ends.get((share * (ends.len().max(1) - 1) as f64).round() as usize).copied()
    };
    let low = end(sets.iter().map(|s| s.0).collect(), lower).filter(|i| *i > 0);
    let high = end(sets.iter().map(|s| s.1).collect(), 1.0 - upper).filter(|i| *i + 1 < scan.len());
    let inside: Vec<f64> = sets
        .iter()
        .filter(|s| s.0 > 0 && s.1 + 1 < scan.len())
        .map(|s| 0.5 * (scan[s.0] + scan[s.1]) - best)
        .collect();
    // Exponential weights on n conditions scatter a mean too little by (n - 1) / (n + 1).
    let variance = inside.iter().map(|d| d * d).sum::<f64>() / inside.len().max(1) as f64;
    let sd = (variance * (conditions + 1.0) / (conditions - 1.0).max(0.5)).sqrt();
    let [below_by, above_by] = against.map(|number| student(number) * sd);
    let [lowest, highest] = RANGE.map(f64::ln);
    // The end lies between the last value that fits and the next, which does not.
    let below = low.map(|i| scan[i - 1].min(best - below_by)).filter(|x| *x > lowest);
    let above = high.map(|i| scan[i + 1].max(best + above_by)).filter(|x| *x < highest);
    Ends { places: [low, high], logs: [below, above] }
}

/// Share of the draws left out on either side for a 95 % interval from so many conditions.
pub fn tail(conditions: f64) -> f64 {
    let expanded = student(conditions) * (conditions / (conditions - 1.0).max(0.5)).sqrt();
    Normal::new(0.0, 1.0).map_or(0.0, |n| n.cdf(-expanded))
}

/// Quantile of Student's t for a 95 % interval.
fn student(conditions: f64) -> f64 {
    StudentsT::new(0.0, 1.0, (conditions - 1.0).max(1.0)).map_or(2.0, |t| t.inverse_cdf(0.975))
}
