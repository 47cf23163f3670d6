//! Contacts of a few bodies: the complementarity problem solved in the space of velocities.
//!
//! `W = J D J'` has no more than `ND` = 6 to 8 degrees of freedom behind it, whatever the
//! number of contacts. Written for the velocities the problem is piecewise linear with `ND`
//! unknowns, and a contact costs a few inner products of `ND` numbers: the cost is linear in
//! the contacts. A solve follows the solution from a problem whose solution is known
//! (`path`) with a small compliance in every contact (`law`), which makes the distribution
//! of impulses unique where rigid contacts leave it free; then the compliance is taken out by
//! repeating with the impulses found (a proximal method: each round is one factorisation).
//! The known problem is the one without contact, or the last one solved (warm start).
//!
//! The answer solves the very problem that [`super::dense`] solves: the certificate is the
//! residual of `z` by the rows of that problem, bounded from above at a cost linear in the
//! contacts (a row's size is at least what its own contact gives to it).

pub(super) mod law;
pub(super) mod path;
pub(super) mod polygon;

use super::factors::{Factors, Impulses};
use super::residual::Residual;
use super::{Outcome, Path, Report, SolveStatus, residual, tolerance};
use crate::linear::Factors as Lu;
use crate::real::{Real, abs, max, min, sqrt};
use law::{Mode, Normal, Regular, Track, add_scaled};
use path::{End, Equations, follow};
use polygon::Polygon;

/// Rounds in which the compliance is taken out.
const ROUNDS: u32 = 12;
/// Starts from open contacts, each with other offsets.
const STARTS: u32 = 4;

/// Working memory, warm start and answer of the contact solver.
#[derive(Clone)]
pub struct ContactSolver<R, const NC: usize, const ND: usize> {
    tracks: [Track<R, ND>; NC],
    /// Contacts of the last problem where it was solved, else 0: the warm start.
    known: usize,
    polygon: Polygon<R>,
    answer: Impulses<R, NC, ND>,
}

impl<R: Real, const NC: usize, const ND: usize> Default for ContactSolver<R, NC, ND> {
    fn default() -> Self {
        Self::new()
    }
}

/// Relative compliance of the first round. Above the rounding of the velocities, below what
/// the certificate sees after a second round.
fn first_shift<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-12 { R::of(1e-6) } else { R::of(1e-3) }
}

/// Residual that ends the rounds, and the least compliance. In f32 rounding ends both sooner.
fn goal<R: Real>(first_shift: R) -> (R, R) {
    if R::EPSILON.to_f64() < 1e-12 {
        (tolerance::<R>() * R::of(1e-3), first_shift * R::of(1e-4))
    } else {
        (tolerance::<R>(), first_shift * R::of(0.3))
    }
}

impl<R: Real, const NC: usize, const ND: usize> ContactSolver<R, NC, ND> {
    /// Empty working memory.
    pub fn new() -> Self {
        Self {
            tracks: [Track::nothing(Regular::nothing()); NC],
            known: 0,
            polygon: Polygon::new(4),
            answer: Impulses::none(),
        }
    }

