"""Basic envelopes of Android: sharpness."""

import numpy as np
import pytest
from tests.rendering.files.documents import read
from tests.rendering.files.formats.test_android_envelope import tone, written

from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.formats import android_basic


def test_sharpness_is_the_share_of_65_to_300_hz():
    document, points = written(tone([0.5, 0.5], [182.5], 0.5), android_basic)
    assert points[:-1, 1] == pytest.approx(0.5, abs=0.01)
    assert document["initialSharpness"] == pytest.approx(0.5, abs=0.1)
    back = envelope_of(read(android_basic, document).signal)
    assert np.interp(0.25, back.times, back.frequency) == pytest.approx(182.5, abs=2)
