"""A stream to a display and its backends: safe, measured, the same samples every time."""

import gc
import math
import os
import sys
import threading
import types
from dataclasses import dataclass
from functools import cache
from itertools import count, pairwise

import numpy as np
import pytest

from tactogram.errors import DataError, DeviceError, ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.level import parse_level
from tactogram.rendering.streaming import backends
from tactogram.rendering.streaming.backends import (
    Clock,
    FrameReader,
    run_audio,
    run_clocked,
    run_miniaudio,
    run_unpaced,
    uninterrupted,
)
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.output import DisplayOutput, Stream
from tactogram.rendering.streaming.recorded_motion import MotionFile, MouseMotion, SimulatedHand, mouse_step
from tactogram.rendering.streaming.texture_table import TextureTable
from tactogram.rendering.streaming.textures import AutoregressiveTexture, SurfaceTexture
from tactogram.rendering.streaming.timing import Durations
from tactogram.signal import Signal

RATE, MOST = 8000.0, 40


@pytest.fixture(scope="module")
def table(sloping):
    return TextureTable(sloping)


@pytest.fixture(name="engine", scope="module")
def engine_fixture(table):
    def make(motion=None, *, count=1, rate=RATE, most=MOST):
        textures = [AutoregressiveTexture(f"t{n}", table, rate=rate, most=most, seed=n) for n in range(count)]
        return Engine(textures, motion or SimulatedHand(3, seed=0), rate=rate, most=most)

    return make


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


# -- displays ----------------------------------------------------------------------------------------------


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
    with pytest.raises(ParameterError, match="cannot be streamed to: render a file"):
        DisplayOutput(display, Signal(np.ones(100, np.float32), 8000, "m/s^2"), level=parse_level("peak=1"))


# -- backends ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("displayed", [False, True])
def test_a_stream_ends_at_rest_without_a_step(engine, output, script, displayed):
    moving = engine(script(lambda t: 200 * t))
    stream = Stream(moving, output() if displayed else None, record_s=0.5)
    run_unpaced(stream, seconds=0.5)
    sent = stream.recorded[0]
    assert len(sent) == 4000
    assert np.abs(sent[-40:]).max() == 0
    assert np.abs(np.diff(sent[-240:])).max() < 1.5 * np.abs(np.diff(sent[2000:3600])).max()


def test_an_interrupt_from_the_keyboard_ends_with_a_fade(engine, script):
    sent = []

    def sink(block, now):
        sent.append(block.copy())
        if len(sent) == 30:
            raise KeyboardInterrupt

    stream = Stream(engine(script(lambda t: 200 * t)))
    run_clocked(stream, seconds=20.0, clock=Clock(), sink=sink)
    samples = np.concatenate(sent, axis=1)[0]
    assert len(sent) < 60
    assert samples[-40:].max() == 0
    assert np.abs(np.diff(samples[-600:])).max() < 1.5 * np.abs(np.diff(samples[:1160])).max()
    assert stream.error is None


def test_to_a_file_the_same_motion_gives_the_same_samples(engine):
    made = []
    for _ in range(2):
        stream = Stream(engine(), record_s=1.0)
        run_unpaced(stream, seconds=1.0)
        made.append(stream.recorded)
    assert made[0].shape == (1, 8000)
    assert np.array_equal(*made)


def test_ten_textures_are_one_mix(engine):
    stream = Stream(engine(count=10), record_s=1.0)
    run_unpaced(stream, seconds=1.0)
    one = Stream(engine(), record_s=1.0)
    run_unpaced(one, seconds=1.0)
    assert stream.recorded.std() == pytest.approx(one.recorded.std(), rel=0.35)


@pytest.mark.parametrize("frames", [7, 40, 64, 441])
def test_a_device_may_ask_for_any_number_of_frames(engine, frames):
    clock = Clock()
    reader = FrameReader(Stream(engine(), record_s=1.0), clock)
    pulled = np.concatenate([reader.read(frames) for _ in range(12)])
    assert pulled.shape == (12 * frames, 1)
    stream = reader._stream
    assert np.array_equal(pulled[:, 0], stream.recorded[0, : len(pulled)])


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


