"""Rejection of unknown surfaces, against scikit-learn."""

import numpy as np
import pytest
from sklearn.metrics import roc_auc_score


def test_the_area_is_that_of_scikit_learn(judged):
    rng = np.random.default_rng(0)
    far = {}

    def answer(opened, question):
        far[question.id] = rng.integers(6)  # with ties
        return np.array([far[question.id], far[question.id] > 3])

    opened, questions, found = judged("none", answer)
    unknown = {e.id: e.material not in opened.materials for e in opened.test}
    ids = [question.id for question in questions]
    of = {e.id: e.material for e in opened.test}
    surfaces = {known: sorted({of[id] for id in ids if unknown[id] != known}) for known in (True, False)}
    for strange in surfaces[False]:
        areas = []
        for near in surfaces[True]:
            asked = [id for id in ids if of[id] in (strange, near)]
            areas.append(roc_auc_score([unknown[id] for id in asked], [far[id] for id in asked]))
        assert found.figures["auroc"].by_item[strange] == pytest.approx(np.mean(areas))
    assert found.figures["auroc"].by_item.keys() == set(surfaces[False])
    kept = [np.mean([far[id] <= 3 for id in ids if of[id] == near]) for near in surfaces[True]]
    assert found.figures["known_kept"].value == pytest.approx(np.mean(kept))
