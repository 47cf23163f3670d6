"""Reports: attributes, pages, models, columns over time."""

import pickle
import shutil

import numpy as np
import pytest

import stickslip
from conftest import DEMO


def test_keys_are_attributes_at_every_depth(demo):
    report = stickslip.check(demo)
    document = report.to_dict()
    assert report.trials == document["trials"] == report["trials"] == 9
    assert report.balance.stages[0].worst_n == document["balance"]["stages"][0]["worst_n"]
    assert "balance" in dir(report) and set(report) == set(document)
    with pytest.raises(AttributeError, match="no key 'balanse'.*balance"):
        report.balanse
    # A copy: what is done to it changes no report.
    document["trials"] = 0
    assert report.trials == 9
    assert pickle.loads(pickle.dumps(report)).to_dict() == report.to_dict()


def test_a_report_shows_its_page_in_a_notebook_and_a_sentence_in_a_terminal(demo, tmp_path):
    comparison = stickslip.compare(demo)
    page = comparison.page()
    assert page.lower().startswith("<!doctype html>") and "<svg" in page
    shown = comparison._repr_html_()
    assert shown.startswith("<iframe") and "<svg" not in shown and "&lt;svg" in shown
    comparison.save_html(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == page
    assert comparison.summary in repr(comparison)
    # The command has no page of it: a table.
    assert "<table>" in stickslip.simulate(demo)._repr_html_()


def test_the_page_of_a_comparison_needs_no_second_comparison(tmp_path):
    data = tmp_path / "data"
    shutil.copytree(DEMO, data)
    comparison = stickslip.compare(data)
    shutil.rmtree(data)
    assert 'class="viewer"' in comparison.page()


def test_a_diagnosis_shows_the_bench_and_the_traces_and_its_cells_lead_there(demo):
    page = stickslip.diagnose(demo).page()
    assert 'class="viewer"' in page and 'class="bench"' in page
    assert "data-goto=" in page and "data-run=" in page


def test_a_replay_has_everything_over_time_as_arrays(demo):
    report = stickslip.replay(demo)
    columns = report.columns()
    t_s = columns["t_s"]
    assert len(t_s) == report.ticks
    force = demo.columns()["finger1_fx_n"]
    assert np.array_equal(columns["measured_finger1_fx_n"], force)
    ahead = columns["predicted_finger_0_peak_utilisation"]
    assert ahead.max() == pytest.approx(report.prediction.peak_utilisation, abs=0.3)
    with pytest.raises(AttributeError, match="no columns over time"):
        stickslip.check(demo).columns()


def test_a_model_is_its_file(tmp_path):
    model = stickslip.Model()
    assert model.friction == {"finger": 0.4, "pusher": 0.25, "support": 0.3}
    model.write(tmp_path / "own.toml")
    again = stickslip.Model.read(tmp_path / "own.toml")
    assert again == model and again.name == "own" and again.called("before").name == "before"
    text = model.to_toml() + '\n[[effects]]\nid = "face_tilt"\n'
    with pytest.raises(stickslip.ModelError):
        stickslip.Model.parse(text)
    assert "face_tilt" in stickslip.effect_names()


def test_the_documented_names_are_there():
    for name in stickslip.__all__:
        assert getattr(stickslip, name).__doc__ or name == "__version__", name
