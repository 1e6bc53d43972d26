"""Predictors of ratings: trained, cross-validated by item and by rater, judged, and used on files."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Ratings, Recording, Scale, create_store
from tactogram.errors import LeakError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.ratings import MODEL, evaluate_reproduction, predicted_ratings
from tactogram.workflows.evaluation.word_signals import generate_rated_surfaces
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.recognition.score import score
from tactogram.workflows.training.train import train

RATE = 400.0
FACTS = {"name": "made up", "licence": "-", "simulated": True}
WORDS = ("rough", "sticky")


def vibration(level, seed):
    return Signal(level * np.random.default_rng(seed).standard_normal((1, 400)), RATE, "1", ("drive",))


def ratings_of(levels, raters=6, seed=0):
    """Simulated: rough goes by the level in dB, sticky by nothing."""
    rng = np.random.default_rng(seed)
    rows = [
        (f"r{r}", item, word, float(np.clip(np.round(mean + rng.normal(0, 0.7)), 1, 7)))
        for item, level in levels.items()
        for r in range(raters)
        for word, mean in zip(WORDS, (7 + 3 * np.log10(level), 4.0), strict=True)
    ]
    rater, item, word, value = zip(*rows, strict=True)
    return Ratings(rater, item, word, np.array(value), words=WORDS)


def rated_store(path, count=20, seed=0, change=lambda ratings: ratings):
    levels = {f"s{n:02d}": float(10 ** -np.random.default_rng([seed, n]).uniform(0, 2)) for n in range(count)}
    recordings = [
        Recording(
            streams={"drive": vibration(level, 100 * seed + n)},
            labels={"item": item},
            source=item,
            simulated=True,
        )
        for n, (item, level) in enumerate(levels.items())
    ]
    return create_store(path, recordings, ratings=change(ratings_of(levels)), **FACTS).path


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return rated_store(tmp_path_factory.mktemp("rated") / "s")


@pytest.fixture(scope="module")
def run(store, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "rater"
    return train("rater", store, recipe="tiny", out=out, accelerator="cpu").folder


def test_crossval_by_item_is_better_than_a_constant_where_there_is_something_to_learn(store, tmp_path):
    found = crossval("rater", store, recipe="tiny", processes=1, folds=4, repeats=2, out=tmp_path)
    rough = found["per_word"]["rough"]
    assert rough["mae"] < 0.6 * rough["constant_mae"]
    assert rough["rank_correlation"] > 0.7
    assert rough["split_half_mae"] < rough["one_rater_mae"]
    assert found["data"]["simulated"]
    assert json.loads((tmp_path / "crossval.json").read_text())["mean"]["mae"] == found["mean"]["mae"]
    assert (tmp_path / "words.png").is_file()


@pytest.mark.slow
def test_processes_change_no_figure(store, tmp_path):
    options = {"recipe": "tiny", "folds": 2, "repeats": 2}
    here = crossval("rater", store, out=tmp_path / "here", processes=1, **options)
    there = crossval("rater", store, out=tmp_path / "there", processes=2, **options)
    assert there | {"report": ""} == here | {"report": ""}


def test_crossval_by_rater_is_judged_by_people_who_were_not_trained_on(store, tmp_path):
    """Held against two people's mean and not six, it cannot come closer than their noise."""
    by_item = crossval(
        "rater", store, recipe="tiny", processes=1, folds=3, repeats=1, by="item", out=tmp_path / "i"
    )
    both = crossval(
        "rater", store, recipe="tiny", processes=1, folds=3, repeats=1, by="both", out=tmp_path / "b"
    )
    by_rater = crossval(
        "rater", store, recipe="tiny", processes=1, folds=3, repeats=1, by="rater", out=tmp_path / "r"
    )
    noise = 0.7 * np.sqrt(2 / np.pi / 2)
    assert by_rater["per_word"]["sticky"]["mae"] == pytest.approx(noise, rel=0.4)
    assert both["per_word"]["sticky"]["mae"] > by_item["per_word"]["sticky"]["mae"]
    assert "raters that were not trained on" in by_rater["split"]


def test_crossval_refuses_what_makes_no_sense(store, tmp_path):
    with pytest.raises(ParameterError, match="must be item, rater or both"):
        crossval("rater", store, by="session", out=tmp_path)
    with pytest.raises(ParameterError, match="7 folds need as many raters, got 6"):
        crossval("rater", store, by="rater", folds=7, out=tmp_path)
    with pytest.raises(ParameterError, match="are for classifiers; a predictor takes `folds`"):
        crossval("rater", store, only_folds=1, out=tmp_path)


def test_evaluate_judges_a_predictor_on_items_kept_apart(run, store, tmp_path):
    found = evaluate(run)
    assert found["per_word"]["rough"]["mae"] < found["per_word"]["rough"]["constant_mae"]
    assert "4 rated items held out" in found["data"]["split"]
    other = evaluate(run, data=rated_store(tmp_path / "other", seed=1))
    assert "20 rated items of another data set" in other["data"]["split"]
    with pytest.raises(LeakError, match="were trained on"):
        evaluate(run, data=store)


def test_score_is_on_the_raters_scale_and_says_who_tells(run):
    loud, quiet = (score(run, vibration(level, 9)) for level in (1.0, 0.02))
    assert 1 <= quiet["scores"]["rough"] < loud["scores"]["rough"] <= 7
    assert loud["scale"] == [1.0, 7.0]
    assert loud["predicted_by"] == "rater model of simulated raters"
    assert score(run, vibration(100.0, 9))["novelty"] > loud["novelty"]