    /// The answer of the last solve with a report that says what it is worth.
    pub(super) fn last(&self, report: Report<R>) -> Outcome<'_, Impulses<R, NC, ND>, R> {
        Outcome::new(&self.answer, report)
    }

    /// Forgets the last problem: the next solve starts from open contacts.
    pub fn forget(&mut self) {
        self.known = 0;
    }

    /// Solves a problem, from the last answer where it had as many contacts.
    ///
    /// Contacts are matched by their order. Bounded: a warm start and `STARTS` cold ones, each
    /// of at most `20 nc + 40` kinks and `ROUNDS` rounds of the same.
    pub fn solve(&mut self, problem: &Factors<R, NC, ND>) -> Outcome<'_, Impulses<R, NC, ND>, R> {
        let report = match problem.defect() {
            Some(defect) => {
                self.answer = Impulses::none();
                self.known = 0;
                Report::refused(defect)
            }
            None => self.search(problem),
        };
        Outcome::new(&self.answer, report)
    }

    fn search(&mut self, problem: &Factors<R, NC, ND>) -> Report<R> {
        let mut roots = [R::zero(); ND];
        for (root, inverse) in roots.iter_mut().zip(problem.inverse_mass) {
            *root = sqrt(inverse);
        }
        let count = problem.contacts.len().min(NC);
        for (track, contact) in self.tracks.iter_mut().zip(&problem.contacts) {
            track.load(contact, &roots);
        }
        let warm = self.known == count;
        self.known = 0;
        let Some(tracks) = self.tracks.get_mut(..count) else { return Report::nothing() };
        let mut best = Report::nothing();
        let mut pivots = 0_u32;
        let mut limits = 0;
        for start in 0..=STARTS {
            if start == 0 && !warm {
                continue;
            }
            let shift = first_shift::<R>() * if start > 2 { R::of(10.0) } else { R::one() };
            let (end, kinks, residual, y) = attempt(&self.polygon, tracks, shift, start);
            pivots = pivots.saturating_add(kinks);
            limits += u32::from(end == End::Limit);
            if residual < best.residual || !best.residual.finite() {
                best.residual = residual;
                best.path = match (start, kinks) {
                    (0, 1) => Path::Warm,
                    (0, _) => Path::Repaired,
                    (1, _) => Path::Velocities,
                    (k, _) => Path::Restarted((k - 1) as u8),
                };
                store(tracks, &y, &roots, &mut self.answer);
            }
            if residual <= tolerance() {
                self.known = count;
                best.status = SolveStatus::Solved;
                break;
            }
        }
        best.pivots = pivots;
        if best.status != SolveStatus::Solved {
            best.status = if contradictory(tracks) {
                SolveStatus::Contradiction
            } else if limits > 0 {
                SolveStatus::IterationLimit
            } else {
                SolveStatus::Numerical
            };
        }
        best
    }
}

/// Rounds in which the weights of a proof are freed from what does not cancel.
const PROOF_ROUNDS: u32 = 20;
/// A proof holds up to velocities of one over so many roundings of the largest constant.
const PROOF_ROUNDINGS: f64 = 64.0;

/// Whether the problem is proved to have no solution: by weights, not negative, under which the normals
/// of rigid contacts cancel and their separations add up to less than zero (Farkas' lemma). No velocity
/// then separates all of them; and where one does, a friction problem has a solution. The normal
/// impulses of a failed solve, which grow along such weights, are where the search begins. What is
/// left of the sum by rounding is weighed: only velocities beyond any number in the problem could
/// make up for it.
fn contradictory<R: Real, const ND: usize>(tracks: &[Track<R, ND>]) -> bool {
    let zero = R::zero();
    let rigid = |t: &Track<R, ND>| t.regular.size[0] > zero && !(t.regular.compliance > zero);
    let mut constant = zero;
    // Of unit normals: the sum of outer products, slightly more on its diagonal.
    let mut gram = [[zero; ND]; ND];
    for track in tracks.iter().filter(|t| rigid(t)) {
        constant = max(abs(track.constant[0]) / sqrt(track.regular.size[0]), constant);
        for r in 0..ND {
            add_scaled(&mut gram[r], track.rows[0][r] / track.regular.size[0], &track.rows[0]);
        }
    }
    for (r, row) in gram.iter_mut().enumerate() {
        row[r] += R::of(64.0) * R::EPSILON;
    }
    let factors = Lu::of(&gram);
    // Weights of the unit normals are `weight * length`; a round takes off what `push` would undo.
    let mut push = [zero; ND];
    for round in 0..=PROOF_ROUNDS {
        let (mut sum, mut total, mut work) = ([zero; ND], zero, zero);
        for track in tracks.iter().filter(|t| rigid(t)) {
            let length = sqrt(track.regular.size[0]);
            let weight = max(track.impulse[0] * length - law::dot(&track.rows[0], &push) / length, zero);
            add_scaled(&mut sum, weight / length, &track.rows[0]);
            total += weight;
            work += weight * track.constant[0] / length;
        }
        let left = max(sqrt(law::dot(&sum, &sum)), total * R::EPSILON);
        if -work * R::of(PROOF_ROUNDINGS) * R::EPSILON > left * constant {
            return true;
        }
        if round == PROOF_ROUNDS || !(total > zero) {
            break;
        }
        let more = factors.solve(&sum);
        add_scaled(&mut push, R::one(), &more);
    }
    false
}

