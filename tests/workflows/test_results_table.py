"""The table of published results and evaluated runs."""

import json

from tactogram.cli import main


def test_an_evaluated_run_is_listed_first_in_the_table(run, capsys):
    assert main(["evaluate", str(run.folder), "--json"]) == 0
    measured = json.loads(capsys.readouterr().out)
    assert main(["table", str(run.folder), "--figure", "recording_accuracy", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["rows"][0]
    assert (first["model"], first["ours"]) == ("stroke_cnn", measured["recording_accuracy"])
    assert first["data"] == "textures (simulated)"
