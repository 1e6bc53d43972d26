"""The experiment of displays with the two models that need no training, on made-up strokes."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.datasets import Recording, create_store
from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal
from tactogram_benchmark.experiments.catalogue import reproduce

SHOWN = ("voice-coil", "string-tablet", "lra-drv2605")


@pytest.fixture(scope="module", name="result")
def result_fixture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("displays")

    def strokes():
        for number in range(6):
            for place, name in enumerate(("cork", "tile")):
                noise = np.random.default_rng([place, number]).standard_normal((3, 1500))
                signal = Signal(lfilter([1], [1, -0.5 * place], noise), 600, "m/s^2")
                yield Recording(
                    streams={"acceleration": signal}, material=name, source=f"{name}/{number}", simulated=True
                )

    create_store(folder / "stroking9", strokes(), name="made up", licence="-", simulated=True)
    options = {"models": "replay", "recipe": "tiny", "shown": ",".join(SHOWN)}
    return reproduce("displays", package="benchmarks.experiments", out=folder, options=options), folder


def test_every_display_gets_a_drive_a_report_and_a_figure(result):
    found, folder = result
    assert found["simulated"] is True
    assert set(found["reports"]) == {"replay"}
    assert set(found["reports"]["replay"]) == set(SHOWN)
    for name in SHOWN:
        display = open_display(name)
        place = folder / "drives" / "replay" / f"{name}.wav"
        drive = read_signal(place)
        assert (drive.rate, drive.axes) == (display.rate, display.channels)
        assert np.abs(drive.samples).max() <= display.limit
        assert drive.samples.any()
        assert read_metadata(place)["simulated"] is True
        report = json.loads(place.with_suffix(".report.json").read_text())
        assert report == found["reports"]["replay"][name]
        assert (folder / f"{name}.png").stat().st_size > 10_000
    assert (folder / "overview.png").exists()


def test_the_level_is_that_of_sensation_where_the_display_has_one(result):
    reports = result[0]["reports"]["replay"]
    asked = {name: report["level"]["asked"] for name, report in reports.items()}
    assert asked == {"voice-coil": "sensation", "lra-drv2605": "sensation", "string-tablet": "peak=0.8"}
    assert "replay              voice-coil            sensation" in result[0]["text"]


def test_an_unknown_model_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="models must be of ar_texture"):
        reproduce(
            "displays", package="benchmarks.experiments", out=tmp_path, options={"models": "stroke_cnn"}
        )
