import json
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from tactogram.datasets import Examples, Recording, create_store
from tactogram.errors import ParameterError, RunError
from tactogram.evaluation.generation.comparison import describe_measures
from tactogram.signal import Signal
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.generator import _ConditionedGenerator, evaluate_generator
from tactogram.workflows.evaluation.reference_models import JUDGES, EvaluationSettings
from tactogram.workflows.evaluation.run_evaluation import evaluate_run
from tactogram.workflows.training import loaded_run
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

QUICK, HASTY = {"steps": 60}, {"steps": 4, "most": 2}
COLUMNS = {"model", "floor", "ceiling", "nearest_other", "ar_texture", "replay"}


@pytest.fixture(scope="module")
def trained(store, tmp_path_factory):
    def make(model, **options):
        out = tmp_path_factory.mktemp("runs") / model
        return train(model, store, recipe="tiny", out=out, accelerator="cpu", **options).folder

    return make


@pytest.fixture(scope="module")
def voice(trained):
    return trained("ar_texture")


@pytest.fixture(scope="module")
def figures(voice):
    return evaluate(voice, evaluation=QUICK)


def judged(loaded, **more):
    """The result alone: no page is written."""
    store, split = loaded_run.test_part(loaded.run)
    train, test = (Examples(store, part, loaded.as_trained) for part in (split.train, split.test))
    return evaluate_generator(loaded, list(test), train, settings=EvaluationSettings(**HASTY | more))[0]


def test_every_figure_stands_beside_floor_ceiling_and_baselines(figures, voice):
    assert set(figures["measures"]) == set(describe_measures())
    for name, row in figures["measures"].items():
        assert set(row) == COLUMNS, name
        assert None not in (row["model"], row["floor"], row["ceiling"], row["replay"]), name
    for rows in figures["per_material"].values():
        assert set(rows) == set(figures["measures"])
    assert set(figures["per_material"]) == {"cork", "foam", "tile", "wool"}
    assert json.loads((voice / "evaluation.json").read_text()) == figures
    assert figures["data"]["simulated"] is True
    assert figures["pieces"] == {"seconds": pytest.approx(1.5, abs=0.01), "count": 4}


def test_the_figures_are_what_these_textures_ask_for(figures):
    """An autoregressive process is met by ar_texture; replay is made of recordings, and caught at it."""
    spectra = figures["measures"]["log_spectral_distance_db"]
    assert spectra["model"] < 2 * spectra["floor"] < spectra["ceiling"]
    assert spectra["replay"] < 2 * spectra["floor"]
    copied = figures["measures"]["memorised_share"]
    assert copied["model"] < 0.5 < copied["replay"]
    assert figures["measures"]["recognised_accuracy"]["ceiling"] == 0.25
    assert figures["positions"]["level_difference_db"]["model"] < 0.3


def test_a_run_that_is_a_baseline_is_its_own_column(figures):
    assert all(row["model"] == row["ar_texture"] for row in figures["measures"].values())
    assert figures["worse_than"]["ar_texture"] == []
    gain = figures["beside"]["replay"]["memorised_share"]
    assert gain["better_on"] == gain["materials"] == 4


def test_what_it_was_judged_with_is_kept_and_found_again(figures, voice, monkeypatch):
    kept = sorted(file.name.split("-")[0] for file in (voice / JUDGES).iterdir())
    assert kept == ["stroke_cnn"]  # ar_texture is the run itself; replay would keep the recordings
    loaded = load_run(voice)
    before = judged(loaded).as_dict()
    (file,) = (f for f in (voice / JUDGES).iterdir() if f.stat().st_mtime_ns == newest(voice))
    with monkeypatch.context() as patched:
        patched.setattr("tactogram.models.stroke_cnn.learner.StrokeCNNLearner.step", None)
        assert judged(loaded).as_dict() == before
    file.write_bytes(file.read_bytes()[:-100])  # a broken one is made again
    assert judged(loaded).as_dict() == before


def newest(run):
    return max(file.stat().st_mtime_ns for file in (run / JUDGES).iterdir())


def test_the_report_shows_and_plays_it(figures, voice):
    page = (voice / "report.html").read_text()
    for heading in (
        "Summary",
        "Every material, every measure",
        "Comparison with the baselines",
        "All values",
    ):
        assert f">{heading}</h2>" in page
    assert page.count("<audio") == 4 * 4
    assert page.count("<img") == 2 + 2 + 4  # where it stands, every measure; pairs of spectrograms; spectra
    assert "Simulated data" in page
    assert "coverage" in page
    assert not re.search(r'(src|href)="(?!data:|#)', page)


def test_replay_is_caught_memorising(trained):
    found = judged(load_run(trained("replay")), most=4)
    row = found.overall["memorised_share"]
    assert row["model"] == row["replay"] > 0.5
    assert found.position("training_correlation") > 0.1
    assert row["ar_texture"] < 0.5


