"""Retrieval, against scikit-learn."""

import numpy as np
import pytest
from sklearn.metrics import average_precision_score


def test_average_precision_is_that_of_scikit_learn(judged):
    rng = np.random.default_rng(1)
    vectors = {}

    def answer(opened, question):
        return vectors.setdefault(question.id, rng.standard_normal(5))

    opened, questions, found = judged("retrieve", answer)
    names = {example.id: example.material for example in opened.test}
    assert not {names[q.id] for q in questions} & set(opened.materials)  # surfaces that were not trained on
    unit = np.stack([vectors[q.id] / np.linalg.norm(vectors[q.id]) for q in questions])
    expected = {}
    for place, question in enumerate(questions):
        others = [n for n in range(len(questions)) if n != place]
        same = [names[questions[n].id] == names[question.id] for n in others]
        precision = average_precision_score(same, unit[others] @ unit[place])
        expected.setdefault(names[question.id], []).append(precision)
    by_surface = found.figures["average_precision"].by_item
    assert by_surface == pytest.approx({name: np.mean(held) for name, held in expected.items()})
