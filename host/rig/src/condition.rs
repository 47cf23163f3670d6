//! One condition of a plan: what is done to which object.

use serde::Serialize;

/// What the gripper or the rod does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Primitive {
    /// Held object pushed along its length against a plate.
    LinearPush,
    /// Gripper turns about the finger axis while an edge holds the object.
    Pivot,
    /// Held cylinder rolled on a platform.
    Roll,
    /// Held object lifted off a table.
    Lift,
    /// Object on a table pushed by a rod.
    PlanarPush,
}

impl Primitive {
    /// Name in trials.csv.
    pub fn name(self) -> &'static str {
        match self {
            Self::LinearPush => "linear_push",
            Self::Pivot => "pivot",
            Self::Roll => "roll",
            Self::Lift => "lift",
            Self::PlanarPush => "planar_push",
        }
    }
}

/// What happens beside the command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "scenario")]
pub enum Scenario {
    /// Nothing.
    Steady,
    /// The commanded grip decays to `share` between two times.
    DecayingGrip {
        /// Of the first grip.
        share: f64,
        /// s.
        from_s: f64,
        /// s.
        until_s: f64,
    },
    /// A load that comes within 10 ms and stays half a second.
    SuddenLoad {
        /// World axes.
        force_n: [f64; 3],
        /// s.
        at_s: f64,
    },
    /// Short knocks of 40 ms every 0.7 s.
    Bumps {
        /// World axes.
        force_n: [f64; 3],
        /// s.
        from_s: f64,
    },
    /// The pads creep under load.
    SoftCreep {
        /// m/(N s).
        rate_m_n_s: f64,
    },
    /// True over told mass.
    HeavierThanTold {
        /// Factor.
        factor: f64,
    },
    /// Centre of mass away from where it is told to be.
    OffCentre {
        /// Along object X.
        offset_m: f64,
    },
    /// Friction of the fingers falls to `share` within 0.2 s.
    FrictionDrop {
        /// Of the first friction.
        share: f64,
        /// s.
        at_s: f64,
    },
    /// The plate grips: high pusher friction.
    Jam {
        /// Coefficient.
        mu_pusher: f64,
    },
}

/// One condition. What a primitive does not use is ignored.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// Name of the condition, unique in its plan; the trial's name adds the run.
    pub label: String,
    /// What is done.
    pub primitive: Primitive,
    /// Object id.
    pub object: String,
    /// Normal force of each finger, N.
    pub grip_n: f64,
    /// Speed of the push, roll, lift or rod, m/s.
    pub speed_m_s: f64,
    /// Speed of pivoting, rad/s.
    pub speed_rad_s: f64,
    /// Linear push: direction above the horizontal. Planar push: direction from the edge's normal, rad.
    pub slope_rad: f64,
    /// Pivot: edge from the object's centre along X. Planar push: contact from the edge's middle, m.
    pub pusher_offset_m: f64,
    /// Length of the motion, m (rad for a pivot).
    pub travel: f64,
    /// Rest of the closed jaw before the recording, s.
    pub rest_s: f64,
    /// Pause in the middle of the motion, s.
    pub pause_s: f64,
    /// Lift: how long the object is held up, s.
    pub hold_s: f64,
    /// Planar push: which edge of the outline is pushed.
    pub edge: usize,
    /// What happens beside the command.
    pub scenario: Scenario,
    /// Share of the plan's sliding distance that lies before this condition.
    pub worn: f64,
}

impl Condition {
    /// A condition of `primitive` with ordinary values.
    pub fn new(primitive: Primitive, object: &str) -> Self {
        let travel = match primitive {
            Primitive::Pivot => 0.5,
            Primitive::PlanarPush | Primitive::Lift => 0.05,
            Primitive::LinearPush | Primitive::Roll => 0.015,
        };
        Self {
            label: format!("{}-{object}", primitive.name()),
            primitive,
            object: object.into(),
            grip_n: 20.0,
            speed_m_s: 0.01,
            speed_rad_s: 10.0_f64.to_radians(),
            slope_rad: 0.0,
            pusher_offset_m: 0.0,
            travel,
            rest_s: 2.0,
            pause_s: 0.0,
            hold_s: 2.0,
            edge: 0,
            scenario: Scenario::Steady,
            worn: 0.0,
        }
    }
}
