"""Scores of recordings by a rater model."""

from made_up_ratings import vibration

from tactogram.signal.io import read_signal
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.recognition.score import score
from tactogram.workflows.training.train import train


def test_score_is_on_the_raters_scale_and_says_who_tells(rater_run):
    loud, quiet = (score(rater_run, vibration(level, 9)) for level in (1.0, 0.02))
    assert 1 <= quiet["scores"]["rough"] < loud["scores"]["rough"] <= 7
    assert loud["scale"] == [1.0, 7.0]
    assert loud["predicted_by"] == "rater model of simulated raters"
    assert score(rater_run, vibration(100.0, 9))["novelty"] > loud["novelty"]


def test_vibviz_recipe_copes_with_mixed_rates_and_channels(real_data, tmp_path):
    folder = real_data("vibviz")
    stereo = [next((folder / "wav").glob(f"*{name}.wav")) for name in ("4-20", "4-23", "7-34", "6-59")]
    chosen = [*stereo, *sorted(set((folder / "wav").glob("*.wav")) - set(stereo))[:6]]
    (tmp_path / "v").mkdir()
    for path in (next(folder.glob("*.csv")), *chosen):
        (tmp_path / "v" / path.name).symlink_to(path)
    import_store("vibviz", tmp_path / "v", tmp_path / "s", workers=1)
    few = {"config.penalties": [1.0], "config.kernels": ["linear"], "config.folds": 2}
    out = train("rater", tmp_path / "s", recipe="vibviz", changes=few, split="all", out=tmp_path / "run")
    scores = score(out.folder, read_signal(stereo[1], unit="1"))["scores"]
    assert list(scores) == ["energy", "tempo", "roughness", "pleasantness", "arousal"]
    assert all(-3 <= value <= 3 for value in scores.values())
