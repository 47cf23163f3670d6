"""The predictor in a loop of one's own."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _stickslip
from ._dataset import FORMAT, Dataset, _plain
from ._model import Model, native
from ._report import Fields
from ._stickslip import Prediction
from ._warning import warn

# A data set, its folder, its dataset.toml, or the content of that.
Rig = Union[Dataset, str, "os.PathLike[str]", Mapping[str, Any]]
# Rows as ``replay`` has them in ``report.plan``.
Plan = Union[Sequence[Union[Mapping[str, Any], Fields]], None]

WRENCH = "6: fx, fy, fz (N), tx, ty, tz (N m)"
POSE = "7: x, y, z (m), qw, qx, qy, qz"


def _rig(rig: Rig) -> _stickslip.Dataset:
    if isinstance(rig, Dataset):
        return rig._native
    if isinstance(rig, Mapping):
        made = _stickslip.Dataset.rig_of_description(json.dumps({"format": FORMAT, **_plain(rig)}))
    elif isinstance(rig, (str, os.PathLike)):
        path = os.fspath(rig)
        made = _stickslip.Dataset.rig_of_file(os.path.join(path, "dataset.toml") if os.path.isdir(path) else path)
    else:
        raise TypeError(
            "rig is a stickslip.Dataset, its folder, a dataset.toml or the content of one, "
            f"not {type(rig).__name__}"
        )
    warn(made.notes)
    return made


def _plan(plan: Plan) -> str:
    rows = [dict(row) for row in plan or []]
    try:
        return json.dumps(_plain(rows))
    except TypeError as error:
        raise ValueError(f"the plan: {error}; give numbers, lists of numbers and the name of the intent") from None


def _numbers(what: str, values: ArrayLike | None, shape: str) -> tuple[float, ...] | None:
    """Of a wrench or a pose: so many numbers, or None."""
    if values is None:
        return None
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: not numbers; give {shape}, or None where it was not measured") from None
    if array.shape != (int(shape[0]),):
        has = "x".join(map(str, array.shape)) or "a single number"
        raise ValueError(f"{what}: the shape is {has}; give {shape}, or None where it was not measured")
    return tuple(array.tolist())


class Predictor:
    """Slip and drop, predicted sample by sample: what :func:`replay` does with a record, and a board with its sensors.

    ``rig``: a :class:`Dataset`, its folder, a dataset.toml, or its content as a dict; only the rig is used, no trials.
    ``object``: id of the object in the fingers. ``primitive``: what is done with it; it selects pusher and support of
    the rig. ``plan``: how the gripper will move, at most eight segments in the form of ``replay(...).plan``:
    ``duration_s``, ``grip_n`` (N, each finger), and where given ``velocity_m_s``, ``angular_rad_s`` (rad/s; both world
    axes, else zero) and ``intent`` (``hold``, ``slide``, ``pivot`` or ``free``, else ``hold``); it counts from the first
    sample. Without a plan the present motion is taken to go on. ``grip_n``: grip command (N) until a sample brings
    one. ``pusher``: pose of a pusher that does not move. ``limits``: what is flagged, and the range of the fingers'
    sensors (docs/python.md), as ``{"sag_m": 0.005, "force_range_n": 50.0}``; the names carry the unit. ``ordinal``:
    place of the trial in its data set, where the model has wear.

    Raises :class:`DataError` for an object that the rig does not have, :class:`ModelError` for a model file that is
    wrong, :class:`AnalysisError` where the predictor refuses rig, model or limits, ``ValueError`` for a plan that
    cannot be.

    Samples are 4 ms apart, as on a board: of a faster sensor pass every second or fourth. A pause above 0.1 s ends the
    grasp: prediction begins again with the next pose of the object.
    """

    def __init__(
        self,
        rig: Rig,
        object: str,
        model: Model | str | os.PathLike[str] | None = None,
        *,
        primitive: str = "lift",
        plan: Plan = None,
        grip_n: float | None = None,
        pusher: ArrayLike | None = None,
        limits: Mapping[str, float] | None = None,
        ordinal: int = 0,
    ) -> None:
        self._native = _stickslip.Predictor.begin(
            _rig(rig),
            object,
            primitive,
            native(model),
            _plan(plan),
            json.dumps(_plain(limits or {})),
            grip_n,
            _numbers("pusher", pusher, POSE),
            ordinal,
        )

    def step(
        self,
        t_s: float,
        finger1: ArrayLike | None = None,
        finger2: ArrayLike | None = None,
        gripper: ArrayLike | None = None,
        object: ArrayLike | None = None,
        grip_n: float | None = None,
        *,
        pusher: ArrayLike | None = None,
    ) -> Prediction:
        """The prediction at one sample. ``None``: not measured.

        ``t_s``: time of measurement, s; rises from sample to sample, from any zero. ``finger1`` (at gripper +Y) and
        ``finger2`` (at -Y): wrench of the finger **on the object**, fx, fy, fz (N), tx, ty, tz (N m), gripper axes, about
        the pad's centre; finger 1 presses towards -Y. ``gripper``, ``object``, ``pusher``: pose in the world, x, y, z (m), qw,
        qx, qy, qz. ``grip_n``: commanded normal force of each finger, N; holds until it is given anew.

        The object's pose is needed to begin; after that it may be missing. Pass a pose once, when it is new: one that is
        repeated looks as if the object stood still. The gripper's pose is needed in every sample.

        Raises ``ValueError``, and changes nothing, for a wrong shape, a number that is not finite, a quaternion whose norm
        is off by more than 1 %, a negative grip, and time that does not rise.
        """
        return self._native.step(
            t_s,
            _numbers("finger1", finger1, WRENCH),
            _numbers("finger2", finger2, WRENCH),
            _numbers("gripper", gripper, POSE),
            _numbers("object", object, POSE),
            grip_n,
            _numbers("pusher", pusher, POSE),
        )

    def set_plan(self, plan: Plan, from_s: float | None = None) -> None:
        """Replaces the plan. It counts from ``from_s`` (s, in the samples' clock), or from the newest sample."""
        self._native.set_plan(_plan(plan), from_s)

    def restart(self, plan: Plan = None) -> None:
        """Forgets object and clock, for a new grasp or a clock that was set anew; what was learnt of the friction stays.

        The next sample may have any time, and needs the object's pose. ``plan`` counts from it.
        """
        text = _plan(plan)
        self._native.restart()
        self._native.set_plan(text, None)

    def reset_friction(self) -> None:
        """Forgets what was learnt of the friction: for other pads, or an object of another surface."""
        self._native.reset_friction()

    @property
    def hash(self) -> str:
        """Hash over all bits of all predictions since the start or restart: equal to ``replay(...).hash`` of the record."""
        return self._native.hash
