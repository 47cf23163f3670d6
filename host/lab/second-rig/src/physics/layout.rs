//! Where the elements of a patch are, which share of the area and of the load each carries.
//!
//! A disc is integrated by Gauss-Legendre rings, so that area, polar moment and the torque of pure
//! spin under uniform pressure (2/3 mu N R) are exact.

use nalgebra::Vector3;
use serde::Serialize;
use std::f64::consts::TAU;

/// How the load spreads over a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// Flat punch on a soft foundation.
    Uniform,
    /// Half ellipsoid, sqrt(1 - r2/R2).
    Hertz,
    /// exp(-2 r2/R2).
    Gaussian,
}

impl Profile {
    fn at(self, share: f64) -> f64 {
        match self {
            Profile::Uniform => 1.0,
            Profile::Hertz => (1.0 - share * share).max(0.0).sqrt(),
            Profile::Gaussian => (-2.0 * share * share).exp(),
        }
    }
}

/// One element.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// In the tool's frame, or in the object's where the object carries the elements, m.
    pub position: Vector3<f64>,
    /// Share of tangential stiffness; all sum to 1.
    pub area: f64,
    /// Share of normal stiffness; all sum to 1.
    pub load: f64,
}

/// Makes both shares sum to 1.
pub fn normalised(mut elements: Vec<Element>) -> Vec<Element> {
    let area: f64 = elements.iter().map(|e| e.area).sum();
    let load: f64 = elements.iter().map(|e| e.load).sum();
    for e in &mut elements {
        e.area /= area;
        e.load /= load;
    }
    elements
}

/// Nodes and weights of Gauss-Legendre on 0 to 1.
const RINGS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];

/// A disc in the plane of X and Z.
pub fn disc(radius_m: f64, profile: Profile, phase_rad: f64) -> Vec<Element> {
    let counts = [4, 8, 12];
    let mut out = Vec::new();
    for (k, (node, weight)) in RINGS.iter().enumerate() {
        let n = counts[k];
        for i in 0..n {
            let angle = TAU * i as f64 / n as f64 + phase_rad * (1.0 + k as f64);
            let r = node * radius_m;
            let area = weight * node / n as f64;
            let position = Vector3::new(r * angle.cos(), 0.0, r * angle.sin());
            out.push(Element { position, area, load: area * profile.at(*node) });
        }
    }
    normalised(out)
}

/// Torque of pure spin over mu N R of a disc with this pressure: 2/3 where it is uniform.
pub fn torsion_share(profile: Profile) -> f64 {
    disc(1.0, profile, 0.0).iter().map(|e| e.load * e.position.norm_squared().sqrt()).sum()
}

/// A line along `axis` through the origin.
pub fn line(axis: Vector3<f64>, length_m: f64, count: usize, profile: Profile) -> Vec<Element> {
    let element = |i: usize| {
        let x = (2.0 * i as f64 + 1.0) / count as f64 - 1.0;
        Element { position: axis * (0.5 * length_m * x), area: 1.0, load: profile.at(x.abs()) }
    };
    normalised((0..count).map(element).collect())
}

/// Nodes and weights of Gauss-Lobatto on each half of -1 to 1, with four and three nodes a half: the rim is included, area, mean
/// distance from the middle and its square are exact.
const SEVEN: &[(f64, f64)] = &[
    (-1.0, 1.0 / 12.0),
    (-0.723_606_797_749_979, 5.0 / 12.0),
    (-0.276_393_202_250_021, 5.0 / 12.0),
    (0.0, 2.0 / 12.0),
    (0.276_393_202_250_021, 5.0 / 12.0),
    (0.723_606_797_749_979, 5.0 / 12.0),
    (1.0, 1.0 / 12.0),
];
const FIVE: [(f64, f64); 5] =
    [(-1.0, 1.0 / 6.0), (-0.5, 4.0 / 6.0), (0.0, 2.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)];

/// Intervals along the side of a plate that an object turns about: one of 1e6 N/m that bears 20 N may touch on a tenth of it.
const INTERVALS: usize = 24;

/// Even nodes of -1 to 1, rim included, with Gregory's weights: a cubic is integrated exactly, and all weights are positive.
fn gregory(k: usize) -> (f64, f64) {
    let weight = match k.min(INTERVALS - k) {
        0 => 3.0 / 8.0,
        1 => 7.0 / 6.0,
        2 => 23.0 / 24.0,
        _ => 1.0,
    };
    (2.0 * k as f64 / INTERVALS as f64 - 1.0, weight * 2.0 / INTERVALS as f64)
}

/// A rectangle spanned by two half sides about a centre, rim included: seven elements along the first, five along the second.
/// Its radius of gyration is that of an even pressure, so that the even case hides nothing.
pub fn rectangle(centre: Vector3<f64>, half: [Vector3<f64>; 2]) -> Vec<Element> {
    spanned(centre, half, FIVE.into_iter())
}

/// The same with 25 elements along the second side, about whose rim an object turns.
pub fn plate(centre: Vector3<f64>, half: [Vector3<f64>; 2]) -> Vec<Element> {
    spanned(centre, half, (0..=INTERVALS).map(gregory))
}

fn spanned(
    centre: Vector3<f64>,
    half: [Vector3<f64>; 2],
    second: impl Iterator<Item = (f64, f64)> + Clone,
) -> Vec<Element> {
    let mut out = Vec::new();
    for (x, a) in SEVEN {
        for (y, b) in second.clone() {
            out.push(Element { position: centre + half[0] * *x + half[1] * y, area: a * b, load: a * b });
        }
    }
    normalised(out)
}

/// Moves the centre of pressure by `offset_m` (in the plane of X and Z): the stiffness grows
/// linearly towards that side. Elements that would pull carry nothing.
pub fn shift_pressure(elements: Vec<Element>, offset_m: [f64; 2]) -> Vec<Element> {
    let second = |f: fn(&Vector3<f64>) -> f64| {
        elements.iter().map(|e| e.load * f(&e.position) * f(&e.position)).sum::<f64>()
    };
    let (xx, zz) = (second(|p| p.x).max(1e-12), second(|p| p.z).max(1e-12));
    let moved = elements.iter().map(|e| {
        let factor = 1.0 + offset_m[0] * e.position.x / xx + offset_m[1] * e.position.z / zz;
        Element { load: e.load * factor.max(0.0), ..*e }
    });
    normalised(moved.collect())
}
