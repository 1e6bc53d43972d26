"""Calibrations read from their file."""

import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.drive.friction_calibration import read_calibrations


def test_toml_that_is_no_calibration_is_refused(tmp_path):
    path = tmp_path / "c.toml"
    path.write_text("[[calibration]]\nperson = 'a'\nvolt = 1\n")
    with pytest.raises(ParameterError, match="calibration"):
        read_calibrations(path)
    path.write_text("x = 1\n")
    with pytest.raises(ParameterError, match="calibration: is missing"):
        read_calibrations(path)
