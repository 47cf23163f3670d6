//! The predictor over samples as they come, and what it says of each.

use std::sync::{Mutex, PoisonError};

use anyhow::Error;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip_analysis::run::live::{Live, LiveError, SampleError, limits_of_json, plan_of_json};
use stickslip_analysis::run::replay::{FLAGS, VALIDITY};
use stickslip_data::{Pose, Sample, TrialInfo, Wrench};
use stickslip_shared::predictor::{self as shared, Slip, flags};

use crate::dataset::Dataset;
use crate::errors::raised;
use crate::model::{Model, file_of};

/// `x, y, z, qw, qx, qy, qz`.
type Seven = Option<[f64; 7]>;
/// `fx, fy, fz, tx, ty, tz`.
type Six = Option<[f64; 6]>;

/// What was passed cannot be: a `ValueError`; other refusals have the exceptions of the analyses.
fn refused(error: LiveError) -> PyErr {
    match error {
        LiveError::Sample(_) | LiveError::Plan(_) | LiveError::Limits(_) => {
            PyValueError::new_err(error.to_string())
        }
        LiveError::Object(error) => raised(&error.into()),
        error => raised(&Error::from(error)),
    }
}

fn pose(numbers: Seven) -> Option<Pose> {
    numbers.map(|[x, y, z, qw, qx, qy, qz]| Pose { position_m: [x, y, z], quaternion: [qw, qx, qy, qz] })
}

fn wrench(numbers: Six) -> Option<Wrench> {
    numbers.map(|[fx, fy, fz, tx, ty, tz]| Wrench { force_n: [fx, fy, fz], torque_nm: [tx, ty, tz] })
}

/// The predictor over samples as they come.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct Predictor {
    live: Mutex<Live>,
}

