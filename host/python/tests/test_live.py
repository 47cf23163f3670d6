"""The predictor sample by sample: the numbers of a replay, and what is refused."""

import json
import threading
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip
from conftest import DEMO, TOP, command, row_of, samples


def predictor(data, trial, plan=None, model=None, **options):
    of = row_of(data, trial)
    return stickslip.Predictor(data, of.pop("object"), model, plan=plan, **of, **options)


def same_as(column, value):
    """A column of a replay has NaN where a prediction has None."""
    return np.isnan(column) if value is None else column == value


def test_samples_one_by_one_have_the_bits_of_replay_and_of_the_command(demo, lifts):
    for data in (demo, lifts):
        for trial in [row["trial"] for row in data.trials][:4]:
            report = stickslip.replay(data, trial)
            one = predictor(data, trial, report.plan)
            said = [one.step(**sample) for sample in samples(data, trial)]
            assert one.hash == report.hash and len(said) == report.ticks, trial
    trial = demo.trials[0]["trial"]
    document = command("replay", DEMO, "--trial", trial)
    one = predictor(demo, trial, document["plan"])
    for sample in samples(demo, trial):
        one.step(**sample)
    assert one.hash == document["hash"]


def test_every_property_is_the_column_of_replay(lifts):
    trial = lifts.trials[-1]["trial"]
    model = stickslip.Model.parse(stickslip.Model().to_toml().replace("finger = 0.4", "finger = 0.5"))
    report = stickslip.replay(lifts, trial, model)
    one = predictor(lifts, trial, report.plan, model)
    said = [one.step(**sample) for sample in samples(lifts, trial)]
    columns = {name[10:]: c for name, c in report.columns().items() if name.startswith("predicted_")}
    plain = ["drop_in_s", "holding_grip_n", "hold_probability", "friction", "friction_least", "sag_m", "sag_ahead_m"]
    plain += ["rotation_rad", "solver_residual_n", "solver_iterations"]
    names = {name: name for name in plain} | {"flag_bits": "flags", "validity_bits": "validity"}
    for name, column in names.items():
        assert all(map(same_as, columns[column], (getattr(p, name) for p in said))), name
    fingers = ["measured_utilisation", "model_utilisation", "peak_utilisation", "slip_speed_m_s", "slip_direction_rad"]
    for name in fingers:
        for k in (0, 1):
            values = (getattr(p.fingers[k], name) for p in said)
            assert all(map(same_as, columns[f"finger_{k}_{name}"], values)), (k, name)
    for k in range(7):
        column = columns[f"position_m_{k}" if k < 3 else f"quaternion_{k - 3}"]
        assert all(map(same_as, column, (p.pose[k] for p in said)))
    for finger in (0, 1):
        for k in range(6):
            column = columns[f"finger_wrench_{finger}_{k}"]
            assert all(map(same_as, column, (p.finger_wrench[finger][k] for p in said)))
    # Flags are up when the report says so.
    for span in report.flags:
        last = span.falls_s if span.falls_s is not None else np.inf
        up = [p for p in said if span.rises_s <= p.t_s < last]
        assert len(up) == span.ticks and all(span.flag in p.flags for p in up), span
    assert sum(len(p.flags) for p in said) == sum(span.ticks for span in report.flags)
    assert sum(len(p.doubts) for p in said) == sum(span.ticks for span in report.doubts)


def test_booleans_and_times_agree_with_flags_and_fingers(lifts):
    seen = set()
    for row in lifts.trials:
        one = predictor(lifts, row["trial"])
        for sample in samples(lifts, row["trial"]):
            said = one.step(**sample)
            up = " ".join(said.flags)
            assert said.slip == ("slip, finger" in up) and said.slip_ahead == ("slip ahead" in up)
            for name in ("unexpected", "sag", "rotation", "drop", "pushing", "unsure"):
                assert getattr(said, name) == (name in said.flags), name
                seen |= {name} & set(said.flags)
            times = [f.slip_in_s for f in said.fingers if f.slip_in_s is not None]
            assert said.slip_in_s == min(times, default=None)
            assert [f.slip for f in said.fingers] == [f.slip_in_s == 0.0 for f in said.fingers]
            used = [
                f.model_utilisation if f.measured_utilisation is None else f.measured_utilisation
                for f in said.fingers
            ]
            assert said.utilisation == max(0.0, *used)
            seen |= {"slip"} if said.slip else {"holds"}
    assert {"slip", "holds", "drop"} <= seen


