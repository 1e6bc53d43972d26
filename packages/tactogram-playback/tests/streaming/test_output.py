"""A stream to a display: safe and within its limits."""

import types
from functools import cache
from itertools import count, pairwise

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.level import parse_level
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Signal
from tactogram_playback.streaming.backends import (
    FrameReader,
    run_unpaced,
)
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.output import DisplayOutput, Stream
from tactogram_playback.streaming.textures import SurfaceTexture

RATE, MOST = 8000.0, 40


@pytest.fixture(name="output", scope="module")
def output_fixture(engine):
    @cache
    def rehearsed(rate):
        tried = Stream(engine(SimulatedHand(2, seed=9), rate=rate, most=int(0.005 * rate)), record_s=2.0)
        run_unpaced(tried, seconds=2.0)
        return Signal(tried.recorded, rate, "m/s^2")

    def make(name="voice-coil", level="gain=1", **changes):
        display = open_display(name, changes=changes)
        return DisplayOutput(display, rehearsed(display.rate), level=parse_level(level))

    return make


class Broken:
    """A texture that fails after a while."""

    name, unit, axes, delay_s, holds_at_rest, level = "broken", "m/s^2", ("z",), 0.0, True, 1.0

    def __init__(self, after, kind):
        self.left, self.kind = after, kind

    def render(self, motion, out):
        self.left -= 1
        out[:, : motion.count] = 3.0
        if self.left < 0:
            if self.kind == "raises":
                raise RuntimeError("gone")
            out[0, 3] = np.nan


def test_the_drive_is_that_of_a_fitted_file(engine, output):
    """Streamed and rendered as a whole, the same signal gives the same level in every octave of the band."""
    from tactogram.rendering.drive.fit import fit

    out = output()
    plain = Stream(engine(), record_s=3.0)
    run_unpaced(plain, seconds=3.0)
    driven = Stream(engine(), out, record_s=3.0)
    run_unpaced(driven, seconds=3.0)
    whole = fit(Signal(plain.recorded, RATE, "m/s^2"), out.display, level=parse_level("gain=1")).signal
    edges = [40, 80, 160, 320, 640]
    streamed, fitted = (octaves(x, edges) for x in (driven.recorded[0], whole.samples[0]))
    assert np.abs(10 * np.log10(streamed / fitted)).max() < 1.0


def octaves(x, edges):
    power = np.abs(np.fft.rfft(x)) ** 2
    frequency = np.fft.rfftfreq(len(x), 1 / RATE)
    return np.array([power[(frequency >= a) & (frequency < b)].sum() for a, b in pairwise(edges)])


@pytest.mark.parametrize("level", ["gain=1", "gain=1000", "peak=0.5", "sensation=20", "physical"])
def test_no_level_leaves_the_limits(engine, output, level):
    out = output(level=level)
    driven = Stream(engine(), out, record_s=2.0)
    run_unpaced(driven, seconds=2.0)
    assert driven.error is None
    assert 0 < np.abs(driven.recorded).max() <= out.display.limit


@pytest.mark.parametrize("kind", ["raises", "nan"])
def test_an_error_brings_the_display_to_rest_without_a_jump(script, output, kind):
    moving = Engine([Broken(60, kind)], script(lambda t: 100 * t), rate=RATE, most=MOST)
    driven = Stream(moving, output(), record_s=1.0)
    for block in range(100):
        driven.next(block * MOST / RATE)
    assert driven.error is not None
    sent = driven.recorded[0]
    assert np.isfinite(sent).all()
    assert np.abs(sent[62 * MOST + 160 :]).max() == 0
    assert np.abs(np.diff(sent[58 * MOST :])).max() < 0.1 * np.abs(sent).max()


def test_without_a_display_an_error_fades_too(script):
    moving = Engine([Broken(20, "raises")], script(lambda t: 100 * t), rate=RATE, most=MOST)
    plain = Stream(moving, record_s=0.2)
    for block in range(40):
        plain.next(block * MOST / RATE)
    assert isinstance(plain.error, RuntimeError)
    assert np.abs(np.diff(plain.recorded[0, 15 * MOST :])).max() < 0.2
    assert np.abs(plain.recorded[0, -10 * MOST :]).max() == 0


def test_a_lost_connection_brings_the_display_to_rest(engine, script, output):
    driven = Stream(engine(script(lambda t: 100 * t, end=0.5)), output(), record_s=1.0)
    run_unpaced(driven, seconds=1.0)
    assert np.abs(driven.recorded[0, 3000:4000]).max() > 0
    assert np.abs(driven.recorded[0, -2000:]).max() == 0
    assert driven.engine.finger.counts.lost_connections == 1


def test_an_ultrasonic_envelope_swings_about_its_carrier(engine, output):
    out = output("ultrasonic-envelope", level="peak=1")
    driven = Stream(engine(rate=out.display.rate, most=80), out, record_s=2.0)
    run_unpaced(driven, seconds=2.0)
    middle = driven.recorded[0, 8000:]
    assert middle.mean() == pytest.approx(out.display.settings.carrier_v, rel=0.05)
    assert middle.std() > 0.02
    assert middle.min() >= 0
    assert middle.max() <= out.display.limit


def test_a_family_that_cannot_be_streamed_to_is_refused_in_one_line():
    display = open_display("phone")
    with pytest.raises(ParameterError, match="cannot be streamed to; render a file"):
        DisplayOutput(display, Signal(np.ones(100, np.float32), 8000, "m/s^2"), level=parse_level("peak=1"))