/// One way to the answer: warm (`start` 0) or from open contacts. Returns pivots, the residual and
/// the velocities that the impulses cause.
fn attempt<R: Real, const ND: usize>(
    polygon: &Polygon<R>,
    tracks: &mut [Track<R, ND>],
    first_shift: R,
    start: u32,
) -> (End, u32, R, [R; ND]) {
    let limit = 20 * tracks.len() as u32 + 40;
    // A repair that takes longer than a cold start is none.
    let first_limit = if start == 0 { 2 * tracks.len() as u32 + 10 } else { limit };
    let infinite = R::of(f64::INFINITY);
    let mut shift = first_shift;
    let (aim, least_shift) = goal(first_shift);
    // A warm answer is near already: a round more would cost as much as the first. The next warm
    // start goes on from it.
    let aim = if start == 0 { max(aim, tolerance::<R>() * R::of(0.1)) } else { aim };
    let mut y = [R::zero(); ND];
    let mut pivots = 1;
    for track in tracks.iter_mut() {
        track.regularise(shift, Normal::Whole);
    }
    if start == 0 {
        anchor(polygon, tracks, &mut y);
    } else {
        open(tracks, start);
    }
    let mut equations = Equations::new(polygon, None);
    let balanced = [R::zero(); ND];
    let (end, kinks) = follow(&mut equations, tracks, &mut y, &balanced, first_limit);
    pivots += kinks;
    if end != End::Arrived {
        // The best there is: the solution for the offsets that are left.
        let speeds = settle(polygon, tracks);
        return (end, pivots, certify(tracks, &speeds), speeds);
    }
    let (mut residual, mut failed) = (infinite, End::Arrived);
    let mut speeds = y;
    for round in 0..ROUNDS {
        speeds = settle(polygon, tracks);
        let before = residual;
        residual = certify(tracks, &speeds);
        if residual <= aim || round + 1 == ROUNDS {
            break;
        }
        // Impulses that squeeze two stiff bodies converge slowly: less compliance.
        if failed != End::Arrived {
            failed = End::Arrived;
        } else if residual > before * R::of(0.1) {
            if residual <= tolerance() && residual > before * R::of(0.5) {
                break;
            }
            shift = max(shift * R::of(0.03), least_shift);
        }
        for track in tracks.iter_mut() {
            track.regular.settled = track.mode;
        }
        for track in tracks.iter_mut() {
            track.regularise(shift, Normal::Coupled);
        }
        anchor(polygon, tracks, &mut y);
        let (end, kinks) = follow(&mut equations, tracks, &mut y, &balanced, limit);
        pivots += 1 + kinks;
        if end != End::Arrived {
            // More compliance takes a shorter step.
            failed = end;
            shift *= R::of(30.0);
            for track in tracks.iter_mut() {
                track.mode = track.regular.settled;
                track.trial = track.impulse;
            }
        }
    }
    (failed, pivots, residual, speeds)
}

/// Start without contact: offsets that open every contact, different for each so that no two
/// close together.
fn open<R: Real, const ND: usize>(tracks: &mut [Track<R, ND>], start: u32) {
    let (mut approach, mut slip) = (R::zero(), R::zero());
    for track in tracks.iter() {
        approach = max(-track.constant[0], approach);
        slip = max(max(abs(track.constant[1]), abs(track.constant[2])), slip);
    }
    let golden = R::of(0.618_033_988_749_894_9);
    let silver = R::of(0.414_213_562_373_095_1);
    let step = |x: R, by: R| if x + by < R::one() { x + by } else { x + by - R::one() };
    let (mut first, mut second) = (R::zero(), R::zero());
    for _ in 0..start {
        first = step(first, silver);
        second = step(second, golden);
    }
    let spread = R::of(0.1);
    let half = R::of(0.5);
    for track in tracks.iter_mut() {
        first = step(first, golden);
        second = step(second, silver);
        track.mode = Mode::Open;
        track.regular.anchor = [R::zero(); 3];
        track.offset = [
            approach * (R::of(1.01) + spread * first),
            slip * spread * (first - half),
            slip * spread * (second - half),
        ];
        let mut speeds = track.constant;
        for k in 0..3 {
            speeds[k] += track.offset[k];
        }
        track.trial = track.trial_at(&speeds);
    }
}

