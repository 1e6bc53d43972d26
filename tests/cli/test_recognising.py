"""What the verbs of recognition print."""

import json

from tactogram.cli import main
from tactogram.cli.recognising import VERBS
from tactogram.signal.io import write_signal


def test_results_are_one_json_object(run, capsys, tmp_path, texture):
    file = tmp_path / "x.wav"
    write_signal(file, texture("tile", 8))
    assert main(["classify", str(run.folder), str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["files"][str(file)]
    assert said["material"] == "tile"
    assert main(["search", str(run.folder), str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nearest"][0]["material"] == "tile"
    assert main(["evaluate", str(run.folder), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert {"window_accuracy", "recording_accuracy"} <= figures.keys()


def test_predictions_have_headings(run, texture, tmp_path, capsys):
    write_signal(tmp_path / "x.wav", texture("tile", 8))
    assert main(["classify", str(run.folder), str(tmp_path / "x.wav")]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["file", "material", "probability"]
    assert row.split()[1] == "tile"


def test_other_candidates_stand_beside_the_likeliest_material():
    known = {"material": "tile", "probability": 0.61, "candidates": ("tile", "cork"), "none_of_these": False}
    strange = {"material": "felt", "probability": 0.4, "candidates": ("felt",), "none_of_these": True}
    head, first, second = VERBS["classify"].text({"files": {"a.wav": known, "b.wav": strange}}).splitlines()
    assert head.split() == ["file", "material", "probability", "or", "(95", "%)"]
    assert first.split() == ["a.wav", "tile", "0.610", "cork"]
    assert second.split() == ["b.wav", "felt", "0.400", "none", "of", "these?"]
