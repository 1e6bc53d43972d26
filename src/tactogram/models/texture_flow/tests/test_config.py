"""Values that do not fit together."""

import pytest
from pydantic import ValidationError

from tactogram.models.texture_flow import Config


def test_frames_that_the_network_cannot_halve_are_refused():
    with pytest.raises(ValueError, match="multiple of 32"):
        Config(widths=(8, 8, 8, 8, 8), frames=40)


def test_modulated_surfaces_need_a_prediction():
    with pytest.raises(ValidationError, match="modulated needs prediction"):
        Config(modulated=0.5)
