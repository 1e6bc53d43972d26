"""The experiments with stroke_cnn: held-out materials, and cost beside accuracy."""

import json
from types import SimpleNamespace

import pytest
from benchmarks.experiments import stroke_cnn_cost, stroke_cnn_none_of_these, stroke_cnn_short

from tactogram.models.stroke_cnn import learner
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.progress import silent

STORE = SimpleNamespace(
    index=[SimpleNamespace(material=name) for name in "abcdefg" for _ in range(2)],
    name="lab",
    sha256="0" * 64,
    simulated=False,
    path="lab",
)


def test_each_turn_holds_other_materials_out(tmp_path, monkeypatch):
    asked = []

    def trained(model, store, out, *, changes, where, **options):
        asked.append((changes["seed"], where["material"].removeprefix("!").split("|"), changes))
        return out

    def evaluated(out, *, unknown, progress):
        kept = {"seed-0-turn-0": 0.9, "seed-0-turn-1": 1.0}.get(out.name, 0.8)
        rejection = {"known_kept": kept, "unknown_rejected": 0.5, "auroc": 0.9}
        return {"recording_accuracy": 1.0, "window_accuracy": 0.7, "none_of_these": rejection}

    monkeypatch.setattr(stroke_cnn_none_of_these, "find_or_simulate", lambda *args, **options: STORE)
    monkeypatch.setattr(stroke_cnn_none_of_these, "trained_run", trained)
    monkeypatch.setattr(stroke_cnn_none_of_these, "evaluate", evaluated)
    found = stroke_cnn_none_of_these.run(
        tmp_path, paper=False, progress=silent, band=(20, 1000), held_out=3, turns=2, seeds=2, steps=50
    )
    assert [seed for seed, _, _ in asked] == [0, 0, 1, 1]
    for (_, first, _), (_, second, _) in (asked[:2], asked[2:]):
        assert len(first) == len(second) == 3
        assert not {*first} & {*second}
    assert asked[0][1] != asked[2][1]
    assert asked[0][2] == {
        "training.precision": "auto", "prepare.band": [20, 1000], "config.steps": 50, "seed": 0,
    }  # fmt: skip
    assert found["known_kept"]["mean"] == pytest.approx((0.9 + 1.0 + 0.8 + 0.8) / 4)
    assert "known_kept" in found["text"]


def test_costs_are_paired_by_seed_and_measured_once(tmp_path, monkeypatch):
    made = []

    def crossval(model, data, *, folds, only_folds, changes, out):
        made.append(out.name)
        exact = "training.precision" in changes
        accuracy = 0.7 + 0.1 * changes["seed"] + 0.05 * exact
        return {
            "window_accuracy": accuracy, "recording_accuracy": 1.0, "recordings": 10, "windows": 99,
        }  # fmt: skip

    monkeypatch.setattr(stroke_cnn_cost, "find_or_simulate", lambda *args, **options: STORE)
    monkeypatch.setattr(stroke_cnn_cost, "crossval", crossval)
    found = stroke_cnn_cost.run(tmp_path, paper=False, progress=silent, seeds=3)
    assert made == ["float32-0", "quick-0", "float32-1", "quick-1", "float32-2", "quick-2"]
    assert found["window_accuracy"]["difference"]["mean"] == pytest.approx(-0.05)
    assert found["window_accuracy"]["difference"]["sd"] == pytest.approx(0, abs=1e-9)
    assert found["window_accuracy"]["float32"]["sd"] == pytest.approx(0.1)
    again = stroke_cnn_cost.run(tmp_path, paper=False, progress=silent, seeds=3)
    assert len(made) == 6
    assert json.dumps(again) == json.dumps(found)


def test_a_shorter_training_is_compared_with_the_whole_on_other_recordings(tmp_path, monkeypatch):
    simulate_to_store("stroking9", tmp_path / "data", per_class=5, seconds=1.0, workers=1)
    quick = tmp_path / "quick.toml"
    quick.write_text(
        'model = "stroke_cnn"\n[config]\nwindow = 384\nsteps = 3\nshort_steps = 2\nfilters = [2, 2]\n'
    )
    monkeypatch.setattr(stroke_cnn_short, "find", lambda name: SimpleNamespace(recipe=lambda name: quick))
    monkeypatch.setattr(learner, "MOST_PASSES", 0)
    for settled, kept in ((1.1, 0), (0.0, 2)):
        monkeypatch.setattr(learner, "SETTLED", settled)
        found = stroke_cnn_short.run(tmp_path, paper=False, progress=silent, materials=4, tested=1, seeds=2)
        assert found["kept"] == kept
        assert [row["recordings"] for row in found["rows"]] == [4, 4]
        assert 0 <= found["classify"]["window_accuracy"]["mean"] <= 1
        assert found["short"]["cpu_seconds"]["mean"] > 0
        for seed in range(2):
            (tmp_path / f"{seed}.json").unlink()