impl Predictor {
    /// Without the interpreter's lock: another thread may step another predictor, or wait for this one.
    fn with<T: Send>(&self, py: Python<'_>, run: impl FnOnce(&mut Live) -> T + Send) -> T {
        py.detach(|| run(&mut self.live.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Predictor {
    /// Of the rig of `data`; plan and limits are JSON.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn begin(
        data: &Dataset,
        object: String,
        primitive: String,
        model: Option<&Model>,
        plan: &str,
        limits: &str,
        grip_n: Option<f64>,
        pusher: Seven,
        ordinal: usize,
    ) -> PyResult<Self> {
        let plan = plan_of_json(plan).map_err(|error| refused(error.into()))?;
        let limits = limits_of_json(limits).map_err(refused)?;
        if grip_n.is_some_and(|grip_n| !(grip_n.is_finite() && grip_n >= 0.0)) {
            return Err(PyValueError::new_err("grip_n is no grip force; give newtons, zero or above"));
        }
        let pusher = pose(pusher).map(Pose::normalised).transpose();
        let pusher =
            pusher.map_err(|norm| refused(SampleError::QuaternionNorm { what: "pusher", norm }.into()))?;
        let info =
            TrialInfo { trial: "live".into(), object, primitive, grip_n, pusher, ..TrialInfo::default() };
        let model = file_of(model).to_model();
        let live = Live::new(&data.index.description, &info, ordinal, plan, &model, limits);
        Ok(Self { live: Mutex::new(live.map_err(refused)?) })
    }

    /// One sample.
    #[allow(clippy::too_many_arguments)]
    fn step(
        &self,
        py: Python<'_>,
        t_s: f64,
        finger1: Six,
        finger2: Six,
        gripper: Seven,
        object: Seven,
        grip_n: Option<f64>,
        pusher: Seven,
    ) -> PyResult<Prediction> {
        let sample = Sample {
            t_s,
            grip_cmd_n: grip_n,
            gripper: pose(gripper),
            object: pose(object),
            pusher: pose(pusher),
            finger: [wrench(finger1), wrench(finger2)],
            pusher_wrench: None,
        };
        match self.with(py, |live| live.step(&sample)) {
            Ok(prediction) => Ok(Prediction { t_s, prediction }),
            Err(error) => Err(refused(error.into())),
        }
    }

    /// A plan as JSON, from a time of the samples on.
    fn set_plan(&self, py: Python<'_>, plan: &str, from_s: Option<f64>) -> PyResult<()> {
        if from_s.is_some_and(|from_s| !from_s.is_finite()) {
            return Err(PyValueError::new_err(
                "from_s is not finite; give a time in the samples' clock, or None",
            ));
        }
        let plan = plan_of_json(plan).map_err(|error| refused(error.into()))?;
        self.with(py, |live| live.set_plan(plan, from_s));
        Ok(())
    }

    /// Forgets object, clock and plan.
    fn restart(&self, py: Python<'_>) {
        self.with(py, Live::restart);
    }

    /// Forgets what was learnt of the friction.
    fn reset_friction(&self, py: Python<'_>) {
        self.with(py, Live::reset_friction);
    }

    /// Hash of every output word, hexadecimal.
    #[getter]
    fn hash(&self, py: Python<'_>) -> String {
        format!("{:08x}", self.with(py, |live| live.hash()))
    }
}

/// Names of the bits that are set.
fn named(word: u32, names: &[&'static str]) -> Vec<&'static str> {
    names.iter().enumerate().filter(|(bit, _)| word >> bit & 1 == 1).map(|(_, name)| *name).collect()
}

/// What the predictor says of one sample: the fields of a replay, in SI units; does not change.
///
/// `None`: not measured, or not foreseen. Flags that are up while `unsure` is up, and those that are not, cannot be
/// relied on; `doubts` says why.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct Prediction {
    t_s: f64,
    prediction: shared::Prediction,
}

impl Prediction {
    fn any(&self, mask: u32) -> bool {
        self.prediction.flags & mask != 0
    }
}

#[pymethods]
impl Prediction {
    /// Time of the sample, s.
    #[getter]
    fn t_s(&self) -> f64 {
        self.t_s
    }

    /// A finger slips now.
    #[getter]
    fn slip(&self) -> bool {
        self.any(flags::SLIP_1 | flags::SLIP_2)
    }

    /// A finger will slip within the horizon.
    #[getter]
    fn slip_ahead(&self) -> bool {
        self.any(flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2)
    }

    /// Slip, now or ahead, that the plan does not intend.
    #[getter]
    fn unexpected(&self) -> bool {
        self.any(flags::UNEXPECTED)
    }

    /// Sag beyond its limit, now or ahead.
    #[getter]
    fn sag(&self) -> bool {
        self.any(flags::SAG)
    }

    /// Rotation in the grasp beyond its limit.
    #[getter]
    fn rotation(&self) -> bool {
        self.any(flags::ROTATION)
    }

    /// The grasp will be lost within the horizon.
    #[getter]
    fn drop(&self) -> bool {
        self.any(flags::DROP)
    }

    /// The object touches the pusher.
    #[getter]
    fn pushing(&self) -> bool {
        self.any(flags::PUSHING)
    }

    /// The flags cannot be relied on, raised or not.
    #[getter]
    fn unsure(&self) -> bool {
        self.any(flags::UNSURE)
    }

    /// Names of the flags that are up, as in a replay's report.
    #[getter]
    fn flags(&self) -> Vec<&'static str> {
        named(self.prediction.flags, &FLAGS)
    }

    /// Names of the reasons to doubt the prediction, as in a replay's report.
    #[getter]
    fn doubts(&self) -> Vec<&'static str> {
        named(self.prediction.validity, &VALIDITY)
    }

    /// The word of the flags, as in a replay's columns (docs/protocol.md).
    #[getter]
    fn flag_bits(&self) -> u32 {
        self.prediction.flags
    }

    /// The word of the doubts, as in a replay's columns (docs/protocol.md).
    #[getter]
    fn validity_bits(&self) -> u32 {
        self.prediction.validity
    }

    /// Finger 1 (+Y), finger 2 (-Y).
    #[getter]
    fn fingers(&self) -> (FingerPrediction, FingerPrediction) {
        let [one, two] = self.prediction.finger;
        (FingerPrediction(one), FingerPrediction(two))
    }

    /// Share of the friction limit in use, of the finger that uses more: by its sensor, otherwise by the model.
    #[getter]
    fn utilisation(&self) -> f64 {
        let used = |f: &shared::FingerPrediction| f.measured_utilisation.unwrap_or(f.model_utilisation);
        self.prediction.finger.iter().map(used).map(f64::from).fold(0.0, f64::max)
    }

    /// Time until a finger slips, s; 0 while one does; None: not within the horizon.
    #[getter]
    fn slip_in_s(&self) -> Option<f64> {
        self.prediction.finger.iter().filter_map(|f| f.slip.in_s()).reduce(f32::min).map(f64::from)
    }

    /// Time until the grasp is lost, s; None: not within the horizon.
    #[getter]
    fn drop_in_s(&self) -> Option<f64> {
        self.prediction.drop_in_s.map(f64::from)
    }

    /// Grip force of each finger that keeps the target utilisation, N; None where the plan does not mean to hold.
    #[getter]
    fn holding_grip_n(&self) -> Option<f64> {
        self.prediction.holding_grip_n.map(f64::from)
    }

    /// Probability that the friction suffices now and within the horizon; None where the plan does not mean to hold,
    /// while it slips, and without a usable wrench.
    #[getter]
    fn hold_probability(&self) -> Option<f64> {
        self.prediction.hold_probability.map(f64::from)
    }

    /// Friction coefficient of the fingers, learnt on-line: the median.
    #[getter]
    fn friction(&self) -> f64 {
        self.prediction.friction.into()
    }

    /// The friction is above this with the probability 0.9875; `holding_grip_n` counts on it.
    #[getter]
    fn friction_least(&self) -> f64 {
        self.prediction.friction_least.into()
    }

    /// Downward motion in the grasp since the start that was not intended, m.
    #[getter]
    fn sag_m(&self) -> f64 {
        self.prediction.sag_m.into()
    }

    /// Sag expected at the end of the horizon, m.
    #[getter]
    fn sag_ahead_m(&self) -> f64 {
        self.prediction.sag_ahead_m.into()
    }

    /// Rotation in the grasp since the start, rad.
    #[getter]
    fn rotation_rad(&self) -> f64 {
        self.prediction.rotation_rad.into()
    }

    /// The object in the grasp by the model: x, y, z (m), qw, qx, qy, qz in the gripper's frame.
    #[getter]
    fn pose(&self) -> [f64; 7] {
        let ([x, y, z], [qw, qx, qy, qz]) = (self.prediction.position_m, self.prediction.quaternion);
        [x, y, z, qw, qx, qy, qz].map(f64::from)
    }

    /// Force of the pusher on the object by the model, N, world axes.
    #[getter]
    fn pusher_force_n(&self) -> [f64; 3] {
        self.prediction.pusher_force_n.map(f64::from)
    }

    /// The wrench of each finger on the object by the model: fx, fy, fz (N), tx, ty, tz (N m), gripper axes.
    #[getter]
    fn finger_wrench(&self) -> [[f64; 6]; 2] {
        self.prediction.finger_wrench.map(|wrench| wrench.map(f64::from))
    }

    /// How the contact problems of the tick ended: `solved`, or the worst.
    #[getter]
    fn solver_status(&self) -> &'static str {
        self.prediction.solver_status.name()
    }

    /// Largest momentum error of the tick's solves, N.
    #[getter]
    fn solver_residual_n(&self) -> f64 {
        self.prediction.solver_residual_n.into()
    }

    /// Newton steps of the tick.
    #[getter]
    fn solver_iterations(&self) -> u16 {
        self.prediction.solver_iterations
    }

    /// All of it as a dictionary, `fingers` as a list of two: for JSON.
    fn to_dict<'py>(of: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let made = dictionary(of.as_any(), &OF_PREDICTION)?;
        let (one, two) = of.get().fingers();
        let each = [one, two].map(|finger| dictionary(Bound::new(of.py(), finger)?.as_any(), &OF_FINGER));
        let [one, two] = each;
        made.set_item("fingers", [one?, two?])?;
        Ok(made)
    }