def test_one_material_has_no_ceiling_and_says_so(trained, store):
    run = trained("ar_texture", where={"material": "cork"})
    split = json.loads((run / "split.json").read_text())
    split["test"] = split["test"][:1]
    (run / "split.json").write_text(json.dumps(split))
    figures, _ = evaluate_run(run, evaluation=HASTY)
    row = figures["measures"]["log_spectral_distance_db"]
    assert row["floor"] > 0
    assert row["ceiling"] is None
    assert "frechet_distance" not in figures["measures"]
    assert any("there is one material" in note for note in figures["notes"])
    json.dumps(figures, allow_nan=False)


def test_other_data_is_judged_beside_the_runs_own(voice, recordings, tmp_path):
    create_store(tmp_path / "new", recordings(("tile", "cork"), 2, first=70), name="new", licence="-")
    figures, _ = evaluate_run(voice, data=tmp_path / "new", evaluation=HASTY)
    assert set(figures["per_material"]) == {"cork", "tile"}
    assert figures["measures"]["log_spectral_distance_db"]["ceiling"] is not None


def test_conditions_of_the_recordings_are_asked_for(voice, monkeypatch):
    asked = []
    loaded = load_run(voice)
    make = loaded.model.generate
    monkeypatch.setattr(
        loaded.model, "generate", lambda condition, **rest: asked.append(condition) or make(condition, **rest)
    )
    judged(loaded)
    assert {c["speed_mm_s"] for c in asked} <= {100.0, 200.0}
    assert {c["material"] for c in asked} == {"cork", "foam", "tile", "wool"}


def test_a_model_that_does_not_know_a_speed_is_asked_for_the_material(trained):
    found = judged(load_run(trained("ar_texture", changes={"config.by_condition": False})))
    assert any(note.startswith("model was conditioned on materials alone") for note in found.notes)
    assert "log_spectral_distance_db" in found.values


def test_sound_at_a_high_rate_and_one_axis(tmp_path):
    def noise(material, seed):
        rng = np.random.default_rng([seed, len(material)])
        x = np.cumsum(rng.standard_normal(8000)) if material == "smooth" else rng.standard_normal(8000)
        return Signal((x - x.mean()) / np.ptp(x), 8000.0, "1")

    made = (
        Recording(streams={"sound": noise(name, seed)}, material=name)
        for name in ("smooth", "rough")
        for seed in range(5)
    )
    create_store(tmp_path / "s", made, name="s", licence="-")
    run = train("replay", tmp_path / "s", recipe="quick", out=tmp_path / "r", accelerator="cpu")
    figures = evaluate(run.folder, evaluation=QUICK | {"most": 4})
    assert "coherence_distance" not in figures["measures"]
    assert figures["measures"]["recognised_accuracy"]["floor"] == 1
    assert "Everything was evaluated at 2500 Hz, which holds all perceptible frequencies." in figures["notes"]
    assert "Simulated data" not in (run.folder / "report.html").read_text()


def test_what_is_missing_is_said_in_a_line(trained, store, recordings, tmp_path):
    alone = trained("ar_texture", split="all")
    with pytest.raises(ParameterError, match="kept no recordings for testing; give `data`"):
        evaluate(alone)
    shutil.copytree(store, tmp_path / "gone")
    run = train("ar_texture", tmp_path / "gone", recipe="tiny", out=tmp_path / "r", accelerator="cpu")
    shutil.rmtree(tmp_path / "gone")
    create_store(tmp_path / "new", recordings(("tile",), 2, first=90), name="new", licence="-")
    with pytest.raises(RunError, match="compared with the recordings it was trained on"):
        evaluate(run.folder, data=tmp_path / "new", evaluation=HASTY)
    assert not (run.folder / "evaluation.json").exists()


def test_a_generator_that_learned_no_contactor_is_given_the_rest():
    asked = []

    class Generator:
        def generate(self, condition, *, seconds, seed):
            if "contactor" in condition:
                raise ParameterError("contactor makes no difference to this run")
            asked.append(condition)
            return Signal(np.random.default_rng(seed).standard_normal((1, 1000)), 1000.0, "m/s^2", ("z",))

    facts = SimpleNamespace(needs=("material",), takes=("speed_mm_s", "contactor"), conditions=())
    kind = SimpleNamespace(materials=("cork",), scale=None, domain="time")
    notes = []
    conditioned = _ConditionedGenerator("run", facts, Generator(), kind, None, {}, 1000.0, 0, notes)
    stroke = SimpleNamespace(
        condition={"speed_mm_s": 50.0, "contactor": "finger"}, photographs=(), material="cork", rated=None
    )
    conditioned.drawn(stroke, 0, 1.0)
    assert (asked, notes) == ([{"speed_mm_s": 50.0, "material": "cork"}], [])
