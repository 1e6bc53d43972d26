"""The guard between a stream and a device."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import display_of
from tactogram_playback.drive_guard import DriveGuard


def display(**changes):
    values = {
        "name": "a",
        "title": "a",
        "family": "linear",
        "rate": 1000,
        "channels": ["a", "b"],
        "unit": "V",
        "limit": 0.7,
        "fade_ms": 20,
    }
    return display_of(values | changes)


@given(
    hnp.arrays(np.float32, (2, 300), elements=st.floats(-5, 5, width=32)),
    st.lists(st.integers(1, 60), min_size=1, max_size=8),
)
def test_blocks_change_nothing_in_a_guarded_stream(samples, cuts):
    whole = DriveGuard(display()).process(samples)
    guard, parts, at = DriveGuard(display()), [], 0
    for cut in [*cuts, 300]:
        parts.append(guard.process(samples[:, at : at + cut]))
        at += cut
    np.testing.assert_allclose(np.concatenate(parts, axis=1), whole, atol=1e-6)
    assert np.abs(whole).max() <= 0.7


def test_a_fault_fades_to_rest_and_stays_there_until_reset():
    guard = DriveGuard(display(dc=True))
    on = guard.process(np.full((2, 100), 0.5))
    assert on[0, -1] == pytest.approx(0.5)
    bad = np.full((2, 100), 0.5)
    bad[1, 3] = np.nan
    off = guard.process(bad)
    assert guard.fault
    assert np.isfinite(off).all()
    assert np.abs(np.diff(np.concatenate([on[:, -1:], off], axis=1))).max() < 0.5 * np.pi / 2 / 20 * 1.01
    assert not off[:, 20:].any()
    assert not guard.process(np.full((2, 50), 0.5)).any()
    guard.reset()
    assert guard.process(np.full((2, 50), 0.5))[0, -1] == pytest.approx(0.5)


def test_a_lost_connection_fades_to_rest_and_comes_back_with_a_fade():
    guard = DriveGuard(display(dc=True))
    sent = [guard.process(np.full((2, 40), 0.5)), guard.missing(10), guard.missing(60)]
    sent.append(guard.process(np.full((2, 40), -0.5)))
    x = np.concatenate(sent, axis=1)
    assert not x[:, 70:100].any()
    assert x[0, -1] == pytest.approx(-0.5)
    assert np.abs(np.diff(x, axis=1)).max() < 0.5 * np.pi / 2 / 20 * 1.01


def test_a_guarded_stream_has_no_dc_where_it_is_forbidden():
    sent = DriveGuard(display()).process(np.full((2, 1000), 0.5))
    assert np.abs(sent[:, -100:]).max() < 1e-3


def test_a_guard_refuses_another_number_of_channels():
    with pytest.raises(ParameterError, match=r"\(2, time\)"):
        DriveGuard(display()).process(np.zeros((3, 5)))


def test_a_guard_has_loaded_what_its_first_block_needs():
    """A device calls it within milliseconds; importing scipy.signal takes a second."""
    program = (
        "import sys\n"
        "from tactogram.rendering.displays.catalogue import open_display\n"
        "from tactogram_playback.drive_guard import DriveGuard\n"
        "display = open_display('electrovibration')\n"
        "assert 'scipy.signal' not in sys.modules\n"
        "DriveGuard(display)\n"
        "assert 'scipy.signal' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
