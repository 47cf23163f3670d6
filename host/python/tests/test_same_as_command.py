"""A function gives what the command of its name prints with --json."""

import pytest

import stickslip
from conftest import DEMO, command


def same(report, document, but=()):
    own = report.to_dict()
    for part in [own, document, *own.get("results", []), *document.get("results", [])]:
        for key in but:
            part.pop(key, None)
    assert own == document


def test_check(demo):
    same(stickslip.check(demo), command("check", DEMO))


def test_compare_with_and_without_a_model(demo, tmp_path):
    same(stickslip.compare(demo), command("compare", DEMO))
    path = tmp_path / "own.toml"
    stickslip.Model().write(path)
    trial = demo.trials[0]["trial"]
    # The model of a file by its path, and the same one read.
    for model in (path, stickslip.Model.read(path)):
        same(stickslip.compare(demo, model, trial=trial), command("compare", DEMO, "--model", path, "--trial", trial))


def test_compare_as_recorded_on_trials_held_out(demo):
    ids = [t["trial"] for t in demo.trials][:2]
    own = stickslip.compare(demo, held_out=ids, tare=False, force_bands=False)
    words = ["--held-out", ",".join(ids), "--no-tare", "--no-force-bands"]
    same(own, command("compare", DEMO, *words))


def test_calibrate_and_its_model_files(demo, tmp_path):
    own = stickslip.calibrate(demo)
    document = command("calibrate", DEMO, "--out", tmp_path / "model.toml")
    same(own, document, but=["file"])
    assert own.model.to_toml() == (tmp_path / "model.toml").read_text()
    assert own.models.keys() == {"linear_push", "pivot", "roll"}
    for name, model in own.models.items():
        assert model.to_toml() == (tmp_path / f"model-{name}.toml").read_text()


def test_replay(demo):
    for trial in demo.trials[:4]:
        same(stickslip.replay(demo, trial["trial"]), command("replay", DEMO, "--trial", trial["trial"]))


def test_score(demo):
    same(stickslip.score(demo, object_pose="start"), command("score", DEMO, "--object-pose", "start"))


def test_simulate_into_a_folder_and_into_memory(demo, tmp_path):
    document = command("simulate", DEMO, "--out", tmp_path / "command")
    written = stickslip.simulate(demo, out=tmp_path / "python")
    kept = stickslip.simulate(demo)
    same(written, document)
    same(kept, document)
    for file in (tmp_path / "command").rglob("*.csv"):
        assert file.read_bytes() == (tmp_path / "python" / file.relative_to(tmp_path / "command")).read_bytes()
    for trial in demo.trials:
        columns, again = kept.predicted.columns(trial["trial"]), written.predicted.columns(trial["trial"])
        assert columns.keys() == again.keys()
        assert all((columns[name] == again[name]).all() for name in columns)


@pytest.fixture(scope="module")
def found(bench):
    base = stickslip.calibrate(bench).model
    return base, stickslip.diagnose(bench, base)


def test_diagnose_add_and_refit_of_a_bench_with_a_hidden_effect(bench, found, tmp_path):
    base, diagnosis = found
    assert diagnosis.effects == ["finger_friction_mismatch"]
    base.write(tmp_path / "base.toml")
    words = ["--model", tmp_path / "base.toml", "--out", tmp_path / "better.toml"]
    same(diagnosis, command("diagnose", bench, *words), but=["seconds"])
    assert diagnosis.model.to_toml() == (tmp_path / "better.toml").read_text()
    added = stickslip.add(bench, "finger_friction_mismatch", base)
    words = ["--model", tmp_path / "base.toml", "--out", tmp_path / "added.toml"]
    same(added, command("add", bench, "finger_friction_mismatch", *words), but=["model"])
    assert added.model.to_toml() == (tmp_path / "added.toml").read_text()
    again = stickslip.refit(bench, added.model)
    words = ["--model", tmp_path / "added.toml", "--out", tmp_path / "again.toml"]
    same(again, command("refit", bench, *words), but=["model"])


def test_suggest(bench, found, tmp_path):
    base, _ = found
    base.write(tmp_path / "base.toml")
    pair = ["grip_force_loss", "sensor_gain"]
    own = stickslip.suggest(bench, base, between=pair)
    words = [word for name in pair for word in ("--between", name)]
    same(own, command("suggest", bench, "--model", tmp_path / "base.toml", *words))