/// Start from the impulses, speeds and modes at hand, which become the known ones.
fn anchor<R: Real, const ND: usize>(polygon: &Polygon<R>, tracks: &mut [Track<R, ND>], y: &mut [R; ND]) {
    *y = [R::zero(); ND];
    for track in tracks.iter() {
        for k in 0..3 {
            add_scaled(y, track.impulse[k], &track.rows[k]);
        }
    }
    for track in tracks.iter_mut() {
        track.regular.anchor = track.impulse;
        let wanted = track.consistent(polygon, &track.speed);
        let true_speeds = track.speeds_at(y);
        for k in 0..3 {
            track.offset[k] = wanted[k] - true_speeds[k];
        }
        track.trial = track.trial_at(&wanted);
    }
}

/// Impulses at the end of a path; returns the velocities that they cause.
///
/// The trial has grown by increments from impulses that were known, which keeps digits that
/// are lost where `y` is inserted into the law: with light fingers `G y` and `q` cancel.
#[inline]
fn settle<R: Real, const ND: usize>(polygon: &Polygon<R>, tracks: &mut [Track<R, ND>]) -> [R; ND] {
    let mut speeds = [R::zero(); ND];
    for track in tracks.iter_mut() {
        track.impulse = track.impulse_of(polygon, &track.trial);
        for k in 0..3 {
            add_scaled(&mut speeds, track.impulse[k], &track.rows[k]);
        }
    }
    speeds
}

/// Upper bound of the residual of the impulses, which cause the velocities `y`; leaves the
/// speeds and slip bounds that belong to them.
fn certify<R: Real, const ND: usize>(tracks: &mut [Track<R, ND>], y: &[R; ND]) -> R {
    let mut largest = R::zero();
    for track in tracks.iter_mut() {
        track.speed = track.speeds_at(y);
        let [normal, first, second] = track.impulse;
        // With what the compliance takes of it.
        for k in 1..3 {
            track.speed[k] += track.regular.tangential_compliance * track.impulse[k];
        }
        track.regular.slip = max(abs(track.speed[1]), abs(track.speed[2]));
        let friction = max(abs(first), abs(second));
        largest = max(max(track.regular.slip, friction), max(normal, largest));
    }
    let (mut worst, mut constant) = (R::zero(), R::zero());
    let mut sum = Residual::zero();
    let four = R::of(4.0);
    let by_largest = if largest > R::zero() { R::one() / largest } else { R::zero() };
    for track in tracks.iter() {
        let [normal, first, second] = track.impulse;
        let [separation, slip_first, slip_second] = track.speed;
        let diagonal = track.regular.size[0] + track.regular.compliance;
        let size = abs(track.constant[0]) + diagonal * largest;
        let slack = separation + track.regular.compliance * normal;
        worst = min(slack, worst);
        for k in 0..3 {
            constant = max(abs(track.constant[k]), constant);
        }
        sum.add_scaled_row(normal, slack, size, by_largest);
        for (k, force, slip) in [(1, first, slip_first), (2, second, slip_second)] {
            // Both signs of the tangent count in the row, and the slip speed bound.
            let diagonal = track.regular.size[k] + track.regular.size[k] + R::one();
            let size = abs(track.constant[k]) + diagonal * largest;
            let slack = if force < R::zero() { track.regular.slip - slip } else { track.regular.slip + slip };
            sum.add_scaled_row(abs(force), slack, size, by_largest);
        }
        let unused = track.friction * normal - abs(first) - abs(second);
        sum.add_scaled_row(track.regular.slip, unused, (track.friction + four) * largest, by_largest);
    }
    residual::credible(sum.value(), worst, constant)
}

fn store<R: Real, const NC: usize, const ND: usize>(
    tracks: &[Track<R, ND>],
    y: &[R; ND],
    roots: &[R; ND],
    answer: &mut Impulses<R, NC, ND>,
) {
    answer.normal.clear();
    answer.tangential.clear();
    answer.slip.clear();
    for track in tracks {
        let [normal, first, second] = track.impulse;
        // The capacity is that of the problem: nothing is refused.
        let _ = answer.normal.push(normal);
        let _ = answer.tangential.push([first, second]);
        let _ = answer.slip.push(track.regular.slip);
    }
    for k in 0..ND {
        answer.velocity_change[k] = y[k] * roots[k];
    }
}
