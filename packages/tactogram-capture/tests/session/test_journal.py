"""The journal of a session: damaged and incomplete lines."""

import json

import pytest

from tactogram.errors import DataError
from tactogram_capture.session.journal import Journal


def test_an_incomplete_last_line_of_the_journal_is_dropped_and_a_damaged_one_refused(tmp_path):
    with Journal(tmp_path) as journal:
        journal.write("begun", {"x": 1})
    with journal.path.open("a") as file:
        file.write('{"event": "sk')
    with Journal(tmp_path) as journal:
        assert [entry["event"] for entry in journal.events] == ["begun"]
        journal.write("closed")
    assert [json.loads(line)["event"] for line in journal.path.read_text().splitlines()] == [
        "begun",
        "closed",
    ]
    journal.path.write_text("nonsense\n")
    with pytest.raises(DataError, match="line 1"):
        Journal(tmp_path).__enter__()
