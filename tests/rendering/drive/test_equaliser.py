"""Equaliser of a stream: the magnitude of a file's, causal, with correct errors and delay."""

import numpy as np
import pytest
from benchmarks.experiments.simulated_transducer import simulate_envelope
from hypothesis import given, settings, strategies as st
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.displays.response import ResonatorResponse
from tactogram.rendering.drive.equaliser import WITHIN_DB, Equaliser, _cut, _impulse, equaliser
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram_playback.streaming.output import DisplayOutput
from tactogram_playback.transducer.circuit import Transducer


def tones(display, low, high, *, level):
    """Return a sum of tones, two periods of 1 s, and the tones' frequencies."""
    frequency = np.unique(np.round(np.geomspace(low, high, 40)))
    t = np.arange(int(display.rate)) / display.rate
    phase = np.random.default_rng(1).uniform(0, 2 * np.pi, len(frequency))
    period = np.cos(2 * np.pi * frequency[:, None] * t + phase[:, None]).sum(axis=0)
    period *= level / np.abs(period).max()
    return Signal(np.tile(period, 3).astype(np.float32), display.rate, "m/s^2"), frequency.astype(int)


def streamed(display, signal):
    """Return the drive of a stream of ``signal``, before the guard, in blocks of 5 ms, and the output."""
    output = DisplayOutput(display, signal, level=parse_level("gain=1"))
    step = int(0.005 * display.rate)
    blocks = [signal.samples[:, i : i + step] for i in range(0, len(signal), step)]
    return np.concatenate([output.drive.process(b, None) for b in blocks], axis=1)[0], output


def decibels(samples, like, frequency, rate):
    """Return the gain of the middle second of ``samples`` over that of ``like``, dB, at whole Hz."""
    middle = slice(int(rate), 2 * int(rate))
    return 20 * np.log10(
        np.abs(np.fft.rfft(samples[middle])[frequency] / np.fft.rfft(like[middle])[frequency])
    )


@pytest.mark.parametrize("on", [True, False])
def test_a_streamed_voice_coil_gives_what_a_file_does(on):
    display = open_display("voice-coil", changes={"linear.equalise": "full" if on else "none"})
    signal, f = tones(display, 30, 880, level=0.3)
    drive, output = streamed(display, signal)
    whole = fit(signal, display, level=parse_level("gain=1")).signal.samples[0]
    wanted = signal.samples[0].astype(float)
    arriving = decibels(drive, wanted, f, display.rate) + 20 * np.log10(np.abs(display.response.at(f)))
    found = output.facts()["equaliser"]
    assert found["on"] is on
    assert found["error_most_db"] < WITHIN_DB
    assert decibels(drive, whole, f, display.rate) == pytest.approx(0, abs=found["error_most_db"] + 0.02)
    assert (np.ptp(arriving[f >= 40]) < 0.25) if on else (np.ptp(arriving) > 17)


@pytest.mark.parametrize("q", [30, 100])
def test_a_streamed_envelope_arrives_flat_up_to_the_end_of_the_band(q):
    """Through the circuit itself, independent of the equaliser's formula."""
    for on in (True, False):
        changes = {"ultrasonic.q": q, "ultrasonic.pre_emphasis": on}
        display = open_display("ultrasonic-envelope", changes=changes)
        signal, f = tones(display, 10, 980, level=0.1)
        drive, _ = streamed(display, signal)
        heard = simulate_envelope(Transducer(q=q), Signal(drive, display.rate, "V")).samples[0]
        carrier = display.settings.carrier_v
        arriving = decibels(heard / carrier - 1, signal.samples[0], f, display.rate)
        if on:
            assert np.abs(arriving).max() < 0.25
        else:
            cutoff = display.settings.carrier_hz / (2 * q)
            assert arriving[-1] == pytest.approx(-10 * np.log10(1 + (f[-1] / cutoff) ** 2), abs=0.6)


def test_what_lies_outside_of_the_band_is_not_driven():
    display = open_display("voice-coil")
    design = DisplayOutput(
        display, tones(display, 30, 800, level=0.1)[0], level=parse_level("gain=1")
    ).drive.design
    inside = np.abs(design.response(design.checked_hz)).min()
    outside = np.abs(design.response(np.array([2.0, 5.0, 2000.0, 3900.0])))
    assert (20 * np.log10(outside / inside) < [-60, -30, -30, -60]).all()


