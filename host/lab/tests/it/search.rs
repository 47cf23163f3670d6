//! The search behind the hunts, on a hill that is known.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use stickslip_lab::hunt::search::{Candidate, search};

#[derive(Clone, Debug, PartialEq)]
struct Point([f64; 6]);

impl Candidate for Point {
    fn fresh(rng: &mut ChaCha8Rng) -> Self {
        Point([0; 6].map(|_| rng.random_range(-1.0..1.0)))
    }
    fn mutated(&self, rng: &mut ChaCha8Rng) -> Self {
        Point(self.0.map(|x| x + 0.1 * rng.random_range(-1.0..1.0_f64)))
    }
    fn mixed(&self, other: &Self, rng: &mut ChaCha8Rng) -> Self {
        let mut new = self.clone();
        for (x, y) in new.0.iter_mut().zip(other.0) {
            if rng.random_bool(0.5) {
                *x = y;
            }
        }
        new
    }
}

#[test]
fn a_search_climbs_beyond_random_drawing_and_repeats_itself() {
    let height = |p: &Point| -p.0.iter().map(|x| (x - 0.5) * (x - 0.5)).sum::<f64>();
    let first = search(3, 2000, height, |_| {});
    assert!(first.worst[0].0 > -0.01 && first.worst[0].0 > first.random_best, "{first:?}");
    assert_eq!(first.scored, 2000);
    assert_eq!(search(3, 2000, height, |_| {}).worst, first.worst);
    assert_ne!(search(4, 2000, height, |_| {}).worst, first.worst);
}
