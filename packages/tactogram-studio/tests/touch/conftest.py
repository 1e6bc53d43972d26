import shutil

import numpy as np
import pytest

from tactogram.signal import Image, Signal
from tactogram.signal.io import write_signal
from tactogram_studio.context import Studio
from tactogram_studio.touch.sources import TouchSources


def ridges(per_mm=0.5, length_mm=80.0, rate=20.0, amplitude=2.0):
    place = np.arange(round(length_mm * rate)) / rate
    wave = amplitude * np.sin(2 * np.pi * per_mm * place)
    return Signal(wave[None].astype(np.float32), rate, "m/s^2", ("z",), domain="displacement")


@pytest.fixture(scope="module")
def workspace(surfaces, tmp_path_factory):
    folder = tmp_path_factory.mktemp("touch") / "workspace"
    shutil.copytree(surfaces, folder)
    write_signal(folder / "recordings" / "ridges.npz", ridges())
    stroke = Signal(np.sin(np.arange(6000) / 4)[None].astype(np.float32), 2000.0, "m/s^2")
    write_signal(folder / "recordings" / "stroke.wav", stroke, metadata={"speed_mm_s": 80, "simulated": True})
    return folder


@pytest.fixture(scope="module")
def studio(workspace):
    found = Studio.at(workspace)
    found.shelf.keep(ridges(), title="Kept ridges", facts={"simulated": True})
    found.shelf.keep(Image(np.zeros((4, 4, 3), np.uint8)), title="A picture", facts={})
    return found


@pytest.fixture(scope="module")
def sources(studio):
    return TouchSources(studio.workspace, studio.shelf)