    fn __repr__(&self) -> String {
        let flags = self.flags().join("; ");
        let up = if flags.is_empty() { "no flag" } else { &flags };
        format!("<stickslip.Prediction at {} s: {up}; utilisation {:.2}>", self.t_s, self.utilisation())
    }
}

/// Names of a prediction's properties, in order of its dictionary.
const OF_PREDICTION: [&str; 29] = [
    "t_s",
    "flags",
    "doubts",
    "slip",
    "slip_ahead",
    "unexpected",
    "sag",
    "rotation",
    "drop",
    "pushing",
    "unsure",
    "utilisation",
    "slip_in_s",
    "drop_in_s",
    "holding_grip_n",
    "hold_probability",
    "friction",
    "friction_least",
    "sag_m",
    "sag_ahead_m",
    "rotation_rad",
    "pose",
    "finger_wrench",
    "pusher_force_n",
    "solver_status",
    "solver_residual_n",
    "solver_iterations",
    "flag_bits",
    "validity_bits",
];

/// The same of a finger.
const OF_FINGER: [&str; 7] = [
    "slip",
    "slip_in_s",
    "slip_speed_m_s",
    "slip_direction_rad",
    "measured_utilisation",
    "model_utilisation",
    "peak_utilisation",
];

fn dictionary<'py>(of: &Bound<'py, PyAny>, names: &[&str]) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(of.py());
    for name in names {
        made.set_item(name, of.getattr(*name)?)?;
    }
    Ok(made)
}