def test_the_null_device_of_miniaudio_is_played_to(engine):
    pytest.importorskip("miniaudio")
    stream = Stream(engine(), record_s=0.3)
    stream.warm_up()
    found = run_miniaudio(stream, seconds=0.3, clock=Clock(), null=True)
    assert found["device"] == "null"
    assert found["frames_per_call"] > 0
    facts = stream.facts()
    assert facts["latency"]["compute"]["count"] > 0
    assert stream.error is None


def test_a_sound_card_is_played_to_through_portaudio(engine, monkeypatch):
    """A simulated library requests blocks from its own thread, and reports one underflow."""

    class OutputStream:
        def __init__(self, *, samplerate, blocksize, channels, dtype, latency, device, callback):
            assert (samplerate, blocksize, channels, dtype, latency, device) == (
                8000,
                40,
                1,
                "float32",
                "low",
                3,
            )
            self.latency, self.device, self.played = 0.007, 3, []
            self._callback, self._ended = callback, threading.Event()
            self._thread = threading.Thread(target=self._ask)
            opened.append(self)

        def _ask(self):
            while not self._ended.wait(0.004):
                out = np.full((40, 1), 9.0, np.float32)
                flags = types.SimpleNamespace(output_underflow=len(self.played) == 3)
                self._callback(out, 40, None, flags)
                self.played.append(out)

        def __enter__(self):
            self._thread.start()
            return self

        def __exit__(self, *_):
            self._ended.set()
            self._thread.join()

    opened = []
    library = types.ModuleType("sounddevice")
    library.OutputStream = OutputStream
    library.query_devices = lambda number: {"name": "card"}
    monkeypatch.setitem(sys.modules, "sounddevice", library)
    stream = Stream(engine(), record_s=1.0)
    stream.warm_up()
    found = run_audio(stream, seconds=0.3, clock=Clock(), device=3)
    assert (found["device"], found["latency_ms"]) == ("card", 7.0)
    assert stream.engine.latency.underruns >= 1
    played = np.concatenate(opened[0].played)[:, 0]
    assert np.array_equal(played, stream.recorded[0])
    assert stream.facts()["latency"]["queued_ms"] == 7.0


def test_without_portaudio_and_without_a_card_the_line_says_both(engine, monkeypatch):
    def imported(name, **_):
        if name == "sounddevice":
            raise DeviceError("sounddevice is installed, but PortAudio was not found")
        return real(name, extra="devices", what="a test")

    def nothing(*_, **__):
        raise DeviceError("failed to init device")

    real = backends.imported
    monkeypatch.setattr(backends, "imported", imported)
    monkeypatch.setattr(backends, "run_miniaudio", nothing)
    with pytest.raises(DeviceError, match=r"miniaudio found no output, and sounddevice .* PortAudio"):
        run_audio(Stream(engine()), seconds=0.1, clock=Clock())


def test_a_clocked_stream_measures_itself(engine):
    told = []
    stream = Stream(engine())
    stream.warm_up()
    run_clocked(stream, seconds=0.3, clock=Clock(), status=told.append)
    latency = stream.facts()["latency"]
    assert latency["compute"]["count"] > 0
    assert latency["total"]["p50_ms"] > 5  # the block itself
    assert latency["compute"]["p50_ms"] <= latency["compute"]["p99_ms"] <= latency["compute"]["max_ms"]
    assert told


@dataclass
class ByHand:
    """A clock that advances only by sleeping."""

    s: float = 0.0

    def start(self):
        self.s = 0.0

    def now(self):
        return self.s

    def sleep(self, seconds):
        self.s += seconds


def test_a_stream_that_is_late_counts_it_and_does_not_burst(engine, monkeypatch):
    clock = ByHand()
    monkeypatch.setattr(backends.time, "sleep", clock.sleep)
    stream = Stream(engine(), on_block=lambda now: clock.sleep(0.012))  # blocks are of 5 ms
    run_clocked(stream, seconds=0.2, clock=clock)
    latency = stream.engine.latency
    assert (latency.compute.count, latency.underruns) == (20, 15)  # 180 ms, and five of the fade


def test_the_collector_is_back_on_afterwards():
    with uninterrupted():
        assert not gc.isenabled()
    assert gc.isenabled()


