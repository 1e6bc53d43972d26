from dataclasses import replace

import numpy as np
import pytest
from scipy.fft import rfft2

from tactogram.errors import ParameterError
from tactogram_simulate import make, tasks
from tactogram_simulate.contact import FINGER, transmission
from tactogram_simulate.fabrics import FABRICS, fabric
from tactogram_simulate.stroke import RecordingTask
from tactogram_simulate.surfaces import MM_PER_PIXEL, frequencies, height_field, inverse

CORDUROY = next(i for i, surface in enumerate(FABRICS) if surface.name == "sim-corduroy")


@pytest.fixture(scope="module")
def corduroy():
    return make(tasks("fabrics", seed=0)[4 * CORDUROY])


def test_friction_over_displacement_with_a_photograph_to_scale(corduroy):
    friction = corduroy.stream("friction")
    assert (friction.domain, friction.unit, friction.rate) == ("displacement", "1", 40.0)
    assert friction.length_mm == pytest.approx(102.4)
    rows, columns = corduroy.image.pixels.shape[:2]
    assert columns * corduroy.image.mm_per_pixel == pytest.approx(friction.length_mm)
    assert rows >= 1024
    assert friction.samples.min() > 0
    assert friction.samples.mean() == pytest.approx(FABRICS[CORDUROY].friction, rel=0.1)
    assert corduroy.simulated
    assert "simulated" in corduroy.history[0]


def test_it_is_registered_to_within_two_pixels(corduroy):
    """The slopes of the surface that the photograph shows, at each place, are in the friction of that place."""
    piece = replace(FABRICS[CORDUROY], name="sim-corduroy piece 1 of 0")
    ky, kx = frequencies()
    felt = rfft2(height_field(piece)) * transmission(FINGER, np.hypot(ky, kx))
    slope = inverse(felt * 2j * np.pi * kx)[512]
    friction = corduroy.stream("friction")
    at = np.arange(2048) * MM_PER_PIXEL
    met = np.interp(at, np.arange(len(friction)) / friction.rate, friction.samples[0])
    one, other = (x[100:-100] - x[100:-100].mean() for x in (met, slope))
    lags = np.arange(-30, 31)
    alike = [np.corrcoef(one[40:-40], np.roll(other, lag)[40:-40])[0, 1] for lag in lags]
    assert abs(lags[int(np.argmax(alike))]) <= 2
    assert max(alike) > 0.9


def test_pieces_of_a_fabric_differ_and_seeds_repeat():
    task = RecordingTask("fabrics", 0, 0, "finger", 25.0, 1, 0.4, 1000.0)
    linen = FABRICS[0]
    one, again = (fabric(linen, task) for _ in range(2))
    other = fabric(linen, replace(task, take=2))
    assert one.id == again.id
    np.testing.assert_array_equal(one.image.pixels, again.image.pixels)
    assert one.image.pixels.shape == (1024, 200, 3)
    assert one.id != other.id
    assert not np.array_equal(one.image.pixels, other.image.pixels)


def test_a_fabric_ends_where_its_patch_does():
    with pytest.raises(ParameterError, match=r"102\.4 mm long"):
        fabric(FABRICS[0], RecordingTask("fabrics", 0, 0, "finger", 25.0, 1, 5.0, 1000.0))
