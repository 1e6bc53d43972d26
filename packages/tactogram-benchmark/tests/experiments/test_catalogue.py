"""The header of a result, and the list of what has run."""

import json

import pytest

from tactogram.cli import main
from tactogram_benchmark.experiments import stroke_cnn_table2
from tactogram_benchmark.experiments.catalogue import reproduce


@pytest.fixture
def made_up(monkeypatch):
    def run(folder, *, paper, progress, data="", folds=10):
        names = (
            {"data": "strokes", "data_sha256": "a1"} if data else {"images": {"name": "i", "sha256": "b2"}}
        )
        return {
            "simulated": not data,
            **names,
            "figures": [str(folder / "a.png")],
            "text": f"{folds} folds, paper {paper}",
        }

    monkeypatch.setattr(stroke_cnn_table2, "run", run)


def test_a_result_states_its_origin(made_up, tmp_path):
    found = reproduce("stroke_cnn_table2", data="lab", recipe="paper", out=tmp_path, options={"folds": 2})
    header = found["header"]
    assert header.pop("finished").startswith("20")
    assert header.pop("version")
    assert header == {
        "experiment": "stroke_cnn_table2",
        "recipe": "paper",
        "options": {"folds": 2},
        "data": [{"name": "strokes", "sha256": "a1", "simulated": False}],
    }
    assert found["text"] == "2 folds, paper True"
    assert found["figures"] == ["a.png"]
    found = reproduce("stroke_cnn_table2", out=tmp_path)
    assert found["header"]["data"] == [{"name": "i", "sha256": "b2", "simulated": True}]


def test_experiments_are_listed_with_what_has_run(made_up, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reproduce("stroke_cnn_table2")
    assert main(["reproduce", "--list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert listed["stroke_cnn_table2"]["title"].startswith("Saga et al., Tables I and II")
    assert listed["stroke_cnn_table2"]["results"]["runs/stroke_cnn_table2/result.json"]["recipe"] == "bench"
    results = listed["visual_tactile_gan_table4"]["results"]
    [header] = [results[name] for name in results if name.endswith("/visual_tactile_gan_table4.json")]
    assert len(results) > 1  # and one of the variants
    assert header["data"][0]["name"] == "stroking9 (simulated)"
    assert main(["reproduce", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    [line] = [line for line in lines if "runs/stroke_cnn_table2/result.json" in line]
    assert line.split()[:5] == ["stroke_cnn_table2", line.split()[1], "bench", "i", "(simulated)"]
