"""Sensitivity of the measures: each must detect its own kind of error, and only that."""

from itertools import pairwise

import numpy as np
import pytest
import soundfile
from hypothesis import HealthCheck, given, settings, strategies as st

from tactogram.evaluation.measures import memorisation, segments, signal_measures
from tactogram.evaluation.measures.measure import SignalSet
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass
from tactogram.signal.resampling import resample

MEASURES = signal_measures()
SPECTRAL = ("log_spectral_distance_db", "weighted_log_spectral_distance_db", "level_difference_db")
FLUCTUATION = ("envelope_spectrum_distance_db", "modulation_spectrum_distance_db")
LEVEL_FREE = (*FLUCTUATION, "amplitude_distance", "coherence_distance")

given_texture = settings(
    max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture(params=MEASURES)
def measure(request):
    return MEASURES[request.param].function


@pytest.fixture
def draw(texture):
    """Return a function that draws eight signals of a texture in bursts, another eight for each seed."""
    return lambda seed, **kind: [texture(100 * seed + k, **{"burst_hz": 8, **kind}) for k in range(8)]


def late(signals):
    """Return ``signals`` without their last 2 ms, and without their first: the same, 2 ms apart."""
    shift = round(0.002 * signals[0].rate)
    return [s.cut(0, len(s) - shift) for s in signals], [s.cut(shift) for s in signals]


@given_texture
@given(st.integers(0, 50), st.floats(0.1, 10))
def test_it_is_zero_on_itself_and_symmetric(measure, texture, seed, gain):
    one, other = [texture(seed), texture(seed + 1)], [texture(seed + 2, centre=90.0, gain=gain)]
    assert measure(one, one) == pytest.approx(0, abs=1e-9)
    assert measure(one, other) == pytest.approx(measure(other, one))
    assert measure(one, other) >= 0


@given_texture
@given(st.permutations(range(4)))
def test_the_order_of_a_set_does_not_count(measure, texture, order):
    one, other = [texture(k, seconds=2 + k % 2) for k in range(4)], [texture(9)]
    assert measure([one[k] for k in order], other) == pytest.approx(measure(one, other))


def test_sets_that_were_compared_before_give_the_same(measure, draw):
    one, other, third = (SignalSet(draw(seed)) for seed in range(3))
    before = measure(one, third), measure(one, other), measure(third, other)
    assert measure(one, other) == before[1] == measure(draw(0), draw(1))


def test_time_reversal_changes_little(measure, draw):
    one = draw(0)
    back = [s.with_samples(s.samples[:, ::-1]) for s in one]
    assert measure(one, back) <= 0.15 * measure(one, draw(1))


def test_a_shift_of_2_ms_changes_nothing(measure, draw):
    floor = measure(draw(0), draw(1))
    assert measure(*late(draw(0))) < 0.1 * floor


def test_real_against_real_is_below_another_material(measure, draw):
    floor = measure(draw(0), draw(1))
    # Another place, another rhythm, other tails, other axes.
    other = [
        s.with_samples(np.stack([s.samples[0], s.samples[1] - s.samples[0], s.samples[2] + s.samples[0]]))
        for s in draw(2, centre=60.0, burst_hz=3, gain=0.1)
    ]
    other = [s.with_samples(np.sign(s.samples) * np.abs(s.samples) ** 1.5) for s in other]
    assert measure(draw(0), other) > 4 * floor


def test_twice_the_pieces_from_the_same_place_change_little(measure, draw):
    one, other = draw(0), draw(2, centre=60.0, burst_hz=3)
    apart = [measure(segments(one, s), segments(other, s)) for s in (4.0, 2.0)]
    assert apart[0] == pytest.approx(apart[1], rel=0.25)


@pytest.mark.parametrize("name", MEASURES)
def test_measures_of_fluctuation_detect_noise_with_the_right_spectrum_but_no_envelope(name, draw, even):
    function = MEASURES[name].function
    floor = function(draw(0), draw(1))
    made = [even(s, k) for k, s in enumerate(draw(1))]
    if name in (*FLUCTUATION, "amplitude_distance"):
        assert function(draw(0), made) > 4 * floor
    else:
        assert function(draw(0), made) < 2 * floor


@pytest.mark.parametrize("gain_db", [-6.0, 3.0])
@pytest.mark.parametrize("name", MEASURES)
def test_measures_of_spectrum_and_level_detect_a_level_error(name, gain_db, draw):
    function = MEASURES[name].function
    gain = 10 ** (gain_db / 20)
    made = [s.with_samples(gain * s.samples) for s in draw(1)]
    apart, floor = function(draw(0), made), function(draw(0), draw(1))
    if name in LEVEL_FREE:
        assert apart == pytest.approx(floor, rel=0.02)
    else:
        assert apart == pytest.approx(abs(gain_db), abs=0.6)
        assert apart > 4 * floor


def test_only_memorisation_detects_a_copy(draw):
    train, unseen, new = draw(0), draw(1), draw(2)
    for each in MEASURES.values():
        assert each.function(late(train)[0], train) < each.function(unseen, train)
    assert memorisation(late(train)[1], train, unseen).copied > 0.95
    assert memorisation(new, train, unseen).copied < 0.05


def test_every_measure_declares_its_name_unit_and_source():
    for name, each in MEASURES.items():
        assert each.function.__name__.removesuffix("_db") == name.removesuffix("_db")
        assert name.endswith("_db") == (each.unit == "dB")
        assert each.title
        assert each.source


def test_multiaxis_measures_return_none_for_one_axis(texture):
    for each in MEASURES.values():
        assert (each.function([texture(0, axes=1)], [texture(1, axes=1)]) is None) == each.multiaxis


# ---- on real recordings


def lmt108(folder, count):
    """Return the sound of tools on ``count`` materials, eight recordings each, as vibration of 20-1000 Hz."""
    by_material = {}
    for path in sorted(folder.rglob("*.flac")):
        by_material.setdefault(path.name.split("_")[0], []).append(path)
    chosen = list(by_material.items())[:: max(1, len(by_material) // count)][:count]

    def read(path):
        samples, rate = soundfile.read(path, dtype="float32")
        return resample(bandpass(Signal(samples, rate, "1"), 20, 1000), 2500)

    return {name: [read(path) for path in paths] for name, paths in chosen}


def biotac(folder, count):
    """Return the (rectified) vibration of a finger on ``count`` materials, eight recordings each."""
    sets = {}
    for path in sorted(folder.glob("mat*.npz"))[:count]:
        with np.load(path, allow_pickle=False) as archive:
            starts = np.cumsum([0, *archive["lengths"]])
            pac = archive["pac"]
        pieces = [pac[a:b].reshape(-1) for a, b in pairwise(starts[:9])]
        sets[path.stem] = [Signal(x.astype(np.float32), 2200, "1") for x in pieces]
    return sets


@pytest.fixture(scope="module", params=["lmt108_sound", "biotac_slide"])
def real(request, real_data):
    return {"lmt108_sound": lmt108, "biotac_slide": biotac}[request.param](real_data(request.param), 5)


def cut(signals):
    return segments(signals, 2.0, count=8)


@pytest.mark.real_data
@pytest.mark.parametrize("name", [n for n, m in MEASURES.items() if not m.multiaxis])
def test_on_real_recordings_the_floor_is_below_the_ceiling_and_a_shift_is_nothing(name, real):
    function = MEASURES[name].function
    floors, ceilings, shifts = [], [], []
    for material, members in real.items():
        others = [s for other, part in real.items() if other != material for s in part]
        floors.append(function(cut(members[::2]), cut(members[1::2])))
        ceilings.append(function(cut(members[::2]), cut(others)))
        shifts.append(function(*late(cut(members[::2]))))
    assert np.mean(ceilings) > 1.3 * np.mean(floors)
    assert np.mean(shifts) < 0.15 * np.mean(floors)


@pytest.mark.real_data
def test_on_real_sound_a_lost_envelope_is_detected_despite_the_right_spectrum(real_data, even):
    for members in lmt108(real_data("lmt108_sound"), 5).values():
        one, made = cut(members[::2]), [even(s, k) for k, s in enumerate(cut(members[1::2]))]
        for name in FLUCTUATION:
            function = MEASURES[name].function
            assert function(one, made) > 2 * function(one, cut(members[1::2]))
        level = MEASURES["level_difference_db"].function
        assert level(one, made) < level(one, cut(members[1::2])) + 0.6


@pytest.mark.real_data
def test_on_real_recordings_only_a_copy_is_detected(real):
    for members in real.values():
        train, unseen, new = members[:4], members[4:6], members[6:]
        assert memorisation([train[1].cut(777)], train, unseen).copied == 1
        assert memorisation(new, train, unseen).copied < 0.35
