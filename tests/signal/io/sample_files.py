"""Files that tests write, and how one is refused."""

import h5py
import numpy as np
import pytest
import soundfile
from nptdms import ChannelObject, RootObject, TdmsWriter

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram.workflows.data.convert import convert

X = np.sin(np.arange(40))
N = 200
T = np.arange(N) / 500
WAVE, Y, Z = np.sin(0.3 * np.arange(N)), np.cos(0.2 * np.arange(N)), 1 + 0.1 * np.sin(np.arange(N))
XYZ = np.stack([WAVE, Y, Z])


def written(tmp_path, text, name="a.csv"):
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def wav(tmp_path, channels=1, subtype="FLOAT", name="a.wav"):
    path = tmp_path / name
    soundfile.write(path, np.zeros((100, channels)), 1000, subtype)
    return path


def noise(axes=3, length=200, rate=333.3, unit="m/s^2", level=20.0, **kind):
    samples = level * np.random.default_rng(axes).normal(size=(axes, length))
    return Signal(samples, rate, unit, tuple(f"axis {i}" for i in range(axes)), **kind)


def tdms(path):
    facts = {"wf_increment": 0.002, "wf_start_offset": 0.0, "unit_string": "g"}
    with TdmsWriter(path) as file:
        channels = [ChannelObject("acc", name, each, facts) for name, each in zip("xyz", XYZ, strict=True)]
        file.write_segment([RootObject(), *channels])


def hdf5(path, **attributes):
    with h5py.File(path, "w") as file:
        data = file.create_dataset("run/acc", data=XYZ.T, compression="gzip")
        data.attrs.update({"unit": "g", "fs": 500.0} | attributes)


def refusal(path, **options):
    """Return the one line with which ``path`` is refused, and check that convert refuses it and writes nothing."""
    with pytest.raises(DataError) as caught:
        read_signal(path, **options)
    with pytest.raises(DataError):
        convert(path, path.with_name("target") / "b.wav", **options)
    assert not path.with_name("target").exists()
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")
