"""The native part; use `stickslip`."""

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__version__: str

class StickslipError(Exception):
    """What stickslip refuses; the text says what to do."""

class DataError(StickslipError):
    """A data set or a recording that cannot be read or made."""

class ModelError(StickslipError):
    """A model, formula or effect that is wrong or unknown."""

class AnalysisError(StickslipError):
    """An analysis that cannot be made of these data."""

_Told = Callable[[str, int, int], object] | None

class Dataset:
    @staticmethod
    def open(folder: str) -> Dataset: ...
    @staticmethod
    def from_memory(
        description: str, rows: str, tables: Sequence[tuple[str, Sequence[tuple[str, NDArray[np.float64]]]]]
    ) -> Dataset: ...
    @staticmethod
    def rig_of_file(file: str) -> Dataset: ...
    @staticmethod
    def rig_of_description(description: str) -> Dataset: ...
    @property
    def name(self) -> str: ...
    @property
    def folder(self) -> os.PathLike[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def refused(self) -> list[str]: ...
    @property
    def description(self) -> str: ...
    def trials(self) -> list[dict[str, Any]]: ...
    def columns(self, trial: str | None) -> dict[str, NDArray[np.float64]]: ...
    def write(self, folder: str, tables: str) -> None: ...

class Model:
    @staticmethod
    def default() -> Model: ...
    @staticmethod
    def read(path: str) -> Model: ...
    @staticmethod
    def parse(text: str, name: str) -> Model: ...
    def called(self, name: str) -> Model: ...
    @property
    def name(self) -> str: ...
    @property
    def friction(self) -> list[tuple[str, float]]: ...
    @property
    def friction_intervals(self) -> list[tuple[str, list[float]]]: ...
    @property
    def effects(self) -> list[tuple[str, list[tuple[str, float]]]]: ...
    def text(self) -> str: ...

class Predictor:
    @staticmethod
    def begin(
        data: Dataset,
        object: str,
        primitive: str,
        model: Model | None,
        plan: str,
        limits: str,
        grip_n: float | None,
        pusher: Sequence[float] | None,
        ordinal: int,
    ) -> Predictor: ...
    def step(
        self,
        t_s: float,
        finger1: Sequence[float] | None,
        finger2: Sequence[float] | None,
        gripper: Sequence[float] | None,
        object: Sequence[float] | None,
        grip_n: float | None,
        pusher: Sequence[float] | None,
    ) -> Prediction: ...
    def set_plan(self, plan: str, from_s: float | None) -> None: ...
    def restart(self) -> None: ...
    def reset_friction(self) -> None: ...
    @property
    def hash(self) -> str: ...

class FingerPrediction:
    """What the predictor says of one finger; does not change."""
    @property
    def slip(self) -> bool:
        """It slips now."""
    @property
    def slip_in_s(self) -> float | None:
        """Time until it slips, s; 0 while it does; None: not within the horizon."""
    @property
    def slip_speed_m_s(self) -> float:
        """Slip speed by the model, m/s; 0 while it sticks."""
    @property
    def slip_direction_rad(self) -> float:
        """Direction of the slip, now or predicted: angle in the finger's plane from gripper X towards gripper Z, rad."""
    @property
    def measured_utilisation(self) -> float | None:
        """Share of the friction limit in use by the measured wrench; None: not measured."""
    @property
    def model_utilisation(self) -> float:
        """The same by the model."""
    @property
    def peak_utilisation(self) -> float:
        """Largest share that the look-ahead foresees."""
    def to_dict(self) -> dict[str, Any]:
        """All of it as a dictionary."""

class Prediction:
    """What the predictor says of one sample: the fields of a replay, in SI units; does not change.

    `None`: not measured, or not foreseen. Flags that are up while `unsure` is up, and those that are not, cannot be
    relied on; `doubts` says why.
    """
    @property
    def t_s(self) -> float:
        """Time of the sample, s."""
    @property
    def slip(self) -> bool:
        """A finger slips now."""
    @property
    def slip_ahead(self) -> bool:
        """A finger will slip within the horizon."""
    @property
    def unexpected(self) -> bool:
        """Slip, now or ahead, that the plan does not intend."""
    @property
    def sag(self) -> bool:
        """Sag beyond its limit, now or ahead."""
    @property
    def rotation(self) -> bool:
        """Rotation in the grasp beyond its limit."""
    @property
    def drop(self) -> bool:
        """The grasp will be lost within the horizon."""
    @property
    def pushing(self) -> bool:
        """The object touches the pusher."""
    @property
    def unsure(self) -> bool:
        """The flags cannot be relied on, raised or not."""
    @property
    def flags(self) -> list[str]:
        """Names of the flags that are up, as in a replay's report."""
    @property
    def doubts(self) -> list[str]:
        """Names of the reasons to doubt the prediction, as in a replay's report."""
    @property
    def flag_bits(self) -> int:
        """The word of the flags, as in a replay's columns (docs/protocol.md)."""
    @property
    def validity_bits(self) -> int:
        """The word of the doubts, as in a replay's columns (docs/protocol.md)."""
    @property
    def fingers(self) -> tuple[FingerPrediction, FingerPrediction]:
        """Finger 1 (+Y), finger 2 (-Y)."""
    @property
    def utilisation(self) -> float:
        """Share of the friction limit in use, of the finger that uses more: by its sensor, otherwise by the model."""
    @property
    def slip_in_s(self) -> float | None:
        """Time until a finger slips, s; 0 while one does; None: not within the horizon."""
    @property
    def drop_in_s(self) -> float | None:
        """Time until the grasp is lost, s; None: not within the horizon."""
    @property
    def holding_grip_n(self) -> float | None:
        """Grip force of each finger that keeps the target utilisation, N; None where the plan does not mean to hold."""
    @property
    def hold_probability(self) -> float | None:
        """Probability that the friction suffices now and within the horizon; None where the plan does not mean to hold, while it slips, and without a usable wrench."""
    @property
    def friction(self) -> float:
        """Friction coefficient of the fingers, learnt on-line: the median."""
    @property
    def friction_least(self) -> float:
        """The friction is above this with the probability 0.9875; `holding_grip_n` counts on it."""
    @property
    def sag_m(self) -> float:
        """Downward motion in the grasp since the start that was not intended, m."""
    @property
    def sag_ahead_m(self) -> float:
        """Sag expected at the end of the horizon, m."""
    @property
    def rotation_rad(self) -> float:
        """Rotation in the grasp since the start, rad."""
    @property
    def pose(self) -> list[float]:
        """The object in the grasp by the model: x, y, z (m), qw, qx, qy, qz in the gripper's frame."""
    @property
    def pusher_force_n(self) -> list[float]:
        """Force of the pusher on the object by the model, N, world axes."""
    @property
    def finger_wrench(self) -> list[list[float]]:
        """The wrench of each finger on the object by the model: fx, fy, fz (N), tx, ty, tz (N m), gripper axes."""
    @property
    def solver_status(self) -> str:
        """How the contact problems of the tick ended: `solved`, or the worst."""
    @property
    def solver_residual_n(self) -> float:
        """Largest momentum error of the tick's solves, N."""
    @property
    def solver_iterations(self) -> int:
        """Newton steps of the tick."""
    def to_dict(self) -> dict[str, Any]:
        """All of it as a dictionary, `fingers` as a list of two: for JSON."""

class Report:
    @property
    def json(self) -> str: ...
    @property
    def has_page(self) -> bool: ...
    def html(self) -> str | None: ...
    def models(self) -> list[Model]: ...
    def take_data(self) -> Dataset | None: ...
    def columns(self) -> dict[str, Any] | None: ...

def command(words: Sequence[str]) -> int:
    """The command `stickslip` with these words; its exit code."""

def effect_names() -> list[str]:
    """Names of the effects that a model can have."""

def check(data: Dataset, told: _Told) -> Report: ...
def calibrate(
    data: Dataset, model: Model | None, share: float, primitive: str | None, told: _Told
) -> Report: ...
def compare(
    data: Dataset,
    models: Sequence[Model],
    trial: str | None,
    held_out: str | None,
    tare: bool,
    force_bands: bool,
    told: _Told,
) -> Report: ...
def import_recording(mapping: str) -> tuple[Dataset, Report]: ...
def diagnose(data: Dataset, model: Model | None, formulas: str | None, told: _Told) -> Report: ...
def add(
    data: Dataset, effects: Sequence[str], model: Model | None, formulas: str | None, told: _Told
) -> Report: ...
def refit(data: Dataset, model: Model, told: _Told) -> Report: ...
def suggest(
    data: Dataset,
    model: Model | None,
    between: Sequence[str],
    formulas: str | None,
    runs: int | None,
    told: _Told,
) -> Report: ...
def score(
    data: Dataset, model: Model | None, object_pose: str, ratio: float, rate_n_s: float, told: _Told
) -> Report: ...
def replay(
    data: Dataset, trial: str | None, model: Model | None, told: _Told
) -> tuple[Report, list[str]]: ...
def simulate(
    data: Dataset, model: Model | None, out: str | None, tables: str, told: _Told
) -> Report: ...
