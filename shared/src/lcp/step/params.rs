//! Constants of the pyramids and of their solution.

use crate::real::Real;

/// How a point's pyramid is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstEdge<R> {
    /// Each point's follows its slip, or, while it sticks, the load.
    Slip,
    /// All at this angle from the point's first tangent, given as cosine and sine: for studies of what
    /// pyramids do.
    Fixed([R; 2]),
}

/// Friction pyramids, and how their problem is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PyramidParams<R: Real> {
    /// 8: edges, 4, 8 or 16. Friction across the load of a point that sticks is at least `cos(pi / edges)` of the
    /// cone's (0.924 for 8); along the load, and of a point that slides, it is the cone's. Doubled: 0.981, and up to twice
    /// the kinks on the path. Halved: 0.707, a third of the kinks, and a disc that spins under a small force is off by
    /// a fifth.
    pub edges: u8,
    /// How they are turned.
    pub first_edge: FirstEdge<R>,
    /// Whether the pyramid's faces touch the cone instead of its edges.
    pub circumscribed: bool,
    /// 4: paths followed from one start: the first leads to the answer but for rounding. Doubled: no change.
    pub paths: u8,
    /// 3: steps with the same equations that take out what rounding left. Doubled: no change.
    pub polish_steps: u8,
    /// 4: most times that pyramids are turned to the slip found and the problem solved again; mostly none or one. Halved: slip that turns fast
    /// is followed with chatter.
    pub turns: u8,
    /// 32: roundings of the largest velocity times the stiffness that the tolerance allows for, as for the
    /// cone. Doubled: rigid contacts count as solved with twice the leftover that `f32` cannot avoid.
    pub roundings: R,
    /// 0.01: least ratio of the coefficients of friction along the two tangents; a smaller one is raised to it. Doubled:
    /// friction below a fiftieth of that across it is raised.
    pub min_friction_ratio: R,
}

impl<R: Real> Default for PyramidParams<R> {
    fn default() -> Self {
        Self {
            edges: 8,
            first_edge: FirstEdge::Slip,
            circumscribed: false,
            paths: 4,
            polish_steps: 3,
            turns: 4,
            roundings: R::of(32.0),
            min_friction_ratio: R::of(0.01),
        }
    }
}
