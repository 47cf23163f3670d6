"""Data sets that the tests share."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

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
