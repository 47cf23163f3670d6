//! A contact problem by its factors, and the linear complementarity problem it stands for.
//!
//! Bodies have `ND` degrees of freedom with a diagonal inverse mass `D`; each contact has a
//! normal and two tangents (rows of `J`). With `W = J D J'`, compliance `c` and friction `mu`:
//!
//! `M = [[W_nn + diag(c), W_nt, 0], [W_tn, W_tt, E], [diag(mu), -E', 0]]`
//!
//! where the tangents are `t1, t2, -t1, -t2` of each contact (a tangential compliance adds to the diagonal
//! of `W_tt`, and with the other sign where opposite tangents meet), and the unknowns are
//! `z = [normal impulse (nc) | tangential impulse (4 nc) | slip speed bound (nc)]` in newton
//! seconds and metres a second (Stewart and Trinkle 1996 with a pyramid of four edges).

use super::Defect;
use crate::real::{Real, abs, max};
use heapless::Vec;

/// One contact: a row of the problem in each of three directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<R, const ND: usize> {
    /// Speed of separation for a unit speed of each degree of freedom.
    pub normal: [R; ND],
    /// Speed of slip along t1 and t2 likewise.
    pub tangents: [[R; ND]; 2],
    /// Normal compliance, m/s per newton second; 0 is rigid.
    pub compliance: R,
    /// Compliance along both tangents likewise; 0 is rigid.
    pub tangential_compliance: R,
    /// Coefficient of friction, 0 to 10.
    pub friction: R,
    /// Speed of separation without impulses, m/s.
    pub separation: R,
    /// Slip along t1 and t2 without impulses, m/s.
    pub slip: [R; 2],
}

/// A problem of up to `NC` contacts and `ND` degrees of freedom; unused ones have inverse mass 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Factors<R, const NC: usize, const ND: usize> {
    /// Inverse mass of each degree of freedom, 1/kg or 1/(kg m^2); 0 does not move.
    pub inverse_mass: [R; ND],
    /// The contacts.
    pub contacts: Vec<Contact<R, ND>, NC>,
}

impl<R: Real, const ND: usize> Contact<R, ND> {
    fn defect(&self) -> Option<Defect> {
        // Only zeros times x can make the sum finite: one test for many numbers.
        // In columns, so that several lanes can work.
        let [first, second] = &self.tangents;
        let (mut zeros, mut acts) = ([R::zero(); ND], [false; ND]);
        for k in 0..ND {
            let (x, y, z) = (self.normal[k], first[k], second[k]);
            zeros[k] = x * R::zero() + y * R::zero() + z * R::zero();
            acts[k] = (x != R::zero()) | (y != R::zero()) | (z != R::zero());
        }
        let acts = acts.iter().fold(false, |any, x| any | x);
        let mut probe = zeros.iter().fold(R::zero(), |sum, x| sum + *x);
        for x in [
            self.compliance,
            self.tangential_compliance,
            self.friction,
            self.separation,
            self.slip[0],
            self.slip[1],
        ] {
            probe += x * R::zero();
        }
        if probe != R::zero() {
            Some(Defect::NotFinite)
        } else if !(self.friction >= R::zero() && self.friction <= R::of(10.0)) {
            Some(Defect::Friction)
        } else if self.compliance < R::zero() || self.tangential_compliance < R::zero() {
            Some(Defect::Compliance)
        } else if !acts {
            Some(Defect::Direction)
        } else {
            None
        }
    }
}

impl<R: Real, const NC: usize, const ND: usize> Factors<R, NC, ND> {
    /// What is wrong with the numbers, if anything.
    pub fn defect(&self) -> Option<Defect> {
        if self.contacts.is_empty() {
            return Some(Defect::Empty);
        }
        if !self.inverse_mass.iter().all(|x| x.finite()) {
            return Some(Defect::NotFinite);
        }
        if self.inverse_mass.iter().any(|&x| x < R::zero()) {
            return Some(Defect::Mass);
        }
        self.contacts.iter().find_map(Contact::defect)
    }

    /// Unknowns of the complementarity problem.
    pub fn unknowns(&self) -> usize {
        6 * self.contacts.len()
    }

    /// Row of `J`: normals, then t1, t2, -t1, -t2 of each contact. `None` past the last.
    fn row(&self, index: usize) -> Option<(R, &[R; ND])> {
        let count = self.contacts.len();
        if let Some(contact) = self.contacts.get(index) {
            return Some((R::one(), &contact.normal));
        }
        let tangent = index.checked_sub(count)?;
        let contact = self.contacts.get(tangent / 4)?;
        let sign = if tangent % 4 < 2 { R::one() } else { -R::one() };
        Some((sign, if tangent % 2 == 0 { &contact.tangents[0] } else { &contact.tangents[1] }))
    }

    /// Entry of `W = J D J'`; zero outside it.
    fn delassus(&self, i: usize, j: usize) -> R {
        let (Some((sign_i, row_i)), Some((sign_j, row_j))) = (self.row(i), self.row(j)) else {
            return R::zero();
        };
        let mut sum = R::zero();
        for ((&a, &b), &inverse) in row_i.iter().zip(row_j).zip(&self.inverse_mass) {
            sum += a * inverse * b;
        }
        sum * sign_i * sign_j
    }

