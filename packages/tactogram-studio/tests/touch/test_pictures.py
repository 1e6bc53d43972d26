import numpy as np
import pytest

from tactogram.signal import Signal
from tactogram_studio.touch.pictures import drawn_surface, picture_of
from tactogram_studio.touch.sources import TextureRequest

VOICES = "studio/first/voices"


def ridges(per_mm=0.5, length_mm=80.0, rate=20.0, amplitude=2.0):
    place = np.arange(round(length_mm * rate)) / rate
    wave = amplitude * np.sin(2 * np.pi * per_mm * place)
    return Signal(wave[None].astype(np.float32), rate, "m/s^2", ("z",), domain="displacement")


def test_the_pad_shows_the_materials_picture_where_the_data_has_one(sources):
    picture = picture_of(sources, TextureRequest(where="run", of=VOICES, material="tile"))
    assert (picture.kind, picture.webp[8:12]) == ("rendered", b"WEBP")
    assert picture.mm_per_pixel == pytest.approx(0.15)
    assert picture.words == "tile: rendered picture of the simulated surface"


def test_without_a_picture_the_signal_is_drawn_and_that_is_said(sources):
    picture = picture_of(sources, TextureRequest(where="file", of="recordings/ridges.npz"))
    assert picture.kind == "drawn"
    assert picture.words == "recordings/ridges.npz: drawn from the signal, no photograph"


@pytest.mark.parametrize("registered", [True, False])
def test_a_drawn_surface_has_the_ridges_of_the_signal(registered):
    drawn = drawn_surface(ridges(per_mm=0.5), 100.0, registered=registered)
    row = drawn.pixels[100, :, 0].astype(float)
    spectrum = np.abs(np.fft.rfft(row - row.mean()))
    per_mm = np.fft.rfftfreq(len(row), drawn.mm_per_pixel)
    assert per_mm[np.argmax(spectrum)] == pytest.approx(0.5, abs=0.03)
    same = np.array_equal(drawn.pixels[10], drawn.pixels[200])
    assert same is registered
