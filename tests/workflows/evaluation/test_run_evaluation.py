"""Evaluation of a generator that is given the words of rated surfaces, at the speeds of their recordings."""

import pytest

from tactogram.workflows.evaluation.run_evaluation import evaluate_run
from tactogram.workflows.generation.word_scores import some_words
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train
from tactogram_simulate import simulate_to_store


@pytest.mark.slow
def test_surfaces_are_described_by_their_ratings(tmp_path):
    data = tmp_path / "surfaces"
    simulate_to_store("surfaces", data, random=3, per_class=5, raters=4, workers=1)
    changes = {"config.prediction": True, "config.components": 6, "config.photographs": False}
    out = train(
        "texture_flow",
        data,
        recipe="tiny",
        changes=changes,
        split="last=2",
        out=tmp_path / "run",
        accelerator="cpu",
    )
    run = load_run(out.folder)
    assert some_words(run, {"rough": 6})["rough"] == 6
    found, _ = evaluate_run(out.folder, given="words", evaluation={"steps": 20})
    spectra = found["measures"]["log_spectral_distance_db"]
    assert spectra["model"] < spectra["ceiling"]
