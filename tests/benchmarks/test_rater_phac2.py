"""Adjectives of objects that were held out, by the rater's regression and a plain one."""

import numpy as np
import pytest
from benchmarks.experiments import rater_phac2

from tactogram.workflows.progress import silent


def phac2(folder, objects=20, trials=2):
    """One adjective that a statistic tells, one that nothing tells, and one of a single object."""
    rng = np.random.default_rng(0)
    given = np.stack([np.arange(objects) % 2, rng.permutation(objects) % 2, np.arange(objects) == 0], axis=1)
    rows = ["object_id,object,trials,hard,nice,sticky"]
    rows += [f"{n},thing{n},{trials},{','.join(map(str, row.astype(int)))}" for n, row in enumerate(given)]
    (folder / "object_adjectives.csv").write_text("\n".join(rows) + "\n")
    ids = np.repeat(np.arange(objects), trials)
    features = rng.standard_normal((len(ids), 2, 3))
    features[:, 0, 0] += 4 * given[ids, 0]
    np.savez(
        folder / "phac2_static_features.npz", features=features, phases=np.array(["a", "b"]),
        trial_names=np.array([f"t{n}" for n in range(len(ids))]), object_ids=ids.astype(np.int32),
        adjectives=np.array(["hard", "nice", "sticky"]), labels=given[ids].astype(np.int8),
    )  # fmt: skip


def test_adjectives_are_told_of_objects_that_were_held_out(tmp_path):
    phac2(tmp_path)
    found = rater_phac2.run(tmp_path, paper=False, progress=silent, data=str(tmp_path), seeds=1)
    assert found["left_out"] == ["sticky"]
    for row in found["rows"].values():
        assert row["per_adjective"]["hard"] > 0.9
        assert row["per_adjective"]["nice"] < 0.8
        assert row["mean_auc"] == pytest.approx(np.mean(list(row["per_adjective"].values())))
    assert "left out, of one object each: sticky" in found["text"]


def test_the_logistic_regression_reaches_what_is_known_of_real_objects(real_data, monkeypatch):
    """About 0.80 over adjectives of several objects; the rater's regression is left out here, it takes a minute."""
    folder = real_data("phac2_adjectives")
    held = rater_phac2.read_phac2(folder)
    drawn = np.array_split(np.random.default_rng(0).permutation(len(held.objects)), 2)
    name = held.adjectives.index("metallic")
    scores = np.full(held.table.shape, np.nan)
    for unseen in drawn:
        scores[unseen] = rater_phac2._logistic(held, unseen, [name], 0)
    assert rater_phac2.roc_auc_score(held.table[:, name], scores[:, name]) > 0.8


def test_folds_leave_every_adjective_two_classes_to_learn_from():
    table = np.zeros((20, 8), bool)
    for n in range(
        8
    ):  # two objects each: a plain drawing of ten folds puts some pair into one fold now and then
        table[[2 * n, 2 * n + 1], n] = True
    for seed in range(40):
        folds = rater_phac2.drawn_folds(table, seed)
        assert sorted(np.concatenate(folds)) == list(range(20))
        for unseen in folds:
            seen = np.setdiff1d(np.arange(20), unseen)
            assert table[seen].any(0).all(), seed
