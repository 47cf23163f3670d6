//! The set of friction forces: a regular polygon inscribed in the disc of Coulomb's law.

use crate::real::{Real, abs, max};

/// Most edges of a polygon.
pub const MAX_EDGES: u8 = 16;
/// Directions of corners and of edges' normals: a turn in parts of half an angle of the finest polygon.
const DIRECTIONS: usize = 2 * MAX_EDGES as usize;

/// A polygon of 4, 8 or 16 edges. Corner `k` lies at the angle `2 pi k / edges` from the first tangent,
/// edge `k` leads from corner `k` to the next.
#[derive(Clone, Debug)]
pub(in crate::lcp) struct Polygon<R> {
    edges: u8,
    /// Places in `directions` from one corner to the next.
    stride: u8,
    directions: [[R; 2]; DIRECTIONS],
    /// Distance of an edge from the centre: `cos(pi / edges)` of that of a corner.
    pub apothem: R,
    /// Half the length of an edge: `sin(pi / edges)`.
    pub half: R,
    /// `tan(pi / edges)`.
    pub tangent: R,
}

impl<R: Real> Polygon<R> {
    /// The finest polygon that has no more than `edges`: 16, 8 or 4.
    pub fn new(edges: u8) -> Self {
        let (zero, one) = (R::zero(), R::one());
        // Cosines of 0 to 90 degrees in steps of 11.25.
        let quarter = [
            one,
            R::of(0.980_785_280_403_230_4),
            R::of(0.923_879_532_511_286_7),
            R::of(0.831_469_612_302_545_2),
            R::of(core::f64::consts::FRAC_1_SQRT_2),
            R::of(0.555_570_233_019_602_2),
            R::of(0.382_683_432_365_089_8),
            R::of(0.195_090_322_016_128_27),
        ];
        let mut directions = [[zero; 2]; DIRECTIONS];
        for k in 0..quarter.len() {
            let c = quarter[k];
            // The sine is the cosine of the rest to 90 degrees.
            let s = if k == 0 { zero } else { quarter[quarter.len() - k] };
            directions[k] = [c, s];
            directions[k + 8] = [-s, c];
            directions[k + 16] = [-c, -s];
            directions[k + 24] = [s, -c];
        }
        let edges = if edges >= 16 {
            16
        } else if edges >= 8 {
            8
        } else {
            4
        };
        let (apothem, half, tangent) = match edges {
            16 => (quarter[1], quarter[7], R::of(0.198_912_367_379_658)),
            8 => (quarter[2], quarter[6], R::of(0.414_213_562_373_095_1)),
            _ => (quarter[4], quarter[4], one),
        };
        Self { edges, stride: 2 * MAX_EDGES / edges, directions, apothem, half, tangent }
    }

    /// How many edges, and corners.
    pub fn edges(&self) -> u8 {
        self.edges
    }

    #[inline(always)]
    fn direction(&self, place: usize) -> [R; 2] {
        self.directions[place % DIRECTIONS]
    }

    /// Direction of a corner.
    #[inline(always)]
    pub fn corner(&self, k: u8) -> [R; 2] {
        self.direction(usize::from(k) * usize::from(self.stride))
    }

    /// Outward normal of an edge.
    #[inline(always)]
    pub fn normal(&self, k: u8) -> [R; 2] {
        self.direction(usize::from(k) * usize::from(self.stride) + usize::from(self.stride / 2))
    }

    /// Direction of an edge, from its corner to the next.
    #[inline(always)]
    pub fn along(&self, k: u8) -> [R; 2] {
        let [x, y] = self.normal(k);
        [-y, x]
    }

    /// The corner, or edge, after `k`.
    #[inline(always)]
    pub fn after(&self, k: u8) -> u8 {
        if k + 1 >= self.edges { 0 } else { k + 1 }
    }

    /// The corner, or edge, before `k`.
    #[inline(always)]
    pub fn before(&self, k: u8) -> u8 {
        if k == 0 { self.edges - 1 } else { k - 1 }
    }

    /// The corner nearest to the direction of `f`.
    pub fn nearest(&self, f: [R; 2]) -> u8 {
        let (mut best, mut most) = (0, along([R::one(), R::zero()], f));
        for k in 1..self.edges {
            let reach = along(self.corner(k), f);
            if reach > most {
                (best, most) = (k, reach);
            }
        }
        best
    }

    /// Distance from the centre to the polygon's edge along `f`, whose length is not zero, over that of a
    /// corner: `cos(pi / edges)` to 1.
    pub fn radius(&self, f: [R; 2], length: R) -> R {
        // The farthest edge is that of the first quadrant for the components' sizes.
        let size = f.map(abs);
        let mut most = along(self.normal(0), size);
        for k in 1..self.edges / 4 {
            most = max(most, along(self.normal(k), size));
        }
        self.apothem * length / most
    }
}

/// Component of `f` along `direction`.
#[inline(always)]
pub(in crate::lcp) fn along<R: Real>(direction: [R; 2], f: [R; 2]) -> R {
    direction[0] * f[0] + direction[1] * f[1]
}
