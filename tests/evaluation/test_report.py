"""Reports: self-contained, and called simulated where they are."""

import base64
import io
import re

import numpy as np
import soundfile
from PIL import Image as Pillow

from tactogram.evaluation.report import (
    ReportFigure,
    ReportSection,
    ReportSound,
    ReportTable,
    ReportText,
    write_report,
)
from tactogram.signal import Signal
from tactogram.signal.figure import signal_figure


def stroke(rate=330.0):
    t = np.arange(int(2 * rate)) / rate
    return Signal(np.stack([9.81 + 0 * t, np.sin(2 * np.pi * 50 * t), 0.1 * t]), rate, "m/s^2")


def test_a_report_is_self_contained(tmp_path):
    path = write_report(
        tmp_path / "r.html",
        title="A <b>title</b>",
        summary="Short.",
        simulated=True,
        sections=[
            ReportSection(
                "One",
                [
                    ReportText("5 < 6"),
                    ReportTable(("name", "value"), [("a", 0.12345), ("b", None)], "caption"),
                ],
            ),
            ReportSection(
                "Two",
                [ReportFigure(signal_figure(stroke()), "a stroke"), ReportSound(stroke(), "listen")],
            ),
        ],
    )
    page = path.read_text()
    assert "A &lt;b&gt;title" in page
    assert "Simulated data" in page
    assert "0.123" in page
    assert not re.search(r'(src|href)="(?!data:|#)', page)  # nothing from elsewhere
    sound = base64.b64decode(re.search(r"data:audio/wav;base64,([^\"]+)", page)[1])
    samples, rate = soundfile.read(io.BytesIO(sound))
    assert rate == 8000
    assert len(samples) == 16_000
    spectrum = np.abs(np.fft.rfft(samples))
    assert np.argmax(spectrum) / 2 == 50  # the axis with the vibration, without gravity
    assert list(tmp_path.iterdir()) == [path]


def test_a_figure_named_as_a_file_is_beside_the_page(tmp_path):
    figures = [
        ReportFigure(signal_figure(stroke())),
        ReportFigure(lambda: signal_figure(stroke()), file="b.png"),
    ]
    sections = [ReportSection("One", figures)]
    write_report(tmp_path / "r.html", title="t", summary="s", simulated=False, sections=sections)
    assert {path.name for path in tmp_path.iterdir()} == {"r.html", "b.png"}
    with Pillow.open(tmp_path / "b.png") as picture:
        assert picture.width > 500


def test_real_data_is_not_called_simulated(tmp_path):
    path = write_report(tmp_path / "r.html", title="t", summary="s", simulated=False, sections=[])
    assert "Simulated data" not in path.read_text()
