"""Pieces that fit the recordings, and positions between floor and ceiling."""

import pytest
from tests.evaluation.generation.test_protocol import RATE, drawn, texture

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import (
    GenerationResult,
    PiecePlan,
    plan_pieces,
)

TRAIN, TEST = drawn(0, 6), drawn(100, 3)


@pytest.mark.parametrize(
    ("lengths", "seconds", "count"),
    [
        ([4.0, 4.0], 2.0, 4),
        ([4.8, 4.8], 1.6, 6),
        ([0.4, 6.0], 1.0, 6),  # the short one is left out
        ([0.4, 0.6], 0.6, 1),
        ([30.0, 30.0], 2.0, 12),
    ],
)
def test_pieces_fit_the_recordings(lengths, seconds, count):
    part = {"cork": [texture("cork", i, seconds=s) for i, s in enumerate(lengths)]}
    pieces = plan_pieces(part, part)
    assert (pieces.seconds, pieces.count) == (pytest.approx(seconds), count)
    cut = pieces.cut(part["cork"])
    assert {len(s) for s in cut.signals} == {round(seconds * RATE)}
    number, long = pieces.draws(part["cork"])
    made = [texture("cork", i, seconds=long) for i in range(number)]
    assert len(set(pieces.cut(made).groups)) == len(set(cut.groups))


def test_a_position_by_hand():
    def row(model, floor, ceiling):
        return {"model": model, "base": 2.0, "floor": floor, "ceiling": ceiling, "nearest_other": None}

    values = {
        "d": {"a": row(2.0, 1.0, 3.0), "b": row(5.0, 1.0, 3.0), "c": row(1.0, 2.0, 2.0)},
        "recall": {"a": row(0.7, 0.9, 0.1)},
    }
    found = GenerationResult(
        ("a", "b", "c"), ("model", "base"), values, {"d": "lower", "recall": "higher"}, {}, 1.0, 1
    )
    assert [found.position("d", m) for m in "abc"] == [0.5, 2.0, None]
    assert [found.verdict("d", m) for m in "abc"] == ["between", "beyond", "undecided"]
    assert found.position("recall", "a") == pytest.approx(0.25)
    assert found.beyond_ceiling() == [("d", "b")]
    assert found.summary == "Between these and other materials in recall; nearer to other materials in d."
    assert found.overall["d"]["model"] == pytest.approx(8 / 3)
    assert found.worse_than("base") == ["d", "recall"]
    assert found.advantage("d", "base")["mean"] == pytest.approx(-2 / 3)
    assert found.advantage("recall", "base")["low"] is None


def test_being_less_like_the_training_data_than_unseen_recordings_is_no_advantage():
    row = {"model": 0.25, "base": 0.2, "floor": 0.3, "ceiling": 1.0, "nearest_other": None}
    values = {"near": {"a": row}, "far": {"a": row}}
    better = dict.fromkeys(values, "lower")
    found = GenerationResult(
        ("a",), ("model", "base"), values, better, {}, 1.0, 1, floored=frozenset({"near"})
    )
    assert found.worse_than("base") == ["far"]


def test_pieces_that_mean_nothing_are_refused():
    with pytest.raises(ParameterError, match="most >= 1"):
        plan_pieces(TRAIN, TEST, most=0)
    with pytest.raises(ParameterError, match="are needed"):
        PiecePlan(2.0, 99).cut(TRAIN["cork"])
