"""Data sets that the tests share."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import stickslip

TOP = Path(__file__).parents[3]
DEMO = TOP / "data" / "demo"
# The command that the package brings.
COMMAND = [sys.executable, "-m", "stickslip"]


def command(*words):
    """The JSON document that the command prints."""
    done = subprocess.run([*COMMAND, "--json", *map(str, words)], capture_output=True, text=True, check=False)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def refusal(*words):
    """What the command says where it fails."""
    done = subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done
    return done.stderr


@pytest.fixture(scope="session")
def demo():
    """Seven recorded trials."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return stickslip.Dataset.read(DEMO)


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Pushes with a hidden effect, which the tour in README.md uses."""
    folder = tmp_path_factory.mktemp("rig") / "bench"
    hidden = ["--hidden", "finger_friction_mismatch", "--seed", "11", "--objects", "obj4"]
    command("rig", "--out", folder, "--plan", "push-small", *hidden)
    return folder


@pytest.fixture(scope="session")
def lifts(tmp_path_factory):
    """Lifts of the synthetic rig, in some of which the object is lost."""
    folder = tmp_path_factory.mktemp("rig") / "lifts"
    command("rig", "--out", folder, "--plan", "lift", "--seed", "3", "--objects", "obj4")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return stickslip.Dataset.read(folder)


WRENCH = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"]
POSE = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]


def samples(data, trial):
    """A trial's samples as `Predictor.step` takes them."""
    columns = data.columns(trial)
    rows = len(columns["t_s"])

    def of(prefix, names):
        parts = [columns.get(f"{prefix}_{name}", np.full(rows, np.nan)) for name in names]
        table = np.stack(parts, axis=1)
        return [None if np.isnan(row).any() else row for row in table]

    signals = {name: of(name, WRENCH) for name in ("finger1", "finger2")}
    signals |= {name: of(name, POSE) for name in ("gripper", "object", "pusher")}
    grip = columns.get("grip_cmd_n", np.full(rows, np.nan))
    return [
        {"t_s": t_s, "grip_n": None if np.isnan(grip[i]) else grip[i], **{k: v[i] for k, v in signals.items()}}
        for i, t_s in enumerate(columns["t_s"])
    ]


def row_of(data, trial):
    """A trial's conditions as `Predictor` takes them; its place in the data set too."""
    at = [row["trial"] for row in data.trials].index(trial)
    row = data.trials[at]
    pusher = [row.get(f"pusher_{name}") for name in POSE]
    return {
        "object": row["object"],
        "primitive": row["primitive"],
        "grip_n": row["grip_n"],
        "pusher": None if None in pusher else pusher,
        "ordinal": at,
    }
