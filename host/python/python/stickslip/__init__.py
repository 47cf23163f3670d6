"""A contact model against measurements: what the data show, what the model predicts, what it lacks.

    import stickslip

    data = stickslip.Dataset.read("data/bench")
    print(stickslip.check(data))
    model = stickslip.calibrate(data).model
    diagnosis = stickslip.diagnose(data, model)
    print(diagnosis)                                    # one sentence
    stickslip.compare(data, [model, diagnosis.model])   # before and after; a page in a notebook

:class:`Predictor` predicts slip and drop sample by sample, in a loop of your own.

Every function here is the command `stickslip` of the same name: the same numbers under the same names
(:meth:`Report.to_dict` is what the command prints with ``--json``, ``stickslip schema COMMAND`` describes what each
key means), the same refusals. All quantities are in SI units; names carry the unit.

What is refused raises :class:`StickslipError`; what was left out while the rest goes on, and what makes results
doubtful, is a :class:`StickslipWarning`. Work runs without the interpreter's lock, and Ctrl-C stops it.
"""

from ._analyses import add, calibrate, check, compare, diagnose, refit, replay, score, simulate, suggest
from ._dataset import Dataset
from ._live import Predictor
from ._model import Model
from ._report import Report
from ._stickslip import (
    AnalysisError,
    DataError,
    FingerPrediction,
    ModelError,
    Prediction,
    StickslipError,
    __version__,
    effect_names,
)
from ._warning import StickslipWarning

__all__ = [
    "AnalysisError",
    "DataError",
    "Dataset",
    "FingerPrediction",
    "Model",
    "ModelError",
    "Prediction",
    "Predictor",
    "Report",
    "StickslipError",
    "StickslipWarning",
    "__version__",
    "add",
    "calibrate",
    "check",
    "compare",
    "diagnose",
    "effect_names",
    "refit",
    "replay",
    "score",
    "simulate",
    "suggest",
]
