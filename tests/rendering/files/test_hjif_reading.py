"""What an HJIF document plays: curves, transients, base signals and bands."""

import copy
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch
from tests.rendering.files.documents import problems, read

from tactogram.errors import DataError
from tactogram.rendering.files import read_haptic
from tactogram.rendering.files.formats import hjif

GOLDEN = Path(__file__).parent / "golden" / "min.hjif"


def minimal():
    return json.loads(GOLDEN.read_text())


def band(document):
    return document["perceptions"][0]["channels"][0]["bands"][0]


def played(rate=8000, seconds=1.0, **changes):
    document = minimal()
    document["perceptions"][0]["channels"][0].update(
        frequency_sampling=rate, sample_count=round(rate * seconds)
    )
    band(document).update(changes)
    assert problems(hjif, document) == []
    return read(hjif, document).signal.samples[0]


def effect(*keyframes, position=0):
    frames = [{"relative_position": p, "amplitude_modulation": a} for p, a in keyframes]
    return {"effect_type": "Basis", "position": position, "keyframes": frames}


def test_the_golden_sweep_goes_from_100_to_300_hz_and_grows():
    file = read_haptic(GOLDEN)
    x, rate = file.signal.samples[0], file.signal.rate
    assert (rate, len(x), file.facts["modality"]) == (8000, 8000, "Vibrotactile Texture")
    for start, hz in ((1600, 150), (5600, 250)):  # at 0.25 s and 0.75 s
        frequency, power = welch(x[start : start + 800], rate, nperseg=800)
        assert frequency[np.argmax(power)] == pytest.approx(hz, abs=12)
    assert np.abs(x[3600:4400]).max() == pytest.approx(0.6, abs=0.05)
    assert np.abs(x).max() <= 1


def test_linear_curves_are_straight_and_cubic_ones_level_at_their_points():
    frames = [effect((0, 0.0), (500, 1.0), (999, 0.0))]
    linear = played(band_type="Curve", curve_type="Linear", effects=frames)
    cubic = played(band_type="Curve", curve_type="Cubic", effects=frames)
    assert linear[[1000, 2000, 4000]] == pytest.approx([0.25, 0.5, 1.0], abs=1e-3)
    assert cubic[[1000, 2000, 4000]] == pytest.approx([3 / 16 - 2 / 64, 0.5, 1.0], abs=1e-3)


def test_an_akima_curve_goes_through_its_points():
    frames = [effect(*[(100 * i, np.sin(i)) for i in range(10)])]
    x = played(band_type="Curve", curve_type="Akima", effects=frames)
    np.testing.assert_allclose(x[np.arange(10) * 800], np.sin(np.arange(10)), atol=1e-6)


@pytest.mark.parametrize("curve", ["Linear", "Cubic", "Akima"])
def test_a_curve_may_jump(curve):
    frames = [effect((0, 0.2), (500, 0.2), (500, 0.8), (999, 0.8))]
    x = played(band_type="Curve", curve_type=curve, effects=frames)
    assert x[[2000, 3990, 4010, 6000]] == pytest.approx([0.2, 0.2, 0.8, 0.8], abs=0.01)


def test_a_transient_is_two_periods_in_22_ms():
    x = played(band_type="Transient", effects=[effect((0, 0.5), position=100)])
    t = (np.arange(8000) / 8000 - 0.1) / 0.022
    expected = np.where((t >= 0) & (t <= 1), 0.5 * np.sin(4 * np.pi * t), 0)
    np.testing.assert_allclose(x, expected, atol=1e-6)


