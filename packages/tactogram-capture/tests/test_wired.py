"""Audio, National Instruments and Digilent inputs, with fake drivers."""

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


class Task:
    """NI-DAQmx's task, as far as it is used, with 40 waiting samples."""

    error = None

    def __init__(self):
        self.ai_channels = self.timing = self
        self.channel_names = ["Dev1/ai0", "Dev1/ai1", "Dev1/ai2"]
        self.in_stream = types.SimpleNamespace(avail_samp_per_chan=40)
        self.calls, self.closed = {}, False
        Task.last = self

    def add_ai_voltage_chan(self, channels, **options):
        self.calls["voltage"] = (channels, options)

    def add_ai_accel_chan(self, channels, **options):
        self.calls["acceleration"] = (channels, options)

    def cfg_samp_clk_timing(self, rate, **options):
        self.samp_clk_rate = 80e6 / round(80e6 / rate)
        self.calls["timing"] = (rate, options)

    def start(self):
        pass

    def close(self):
        self.closed = True

    def read(self, *, number_of_samples_per_channel, timeout):
        if Task.error is not None:
            raise Task.error
        self.in_stream.avail_samp_per_chan = 0
        return [[c + 0.5] * number_of_samples_per_channel for c in range(3)]


@pytest.fixture(name="nidaqmx")
def nidaqmx_fixture(monkeypatch):
    nidaqmx = pytest.importorskip("nidaqmx")
    monkeypatch.setattr(nidaqmx, "Task", Task)
    monkeypatch.setattr(Task, "error", None)
    return nidaqmx


def test_ni_voltages_are_read_at_the_devices_own_rate(nidaqmx):
    with open_source("ni:Dev1/ai0:2?rate=3000&range=10&unit=m/s^2&scale=98.0665") as source:
        block = source.read(0.1)
        task = Task.last
    assert task.calls["voltage"][0] == "Dev1/ai0:2"
    assert task.calls["voltage"][1]["max_val"] == 10
    assert source.rate == pytest.approx(80e6 / 26667)
    assert (source.axes, source.unit) == (("x", "y", "z"), "m/s^2")
    assert block.samples.shape == (3, 40)
    assert block.samples[:, 0] == pytest.approx(np.array([0.5, 1.5, 2.5]) * 98.0665)
    assert task.closed


def test_ni_iepe_sensors_get_their_current_and_are_read_in_m_per_s2(nidaqmx):
    with open_source("ni:Dev1/ai0:2?kind=acceleration&sensitivity=10.2&current_ma=2") as source:
        block = source.read(0.1)
    options = Task.last.calls["acceleration"][1]

    assert (options["sensitivity"], options["current_excit_val"]) == (10.2, 0.002)
    assert block.samples[0, 0] == pytest.approx(0.5 * 9.80665)


def test_an_ni_timeout_is_no_block_and_an_overrun_loses_the_source(nidaqmx):
    with open_source("ni:Dev1/ai0:2") as source:
        Task.last.in_stream.avail_samp_per_chan = 0
        Task.error = nidaqmx.errors.DaqReadError(
            "some or all of the samples requested have not yet been acquired", -200284, 0
        )
        assert source.read(0.01) is None
        Task.error = nidaqmx.errors.DaqReadError("samples no longer available", -200279, 0)
        with pytest.raises(SourceLost, match="stopped while it was read"):
            source.read(0.01)


class Discovery:
    """An Analog Discovery, as far as it is used; `status` is its next status."""

    def __init__(self, serial_number=None):
        self.serial_number, self.analog_input = serial_number, self
        self.frequency, self.set_up, self.acquisition = 0.0, [], {}
        self.channels = [
            types.SimpleNamespace(get_data=lambda first, n, c=c: np.full(n, c + 1.0)) for c in range(2)
        ]
        self.record_status = (0, 0, 0)
        self.closed = False
        Discovery.last = self

    def open(self):
        if self.serial_number == "none":
            raise RuntimeError("Device not found")

    def close(self):
        self.closed = True

    def setup_channel(self, channel, **options):
        self.set_up.append((channel, options))

    def setup_acquisition(self, **options):
        self.acquisition = options
        self.frequency = options["sample_rate"]

    def read_status(self, *, read_data):
        if self.closed:
            raise RuntimeError("Device not open")


@pytest.fixture(name="dwfpy")
def dwfpy_fixture(monkeypatch):
    fake = types.ModuleType("dwfpy")
    fake.Device = Discovery
    monkeypatch.setitem(sys.modules, "dwfpy", fake)


def test_digilent_samples_have_losses_in_their_place(dwfpy):
    with open_source("digilent:?channels=1,2&rate=20000&range=10") as source:
        Discovery.last.record_status = (6, 3, 2)
        block = source.read(0.0)
        Discovery.last.record_status = (0, 0, 0)
        assert source.read(0.0) is None
    assert Discovery.last.acquisition["mode"] == "record"
    assert [channel for channel, _ in Discovery.last.set_up] == [0, 1]
    assert Discovery.last.closed
    # Three were lost before them, and the oldest two of the six written over.
    assert np.isnan(block.samples[:, :5]).all()
    assert block.samples[:, 5:].tolist() == [[1.0] * 4, [2.0] * 4]
    facts = source.facts()
    assert (facts["samples"], facts["lost"], facts["corrupted"]) == (4, 5, 2)


def test_a_digilent_device_that_disappears_or_is_missing_is_reported(dwfpy):
    with pytest.raises(DeviceError, match="digilent:none: Device not found"), open_source("digilent:none"):
        pass
    with open_source("digilent:") as source:
        Discovery.last.close()
        with pytest.raises(SourceLost, match="disappeared"):
            source.read(0.0)
