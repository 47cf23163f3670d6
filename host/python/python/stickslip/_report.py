"""Reports: the JSON documents of the commands, with attributes."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterator, Mapping
from typing import Any

from . import _stickslip


class Fields(Mapping[str, Any]):
    """Part of a report: its keys are attributes (``row.place.channel``) and items (``row["place"]``)."""

    __slots__ = ("_data",)

    def __init__(self, data: dict[str, Any]) -> None:
        self._data = data

    def __getattr__(self, name: str) -> Any:
        try:
            return _wrapped(self._data[name])
        except KeyError:
            known = ", ".join(self._data)
            raise AttributeError(f"no key {name!r} in this part of the report; it has {known}") from None

    def __getitem__(self, name: str) -> Any:
        return _wrapped(self._data[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._data]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Fields) and self._data == other._data

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return (Fields, (self._data,))

    def to_dict(self) -> dict[str, Any]:
        """As dictionaries, lists, numbers, texts; a copy."""
        copy: dict[str, Any] = json.loads(json.dumps(self._data))
        return copy

    def __repr__(self) -> str:
        inside = ", ".join(f"{key}={_short(value)}" for key, value in self._data.items())
        return f"({inside})"


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Fields(value)
    if isinstance(value, list):
        return [_wrapped(item) for item in value]
    return value


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return "{...}" if value else "{}"
    if isinstance(value, list) and value:
        if all(isinstance(item, (int, float)) for item in value) and len(value) <= 6:
            return "[" + ", ".join(_short(item) for item in value) + "]"
        return f"[{len(value)} entries]"
    return repr(value)


class Report(Fields):
    """What an analysis found.

    Its keys are those of the JSON document that the command of the same name prints; ``stickslip schema
    COMMAND`` describes what each means. In a notebook it shows its page.
    """

    __slots__ = ("_extra", "_native")

    def __init__(self, native: _stickslip.Report, **extra: Any) -> None:
        super().__init__(json.loads(native.json))
        self._native = native
        self._extra = extra

    def __getattr__(self, name: str) -> Any:
        # What is no number or text and so in no document: models, data sets.
        extra = object.__getattribute__(self, "_extra")
        return extra[name] if name in extra else super().__getattr__(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._extra]

    def __reduce__(self) -> tuple[Any, ...]:
        return (Fields, (self._data,))

    @property
    def _title(self) -> str:
        return str(self._data.get("schema", "stickslip"))

    def columns(self) -> dict[str, Any]:
        """Of ``replay``: measured, modelled and predicted values over time as arrays, by name.

        The columns are those of the command's ``--series``; NaN where nothing was measured.
        """
        columns = self._native.columns()
        if columns is None:
            raise AttributeError(f"{self._title} has no columns over time; replay and simulate have")
        return columns

    def page(self) -> str:
        """The page of the command's ``--html``: it needs no network. A table where the command has none."""
        if self._native.has_page:
            return self._native.html() or ""
        return f"<!doctype html><meta charset=utf-8><title>{self._title}</title>{self._table()}"

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Writes the page."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.page())

    def _table(self) -> str:
        rows = "".join(
            f"<tr><th>{html.escape(key)}</th><td>{html.escape(_short(value))}</td></tr>"
            for key, value in self._data.items()
        )
        return f"<table>{rows}</table>"

    def _repr_html_(self) -> str:
        if not self._native.has_page:
            return self._table()
        # A page brings its own style: a frame keeps it from the notebook's.
        page = html.escape(self.page(), quote=True)
        return (
            f'<iframe sandbox="allow-scripts" style="width:100%;height:36em;border:1px solid #8888" '
            f'title="{html.escape(self._title)}" srcdoc="{page}"></iframe>'
        )

    def __repr__(self) -> str:
        summary = self._data.get("summary")
        return f"<{self._title}> {summary}" if summary else f"<{self._title}> {super().__repr__()}"
