"""Names of materials: what right and wrong ones are worth."""

import numpy as np
import pytest


def shares(opened, question, right):
    true = {example.id: example.material for example in opened.test}[question.id]
    place = opened.materials.index(true)
    return np.eye(len(opened.materials))[place if right else (place + 1) % len(opened.materials)]


def test_the_right_names_are_worth_1_and_wrong_ones_0(judged):
    _opened, _, right = judged("name", lambda opened, q: shares(opened, q, right=True))
    assert right.figures["accuracy"].value == 1
    assert right.figures["cross_entropy"].value == 0
    assert right.figures["accuracy"].ceiling == pytest.approx(1 / 6)
    wrong = judged("name", lambda opened, q: shares(opened, q, right=False))[2]
    assert wrong.figures["accuracy"].value == 0
    assert wrong.figures["cross_entropy"].value == pytest.approx(np.log(1e6))