/// What the predictor says of one finger; does not change.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct FingerPrediction(shared::FingerPrediction);

#[pymethods]
impl FingerPrediction {
    /// It slips now.
    #[getter]
    fn slip(&self) -> bool {
        self.0.slip == Slip::Now
    }

    /// Time until it slips, s; 0 while it does; None: not within the horizon.
    #[getter]
    fn slip_in_s(&self) -> Option<f64> {
        self.0.slip.in_s().map(f64::from)
    }

    /// Slip speed by the model, m/s; 0 while it sticks.
    #[getter]
    fn slip_speed_m_s(&self) -> f64 {
        self.0.slip_speed_m_s.into()
    }

    /// Direction of the slip, now or predicted: angle in the finger's plane from gripper X towards gripper Z, rad.
    #[getter]
    fn slip_direction_rad(&self) -> f64 {
        self.0.slip_direction_rad.into()
    }

    /// Share of the friction limit in use by the measured wrench; None: not measured.
    #[getter]
    fn measured_utilisation(&self) -> Option<f64> {
        self.0.measured_utilisation.map(f64::from)
    }

    /// The same by the model.
    #[getter]
    fn model_utilisation(&self) -> f64 {
        self.0.model_utilisation.into()
    }

    /// Largest share that the look-ahead foresees.
    #[getter]
    fn peak_utilisation(&self) -> f64 {
        self.0.peak_utilisation.into()
    }

    /// All of it as a dictionary.
    fn to_dict<'py>(of: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(of.as_any(), &OF_FINGER)
    }

    fn __repr__(&self) -> String {
        let slip = self.slip_in_s().map_or("sticks".to_owned(), |t_s| match self.slip() {
            true => "slips".to_owned(),
            false => format!("slips in {t_s:.3} s"),
        });
        format!("<stickslip.FingerPrediction {slip}; peak utilisation {:.2}>", self.peak_utilisation())
    }
}