@pytest.mark.parametrize("base", ["Sine", "Square", "Triangle", "SawToothUp", "SawToothDown"])
def test_base_signals_have_their_period_and_range(base):
    frames = {
        "effect_type": "Basis",
        "position": 0,
        "base_signal": base,
        "keyframes": [
            {"relative_position": 0, "amplitude_modulation": 0.5, "frequency_modulation": 100},
            {"relative_position": 1000, "amplitude_modulation": 0.5, "frequency_modulation": 100},
        ],
    }
    x = played(effects=[frames])
    assert np.abs(x).max() == pytest.approx(0.5, rel=0.05)
    np.testing.assert_allclose(x[1:7800], x[81:7880], atol=0.03 if base == "Sine" else 1.01)
    assert np.mean(np.abs(x[1:7800] - x[81:7880])) < 0.02


def test_bands_add_up_and_are_limited():
    document = minimal()
    one = {
        "band_type": "Curve",
        "curve_type": "Linear",
        "lower_frequency_limit": 0,
        "upper_frequency_limit": 9,
    }
    bands = [one | {"effects": [effect((0, 0.7), (999, 0.7))]} for _ in range(2)]
    document["perceptions"][0]["channels"][0].update(bands=bands, gain=0.5)
    assert read(hjif, document).signal.samples[0, :100] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"band_type": "WaveletWave", "block_length": 128}, "WaveletWave bands cannot be read"),
        ({"band_type": "Curve", "curve_type": "Bezier"}, "type Bezier cannot be read"),
        ({"effects": [{"effect_type": "Reference", "position": 0}]}, "Reference effects cannot be read"),
    ],
)
def test_what_has_no_public_description_is_refused(changes, message):
    document = minimal()
    band(document).update(changes)
    with pytest.raises(DataError, match=message):
        read(hjif, document)


def perception(document):
    return document["perceptions"][0]


RULES = {
    **{
        f"{name}: is required": lambda d, name=name: d.pop(name)
        for name in (
            "version",
            "profile",
            "level",
            "date",
            "description",
            "timescale",
            "avatars",
            "perceptions",
            "syncs",
        )
    },
    "a year from 2023 on": lambda d: d.update(version="2022"),
    "got 2023-12": lambda d: d.update(version="2023-12"),
    "profile: must be": lambda d: d.update(profile="Best"),
    "level must be 1 to 2, got 3": lambda d: d.update(level=3),
    "timescale of Simple Parametric must be 1000": lambda d: d.update(
        profile="Simple Parametric", timescale=999
    ),
    "timescale must be 1 to 48000, got 48001": lambda d: d.update(timescale=48_001),
    "each perception must have": lambda d: d["perceptions"].append(perception(d)),
    "each channel must have": lambda d: perception(d)["channels"].append(perception(d)["channels"][0]),
    "perception_modality": lambda d: perception(d).update(perception_modality="Texture"),
    "effect_library: is required": lambda d: perception(d).pop("effect_library"),
    "gain: is required": lambda d: perception(d)["channels"][0].pop("gain"),
    "band_type": lambda d: band(d).update(band_type="Wave"),
    "lower_frequency_limit must not be above": lambda d: band(d).update(lower_frequency_limit=2000),
    "in order of relative_position": lambda d: band(d)["effects"][0]["keyframes"].reverse(),
    "frequency_modulation must be numbers": lambda d: band(d)["effects"][0]["keyframes"][0].update(
        frequency_modulation="x"
    ),
    "a VectorialWave effect must have a frequency: left out": lambda d: [
        frame.pop("frequency_modulation", None) for frame in band(d)["effects"][0]["keyframes"]
    ],
    "7 bands per channel": lambda d: perception(d)["channels"][0].update(bands=[band(d)] * 8),
    "127 channels at most, got 128": lambda d: perception(d).update(
        channels=[perception(d)["channels"][0] | {"id": i} for i in range(128)]
    ),
}


@pytest.mark.parametrize("problem", RULES)
def test_each_rule_is_checked(problem):
    document = minimal()
    assert problems(hjif, document) == []
    bad = copy.deepcopy(document)
    RULES[problem](bad)
    assert any(problem in line for line in problems(hjif, bad)), problems(hjif, bad)
