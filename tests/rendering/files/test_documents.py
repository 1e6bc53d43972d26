"""Nodes of a document: what is missing or of another type is noted, and read as players read it."""

import math

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files import documents
from tactogram.rendering.files.documents import (
    MOST_SAMPLES,
    Node,
    Notes,
    encoded,
    has_key,
    in_order,
    parse,
    sample_count,
)


def node(**values):
    return Node(values, Notes(), "effect")


@pytest.mark.parametrize(
    ("stated", "read", "problems", "warnings"),
    [
        (0.5, 0.5, [], []),
        ("0.5", 0.5, [], ["time must be a number, got '0.5': read as one"]),
        (2, 1.0, [], ["time must be 0 to 1, got 2: clamped"]),
        ("x", 0.0, ["effect.time: must be a number, got 'x'"], []),
        (True, 0.0, ["effect.time: must be a number, got True"], []),
        (None, 0.0, ["effect.time: is required"], []),
        ([], 0.0, ["effect.time: must be a number, got []"], []),
    ],
)
def test_a_number_is_read_as_players_read_it(stated, read, problems, warnings):
    document = node(time=stated)
    assert document.number("time", low=0, high=1) == read
    assert (document.notes.problems, document.notes.warnings) == (problems, warnings)


def test_what_is_optional_has_a_default_and_no_note():
    document = node(empty=None)
    assert document.number("time", 0.25) == 0.25
    assert document.text("name", "none") == "none"
    assert document.list("entries", optional=True) == []
    assert document.node("part", optional=True).number("time", 1.0) == 1.0
    assert not document.has("empty", "time")
    assert document.notes.problems == []


def test_a_fault_in_a_part_that_is_missing_is_noted_once():
    document = node()
    document.node("part").number("time")
    assert document.notes.problems == ["effect.part: is required"]


def test_places_name_the_way_to_a_fault():
    document = node(points=[{"time": 0}, 3, {"time": "x"}])
    first, last = document.nodes("points")
    assert (first.number("time"), last.number("time")) == (0, 0)
    assert document.notes.problems == [
        "effect.points.1: must be an object, got 3",
        "effect.points.2.time: must be a number, got 'x'",
    ]


def test_a_list_of_too_many_entries_is_not_read(monkeypatch):
    monkeypatch.setattr(documents, "MOST_ENTRIES", 3)
    document = node(points=[0] * 4)
    assert document.numbers("points", 0, 1) == []
    assert document.notes.problems == ["effect.points: must have at most 3 entries"]


def test_a_rule_that_is_broken_twice_is_one_warning_with_the_first_value():
    document = node(levels=[0.5, 3, 4])
    assert document.numbers("levels", 0, 1) == [0.5, 1, 1]
    assert document.notes.warnings == ["levels must be 0 to 1, got 3: clamped (2 times)"]
    document.notes.check()


def test_the_first_problem_is_raised_with_the_number_of_others():
    document = node()
    document.number("a"), document.number("b"), document.number("c")
    with pytest.raises(DataError, match=r"^effect.a: is required \(and 2 more, see --check\)$"):
        document.notes.check()


def test_entries_are_sorted_by_time_and_it_is_said():
    notes = Notes()
    assert in_order([(0.0, 5), (1.0, 2)], notes, "points") == [(0.0, 5), (1.0, 2)]
    assert notes.warnings == []
    assert in_order([(1.0, 2), (0.0, 5), (1.0, 1)], notes, "points") == [(0.0, 5), (1.0, 2), (1.0, 1)]
    assert notes.warnings == ["points must be in order of time: sorted"]


def test_a_document_is_one_line_and_comes_back():
    document = {"name": "é", "points": [0.5, 1]}
    assert encoded(document) == b'{"name":"\\u00e9","points":[0.5,1]}\n'
    assert parse(encoded(document), "x.json") == document
    with pytest.raises(ValueError, match="JSON compliant"):
        encoded({"time": math.nan})


def test_more_samples_than_any_device_plays_are_refused():
    assert sample_count(0.5, 8000.4) == 4000
    assert sample_count(MOST_SAMPLES, 1) == MOST_SAMPLES
    for seconds in (MOST_SAMPLES + 1, math.nan):
        with pytest.raises(ParameterError, match="at 1 Hz are more than 33554432 samples; cut the file"):
            sample_count(seconds, 1)


def test_a_key_is_looked_for_in_objects_alone():
    assert [has_key("Pattern")(document) for document in ({"Pattern": None}, {}, ["Pattern"], 3)] == [
        True, False, False, False,
    ]  # fmt: skip
