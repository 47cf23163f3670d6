"""Data sets: from a folder, a recording, pandas tables, arrays."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stickslip
from ._report import Report
from ._warning import warn

if TYPE_CHECKING:
    import pandas

FORMAT = "stickslip-dataset/1"


class Dataset:
    """Recorded trials and the rig that they were recorded on (docs/dataset.md). It does not change.

    Of a folder, trials are read when an analysis needs them.
    """

    _native: _stickslip.Dataset
    _imported: Report | None

    def __init__(self) -> None:
        raise TypeError("use Dataset.read(folder), from_recording, from_pandas or from_arrays")

    @classmethod
    def _of(cls, native: _stickslip.Dataset, imported: Report | None = None) -> Dataset:
        data = cls.__new__(cls)
        data._native = native
        data._imported = imported
        return data

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> Dataset:
        """The data set in ``folder``.

        Raises :class:`DataError` where dataset.toml or trials.csv cannot be read; rows that are refused and what
        is doubtful are warnings.
        """
        native = _stickslip.Dataset.open(os.fspath(folder))
        warn([f"refused: {text}" for text in native.refused] + native.notes)
        return cls._of(native)

    @classmethod
    def from_recording(cls, mapping: str | os.PathLike[str]) -> Dataset:
        """CSV, Parquet or MCAP files of any laboratory (ROS 2 bags too), by a mapping file.

        The mapping says which columns or topics are which signals, in which units, axes and clocks
        (docs/import-recordings.md; ``stickslip new FILE...`` begins one). What was assumed is in
        :attr:`imported`; run :func:`check` on the result: it sees millimetres, turned signs, two clocks.
        """
        native, report = _stickslip.import_recording(os.fspath(mapping))
        imported = Report(report)
        rows = [f"{file}: line {row['line']}: {row['reason']}" for file, row in imported.to_dict()["bad_rows"]]
        warn([f"refused: {text}" for text in [*imported.refused, *rows[:20]]] + native.notes)
        if len(rows) > 20:
            warn([f"refused: {len(rows) - 20} more rows; data.imported.bad_rows lists all"])
        return cls._of(native, imported)

    # The mapping names the files and topics.
    from_mcap = from_recording

    @classmethod
    def from_arrays(
        cls,
        description: Mapping[str, Any],
        trials: Sequence[Mapping[str, Any]],
        samples: Mapping[str, Mapping[str, ArrayLike]],
    ) -> Dataset:
        """A data set from memory.

        ``description``: the content of dataset.toml (``format`` may be left out). ``trials``: a row of trials.csv
        each; ``None`` or NaN: not applicable. ``samples``: by trial, one-dimensional arrays of numbers by the
        names of docs/dataset.md (``t_s``, ``finger1_fx_n``, ...), all of one length; NaN: not measured.

        Raises :class:`DataError` with trial, row and column of what the format refuses.
        """
        rows = [{str(key): value for key, value in row.items() if not _empty(value)} for row in trials]
        text = io.StringIO()
        names = list(dict.fromkeys(name for row in rows for name in row))
        writer = csv.DictWriter(text, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: _text(value) for key, value in row.items()} for row in rows)
        whole = {"format": FORMAT, **_plain(description)}
        tables = []
        for trial, columns in samples.items():
            table = [(str(name), _column(f"trial {trial}", str(name), c)) for name, c in columns.items()]
            tables.append((str(trial), table))
        native = _stickslip.Dataset.from_memory(json.dumps(whole), text.getvalue(), tables)
        warn(native.notes)
        return cls._of(native)

    @classmethod
    def from_pandas(
        cls,
        description: Mapping[str, Any],
        trials: pandas.DataFrame,
        samples: pandas.DataFrame | Mapping[str, pandas.DataFrame],
    ) -> Dataset:
        """A data set from pandas tables.

        As :meth:`from_arrays`; ``samples`` is one table with a column ``trial``, or a table for each trial.
        """
        if isinstance(samples, Mapping):
            by_trial = {str(name): table for name, table in samples.items()}
        else:
            if "trial" not in samples.columns:
                raise ValueError("samples has no column trial; give it one, or a dict of a table for each trial")
            groups = samples.groupby("trial", sort=False)
            by_trial = {str(name): table.drop(columns="trial") for name, table in groups}
        rows = trials if "trial" in trials.columns else trials.rename_axis("trial").reset_index()
        records = [{str(k): v for k, v in row.items()} for row in rows.to_dict("records")]
        arrays = {
            name: {str(column): table[column].to_numpy() for column in table.columns}
            for name, table in by_trial.items()
        }
        return cls.from_arrays(description, records, arrays)

    @property
    def name(self) -> str:
        """Its name."""
        return self._native.name

    @property
    def folder(self) -> str:
        """Where it was read from; empty: memory."""
        return str(self._native.folder)

    @property
    def description(self) -> dict[str, Any]:
        """The content of dataset.toml."""
        content: dict[str, Any] = json.loads(self._native.description)
        return content

    @property
    def trials(self) -> list[dict[str, Any]]:
        """Trials with their conditions, in order."""
        return self._native.trials()

    @property
    def refused(self) -> list[str]:
        """What was refused so far: the rest is used."""
        return self._native.refused

    @property
    def imported(self) -> Report | None:
        """Of a recording: what was assumed of each signal, tares, clocks that were estimated, rows that could not be used.

        In a notebook the page of ``import recording``: look there for swapped fingers, millimetres, turned signs.
        """
        return self._imported

    def columns(self, trial: str | None = None) -> dict[str, NDArray[np.float64]]:
        """Measured columns of a trial (the first, where none is named) by their names; NaN: not measured."""
        return self._native.columns(trial)

    def to_pandas(self, trial: str | None = None) -> pandas.DataFrame:
        """The same as a pandas table."""
        import pandas

        return pandas.DataFrame(self.columns(trial))

    def write(self, folder: str | os.PathLike[str], tables: str = "csv") -> None:
        """Writes it into ``folder``, new or empty; ``tables``: ``csv`` or ``parquet``."""
        self._native.write(os.fspath(folder), tables)

    def __len__(self) -> int:
        return len(self._native.trials())

    def __repr__(self) -> str:
        return f"<stickslip.Dataset {self.name!r}: {len(self)} trials>"


def _empty(value: Any) -> bool:
    if value is None:
        return True
    try:
        return bool(np.isnan(value))
    except TypeError:
        # pandas.NA and texts have no NaN.
        return type(value).__name__ in ("NAType", "NaTType")


def _text(value: Any) -> str:
    """A cell of trials.csv; a whole number of a float column (pandas makes them) without its point."""
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return str(int(number)) if number.is_integer() and abs(number) < 2**53 else repr(number)
    return str(value)


def _plain(value: Any) -> Any:
    """For JSON: numpy's numbers and arrays as Python's, no empty keys."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inside) for key, inside in value.items() if inside is not None}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(inside) for inside in value]
    return value.item() if isinstance(value, np.generic) else value


def _column(trial: str, name: str, values: ArrayLike) -> NDArray[np.float64]:
    """A contiguous column of numbers; what is one already is not copied."""
    array = np.asarray(values)
    if array.ndim != 1:
        shape = "x".join(str(length) for length in array.shape) or "a single number"
        raise _stickslip.DataError(
            f"{trial}, column {name}: the array is {shape}; give one dimension, a number for each sample"
        )
    try:
        return np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise _stickslip.DataError(
            f"{trial}, column {name}: not numbers ({array.dtype}); give floats, NaN where nothing was measured"
        ) from None
