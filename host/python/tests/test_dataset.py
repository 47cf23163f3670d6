"""Data sets from folders, arrays, pandas tables and recordings."""

import numpy as np
import pandas as pd
import pytest

import stickslip
from conftest import DEMO, TOP


def parts(data):
    return data.description, data.trials, {t["trial"]: data.columns(t["trial"]) for t in data.trials}


def test_columns_are_arrays_that_nobody_copied_again(demo):
    columns = demo.columns()
    assert columns["t_s"].dtype == np.float64 and columns["t_s"].flags.c_contiguous
    assert (np.diff(columns["t_s"]) > 0).all()
    assert np.array_equal(demo.to_pandas()["finger1_fy_n"].to_numpy(), columns["finger1_fy_n"], equal_nan=True)


def test_arrays_and_pandas_tables_give_the_data_set_of_the_folder(demo):
    description, trials, samples = parts(demo)
    of_arrays = stickslip.Dataset.from_arrays(description, trials, samples)
    tables = {name: pd.DataFrame(columns) for name, columns in samples.items()}
    long = pd.concat([table.assign(trial=name) for name, table in tables.items()])
    rows = pd.DataFrame(trials)
    made = [
        of_arrays,
        stickslip.Dataset.from_pandas(description, rows, tables),
        stickslip.Dataset.from_pandas(description, rows.set_index("trial"), long),
    ]
    reports = [stickslip.check(data).to_dict() for data in [demo, *made]]
    assert all(report == reports[0] for report in reports[1:])
    assert [data.trials for data in made] == [demo.trials] * 3
    hashes = {stickslip.replay(data, demo.trials[1]["trial"]).hash for data in [demo, *made]}
    assert len(hashes) == 1


def test_what_is_written_is_read_again(demo, tmp_path):
    demo.write(tmp_path / "copy", tables="parquet")
    again = stickslip.Dataset.read(tmp_path / "copy")
    one, other = demo.columns(), again.columns()
    assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)
    with pytest.raises(stickslip.DataError, match="the folder has content"):
        demo.write(tmp_path / "copy")
    with pytest.raises(ValueError, match="tables is \"xls\"; give one of csv, parquet"):
        demo.write(tmp_path / "other", tables="xls")


def test_arrays_of_a_wrong_shape_are_refused_with_trial_and_column(demo):
    description, trials, samples = parts(demo)
    name = trials[0]["trial"]
    good = samples[name]
    rows = len(good["t_s"])
    cases = [
        ({"finger1_fx_n": good["finger1_fx_n"][:10]}, f"finger1_fx_n: 10 values where t_s has {rows}"),
        ({"finger1_fx_n": np.ones((rows, 3))}, f"finger1_fx_n: the array is {rows}x3; give one dimension"),
        ({"finger1_fx_n": 1.0}, "the array is a single number"),
        ({"finger1_fx_n": ["a"] * rows}, "finger1_fx_n: not numbers"),
        ({"t_s": np.zeros(rows)}, "row 2, column t_s, value \"0\": time does not rise"),
        ({"object_qw": good["object_qw"] * 1.5}, "row 1, column object_qw.*the quaternion's norm is 1.5"),
        ({"finger1_fx_n": np.full(rows, np.inf)}, "not a finite number"),
        ({"t_s": np.array([])}, "values where t_s has 0"),
    ]
    for change, words in cases:
        with pytest.raises(stickslip.DataError, match=words) as refused:
            stickslip.Dataset.from_arrays(description, trials, {**samples, name: {**good, **change}})
        assert str(refused.value).startswith(f"trial {name}")
    with pytest.raises(stickslip.DataError, match="column t_s: the column is missing"):
        less = {column: values for column, values in good.items() if column != "t_s"}
        stickslip.Dataset.from_arrays(description, trials, {**samples, name: less})


