"""Lines nearest to an envelope."""

import itertools

import numpy as np

from tactogram.rendering.files import control_points as module_of_points


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
