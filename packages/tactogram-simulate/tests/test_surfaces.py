"""Height fields."""

import numpy as np

from tactogram_simulate.materials import STROKING_9, STROKING_30
from tactogram_simulate.photo import photograph
from tactogram_simulate.surfaces import height_field


def test_surfaces_are_periodic_and_distinct():
    pixels = []
    for surface in (*STROKING_9[::3], STROKING_30[9]):
        heights = height_field(surface)
        inside = np.abs(np.diff(heights, axis=0)).max()
        assert np.abs(heights[0] - heights[-1]).max() <= 1.5 * inside
        assert abs(heights.mean()) < 1e-4
        pixels.append(photograph(surface).pixels)
    assert len({p.tobytes() for p in pixels}) == 4
    assert all(p.std() > 3 for p in pixels)
