"""Columns of ratings."""

import pytest

from tactogram.datasets.ratings.questions import RatingColumns
from tactogram.errors import ParameterError


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"named": {"who": "rater"}}, "a column must be one of rater, item, .*got 'who'"),
        ({"encoding": "utf-99"}, "one that Python knows, got 'utf-99'"),
        ({"item": "plate{a}"}, "a place for the cell"),
    ],
)
def test_columns_that_cannot_be_meant_are_refused(changes, says):
    with pytest.raises(ParameterError, match=says):
        RatingColumns(**changes)