@settings(max_examples=8, deadline=None)
@given(
    resonance=st.floats(40, 600),
    q=st.floats(0.7, 8),
    cap_db=st.floats(0, 30),
    cuts=st.lists(st.integers(1, 90), min_size=1, max_size=8),
)
def test_any_resonance_is_made_up_for_and_cutting_changes_nothing(resonance, q, cap_db, cuts):
    response = ResonatorResponse(kind="resonator", unit="m/s^2", gain=3.0, resonance_hz=resonance, q=q)
    most = np.abs(response.at(np.geomspace(20, 1000, 500))).max() / 10 ** (cap_db / 20)
    design = equaliser(
        8000, (20, 1000), lambda f: 1 / np.maximum(np.abs(response.at(f)), most), checked=(23, 890)
    )
    facts = design.facts()
    assert facts["error_most_db"] <= 0.5
    assert facts["raised_db"] <= cap_db + 1.0
    x = np.random.default_rng(0).standard_normal((2, sum(cuts)))
    whole, cut = Equaliser(design), Equaliser(design)
    blocks = [cut.process(block) for block in np.split(x, np.cumsum(cuts)[:-1], axis=1)]
    np.testing.assert_allclose(np.concatenate(blocks, axis=1), whole.process(x), atol=1e-9)


def test_a_band_of_less_than_its_edges_is_checked_where_it_is():
    display = open_display("voice-coil", changes={"band": [200, 210]})
    facts = DisplayOutput(display, tones(display, 30, 800, level=0.1)[0], level=parse_level("gain=1")).facts()
    found = facts["equaliser"]
    assert found["checked_hz"] == pytest.approx([200, 210])
    assert found["error_most_db"] < WITHIN_DB


def test_the_delay_that_is_told_is_measured():
    """A tone burst of 250 Hz comes out later by the group delay."""
    design = DisplayOutput(
        open_display("voice-coil"),
        tones(open_display("voice-coil"), 30, 800, level=0.1)[0],
        level=parse_level("gain=1"),
    ).drive.design
    t = np.arange(8000) / 8000
    burst = np.exp(-(((t - 0.5) / 0.05) ** 2)) * np.sin(2 * np.pi * 250 * t)
    out = Equaliser(design).process(burst[None])[0]
    centre = [
        np.sum(np.abs(dsp.hilbert(x)) ** 2 * t) / np.sum(np.abs(dsp.hilbert(x)) ** 2) for x in (burst, out)
    ]
    assert 8000 * (centre[1] - centre[0]) == pytest.approx(design.facts()["delay_samples"], abs=0.3)
    assert 3 < design.facts()["delay_samples"] < 6


def test_least_phase_has_the_magnitude_and_is_early():
    frequency = np.linspace(0, 4000, 4097)
    gain = 1 / np.hypot(1, frequency / 200)
    taps = _cut(_impulse(gain), 400)
    assert np.abs(np.fft.rfft(taps, 8192)) == pytest.approx(gain, rel=0.02)
    assert np.abs(taps[:60]).sum() > 0.98 * np.abs(taps).sum()


def test_what_cannot_be_made_up_for_is_said():
    audio = open_display("audio")
    moved = open_display("voice-coil", changes={"linear.equalise": "none"})
    with pytest.raises(ParameterError, match="does not fit a rate of 100 Hz"):
        equaliser(100, (60, 1000), np.ones_like)
    with pytest.raises(ParameterError, match="finite and > 0"):
        equaliser(8000, (20, 1000), np.zeros_like)
    noise = tones(moved, 30, 800, level=0.1)[0]
    said = DisplayOutput(
        audio, Signal(np.tile(noise.samples, 6), 48_000, "m/s^2"), level=parse_level("peak=0.5")
    )
    assert "is not known: measure it" in said.sentence()
    left = DisplayOutput(moved, noise, level=parse_level("gain=1")).sentence()
    assert "is not equalised" in left
