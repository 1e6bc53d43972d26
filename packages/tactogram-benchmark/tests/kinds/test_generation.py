"""Generated recordings: what a recording, another material and the baselines are worth."""

import numpy as np
from scipy.signal import welch

from tactogram_benchmark.task_kind import kind_of


def recordings(opened, material, part):
    return [e.signal.samples for e in opened.examples(part) if e.material == material]


def repeated(samples, question, rate):
    count = int(np.ceil(question.seconds * rate))
    return np.tile(samples, (1, -(-count // samples.shape[1])))[:, :count]


def test_recordings_are_near_the_floor_and_another_material_is_far(judged):
    def from_training(opened, question):
        material, place = question.id.split("/")
        held = recordings(opened, material, "train")
        return repeated(held[int(place) % len(held)], question, opened.kind.rate)

    def another(opened, question):
        names = list(opened.materials)
        other = names[(names.index(question.id.split("/")[0]) + 1) % len(names)]
        return repeated(recordings(opened, other, "train")[0], question, opened.kind.rate)

    near, far = judged("generate", from_training)[2], judged("generate", another)[2]
    assert near.figures["distance"].value < 0.05
    assert 0.5 < far.figures["distance"].value < 2
    assert near.figures["recognised_accuracy"].value > far.figures["recognised_accuracy"].value
    assert set(near.shown) == {"material-0", "material-0 recorded", *far.shown}


def test_a_random_answer_is_a_training_item_and_the_mean_is_noise_of_its_log_spectrum(tasks):
    opened = tasks.open("generate")
    kind = kind_of("generation")
    questions, rate = kind.questions(opened), opened.kind.rate
    drawn, mean = (kind.baselines[name](opened, questions, 0) for name in ("random", "mean"))
    known = {e.signal.samples[:, :100].tobytes(): e.material for e in opened.train}
    shown = [known[drawn[q.id][:, :100].astype(np.float32).tobytes()] for q in questions]
    assert len(set(shown)) > 2
    assert any(of != q.id.split("/")[0] for of, q in zip(shown, questions, strict=True))
    again = kind.baselines["random"](opened, questions, 1)
    assert any(not np.array_equal(again[q.id], drawn[q.id]) for q in questions)
    powers = [welch(e.signal.samples[0], rate, nperseg=256)[1] for e in opened.train]
    expected = 10 * np.log10(powers).mean(0)
    made = np.hstack([mean[q.id] for q in questions])[0]
    got = 10 * np.log10(welch(made, rate, nperseg=256)[1])
    assert np.abs(got - expected)[6:80].mean() < 1.5  # dB, in the bands of the materials
    assert all(mean[q.id].shape[1] >= q.seconds * rate for q in questions)
