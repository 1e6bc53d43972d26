"""Lines nearest to an envelope."""

import itertools

import numpy as np
import pytest

from tactogram.rendering.files import control_points as module_of_points
from tactogram.rendering.files.events import Events, Transient


def test_no_other_three_lines_are_closer(monkeypatch):
    monkeypatch.setattr(module_of_points, "MOST_POINTS", 3)
    amplitude = np.random.default_rng(5).uniform(0, 1, 4 * 9 + 1)
    at = np.arange(len(amplitude))
    corners = {end: amplitude[4 * end] for end in range(1, 9)} | {0: 0.0, 9: 0.0}

    def error(ends):
        line = np.interp(at, 4 * np.array(ends), [corners[end] for end in ends])
        return np.sum((line - amplitude)[4:-5] ** 2)

    every = [(0, a, b, 9) for a, b in itertools.combinations(range(1, 9), 2)]
    found = module_of_points._chosen(amplitude, np.full(len(at), 150.0), 20 * np.arange(10))
    assert tuple(found) == min(every, key=error)


@pytest.mark.parametrize(
    ("times", "rises"),
    [
        ((0.005,), (0,)),  # a button of Meta's
        ((0.014,), (20,)),
        ((0.0, 0.045, 0.158), (0, 40, 158)),
        ((0.03, 0.086), (30, 90)),
    ],
)
def test_a_transient_is_moved_where_no_line_would_fit_before_it(times, rises):
    events = Events(0.25, transients=tuple(Transient(time, 0.6, 150.0) for time in times))
    part = module_of_points.control_points(events, what="effect")
    peaks = 1e3 * part.times[part.amplitude == 0.6] - module_of_points.SHORTEST_MS
    np.testing.assert_allclose(peaks, rises, atol=1e-9)
    assert np.abs(peaks - 1e3 * np.array(times)).max() <= 1e3 * module_of_points.MOVED_S
    assert np.diff(part.times).min() > 0.0199