    /// Entry `M_ij`.
    pub fn entry(&self, i: usize, j: usize) -> R {
        let count = self.contacts.len();
        let (tangents_end, n) = (5 * count, 6 * count);
        if i >= n || j >= n {
            return R::zero();
        }
        if i >= tangents_end {
            let Some(contact) = self.contacts.get(i - tangents_end) else { return R::zero() };
            if j == i - tangents_end {
                contact.friction
            } else if j >= count && j < tangents_end && (j - count) / 4 == i - tangents_end {
                -R::one()
            } else {
                R::zero()
            }
        } else if j >= tangents_end {
            let same = i >= count && (i - count) / 4 == j - tangents_end;
            if same { R::one() } else { R::zero() }
        } else {
            let tangent = |i: usize| i.checked_sub(count).map(|k| (k / 4, k % 4));
            let extra = match (tangent(i), tangent(j)) {
                (None, None) if i == j => self.contacts.get(i).map_or(R::zero(), |c| c.compliance),
                (Some((a, s)), Some((b, t))) if a == b && s % 2 == t % 2 => {
                    let c = self.contacts.get(a).map_or(R::zero(), |c| c.tangential_compliance);
                    if s == t { c } else { -c }
                }
                _ => R::zero(),
            };
            self.delassus(i, j) + extra
        }
    }

    /// Entry `q_i`.
    pub fn constant(&self, i: usize) -> R {
        let count = self.contacts.len();
        if let Some(contact) = self.contacts.get(i) {
            return contact.separation;
        }
        let Some(tangent) = i.checked_sub(count) else { return R::zero() };
        let Some(contact) = self.contacts.get(tangent / 4) else { return R::zero() };
        let slip = if tangent % 2 == 0 { contact.slip[0] } else { contact.slip[1] };
        if tangent % 4 < 2 { slip } else { -slip }
    }

    /// Writes the dense form; `m` must hold n x n and `q` n with n = [`Self::unknowns`].
    /// Returns `false`, and writes nothing, where the sizes differ.
    pub fn write_dense(&self, m: &mut [R], q: &mut [R]) -> bool {
        let n = self.unknowns();
        if n == 0 || m.len() != n * n || q.len() != n {
            return false;
        }
        for (i, (row, constant)) in m.chunks_exact_mut(n).zip(q.iter_mut()).enumerate() {
            *constant = self.constant(i);
            for (j, value) in row.iter_mut().enumerate() {
                *value = self.entry(i, j);
            }
        }
        true
    }

    /// Exact residual of `z` (n) by the dense rows, none of which is stored.
    pub fn residual(&self, z: &[R]) -> super::residual::Residual<R> {
        let mut sum = super::residual::Residual::zero();
        let n = self.unknowns();
        if z.len() != n {
            sum.slack = R::of(f64::INFINITY);
            return sum;
        }
        let biggest = super::residual::largest(z);
        for (i, &unknown) in z.iter().enumerate() {
            let constant = self.constant(i);
            let (mut w, mut size) = (constant, R::zero());
            for (j, &x) in z.iter().enumerate() {
                let entry = self.entry(i, j);
                w += entry * x;
                size += abs(entry);
            }
            sum.add_row(unknown, w, abs(constant) + size * biggest, biggest);
        }
        sum
    }
}

/// Impulses and speeds of the contacts of a problem: the unknowns, tangents paired.
#[derive(Clone, Debug, PartialEq)]
pub struct Impulses<R, const NC: usize, const ND: usize> {
    /// Along the normal, newton seconds.
    pub normal: Vec<R, NC>,
    /// Along t1 and t2, newton seconds.
    pub tangential: Vec<[R; 2], NC>,
    /// Slip speed bound (largest component of the slip), m/s.
    pub slip: Vec<R, NC>,
    /// Change of speed of each degree of freedom by the impulses.
    pub velocity_change: [R; ND],
}

impl<R: Real, const NC: usize, const ND: usize> Impulses<R, NC, ND> {
    /// No contacts, no impulses.
    pub fn none() -> Self {
        Self {
            normal: Vec::new(),
            tangential: Vec::new(),
            slip: Vec::new(),
            velocity_change: [R::zero(); ND],
        }
    }

    /// Takes `z` in the order of the complementarity problem; opposite tangents are paired.
    pub fn read_unknowns(&mut self, z: &[R], problem: &Factors<R, NC, ND>) {
        *self = Self::none();
        let count = problem.contacts.len();
        let at = |k: usize| z.get(k).copied().unwrap_or(R::zero());
        for (i, contact) in problem.contacts.iter().enumerate() {
            let place = count + 4 * i;
            let pair = [at(place) - at(place + 2), at(place + 1) - at(place + 3)];
            // The capacity is that of the problem: nothing is refused.
            let _ = self.normal.push(at(i));
            let _ = self.tangential.push(pair);
            let _ = self.slip.push(at(5 * count + i));
            for (k, change) in self.velocity_change.iter_mut().enumerate() {
                let row = |row: &[R; ND]| row.get(k).copied().unwrap_or(R::zero());
                *change += row(&contact.normal) * at(i)
                    + row(&contact.tangents[0]) * pair[0]
                    + row(&contact.tangents[1]) * pair[1];
            }
        }
        for (change, &inverse) in self.velocity_change.iter_mut().zip(&problem.inverse_mass) {
            *change *= inverse;
        }
    }

    /// Writes `z` in the order of the complementarity problem; the rest of `z` is untouched.
    pub fn write_unknowns(&self, z: &mut [R]) {
        let count = self.normal.len();
        let all = self.normal.iter().zip(&self.tangential).zip(&self.slip);
        for (i, ((&normal, &[first, second]), &slip)) in all.enumerate() {
            let tangents = [first, second, -first, -second];
            let places = (0..4).map(|k| count + 4 * i + k);
            if let Some(place) = z.get_mut(i) {
                *place = normal;
            }
            for (place, tangent) in places.zip(tangents) {
                if let Some(place) = z.get_mut(place) {
                    *place = max(tangent, R::zero());
                }
            }
            if let Some(place) = z.get_mut(5 * count + i) {
                *place = slip;
            }
        }
    }
}