def test_durations_have_quantiles_to_a_percent():
    durations = Durations()
    values = np.exp(np.random.default_rng(0).normal(-7, 1, 5000))
    for value in values:
        durations.add(float(value))
    for share in (0.5, 0.99):
        assert durations.quantile(share) == pytest.approx(np.quantile(values, share), rel=0.02)
    assert durations.facts()["max_ms"] == pytest.approx(1e3 * values.max())
    assert Durations().facts()["p50_ms"] is None


# -- motion from elsewhere ---------------------------------------------------------------------------------


def test_a_simulated_hand_strokes_rests_and_lifts():
    hand = SimulatedHand(20, seed=3, noise_mm=0)
    samples = hand.poll(20.0)
    places = np.array([(s.time_s, s.x_mm) for s in samples if s.x_mm == s.x_mm])
    forces = np.array([s.force_n for s in samples if s.force_n == s.force_n])
    speed = np.abs(np.diff(places[:, 1]) / np.diff(places[:, 0]))
    assert len(places) == 5000
    assert len(forces) == 10_000
    assert 100 < speed.max() < 1.875 * 120 / 0.4 + 400
    assert 0.02 < np.mean(forces == 0) < 0.5
    assert 0.3 < forces[forces > 0].mean() < 0.9
    again = SimulatedHand(20, seed=3, noise_mm=0).poll(20.0)
    assert repr(again) == repr(samples)


def test_a_motion_file_is_read_with_its_gaps(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time_s,x_mm,force_n\n5.0,1.5,\n5.1,,0.4\n5.2,2.5,0.5\n")
    motion = MotionFile(path)
    assert [s.time_s for s in motion.poll(0.15)] == pytest.approx([0.0, 0.1])
    (last,) = motion.poll(1.0)
    assert (last.x_mm, last.y_mm, last.force_n) == (2.5, 0.0, 0.5)
    assert math.isnan(last.speed_mm_s)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected columns"),
        ("time_s,speed\n0,1\n", "line 1: expected columns"),
        ("time_s,force_n\n", "no motion"),
        ("time_s,force_n\n0,1\n0,1\n", "line 3: times must ascend"),
        ("time_s,force_n\n0,-1\n", "line 2: speed and force"),
        ("time_s,force_n\n0,a\n", "line 2: expected 2 numbers"),
        ("time_s,y_mm\n0,1\n", "y_mm needs x_mm"),
    ],
)
def test_a_wrong_motion_file_is_refused_by_its_line(tmp_path, text, says):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=says):
        MotionFile(path)


def test_a_mouse_packet_is_buttons_right_and_up():
    assert mouse_step(bytes([0x09, 5, 7])) == (True, 5, 7)
    assert mouse_step(bytes([0x38, 0xFB, 0xF9])) == (False, -5, -7)


def test_a_mouse_moves_the_finger(tmp_path):
    pipe = tmp_path / "mice"
    os.mkfifo(pipe)
    mouse = MouseMotion(path=pipe, counts_per_mm=10.0)
    with open(pipe, "wb", buffering=0) as device:
        device.write(bytes([0x09, 50, 0, 0x09]))
        (first,) = mouse.poll(0.0)
        device.write(bytes([50, 20]))
        (second,) = mouse.poll(0.01)
    mouse.close()
    assert (first.x_mm, first.y_mm, first.force_n) == (5.0, 0.0, 0.5)
    assert (second.x_mm, second.y_mm) == (10.0, 2.0)


def test_a_mouse_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(DeviceError, match="cannot be read"):
        MouseMotion(path=tmp_path / "none")


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


def test_a_sound_card_that_was_pulled_out_ends_the_stream(engine, monkeypatch):
    """It requests nothing more, without an error of the library."""

    class OutputStream:
        latency, device = 0.0, 0

        def __init__(self, **options):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            ended.append(True)

    ended = []
    card = types.SimpleNamespace(OutputStream=OutputStream, query_devices=lambda device: {"name": "x"})
    monkeypatch.setattr(backends, "imported", lambda *_, **__: card)
    monkeypatch.setattr(backends, "STALLED_S", 0.05)
    monkeypatch.setattr(backends, "STATUS_S", 0.02)
    with pytest.raises(DeviceError, match="requested no samples for 0.05 s"):
        run_audio(Stream(engine()), seconds=20.0, clock=Clock())
    assert ended
