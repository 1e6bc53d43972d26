"""Digilent inputs, with a stand-in for the library."""

import sys
import types

import numpy as np
import pytest

from tactogram.errors import DeviceError
from tactogram_capture import SourceLost, open_source


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
