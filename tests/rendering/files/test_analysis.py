import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import carrier, envelope_of, events_of
from tactogram.rendering.files.events import Events, FrequencySpan, Part, Transient, joined, thinned
from tactogram.signal import Signal

RATE = 8000


def sine(hz, amplitude=1.0, seconds=1.0, rate=RATE):
    t = np.arange(round(seconds * rate)) / rate
    return Signal(amplitude * np.sin(2 * np.pi * hz * t), rate, "1")


def middle(envelope, values):
    return values[(envelope.times > 0.1) & (envelope.times < envelope.end - 0.1)]


@pytest.mark.parametrize("rate", [1000, 8000, 44100])
@pytest.mark.parametrize("hz", [40, 150, 300])
def test_a_sine_has_its_amplitude_and_frequency(hz, rate):
    envelope = envelope_of(sine(hz, 0.7, rate=rate))
    np.testing.assert_allclose(middle(envelope, envelope.amplitude), 0.7, rtol=0.02)
    np.testing.assert_allclose(middle(envelope, envelope.frequency), hz, rtol=0.01)
    assert (envelope.start, envelope.end) == (0.0, 1.0)


def test_a_constant_and_what_is_above_1_khz_are_not_felt():
    x = sine(150, 0.5).samples + 3 + sine(2500, 0.9).samples
    envelope = envelope_of(Signal(x, RATE, "1"))
    np.testing.assert_allclose(middle(envelope, envelope.amplitude), 0.5, rtol=0.02)


def test_a_modulated_carrier_comes_back():
    t = np.arange(2 * RATE) / RATE
    x = (0.5 + 0.4 * np.sin(2 * np.pi * 3 * t)) * np.sin(2 * np.pi * (120 * t + 20 * t**2))
    once = envelope_of(Signal(x, RATE, "1"))
    back = envelope_of(carrier(Events(2.0, (once,)), RATE))
    inside = (once.times > 0.1) & (once.times < 1.9)
    assert np.abs(back.amplitude - once.amplitude)[inside].max() < 0.02
    assert np.abs(back.frequency - once.frequency)[inside].max() < 2


def test_a_click_is_a_transient_and_both_have_its_energy():
    t = np.arange(RATE) / RATE
    click = np.where(np.abs(t - 0.5) < 0.002, 0.9 * np.sin(2 * np.pi * 250 * t), 0.0)
    signal = Signal(click + 0.03 * np.sin(2 * np.pi * 100 * t), RATE, "1")
    events = events_of(signal)
    [tap] = events.transients
    assert tap.time == pytest.approx(0.498, abs=0.003)
    without = envelope_of(signal)
    assert without.peak > events.joined.peak
    energy = float(np.sum(carrier(Events(1.0, (without,)), RATE).samples ** 2))
    assert float(np.sum(carrier(events, RATE).samples ** 2)) == pytest.approx(energy, rel=0.2)


