"""The figure of a live run: probabilities, true materials, none of these, latency."""

import pytest
from benchmarks.experiments.live_figure import live_figure

from tactogram.errors import ParameterError
from tactogram_capture.live.recognition import Classification, WindowClassification


def guess(k, **heard):
    return WindowClassification(
        100 * k,
        0.3 * k,
        Classification(heard, none_of_these=k == 5) if heard else None,
        0.0,
        1.0,
        0.01 + k / 1000,
        0,
    )


def test_the_figure_shows_each_material_and_each_true_interval():
    found = [guess(k, cork=k / 10, tile=1 - k / 10) for k in range(1, 10)] + [guess(10)]
    figure = live_figure(found, ["tile"] * 5 + ["wool"] * 5, title="simulated")
    top, bottom = figure.axes[:2]
    assert [label.get_text() for label in top.get_yticklabels()] == ["cork", "tile"]
    texts = [text.get_text() for text in top.texts]
    assert "tile" in texts
    assert "wool\n(not trained on)" in texts
    [mesh] = top.collections
    assert mesh.get_array().shape == (2, 9)
    assert bottom.get_ylabel() == "latency, ms"
    assert max(line.get_ydata().max() for line in bottom.lines) == pytest.approx(20.0)


def test_a_figure_without_a_classified_window_is_refused():
    with pytest.raises(ParameterError, match="classified window"):
        live_figure([guess(1)], ["tile"], title="")
