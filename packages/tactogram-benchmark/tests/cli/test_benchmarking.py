"""What the verbs of the benchmark print."""

import json

from tactogram.cli import main


def test_the_table_is_filtered_and_fits_a_terminal(capsys, monkeypatch):
    assert main(["table", "--model", "cnn", "--figure", "CLASSIFIED", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert rows
    assert all(row["model"] == "stroke_cnn" and "classified" in row["what"] for row in rows)
    monkeypatch.setattr("tactogram_benchmark.cli.benchmarking.terminal_width", lambda: 100)
    assert main(["table"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    assert any("…" in line for line in lines)
