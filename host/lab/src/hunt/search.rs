//! Evolutionary search with restarts.
//!
//! A round begins with many random candidates; the best of them breed (tournament of three,
//! mutation, sometimes a mix of two) until several generations bring nothing new; then the
//! next round begins. Candidates are drawn by one generator in one order and scored in
//! parallel: the finds depend on the seed alone.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use stickslip_lcp::generate::rng;

/// Random candidates at the start of a round.
const FRESH: usize = 96;
/// Those that breed.
const PARENTS: usize = 16;
/// Children of a generation.
const CHILDREN: usize = 32;
/// Generations without a gain that end a round.
const PATIENCE: usize = 8;

/// What can be searched over.
pub trait Candidate: Clone + Send + Sync {
    /// At random.
    fn fresh(rng: &mut ChaCha8Rng) -> Self;
    /// A little different.
    #[must_use]
    fn mutated(&self, rng: &mut ChaCha8Rng) -> Self;
    /// Something of both.
    #[must_use]
    fn mixed(&self, other: &Self, rng: &mut ChaCha8Rng) -> Self;
}

/// What a search found.
#[derive(Clone, Debug)]
pub struct Found<C> {
    /// The best of each round with its score, the largest first.
    pub worst: Vec<(f64, C)>,
    /// Largest score among candidates that were only drawn at random.
    pub random_best: f64,
    /// Candidates scored.
    pub scored: usize,
}

/// Searches for the largest `score` with `budget` candidates. `progress` is told how many more
/// are scored. A score that is not a number counts as none.
pub fn search<C: Candidate>(
    seed: u64,
    budget: usize,
    score: impl Fn(&C) -> f64 + Sync,
    mut progress: impl FnMut(usize),
) -> Found<C> {
    let rng = &mut rng(seed);
    let mut found = Found { worst: Vec::new(), random_best: f64::NEG_INFINITY, scored: 0 };
    let mut judge = |list: Vec<C>, found: &mut Found<C>| -> Vec<(f64, C)> {
        found.scored += list.len();
        progress(list.len());
        let judged: Vec<(f64, C)> = list.into_par_iter().map(|c| (score(&c), c)).collect();
        judged.into_iter().filter(|(s, _)| !s.is_nan()).collect()
    };
    let descending = |list: &mut Vec<(f64, C)>| list.sort_by(|a, b| b.0.total_cmp(&a.0));
    while found.scored < budget {
        let number = FRESH.min(budget - found.scored);
        let mut parents = judge((0..number).map(|_| C::fresh(rng)).collect(), &mut found);
        descending(&mut parents);
        parents.truncate(PARENTS);
        let Some(first) = parents.first() else { continue };
        found.random_best = found.random_best.max(first.0);
        let (mut best, mut idle) = (first.0, 0);
        while idle < PATIENCE && found.scored < budget {
            let number = CHILDREN.min(budget - found.scored);
            let children = (0..number).map(|_| child(&parents, rng)).collect();
            parents.extend(judge(children, &mut found));
            descending(&mut parents);
            // Equals drive each other out: one of each score breeds.
            parents.dedup_by(|a, b| a.0 == b.0);
            parents.truncate(PARENTS);
            let now = parents.first().map_or(best, |p| p.0);
            idle = if now > best { 0 } else { idle + 1 };
            best = now;
        }
        found.worst.extend(parents.into_iter().next());
    }
    descending(&mut found.worst);
    found
}

fn child<C: Candidate>(parents: &[(f64, C)], rng: &mut ChaCha8Rng) -> C {
    // Sorted: the lowest of three places is the best of three.
    let mut pick = || (0..3).map(|_| rng.random_range(0..parents.len())).min().unwrap_or(0);
    let (a, b) = (pick(), pick());
    let (a, b) = (&parents[a].1, &parents[b].1);
    let mixed = if rng.random_bool(0.3) { a.mixed(b, rng) } else { a.clone() };
    mixed.mutated(rng)
}
