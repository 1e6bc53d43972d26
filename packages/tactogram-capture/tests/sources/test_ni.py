"""National Instruments inputs, with a stand-in for the driver's task."""

import types

import numpy as np
import pytest

from tactogram_capture import SourceLost, open_source


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