def test_a_prediction_is_a_dictionary_for_json(demo):
    trial = demo.trials[0]["trial"]
    one = predictor(demo, trial)
    for sample in samples(demo, trial)[:50]:
        said = one.step(**sample)
    again = json.loads(json.dumps(said.to_dict()))
    assert again["t_s"] == said.t_s and again["flags"] == said.flags and len(again["pose"]) == 7
    assert again["fingers"][1]["peak_utilisation"] == said.fingers[1].peak_utilisation
    properties = {name for name in dir(said) if not name.startswith("_")} - {"to_dict"}
    assert set(again) == properties
    assert "utilisation" in repr(said) and "Finger" in repr(said.fingers[0])
    with pytest.raises(AttributeError):
        said.slip = True


def test_a_rig_is_a_data_set_a_folder_a_file_or_its_content(demo):
    trial = demo.trials[0]["trial"]
    hashes = set()
    for rig in (demo, DEMO, str(DEMO / "dataset.toml"), demo.description):
        of = row_of(demo, trial)
        one = stickslip.Predictor(rig, of.pop("object"), **of)
        for sample in samples(demo, trial)[:100]:
            one.step(**sample)
        hashes.add(one.hash)
    assert len(hashes) == 1
    # Lists are numbers too, and what is not passed holds or is not measured.
    one = predictor(demo, trial)
    for sample in samples(demo, trial)[:100]:
        parts = {k: v.tolist() for k, v in sample.items() if isinstance(v, np.ndarray)}
        one.step(sample["t_s"], **parts)
    assert one.hash in hashes


def test_what_no_sample_can_be_is_a_value_error_and_changes_nothing(demo):
    trial = demo.trials[0]["trial"]
    every = samples(demo, trial)
    one, spared = predictor(demo, trial), predictor(demo, trial)
    good = every[50]
    cases = [
        ({"finger1": np.ones(5)}, "finger1: the shape is 5; give 6: fx, fy, fz"),
        ({"finger2": np.ones((2, 3))}, "finger2: the shape is 2x3; give 6"),
        ({"gripper": 1.0}, "gripper: the shape is a single number; give 7: x, y, z"),
        ({"finger1": ["a"] * 6}, "finger1: not numbers"),
        ({"finger1": np.full(6, np.nan)}, "finger1 has a number that is not finite; give None"),
        ({"object": [0, 0, np.inf, 1, 0, 0, 0]}, "object has a number that is not finite"),
        ({"gripper": [0, 0, 0, 2, 0, 0, 0]}, "gripper: the quaternion's norm is 2.0000"),
        ({"grip_n": -1.0}, "grip_n is -1; a grip force cannot be below zero"),
        ({"t_s": float("nan")}, "t_s has a number that is not finite"),
        ({"t_s": every[49]["t_s"]}, "time does not rise"),
        ({"t_s": -1.0}, "time does not rise; .*restart"),
    ]
    for sample in every[:50]:
        one.step(**sample)
        spared.step(**sample)
    for change, words in cases:
        with pytest.raises(ValueError, match=words):
            one.step(**{**good, **change})
    for sample in every[50:150]:
        one.step(**sample)
        spared.step(**sample)
    assert one.hash == spared.hash


