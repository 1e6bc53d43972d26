"""Mixes: where their steps lie between recordings of the ends."""

import pytest


def recordings(opened, material, part):
    return [e.signal.samples for e in opened.examples(part) if e.material == material]


def test_steps_of_a_mix_lie_where_recordings_of_the_ends_put_them(judged):
    def step(opened, question):
        (start, end), weight = question.id.split("/")[0].split("+"), float(question.id.split("/")[1])
        held = recordings(opened, end if weight > 0.5 else start, "test")
        return held[int(question.id.split("/")[2])]

    def one_end(opened, question):
        return recordings(opened, question.id.split("+")[0], "test")[int(question.id.split("/")[2])]

    found = judged("mix", step)[2].figures
    assert found["position_error"].value == pytest.approx(0.5 / 3, abs=0.05)  # 0, 0 instead of 0.5, 1
    assert judged("mix", one_end)[2].figures["position_error"].value == pytest.approx(0.5, abs=0.05)
    assert found["position_error"].ceiling == pytest.approx(1 / 3)  # of 0, 0.5 and 1
