import copy
import json
from pathlib import Path

import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files import read_haptic
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.formats import haptic
from tactogram.signal import Signal

GOLDEN = Path(__file__).parents[1] / "golden" / "my.haptic"


def amplitude(document):
    return document["signals"]["continuous"]["envelopes"]["amplitude"]


def frequency(document):
    return document["signals"]["continuous"]["envelopes"]["frequency"]


REFUSED = {
    "at least two breakpoints, got 1": lambda d: amplitude(d).__delitem__(slice(1, None)),
    "longer than 0 s": lambda d: [point.update(time=0.5) for point in amplitude(d)],
    "version.major: must be 1, got 2": lambda d: d["version"].update(major=2),
    "version: is required": lambda d: d.pop("version"),
    "signals: is required": lambda d: d.pop("signals"),
    "amplitude: is required": lambda d: d["signals"]["continuous"]["envelopes"].pop("amplitude"),
    "at least two breakpoints, got 0": lambda d: amplitude(d).clear(),
    "time: must be a number, got []": lambda d: amplitude(d)[0].update(time=[]),
}
FORGIVEN = {
    "amplitude must be 0 to 1, got 1.2: clamped": lambda d: amplitude(d)[0].update(amplitude=1.2),
    "amplitude breakpoints must be in order": lambda d: amplitude(d).reverse(),
    "amplitude must be 0 to 1, got 1.5": lambda d: amplitude(d)[1]["emphasis"].update(amplitude=1.5),
    "frequency must be 0 to 1, got -0.1": lambda d: amplitude(d)[1]["emphasis"].update(frequency=-0.1),
    "at least the envelope's, got 0.7 of 0.8": lambda d: amplitude(d)[1]["emphasis"].update(amplitude=0.7),
    "frequency must be 0 to 1, got 2": lambda d: frequency(d)[0].update(frequency=2),
    "frequency breakpoints must be in order": lambda d: frequency(d).reverse(),
    "within the amplitude envelope, 0 to 1 s, got 1.5 s": lambda d: frequency(d)[1].update(time=1.5),
    "version must have a minor": lambda d: d["version"].pop("minor"),
}
"""Rules that `haptic_data` checks in strict mode, and players forgive."""


@pytest.mark.parametrize("problem", [*REFUSED, *FORGIVEN])
def test_each_rule_is_checked_and_what_players_forgive_is_read(problem):
    document = json.loads(GOLDEN.read_text())
    assert problems(haptic, document) == []
    bad = copy.deepcopy(document)
    (REFUSED | FORGIVEN)[problem](bad)
    [found] = problems(haptic, bad)
    assert problem in found
    if problem in FORGIVEN:
        assert read(haptic, bad).events.seconds == 1
    else:
        with pytest.raises(DataError):
            read(haptic, bad)


def test_the_golden_file_is_read():
    file = read_haptic(GOLDEN)
    assert (file.signal.seconds, file.signal.rate, file.signal.unit) == (1.0, 8000, "1")
    assert file.facts["carrier_hz"] == [55, 200]
    found = envelope_of(file.signal)
    assert np.interp(0.25, found.times, found.amplitude) == pytest.approx(0.4, abs=0.02)
    expected = 55 + 145 * np.array([0.4, 0.6])
    assert np.interp([0.25, 0.75], found.times, found.frequency) == pytest.approx(expected, abs=4)


def test_an_emphasis_stands_out():
    document = json.loads(GOLDEN.read_text())
    document["signals"]["continuous"]["envelopes"]["amplitude"][1]["emphasis"]["amplitude"] = 1.0
    with_it = read(haptic, document).signal.samples
    amplitude(document)[1].pop("emphasis")
    without = read(haptic, document).signal.samples
    added = np.abs(with_it - without)[0]
    assert added.max() == pytest.approx(0.2, abs=0.1)
    assert np.flatnonzero(added)[[0, -1]] / 8000 == pytest.approx([0.5, 0.506], abs=0.002)


def test_without_frequencies_the_middle_is_taken():
    document = json.loads(GOLDEN.read_text())
    document["signals"]["continuous"]["envelopes"].pop("frequency")
    decoded = read(haptic, document)
    found = envelope_of(decoded.signal)
    assert np.interp(0.5, found.times, found.frequency) == pytest.approx(127.5, abs=2)
    assert "nothing in the file" in decoded.facts["carrier_from"]


def test_a_burst_gets_an_emphasis_that_is_valid():
    t = np.arange(8000) / 8000
    x = np.where(np.abs(t - 0.5) < 0.003, np.sin(2 * np.pi * 250 * t), 0.02 * np.sin(2 * np.pi * 90 * t))
    document = written_by(haptic, Signal(0.9 * x, 8000, "1"))
    assert problems(haptic, document) == []
    emphasised = [point for point in amplitude(document) if "emphasis" in point]
    assert any(abs(point["time"] - 0.5) < 0.005 for point in emphasised)
    assert all(point["emphasis"]["amplitude"] >= point["amplitude"] for point in emphasised)


def test_too_short_a_signal_is_refused():
    with pytest.raises(ParameterError, match="at least 1e-05 s"):
        written_by(haptic, Signal(np.ones(1), 1e6, "1"))
