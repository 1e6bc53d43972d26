import json

import pytest
from benchmarks.experiments import transducer

from tactogram.workflows.progress import silent


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("transducer")
    saved = transducer.save_figure
    transducer.save_figure = lambda path, figure: path  # drawing is timed by nobody
    try:
        made = transducer.run(folder, paper=False, progress=silent, seeds=1)
    finally:
        transducer.save_figure = saved
    return {**made, "folder": folder}


def test_what_arrives_is_what_is_reported(result):
    assert len(result["arriving"]) == 6
    for row in result["arriving"]:
        assert row["largest_difference_from_formula_db"] < 0.02
        half = row["minus_3_db_hz_simulated"]
        if row["minus_3_db_hz"] < 1000:
            assert half == pytest.approx(row["minus_3_db_hz"], rel=0.01)
        else:
            assert half is None
        if row["pre_emphasis"]:
            assert row["unevenness_db_to_flat"] < 0.05
        assert row["highest_v_at_transducer"] <= 11


def test_the_waveform_says_the_same_as_its_envelope(result):
    assert result["waveform_check"]["largest_difference"] < 0.01


def test_each_way_of_tracking_ends_where_its_maximum_is(result):
    rows = {(row["transducer"], row["method"]): row for row in result["tracking"]}
    assert rows["finger", "dither_admittance"]["mean_hz"] == pytest.approx(-27.3, abs=3)
    assert rows["finger", "motional_phase"]["mean_hz"] == pytest.approx(0, abs=1)
    assert rows["touched", "motional_phase"]["max_hz"] < 20
    assert all(row["lost"] == 0 for row in result["tracking"])


def test_the_result_is_json_that_calls_itself_simulated(result):
    plain = {key: value for key, value in result.items() if key != "folder"}
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert plain["simulated"] is True
    assert plain["text"].startswith("Simulated transducers; nothing was measured on a device.")
    assert (result["folder"] / "tracking-log.csv").read_text().startswith("step,state,frequency_hz")