def test_score_and_crossval_are_verbs(run, store, tmp_path, capsys):
    write_signal(tmp_path / "a.npz", vibration(0.5, 3))
    assert main(["score", str(run), str(tmp_path / "a.npz"), "--json"]) == 0
    [found] = json.loads(capsys.readouterr().out)["files"].values()
    assert set(found["scores"]) == set(WORDS)
    assert main(["score", str(run), str(tmp_path / "a.npz")]) == 0
    assert "predicted by a rater model of simulated raters, scale 1 to 7" in capsys.readouterr().out
    arguments = [
        "crossval",
        "rater",
        "--data",
        str(store),
        "--recipe",
        "tiny",
        "--folds",
        "2",
        "--repeats",
        "1",
    ]
    assert main([*arguments, "--by", "material", "--out", str(tmp_path / "cv")]) == 0
    assert "simulated raters" in capsys.readouterr().out
    assert main(["score", str(run), str(tmp_path / "nothing.wav")]) == 1


def test_a_rater_model_tells_the_errors_of_generated_signals(run, tmp_path):
    given = {
        f"{kind}/p{n}": vibration(level, n) for kind, level in (("sensor", 1.0), ("A", 0.1)) for n in range(3)
    }
    said = predicted_ratings(run, given)
    assert said.raters == (MODEL,)
    targets = {f"p{n}": [4.0, 4.0] for n in range(3)}
    found = evaluate_reproduction(
        said, targets, conditions=("sensor", "A"), told_by="a rater model", out=tmp_path / "f.png"
    )
    assert found["conditions"]["A"]["mae"] < found["conditions"]["sensor"]["mae"]
    assert (tmp_path / "f.png").is_file()
    assert json.loads((tmp_path / "f.json").read_text())["told_by"] == "a rater model"


def strain(seed):
    return Signal(np.random.default_rng(seed).standard_normal((2, 500)), RATE, "V", ("g1", "g2"))


def plates_and_signals(path):
    levels = {f"s{n}": float(10 ** -(n / 8)) for n in range(12)} | {
        "plate1": 0.9,
        "plate2": 0.05,
        "plate3": 0.3,
    }
    signals = [
        Recording(streams={"drive": vibration(levels[f"s{n}"], n)}, labels={"item": f"s{n}"}, source=f"s{n}")
        for n in range(12)
    ]
    plates = [
        Recording(
            streams={"strain": strain(10 * p + m)},
            material=f"plate{p}",
            session=f"plate{p}-m{m}",
            source=f"plate{p}/{m}",
        )
        for p in (1, 2, 3)
        for m in range(5)
    ]
    return create_store(path, plates + signals, ratings=ratings_of(levels), **FACTS).path


def test_a_generator_by_words_is_judged_by_a_rater_model_beside_the_sensor_and_the_nearest_signal(
    run, tmp_path
):
    data = plates_and_signals(tmp_path / "s")
    trained = train(
        "ultrasonic_cgan", data, recipe="tiny", by="session", out=tmp_path / "run", accelerator="cpu",
        changes={"config.clusters": 1},
    )  # fmt: skip
    made = generate_rated_surfaces(trained.folder)
    assert set(made.signals) == set(made.targets) == set(made.straight) == {"plate1", "plate2", "plate3"}
    assert all(np.abs(one.samples).max() == 1 for one in made.straight.values())
    assert len(made.nearest["plate1"]) == 400
    with pytest.raises(ParameterError, match="give `rater`"):
        evaluate(trained.folder)
    found = evaluate(trained.folder, rater=run)
    assert set(found["conditions"]) == {"sensor", "nearest", "run"}
    assert found["told_by"] == "a rater model of simulated raters"
    assert found["conditions"]["nearest"]["mae"] < found["conditions"]["sensor"]["mae"]

    turned = rated_store(tmp_path / "turned", change=lambda ratings: ratings.in_words(WORDS[::-1]))
    rater = train("rater", turned, recipe="tiny", out=tmp_path / "turned-run", accelerator="cpu").folder
    again = evaluate(trained.folder, rater=rater)
    for name, row in found["conditions"].items():
        assert again["conditions"][name]["mae"] == pytest.approx(row["mae"], rel=1e-6), "words by their names"

    other = rated_store(
        tmp_path / "other", change=lambda ratings: replace(ratings, scale=Scale("wide", 0.0, 10.0))
    )
    rater = train("rater", other, recipe="tiny", out=tmp_path / "other-run", accelerator="cpu").folder
    with pytest.raises(ParameterError, match=r"on the scale of the surfaces, 1 to 7; got \(0.0, 10.0\)"):
        evaluate(trained.folder, rater=rater)


def test_what_a_rater_cannot_score_is_named_with_its_file(run, tmp_path, capsys):
    good, other = tmp_path / "good.npz", tmp_path / "other.npz"
    write_signal(good, vibration(0.1, 5))
    write_signal(other, Signal(vibration(0.1, 5).samples, RATE, "V", ("g1",)))
    assert main(["score", str(run), str(good), str(other)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(
        f"tactogram: {other}: signal must be 400 Hz, 1, axes drive; got 400 Hz, V, axes g1"
    )
    assert said.err.count("\n") == 1


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


def test_rated_vibrations_of_no_material_train_a_generator_that_follows_words(store, tmp_path):
    out = tmp_path / "run"
    train("texture_flow", store, recipe="tiny", label="item", split="all", out=out, accelerator="cpu")
    smooth, rough = (
        next(generate(out, {"words": {"rough": score}}, seconds=2)).samples.std() for score in (2.0, 6.0)
    )
    assert rough > 5 * smooth
