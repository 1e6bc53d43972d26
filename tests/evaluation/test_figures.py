"""Figures of results: what is drawn."""

import numpy as np
from PIL import Image as Pillow

from tactogram.evaluation import figures
from tactogram.evaluation.report import (
    save_figure,
)
from tactogram.signal import Signal


def stroke(rate=330.0):
    t = np.arange(int(2 * rate)) / rate
    return Signal(np.stack([9.81 + 0 * t, np.sin(2 * np.pi * 50 * t), 0.1 * t]), rate, "m/s^2")


def test_figures_are_drawn(tmp_path):
    counts = np.array([[3, 1], [0, 4]])
    drawn = {
        "confusion": figures.confusion_figure(counts, ("a", "b")),
        "spectra": figures.spectra_figure({"one": [stroke(), stroke()], "other": [stroke()]}),
        "losses": figures.losses_figure([{"stage": 1, "step": s, "loss": 1 / s} for s in range(1, 40)]),
    }
    for name, figure in drawn.items():
        with Pillow.open(save_figure(tmp_path / f"{name}.png", figure)) as picture:
            assert picture.width > 300
            assert len(set(picture.convert("L").get_flattened_data())) > 2


def test_a_confusion_matrix_shows_shares_of_the_true_class():
    figure = figures.confusion_figure(np.array([[3, 1], [0, 4]]), ("a", "b"))
    np.testing.assert_allclose(figure.axes[0].images[0].get_array(), [[0.75, 0.25], [0, 1]])


def test_spectra_of_short_and_long_signals_share_their_frequencies():
    drawn = figures.spectra_figure({"one": [stroke(), stroke().cut(0, 100)], "other": [stroke()]})
    lines = drawn.axes[0].lines
    assert [len(line.get_xdata()) for line in lines] == [51, 51]
    assert lines[0].get_xdata()[-1] == 165.0
