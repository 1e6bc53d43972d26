"""Backends: the same samples every time, on time, and errors in one line."""

import gc
import sys
import threading
import types
from dataclasses import dataclass

import numpy as np
import pytest

from tactogram.errors import DeviceError
from tactogram_playback.streaming import backends
from tactogram_playback.streaming.backends import (
    Clock,
    FrameReader,
    run_audio,
    run_clocked,
    run_miniaudio,
    run_unpaced,
    uninterrupted,
)
from tactogram_playback.streaming.output import Stream

RATE, MOST = 8000.0, 40


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


@pytest.mark.parametrize("frames", [7, 40, 64, 441])
def test_a_device_may_ask_for_any_number_of_frames(engine, frames):
    clock = Clock()
    reader = FrameReader(Stream(engine(), record_s=1.0), clock)
    pulled = np.concatenate([reader.read(frames) for _ in range(12)])
    assert pulled.shape == (12 * frames, 1)
    stream = reader._stream
    assert np.array_equal(pulled[:, 0], stream.recorded[0, : len(pulled)])


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


def test_a_stream_that_is_late_at_its_end_fades_all_the_same(engine, script, monkeypatch):
    clock = ByHand()
    monkeypatch.setattr(backends.time, "sleep", clock.sleep)
    moving = engine(script(lambda t: 200 * t))
    stream, sent = Stream(moving, on_block=lambda now: clock.sleep(0.3)), []
    run_clocked(stream, seconds=1.0, clock=clock, sink=lambda block, now: sent.append(block.copy()))
    assert np.abs(sent[3]).max() > 0
    assert len(sent) == 4 + 4  # blocks of 5 ms: the fade takes 20 ms, and begins when the time is over
    assert sent[4][0, -1] == 0
    assert not sent[5].any()


def test_the_collector_is_back_on_afterwards():
    with uninterrupted():
        assert not gc.isenabled()
    assert gc.isenabled()


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
