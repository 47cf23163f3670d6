"""The commands as functions."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Union

from . import _stickslip
from ._dataset import Dataset
from ._model import Model, native
from ._report import Report
from ._warning import warn

Path = Union[str, "os.PathLike[str]"]
Data = Union[Dataset, str, "os.PathLike[str]"]
AnyModel = Union[Model, str, "os.PathLike[str]", None]
# Called with the stage, the steps done and the steps in all.
Progress = Union[Callable[[str, int, int], object], None]


def _data(data: Data) -> _stickslip.Dataset:
    if isinstance(data, Dataset):
        return data._native
    if isinstance(data, (str, os.PathLike)):
        return Dataset.read(data)._native
    raise TypeError(f"data is a stickslip.Dataset or the folder of one, not {type(data).__name__}")


def _file(path: Path | None) -> str | None:
    return None if path is None else os.fspath(path)


def _refused(before: set[str], data: _stickslip.Dataset, report: Report) -> None:
    """Warns of what was refused on the way, and of trials that were left out."""
    texts = dict.fromkeys([*data.refused, *(report._data.get("refused") or [])])
    warn(f"refused: {text}" for text in texts if text not in before)
    for result in report._data.get("results") or [report._data]:
        left_out = [*result.get("left_out", []), *result.get("skipped", [])]
        warn(f"left out: trial {one['trial']}: {one['reason']}" for one in left_out[:20])
        if len(left_out) > 20:
            warn([f"left out: {len(left_out) - 20} more trials; the report lists all"])


def check(data: Data, *, progress: Progress = None) -> Report:
    """What a data set holds and whether it can be trusted: trials, noise, balance of forces, units, signs, clocks.

    ``report.findings``: what physics does not allow; ``report.errors``: what was refused. Both empty: no errors.
    """
    of = _data(data)
    before = set(of.refused)
    report = Report(_stickslip.check(of, progress))
    _refused(before, of, report)
    return report


def calibrate(
    data: Data,
    model: AnyModel = None,
    *,
    share: float = 0.1,
    primitive: str | None = None,
    progress: Progress = None,
) -> Report:
    """Fits friction to a ``share`` of the trials (at least eight) and validates it on the rest.

    ``report.model`` has the best determined friction of all primitives, ``report.models`` each primitive's;
    ``report.results`` has estimates with 95 % intervals, errors and remarks of each.
    """
    of = _data(data)
    before = set(of.refused)
    found = _stickslip.calibrate(of, native(model), share, primitive, progress)
    best, *each = [Model._of(made) for made in found.models()]
    report = Report(found, model=best, models={made.name: made for made in each})
    _refused(before, of, report)
    return report


def compare(
    data: Data,
    models: AnyModel | list[AnyModel] | tuple[AnyModel, ...] = None,
    *,
    trial: str | None = None,
    held_out: float | Sequence[str] | None = None,
    tare: bool = True,
    force_bands: bool = True,
    progress: Progress = None,
) -> Report:
    """Where a model and the measurements differ, by channel and phase; with two models, before and after.

    Without a model, friction is calibrated on at most twelve trials of each primitive. ``held_out``: compare only
    this share of the conditions, or these trials, and calibrate on none of them. ``tare=False``: use the
    measurements as recorded. ``force_bands=False``: count the whole residual as error, also where rigid contact
    leaves a force undetermined.
    """
    listed = models if isinstance(models, (list, tuple)) else [models]
    ready = [made for made in map(native, listed) if made is not None]
    ids = None
    if held_out is not None:
        ids = str(held_out) if isinstance(held_out, (int, float, str)) else ",".join(held_out)
    of = _data(data)
    before = set(of.refused)
    report = Report(_stickslip.compare(of, ready, trial, ids, tare, force_bands, progress))
    _refused(before, of, report)
    return report


def diagnose(
    data: Data, model: AnyModel = None, *, formulas: Path | None = None, progress: Progress = None
) -> Report:
    """Which physical effect ``model`` lacks: verdict, sentence, probabilities, what these data leave open.

    ``formulas``: a file with more candidates. ``report.model``: the model with the effect; ``None`` where no
    effect is named.
    """
    of = _data(data)
    before = set(of.refused)
    found = _stickslip.diagnose(of, native(model), _file(formulas), progress)
    better = [Model._of(made) for made in found.models()]
    report = Report(found, model=better[0] if better else None)
    _refused(before, of, report)
    return report


def add(
    data: Data,
    effects: str | Sequence[str],
    model: AnyModel = None,
    *,
    formulas: Path | None = None,
    progress: Progress = None,
) -> Report:
    """``model`` with one or more effects, all parameters fitted together: ``report.model``, ``report.parameters``.

    :func:`effect_names` lists the effects; ``formulas``: a file with more.
    """
    names = [effects] if isinstance(effects, str) else list(effects)
    of = _data(data)
    before = set(of.refused)
    found = _stickslip.add(of, names, native(model), _file(formulas), progress)
    report = Report(found, model=Model._of(found.models()[0]))
    _refused(before, of, report)
    return report


def refit(data: Data, model: Model | Path, *, progress: Progress = None) -> Report:
    """All parameters of ``model`` refitted: ``report.model``, ``report.parameters``."""
    of = _data(data)
    before = set(of.refused)
    ready = native(model)
    if ready is None:
        raise TypeError("refit needs the model to fit; stickslip.Model() is the default one")
    found = _stickslip.refit(of, ready, progress)
    report = Report(found, model=Model._of(found.models()[0]))
    _refused(before, of, report)
    return report


def suggest(
    data: Data,
    model: AnyModel = None,
    *,
    between: Sequence[str] = (),
    formulas: Path | None = None,
    runs: int | None = None,
    progress: Progress = None,
) -> Report:
    """The experiments that would separate two effects; without ``between``, all that are credible.

    ``runs``: also a plan of this many trials that together give the most information (``report.plan``).
    """
    of = _data(data)
    before = set(of.refused)
    report = Report(_stickslip.suggest(of, native(model), list(between), _file(formulas), runs, progress))
    _refused(before, of, report)
    return report


def replay(
    data: Data, trial: str | None = None, model: AnyModel = None, *, progress: Progress = None
) -> Report:
    """The predictor along a recorded trial (the first, where none is named), as a board runs it.

    ``report.flags``: when slip, sag and drop were announced; ``report.columns()``: everything over time.
    """
    found, notes = _stickslip.replay(_data(data), trial, native(model), progress)
    warn(notes)
    return Report(found)


def score(
    data: Data,
    model: AnyModel = None,
    *,
    object_pose: str = "every",
    ratio: float = 0.3,
    rate_n_s: float = 20.0,
    progress: Progress = None,
) -> Report:
    """How early slip and drop are predicted, and how many alarms are false, against simple thresholds.

    ``object_pose``: the predictor gets the object's pose at ``every`` sample or at the ``start`` only. ``ratio``
    (tangential over normal force) and ``rate_n_s`` (rate of the tangential force) are the thresholds.
    """
    of = _data(data)
    before = set(of.refused)
    report = Report(_stickslip.score(of, native(model), object_pose, ratio, rate_n_s, progress))
    _refused(before, of, report)
    return report


def simulate(
    data: Data,
    model: AnyModel = None,
    *,
    out: Path | None = None,
    tables: str = "csv",
    progress: Progress = None,
) -> Report:
    """What ``model`` predicts along the recorded trials, as a data set of the same format: ``report.predicted``.

    With ``out`` it is written into that folder, new or empty (``tables``: ``csv`` or ``parquet``).
    """
    of = _data(data)
    before = set(of.refused)
    found = _stickslip.simulate(of, native(model), _file(out), tables, progress)
    made = found.take_data()
    report = Report(found, predicted=Dataset.read(out) if made is None and out is not None else _made(made))
    _refused(before, of, report)
    return report


def _made(data: _stickslip.Dataset | None) -> Dataset | None:
    return None if data is None else Dataset._of(data)