def test_what_no_predictor_can_be_is_refused_with_what_can(demo, tmp_path):
    with pytest.raises(stickslip.DataError, match="objects.id.*obj9.*no such object in dataset.toml, which has obj1, obj4"):
        stickslip.Predictor(demo, "obj9")
    with pytest.raises(stickslip.DataError, match="nowhere"):
        stickslip.Predictor("nowhere", "obj4")
    with pytest.raises(stickslip.DataError, match="sample_rate_hz"):
        stickslip.Predictor({**demo.description, "sample_rate_hz": -1}, "obj4")
    with pytest.warns(stickslip.StickslipWarning, match="gravity"):
        stickslip.Predictor({**demo.description, "gravity": 9.81}, "obj4")
    with pytest.raises(TypeError, match="rig is a stickslip.Dataset, its folder, .*not int"):
        stickslip.Predictor(3, "obj4")
    with pytest.raises(stickslip.ModelError, match="none.toml"):
        stickslip.Predictor(demo, "obj4", tmp_path / "none.toml")
    with pytest.raises(stickslip.AnalysisError, match="refuses scene, model or limits: Limit\\(Sag\\)"):
        stickslip.Predictor(demo, "obj4", limits={"sag_m": -1.0})
    segment = {"duration_s": 1.0, "grip_n": 20.0}
    for options, words in [
        ({"limits": {"sag": 1.0}}, "no limit `sag`; there are .*sag_m"),
        ({"plan": [segment] * 9}, "the plan has 9 segments; at most 8 fit"),
        ({"plan": [{"duration_s": 1.0}]}, "the plan: missing field `grip_n`"),
        ({"plan": [{**segment, "intent": "throw"}]}, "the plan: unknown variant `throw`"),
        ({"plan": [{**segment, "velocity_m_s": [0, 0, 9]}]}, "Velocity is 9; give -5 to 5"),
        ({"plan": [{**segment, "intent": object()}]}, "the plan: .*give numbers"),
        ({"grip_n": -1.0}, "grip_n is no grip force"),
        ({"pusher": [0, 0, 0]}, "pusher: the shape is 3; give 7"),
        ({"pusher": [0, 0, 0, 2, 0, 0, 0]}, "pusher: the quaternion's norm is 2"),
    ]:
        with pytest.raises(ValueError, match=words):
            stickslip.Predictor(demo, "obj4", **options)


def test_without_a_plan_the_present_motion_goes_on_and_a_plan_may_come_later(demo):
    trial = demo.trials[0]["trial"]
    every = samples(demo, trial)
    plan = stickslip.replay(demo, trial).plan
    without, later, before = predictor(demo, trial), predictor(demo, trial), predictor(demo, trial, plan)
    for sample in every[:100]:
        said = [one.step(**sample) for one in (without, later, before)]
    assert [("doubt: no plan" in one.doubts) for one in said] == [True, True, False]
    later.set_plan(plan, from_s=every[0]["t_s"])
    said = [one.step(**every[100]) for one in (without, later, before)]
    assert [("doubt: no plan" in one.doubts) for one in said] == [True, False, False]
    with pytest.raises(ValueError, match="from_s"):
        later.set_plan(plan, from_s=float("nan"))


def test_after_a_restart_the_clock_may_go_back_and_the_object_is_seen_anew(demo):
    trial = demo.trials[0]["trial"]
    every = samples(demo, trial)
    one = predictor(demo, trial)
    empty = one.hash
    for sample in every[:100]:
        one.step(**{**sample, "t_s": sample["t_s"] + 1.7e9})
    one.restart(stickslip.replay(demo, trial).plan)
    one.reset_friction()
    assert one.hash == empty
    blind = one.step(**{**every[0], "object": None})
    assert blind.unsure and "doubt: waiting for the object's pose" in blind.doubts
    said = [one.step(**sample) for sample in every[1:100]]
    assert not said[-1].unsure and "doubt: no plan" not in said[-1].doubts


def test_two_predictors_step_in_two_threads_and_neither_disturbs_the_other(demo):
    trials = [row["trial"] for row in demo.trials][:2]
    expected = [stickslip.replay(demo, trial) for trial in trials]
    ones = [predictor(demo, t, report.plan) for t, report in zip(trials, expected)]

    def run(one, trial):
        for sample in samples(demo, trial):
            one.step(**sample)

    threads = [threading.Thread(target=run, args=pair) for pair in zip(ones, trials)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [one.hash for one in ones] == [report.hash for report in expected]


def test_the_loop_of_the_manual_runs_as_it_stands(lifts, tmp_path, monkeypatch):
    page = (TOP / "docs" / "python.md").read_text()
    block = page.split("## Live")[1].split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(tmp_path)
    lifts.write("bench")
    stickslip.Model().write("better.toml")
    asked = []
    for row in lifts.trials:
        source = [SimpleNamespace(**sample) for sample in samples(lifts, row["trial"])]
        exec(block, {"stickslip": stickslip, "source": source, "ask_for": asked.append})
    assert any(grip_n is not None and grip_n > 0.0 for grip_n in asked)