def test_a_description_or_a_trial_that_is_wrong_is_refused_with_its_key(demo):
    description, trials, samples = parts(demo)
    wrong = {**description, "sample_rate_hz": -1}
    with pytest.raises(stickslip.DataError, match="column sample_rate_hz, .*negative"):
        stickslip.Dataset.from_arrays(wrong, trials, samples)
    with pytest.raises(stickslip.DataError, match="no such object in dataset.toml, which has obj1, obj4"):
        stickslip.Dataset.from_arrays(description, [{**trials[0], "object": "obj9"}], samples)
    with pytest.raises(stickslip.DataError, match="trial .*give the columns of every trial"):
        stickslip.Dataset.from_arrays(description, trials, {})
    with pytest.raises(ValueError, match="samples has no column trial"):
        stickslip.Dataset.from_pandas(description, pd.DataFrame(trials), pd.DataFrame({"t_s": [0.0]}))


def test_what_is_doubtful_is_a_warning(demo):
    description, trials, samples = parts(demo)
    name = trials[0]["trial"]
    misspelt = {**samples[name], "finger1_fx": samples[name]["finger1_fx_n"]}
    with pytest.warns(stickslip.StickslipWarning, match="did you mean finger1_fx_n"):
        stickslip.Dataset.from_arrays(description, trials, {**samples, name: misspelt})
    with pytest.warns(stickslip.StickslipWarning, match="uncertainty"):
        stickslip.Dataset.from_arrays({**description, "sensors": None}, trials, samples)


def test_a_cut_table_is_used_in_part_and_said(demo, tmp_path):
    demo.write(tmp_path / "cut")
    table = tmp_path / "cut" / "trials" / f"{demo.trials[0]['trial']}.csv"
    text = table.read_text().splitlines()
    table.write_text("\n".join([*text[:200], "0.9,nonsense"]))
    data = stickslip.Dataset.read(tmp_path / "cut")
    with pytest.warns(stickslip.StickslipWarning, match="the 199 rows before are used"):
        stickslip.calibrate(data, primitive="linear_push")
    assert len(data.refused) == 1


def test_a_ros_2_bag_is_read_by_its_mapping(tmp_path):
    bag = TOP / "host" / "data" / "tests" / "it" / "recorded" / "ros2.mcap"
    mapping = tmp_path / "mapping.toml"
    mapping.write_text(MAPPING.replace("BAG", str(bag)))
    with pytest.warns(stickslip.StickslipWarning, match="UNCERTAINTY NOT STATED"):
        data = stickslip.Dataset.from_mcap(mapping)
    columns = data.columns()
    assert {"finger1_fx_n", "object_qw"} <= columns.keys()
    assert {signal.signal for signal in data.imported.signals} >= {"finger1", "object"}
    assert "What was assumed" in data.imported.page() and data.imported._repr_html_().startswith("<iframe")
    broken = mapping.read_text().replace("rate_hz", "rate_khz", 1)
    mapping.write_text(broken)
    with pytest.raises(stickslip.DataError, match="rate_hz"):
        stickslip.Dataset.from_recording(mapping)


def test_a_folder_that_is_none_is_refused_as_by_the_command(tmp_path):
    with pytest.raises(stickslip.DataError, match="give the folder that holds dataset.toml"):
        stickslip.Dataset.read(tmp_path)
    with pytest.raises(stickslip.DataError, match="no trial is named `x`"):
        stickslip.Dataset.read(DEMO).columns("x")
    with pytest.raises(TypeError, match="Dataset.read"):
        stickslip.Dataset()


MAPPING = """
format = "stickslip-mapping/1"
rate_hz = 250.0

[trials]
constants = { object = "obj4", primitive = "linear_push" }

[dataset]
name = "bag"
sample_rate_hz = 250.0
gravity_m_s2 = [0.0, 0.0, -9.81]
objects = [{ id = "obj4", shape = "prism", length_m = 0.1, side_m = 0.025, mass_kg = 0.2005 }]
fingers = { contact = "disc", diameter_m = 0.02 }

[[streams]]
name = "left"
file = "BAG"
topic = "/ft/left"
time = { column = "header.stamp" }
finger1 = { force = ["force.x", "force.y", "force.z"], acts_on = "object" }

[[streams]]
name = "block"
file = "BAG"
topic = "/tf"
child_frame = "block"
time = { column = "header.stamp" }

[streams.object]
position = ["translation.x", "translation.y", "translation.z"]
quaternion_wxyz = ["rotation.w", "rotation.x", "rotation.y", "rotation.z"]

[fixed.gripper]
position_m = [0.0, 0.0, 0.5]
"""
