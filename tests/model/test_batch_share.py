"""Shares of a batch: disjoint, and together the whole."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import WHOLE_BATCH, BatchShare


def test_shares_are_disjoint_and_whole():
    places = np.arange(24)  # three batches of eight
    shares = [BatchShare(number, 4).places(places, 8) for number in range(4)]
    np.testing.assert_array_equal(shares[1], [2, 3, 10, 11, 18, 19])
    np.testing.assert_array_equal(np.sort(np.concatenate(shares)), places)
    np.testing.assert_array_equal(WHOLE_BATCH.places(places, 8), places)
    with pytest.raises(
        ParameterError, match="must be a multiple of the 4 processes that share a batch, got 10"
    ):
        BatchShare(0, 4).size(10)
