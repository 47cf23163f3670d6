"""What is worth knowing while work goes on."""

import os
import warnings
from collections.abc import Iterable

HERE = os.path.dirname(__file__)


class StickslipWarning(UserWarning):
    """Something was left out, or makes results doubtful; the text says what."""


def warn(texts: Iterable[str]) -> None:
    """One warning each, shown where the user called."""
    for text in texts:
        warnings.warn(text, StickslipWarning, stacklevel=3)