@pytest.mark.parametrize("displayed", [False, True])
def test_a_stream_ends_at_rest_without_a_step(engine, output, script, displayed):
    moving = engine(script(lambda t: 200 * t))
    stream = Stream(moving, output() if displayed else None, record_s=0.5)
    run_unpaced(stream, seconds=0.5)
    sent = stream.recorded[0]
    assert len(sent) == 4000
    assert np.abs(sent[-40:]).max() == 0
    assert np.abs(np.diff(sent[-240:])).max() < 1.5 * np.abs(np.diff(sent[2000:3600])).max()


def test_ten_textures_are_one_mix(engine):
    stream = Stream(engine(count=10), record_s=1.0)
    run_unpaced(stream, seconds=1.0)
    one = Stream(engine(), record_s=1.0)
    run_unpaced(one, seconds=1.0)
    assert stream.recorded.std() == pytest.approx(one.recorded.std(), rel=0.35)


def test_a_stream_plays_on_the_cards_channels_that_its_display_names(engine, output):
    pad = output("dualsense", "peak=0.5", rate=8000, card_channels=[4, 3])
    reads = count()
    clock = types.SimpleNamespace(
        now=lambda: next(reads) * MOST / RATE
    )  # not the machine's: the finger lands at 0.2 s
    reader = FrameReader(Stream(engine(), pad, record_s=1.0), clock)
    pulled = np.concatenate([reader.read(100) for _ in range(60)])
    assert (reader.channels, pulled.shape) == (4, (6000, 4))
    np.testing.assert_array_equal(pulled[:, :2], 0)
    np.testing.assert_array_equal(pulled[:, [3, 2]].T, reader._stream.recorded[:, :6000])
    assert np.abs(pulled).max() > 0


def test_a_stream_and_its_display_have_one_rate(engine, output):
    with pytest.raises(ParameterError, match="display's 8000 Hz"):
        Stream(engine(rate=16_000.0, most=80), output())


def friction(k=0.5, *, mu=0.35, swing=0.03):
    """A friction coefficient with ridges, k of them per mm, 40 mm long."""
    x = np.arange(1600) / 40
    return Signal(
        (mu + swing * np.sin(2 * np.pi * k * x)).astype(np.float32), 40.0, "1", ("mu",), domain="displacement"
    )


def test_electrovibration_is_friction_at_the_fingers_place(script):
    """At 50 mm/s over 0.5 ridges per mm the square of the voltage goes at 25 Hz, by the square law."""
    display = open_display("electrovibration")
    most = int(0.005 * display.rate)
    surface = SurfaceTexture("mu", friction(), rate=display.rate, along="x")
    motion = script(lambda t: 50 * t, lambda t: 0.5)
    engine = Engine([surface], motion, rate=display.rate, most=most)
    stream = Stream(engine, DisplayOutput(display, surface, level=parse_level("physical")), record_s=1.0)
    run_unpaced(stream, seconds=0.8)
    assert stream.error is None
    sent = stream.recorded[0].astype(np.float64)
    assert np.abs(sent).max() <= 141.0
    middle = sent[int(0.2 * display.rate) : int(0.7 * display.rate)]
    square = np.convolve(2 * middle**2, np.ones(48) / 48, "same")[100:-100]
    settings = display.settings
    t = np.arange(len(square)) / display.rate
    basis = np.stack([np.ones_like(t), np.sin(2 * np.pi * 25 * t), np.cos(2 * np.pi * 25 * t)])
    mean, a, b = np.linalg.lstsq(basis.T, square, rcond=None)[0]
    # mu = mu_0 (1 + k_e V_rms^2 / F): the amplitude's square is twice that of V_rms.
    per_mu = 2 * settings.normal_force_n / (settings.newton_per_v2 * settings.mu_0)
    assert mean == pytest.approx(per_mu * 0.05, rel=0.03)
    assert np.hypot(a, b) == pytest.approx(per_mu * 0.03, rel=0.05)
    assert sent[-1] == 0.0


def test_electrovibration_has_no_voltage_once_the_finger_is_lost(script):
    display = open_display("electrovibration")
    most = int(0.005 * display.rate)
    surface = SurfaceTexture("mu", friction(), rate=display.rate, along="x")
    engine = Engine([surface], script(lambda t: 50 * t, end=0.3), rate=display.rate, most=most)
    stream = Stream(engine, DisplayOutput(display, surface, level=parse_level("physical")), record_s=0.6)
    run_unpaced(stream, seconds=0.6)
    sent = stream.recorded[0]
    assert np.abs(sent[int(0.25 * display.rate) : int(0.3 * display.rate)]).max() > 50
    assert not sent[int(0.45 * display.rate) :].any()
    # Its carrier fades: no direct voltage is left of it.
    fading = sent[int(0.38 * display.rate) : int(0.45 * display.rate)]
    assert abs(float(fading.mean())) < 0.5


def test_what_the_limits_cut_off_is_counted(engine, output):
    quiet_one, loud = output(level="gain=0.01"), output(level="gain=1000")
    for made in (quiet_one, loud):
        run_unpaced(Stream(engine(), made), seconds=1.0)
    assert quiet_one.clipped == 0
    assert loud.clipped > 0
