"""Contact models."""

from __future__ import annotations

import os

from . import _stickslip


class Model:
    """A contact model as its file has it: contact law, friction, effects. It does not change.

    ``Model()`` is the default model: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support).
    """

    def __init__(self) -> None:
        self._native = _stickslip.Model.default()

    @classmethod
    def _of(cls, native: _stickslip.Model) -> Model:
        model = cls.__new__(cls)
        model._native = native
        return model

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Model:
        """Reads a model file (docs/model.md); raises :class:`ModelError` with its line."""
        return cls._of(_stickslip.Model.read(os.fspath(path)))

    @classmethod
    def parse(cls, text: str, name: str = "model") -> Model:
        """A model from the text of a model file."""
        return cls._of(_stickslip.Model.parse(text, name))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the model file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.to_toml())

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._native.text()

    def called(self, name: str) -> Model:
        """The same model under another name, as ``compare`` shows it."""
        return Model._of(self._native.called(name))

    @property
    def name(self) -> str:
        """What ``compare`` calls it: the file's name without its ending."""
        return self._native.name

    @property
    def friction(self) -> dict[str, float]:
        """Coefficients of ``finger``, ``pusher`` and ``support``."""
        return dict(self._native.friction)

    @property
    def friction_intervals(self) -> dict[str, tuple[float, float]]:
        """95 % intervals of the coefficients, where a fit found them."""
        return {name: (low, high) for name, (low, high) in self._native.friction_intervals}

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        """Effects in order of application, each with its parameters (SI units)."""
        return {name: dict(parameters) for name, parameters in self._native.effects}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        friction = ", ".join(f"{name} {value:.3f}" for name, value in self.friction.items())
        effects = ", ".join(self.effects) or "none"
        return f"<stickslip.Model {self.name}: friction {friction}; effects: {effects}>"


def native(model: Model | str | os.PathLike[str] | None) -> _stickslip.Model | None:
    """A model, or the file of one."""
    if model is None or isinstance(model, Model):
        return None if model is None else model._native
    if isinstance(model, (str, os.PathLike)):
        return Model.read(model)._native
    raise TypeError(f"a model is a stickslip.Model or the path of a model file, not {type(model).__name__}")
