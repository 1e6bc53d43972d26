"""Simulated photographs."""

from functools import cache

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_simulate import photo
from tactogram_simulate.photo import photographs
from tactogram_simulate.sets import STROKING_9


def test_places_do_not_overlap_and_have_a_scale(monkeypatch):
    monkeypatch.setattr(photo, "render", cache(photo.render))  # the same ground each time
    images = list(photographs(STROKING_9[0], 9))
    assert all(image.mm_per_pixel == pytest.approx(0.15) for image in images)
    assert {image.size for image in images} == {(224, 224)}
    assert len({image.pixels.tobytes() for image in images}) == 9
    few = list(photographs(STROKING_9[0], 4))
    assert [image.size for image in few] == [(336, 336)] * 4  # larger, of the same ground
    np.testing.assert_array_equal(few[3].pixels[-224:, -224:], images[8].pixels)
    (one,) = photographs(STROKING_9[0], 1)
    assert one.size == (672, 672)
    assert list(photographs(STROKING_9[0], 0)) == []
    with pytest.raises(ParameterError, match="room for 0 to 9 photographs, got 10"):
        list(photographs(STROKING_9[0], 10))
