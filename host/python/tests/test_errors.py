"""What is refused is said in the words of the command."""

import shutil

import pytest

import stickslip
from conftest import DEMO, refusal


@pytest.mark.parametrize(
    ("call", "raised", "words"),
    [
        (lambda: stickslip.Dataset.read("nowhere"), stickslip.DataError, ["check", "nowhere"]),
        (
            lambda: stickslip.replay(DEMO, "no-such-trial"),
            stickslip.DataError,
            ["replay", DEMO, "--trial", "no-such-trial"],
        ),
        (
            lambda: stickslip.compare(DEMO, trial="no-such-trial"),
            stickslip.AnalysisError,
            ["compare", DEMO, "--trial", "no-such-trial"],
        ),
        (
            lambda: stickslip.calibrate(DEMO, primitive="throw"),
            stickslip.AnalysisError,
            ["calibrate", DEMO, "--primitive", "throw"],
        ),
        (
            lambda: stickslip.add(DEMO, "face_tlit"),
            stickslip.ModelError,
            ["add", DEMO, "face_tlit", "--out", "never.toml"],
        ),
        (
            lambda: stickslip.suggest(DEMO, between=["face_tilt"]),
            stickslip.AnalysisError,
            ["suggest", DEMO, "--between", "face_tilt"],
        ),
    ],
)
def test_an_exception_has_the_text_of_the_command(call, raised, words):
    with pytest.raises(raised) as refused:
        call()
    text = str(refused.value)
    assert f"error: {text}" in refusal(*words)
    assert isinstance(refused.value, stickslip.StickslipError)


def test_a_model_file_is_refused_with_its_line(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text('format = "stickslip-model/1"\n[friction]\nfinger = -1.0\npusher = 0.2\nsupport = 0.3\n')
    with pytest.raises(stickslip.ModelError, match=r"model\.toml:3:"):
        stickslip.Model.read(path)
    with pytest.raises(stickslip.ModelError, match="cannot be read"):
        stickslip.compare(DEMO, tmp_path / "none.toml")
    with pytest.raises(stickslip.ModelError, match="typed"):
        stickslip.Model.parse("nothing", name="typed")


def test_wrong_arguments_say_what_to_give():
    with pytest.raises(ValueError, match="share is 2; give a share above 0"):
        stickslip.calibrate(DEMO, share=2)
    with pytest.raises(ValueError, match="object_pose is \"often\"; give one of every, start"):
        stickslip.score(DEMO, object_pose="often")
    with pytest.raises(ValueError, match="a share of 3 cannot be held out"):
        stickslip.compare(DEMO, held_out=3)
    with pytest.raises(TypeError, match="a model is a stickslip.Model or the path of a model file, not int"):
        stickslip.compare(DEMO, 3)
    with pytest.raises(TypeError, match="data is a stickslip.Dataset or the folder of one, not dict"):
        stickslip.check({})


def test_every_fit_warns_of_the_trials_that_it_leaves_out(tmp_path):
    data = tmp_path / "data"
    shutil.copytree(DEMO, data)
    # A push without the object's pose in its first half.
    path = data / "trials" / "linear_push-obj4-g20-v10-s0-r1.csv"
    header, *rows = path.read_text().splitlines()
    blind = [name.startswith("object_") for name in header.split(",")]
    for at in range(len(rows) // 2):
        cells = zip(rows[at].split(","), blind)
        rows[at] = ",".join("" if of_object else cell for cell, of_object in cells)
    path.write_text("\n".join([header, *rows]) + "\n")
    between = ["sensor_gain", "grip_force_loss"]
    for fit in [
        lambda: stickslip.add(data, "sensor_gain"),
        lambda: stickslip.refit(data, stickslip.Model()),
        lambda: stickslip.suggest(data, between=between),
    ]:
        with pytest.warns(stickslip.StickslipWarning, match="left out: trial linear_push-obj4-g20-v10-s0-r1"):
            report = fit()
        assert (report.trials, len(report.left_out)) == (8, 1)
