"""Audio inputs, with a stand-in for PortAudio."""

import sys
import types

import numpy as np
import pytest

from tactogram.errors import DeviceError
from tactogram_capture import SourceLost, open_source
from tactogram_capture.sources.audio import BlockQueue


class InputStream:
    """PortAudio's stream, as far as it is used; its thread would call `deliver`."""

    last = None

    def __init__(self, *, callback, finished_callback, **options):
        self.options, self.callback, self.finished = options, callback, finished_callback
        self.running = False
        InputStream.last = self

    def start(self):
        if self.options["device"] == "none":
            raise ValueError("No input device matching 'none'")
        self.running = True

    def close(self):
        self.running = False

    def deliver(self, data, *, overflow=False):
        status = types.SimpleNamespace(input_overflow=overflow)
        self.callback(np.asarray(data, np.float32), len(data), None, status)


@pytest.fixture(name="portaudio")
def portaudio_fixture(monkeypatch):
    fake = types.ModuleType("sounddevice")
    fake.InputStream = InputStream
    fake.query_devices = lambda: [
        {"name": "USB", "max_input_channels": 2},
        {"name": "HDMI", "max_input_channels": 0},
    ]
    monkeypatch.setitem(sys.modules, "sounddevice", fake)


def test_audio_has_its_unit_and_an_overflow_leaves_a_gap(portaudio):
    with open_source("audio:USB?rate=8000&channels=2&axes=x,y&unit=m/s^2&full_scale=50") as source:
        stream = InputStream.last
        stream.deliver([[0.5, -0.5], [1.0, 0.0]])
        stream.deliver([[0.25, 0.25]], overflow=True)
        block = source.read(0.1)
        assert source.read(0.0) is None
    assert stream.options["samplerate"] == 8000
    assert stream.options["device"] == "USB"
    assert not stream.running
    assert block.samples[:, :2].tolist() == [[25, 50], [-25, 0]]
    assert np.isnan(block.samples[:, 2]).all()
    assert block.samples[:, 3].tolist() == [12.5, 12.5]
    assert (source.facts()["samples"], source.facts()["lost"], source.facts()["overflows"]) == (3, 1, 1)


def test_audio_that_stops_is_lost_after_the_samples_before(portaudio):
    with open_source("audio:USB") as source:
        InputStream.last.deliver([[0.5]])
        InputStream.last.finished()
        assert len(source.read(0.1)) == 1
        with pytest.raises(SourceLost, match="the audio input stopped"):
            source.read(0.1)


def test_a_missing_audio_device_is_reported_and_no_other_opened(portaudio):
    with (
        pytest.raises(DeviceError, match="audio:none: No input device matching 'none'"),
        open_source("audio:none"),
    ):
        pass


def test_a_full_queue_marks_losses_in_their_place_and_counts_them():
    queue = BlockQueue(1, 10)
    for n in range(4):
        queue.put(np.full((1, 4), n, np.float32))
    first = queue.get(0.0)
    queue.put(np.full((1, 4), 9, np.float32))
    second = queue.get(0.0)

    assert first.samples[0].tolist() == [0] * 4 + [1] * 4
    assert np.isnan(second.samples[0, :8]).all()
    assert second.samples[0, 8:].tolist() == [9] * 4
    assert (second.first_index, queue.lost, queue.received) == (8, 8, 12)