def test_a_click_in_silence_is_a_transient_without_a_ghost():
    for rate in (2000, 8000, 44_100):
        x = np.zeros(2 * rate)
        x[rate : rate + rate // 500] = 0.9
        events = events_of(Signal(x, rate, "1"))
        assert [round(tap.time, 2) for tap in events.transients] == [1.0]
        t = np.arange(0, 2, 0.001)
        assert events.strength(t)[np.abs(t - 1.0) > 0.022].max() == 0


def test_a_steady_vibration_has_no_transient_but_at_its_beginning():
    assert all(tap.time < 0.01 for tap in events_of(sine(150, 0.5)).transients)


def test_a_jump_and_a_transient_are_played_where_they_stand():
    part = Part.of([0, 0.5, 0.5, 1.0], [0, 0, 0.5, 0.5], 0.0, 100.0)
    x = carrier(Events.of([part], [Transient(0.25, 0.3, 200.0)]), RATE).samples[0]
    assert np.abs(x[: RATE // 4]).max() == 0
    assert 0.2 < np.abs(x[RATE // 4 : RATE // 4 + 160]).max() <= 0.3
    assert np.abs(x[RATE // 4 + 161 : RATE // 2]).max() == 0
    assert np.abs(x[RATE // 2 + 1 :]).max() == pytest.approx(0.5, rel=0.01)


def test_vibrations_together_are_no_weaker_than_the_strongest_of_them():
    parts = [
        Part.of([a, a + 1], [level, level], 0.0, hz)
        for a, level, hz in ((0, 0.6, 100), (0.5, 0.3, 200), (3, 0.2, 50))
    ]
    t = np.array([0.2, 0.7, 1.2, 2.0, 3.5])
    power = joined(parts)
    assert power.at(t) == pytest.approx([0.6, np.hypot(0.6, 0.3), 0.3, 0, 0.2])
    assert power.hz(t[:3]) == pytest.approx([100, 120, 200])
    strongest = joined(parts, strongest=True)
    assert strongest.at(t) == pytest.approx([0.6, 0.6, 0.3, 0, 0.2])
    assert strongest.hz(t[:3]) == pytest.approx([100, 100, 200])


def test_silence_and_one_sample_have_envelopes():
    assert envelope_of(Signal(np.zeros(100), RATE, "1")).peak == 0
    one = envelope_of(Signal(np.ones(1), RATE, "1"))
    assert (len(one.times), one.end) == (2, 1 / RATE)


def test_several_axes_and_displacement_are_refused():
    with pytest.raises(ParameterError, match="one axis, got x, y, z"):
        envelope_of(Signal(np.ones((3, 9)), RATE, "1"))
    with pytest.raises(ParameterError, match="at a speed first"):
        envelope_of(Signal(np.ones(9), 40, "1", domain="displacement"))


def test_a_carrier_above_half_the_rate_is_refused():
    with pytest.raises(ParameterError, match="a carrier of 1.* Hz needs more than .* Hz, got 200"):
        carrier(events_of(sine(150)), 200)


def test_a_span_maps_both_ways():
    span = FrequencySpan(65, 300)
    np.testing.assert_allclose(span.hz(span.share([65, 100, 300])), [65, 100, 300])
    np.testing.assert_array_equal(span.share([10, 1000]), [0, 1])


@given(
    st.lists(st.floats(0, 1, allow_subnormal=False), min_size=2, max_size=500),
    st.floats(0.001, 0.3),
)
def test_thinned_lines_stay_within_tolerance(values, tolerance):
    values = np.array(values)
    times = np.arange(len(values)) * 0.005
    kept = thinned(times, values, tolerance)
    assert (kept[0], kept[-1]) == (0, len(values) - 1)
    assert np.abs(np.interp(times, times[kept], values[kept]) - values).max() <= tolerance + 1e-12


@pytest.mark.parametrize("seconds", [1.99991, 2.0, 2.00007])
def test_a_tone_that_is_not_felt_has_no_events_at_its_ends(seconds):
    rate = 44_100
    t = np.arange(round(seconds * rate)) / rate
    events = events_of(Signal(0.7 * np.sin(2 * np.pi * 3000 * t + 0.5), rate, "1"))
    assert (events.parts, events.transients) == ((), ())
    click = np.where(t < 0.002, np.sin(2 * np.pi * 300 * t), 0)
    [tap] = events_of(Signal(click, rate, "1")).transients
    assert tap.time == pytest.approx(0, abs=0.003)


def test_vibrations_that_overlap_sound_at_their_own_frequencies():
    ends = [0.0, 2.0]
    parts = [Part.of(ends, [0.3, 0.3], ends, hz) for hz in ([80, 90], [200, 210])]
    x = carrier(Events(2.0, tuple(parts))).samples[0]
    power = np.abs(np.fft.rfft(x)) ** 2
    hz = np.fft.rfftfreq(len(x), 1 / RATE)
    shares = [power[(hz > low) & (hz < high)].sum() / power.sum() for low, high in ((70, 100), (190, 220))]
    assert shares == pytest.approx([0.5, 0.5], abs=0.02)


def test_a_frequency_above_half_the_usual_rate_gets_a_higher_rate():
    events = Events.of([Part.of([0, 1], [0.5, 0.5], 0.0, 4500.0)], [])
    assert carrier(events).rate == 11_250
    with pytest.raises(ParameterError, match="needs more than 9000 Hz, got 8000"):
        carrier(events, 8000)
