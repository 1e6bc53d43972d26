import numpy as np
import pytest

from tactogram.evaluation.generation.comparison import GenerationResult
from tactogram.evaluation.generation.report import generation_sections, overview_figure, position_figure
from tactogram.evaluation.report import ReportFigure, ReportSound, ReportTable, ReportText, write_report
from tactogram.signal import Signal


def row(model, floor=1.0, ceiling=3.0, replay=1.5):
    return {
        "model": model,
        "ar_texture": model,
        "replay": replay,
        "floor": floor,
        "ceiling": ceiling,
        "nearest_other": None,
    }


RESULT = GenerationResult(
    materials=("a", "b"),
    columns=("model", "ar_texture", "replay"),
    values={
        "log_spectral_distance_db": {"a": row(2.0), "b": row(9.0)},
        "recall": {"a": row(0.5, 0.9, 0.1, 0.9), "b": row(0.9, 0.9, 0.9, 0.9)},
    },
    better={"log_spectral_distance_db": "lower", "recall": "higher"},
    answers={},
    seconds=1.0,
    count=3,
    notes=("Something was left out.",),
)
SIGNALS = {
    name: [Signal(np.random.default_rng(seed).standard_normal((1, 600)), 300, "m/s^2") for seed in range(2)]
    for name in ("a", "b")
}


def sections():
    sets = dict.fromkeys(RESULT.columns, SIGNALS)
    return generation_sections(RESULT, SIGNALS, sets)


def test_the_map_shows_positions_and_where_there_is_none():
    shown = overview_figure(RESULT).axes[0].images[0].get_array()
    overall = [(5.5 - 1) / 2, (0.7 - 0.9) / (0.5 - 0.9)]
    np.testing.assert_allclose(np.ma.filled(shown, np.nan), [overall, [0.5, 0.5], [4.0, np.nan]])


def test_far_out_is_drawn_at_the_edge_and_a_baseline_that_is_the_model_once():
    axes = position_figure(RESULT).axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["model", "replay"]
    drawn = np.concatenate([points.get_offsets()[:, 0] for points in axes.collections])
    assert drawn.max() == 1.5


def test_the_sections_say_what_is_worse_and_what_is_beyond(tmp_path):
    blocks = {section.title: section.blocks for section in sections()}
    summary = next(b.text for b in blocks["Summary"] if isinstance(b, ReportText))
    assert "Of 3 values" in summary
    assert "0 are at the floor or better, 2 between floor and ceiling, 1 beyond" in summary
    assert "Worse than replay in log spectral and recall" in summary
    assert "ar_texture" not in summary
    (beyond,) = (b for b in blocks["Every material, every measure"] if isinstance(b, ReportTable))
    assert beyond.rows == [("log-spectral distance", 1, "b")]
    (against,) = blocks["Comparison with the baselines"]
    assert against.rows[0][1] == pytest.approx(-4.0)
    assert sum(isinstance(b, ReportSound) for b in blocks["Examples to view and listen to"]) == 2 * 4
    assert sum(isinstance(b, ReportFigure) for b in blocks["Examples to view and listen to"]) == 1 + 2
    assert "Something was left out." in [b.text for b in blocks["Protocol"]]
    page = write_report(
        tmp_path / "r.html", title="t", summary="s", sections=sections(), simulated=False
    ).read_text()
    assert page.count("<details>") == page.count("</details>") == 2
    assert "<summary>log-spectral distance, dB</summary>" in page
