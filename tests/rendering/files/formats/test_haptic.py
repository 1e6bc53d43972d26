import copy
import json
from pathlib import Path

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.files import read_haptic
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.envelope import envelope_of
from tactogram.rendering.files.formats import haptic
from tactogram.signal import Signal

GOLDEN = Path(__file__).parents[1] / "golden" / "my.haptic"


def amplitude(document):
    return document["signals"]["continuous"]["envelopes"]["amplitude"]


def frequency(document):
    return document["signals"]["continuous"]["envelopes"]["frequency"]


RULES = {
    "amplitude must be 0 to 1, got 1.2": lambda d: amplitude(d)[0].update(amplitude=1.2),
    "amplitude breakpoint 1 at -1 s: out of order": lambda d: amplitude(d)[1].update(time=-1),
    "emphasis amplitude must be 0 to 1, got 1.5": lambda d: amplitude(d)[1]["emphasis"].update(amplitude=1.5),
    "emphasis frequency must be 0 to 1, got -0.1": lambda d: amplitude(d)[1]["emphasis"].update(
        frequency=-0.1
    ),
    "at least the envelope's 0.8, got 0.7": lambda d: amplitude(d)[1]["emphasis"].update(amplitude=0.7),
    "at least two breakpoints, got 1": lambda d: amplitude(d).__delitem__(slice(1, None)),
    "longer than 0 s": lambda d: [point.update(time=0.5) for point in amplitude(d)],
    "frequency must be 0 to 1, got 2": lambda d: frequency(d)[0].update(frequency=2),
    "frequency breakpoint 1 at 0.2 s: out of order": lambda d: [
        frequency(d)[0].update(time=0.4),
        frequency(d)[1].update(time=0.2),
    ],
    "outside the amplitude envelope, 0 to 1 s": lambda d: frequency(d)[1].update(time=1.5),
}
"""The ten of `haptic_data`'s ValidationError."""
STRUCTURE = {
    "version.major": lambda d: d["version"].update(major=2),
    "signals: is required": lambda d: d.pop("signals"),
    "amplitude: is required": lambda d: d["signals"]["continuous"]["envelopes"].pop("amplitude"),
    "at least two breakpoints, got 0": lambda d: amplitude(d).clear(),
    "time: must be a valid number": lambda d: amplitude(d)[0].update(time="0"),
}


@pytest.mark.parametrize("problem", [*RULES, *STRUCTURE])
def test_each_rule_is_checked(problem):
    document = json.loads(GOLDEN.read_text())
    assert haptic.validate(document) == []
    bad = copy.deepcopy(document)
    (RULES | STRUCTURE)[problem](bad)
    assert any(problem in line for line in haptic.validate(bad)), haptic.validate(bad)


def test_the_golden_file_is_read():
    file = read_haptic(GOLDEN)
    assert (file.signal.seconds, file.signal.rate, file.signal.unit) == (1.0, 8000, "1")
    assert file.facts["carrier_hz"] == [55, 200]
    found = envelope_of(file.signal, pulses=False)
    assert np.interp(0.25, found.times, found.amplitude) == pytest.approx(0.4, abs=0.02)
    expected = 55 + 145 * np.array([0.4, 0.6])
    assert np.interp([0.25, 0.75], found.times, found.frequency) == pytest.approx(expected, abs=4)


def test_an_emphasis_stands_out():
    document = json.loads(GOLDEN.read_text())
    document["signals"]["continuous"]["envelopes"]["amplitude"][1]["emphasis"]["amplitude"] = 1.0
    with_it = haptic.decode(document, 8000).signal.samples
    amplitude(document)[1].pop("emphasis")
    without = haptic.decode(document, 8000).signal.samples
    added = np.abs(with_it - without)[0]
    assert added.max() == pytest.approx(0.2, abs=0.1)
    assert np.flatnonzero(added)[[0, -1]] / 8000 == pytest.approx([0.5, 0.52], abs=0.005)


def test_without_frequencies_the_middle_is_taken():
    document = json.loads(GOLDEN.read_text())
    document["signals"]["continuous"]["envelopes"].pop("frequency")
    decoded = haptic.decode(document, 8000)
    found = envelope_of(decoded.signal, pulses=False)
    assert np.interp(0.5, found.times, found.frequency) == pytest.approx(127.5, abs=2)
    assert "nothing in the file" in decoded.facts["carrier_from"]


def test_a_burst_gets_an_emphasis_that_is_valid():
    t = np.arange(8000) / 8000
    x = np.where(np.abs(t - 0.5) < 0.003, np.sin(2 * np.pi * 250 * t), 0.02 * np.sin(2 * np.pi * 90 * t))
    document = haptic.encode(Signal(0.9 * x, 8000, "1"), DocumentHeader())
    assert haptic.validate(document) == []
    emphasised = [point for point in amplitude(document) if "emphasis" in point]
    assert any(abs(point["time"] - 0.5) < 0.005 for point in emphasised)
    assert all(point["emphasis"]["amplitude"] >= point["amplitude"] for point in emphasised)


def test_too_short_a_signal_is_refused():
    with pytest.raises(ParameterError, match="at least 1e-05 s"):
        haptic.encode(Signal(np.ones(1), 1e6, "1"), DocumentHeader())
