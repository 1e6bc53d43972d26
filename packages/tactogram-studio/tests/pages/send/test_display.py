import numpy as np

from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.rendering.render import render
from tactogram_studio.pages.send.display import warnings_of


def test_the_most_dangerous_is_said_first(tmp_path):
    t = np.arange(4000) / 4000
    write_signal(tmp_path / "mu.npz", Signal((0.34 + 0.04 * np.sin(60 * t)).astype(np.float32), 4000, "1"))
    report = render(tmp_path / "mu.npz", tmp_path / "d.wav", display="electrovibration", level="peak=0.5")[
        "report"
    ]
    first = warnings_of(open_display("electrovibration"), report)[0]
    assert "limits the current" in first
