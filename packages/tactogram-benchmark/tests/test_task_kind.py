"""Kinds of tasks: what perfect, useless and broken answers are worth."""

from collections import Counter

import numpy as np
import pytest
from scipy.signal import welch
from sklearn.metrics import average_precision_score, roc_auc_score

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.workflows.progress import silent
from tactogram_benchmark import ignoring
from tactogram_benchmark.data import items_of, mean_scores, rated_examples
from tactogram_benchmark.kinds import words
from tactogram_benchmark.task_kind import check_answers, kind_of
from tactogram_benchmark.training import training_plan


@pytest.fixture(name="judged")
def judged_fixture(tasks):
    """Give a function that judges answers, by question, of a task."""

    def judge(name, answer):
        opened = tasks.open(name)
        kind = kind_of(opened.task.kind)
        kind.check(opened)
        questions = kind.questions(opened)
        answers = {question.id: answer(opened, question) for question in questions}
        check_answers(kind.form(opened), questions, answers, where=name)
        return opened, questions, kind.judge(opened, answers, silent)

    return judge


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


def test_what_ignores_the_surface_keeps_speed_and_force():
    fast, slow = {"speed_mm_s": 200.0, "force_n": 1.0}, {"speed_mm_s": 50.0, "force_n": 1.0}
    items = [(fast, "a"), (slow, "b"), (slow, "c"), ({}, "d")]
    assert ignoring._alike(items, {**slow, "image": "photo"}) == ["b", "c"]
    assert ignoring._alike(items, {"force_n": 1.0}) == ["a", "b", "c"]
    assert ignoring._alike(items, {"speed_mm_s": 120.0}) == ["a", "b", "c", "d"]  # none of that speed


def test_the_mean_of_scores_is_worth_the_ceiling(judged, tasks):
    mean = kind_of("rating").baselines["mean"]
    found = judged("rate", lambda opened, q: mean(opened, [q], 0)[q.id])[2].figures
    assert found["error"].value == pytest.approx(found["error"].ceiling)


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


def test_the_scores_of_people_are_worth_an_error_of_0(judged):
    def right(opened, question):
        item = {e.id: e.item for e in rated_examples(opened, "test")}[question.id]
        return mean_scores(opened, [item])[0]

    found = judged("rate", right)[2].figures
    assert found["error"].value == 0
    assert found["rank_correlation"].value == pytest.approx(1)
    assert found["error"].ceiling > 0.3


def test_the_correlation_of_words_is_the_mean_of_its_parts(judged):
    rng = np.random.default_rng(2)

    def noise(opened, question):
        return rng.standard_normal((len(opened.kind.axes), 2500)).astype(np.float32)

    opened, _questions, found = judged("words", noise)
    figure = found.figures["correlation"]
    assert np.mean(list(figure.by_item.values())) == pytest.approx(figure.value)
    assert set(figure.by_item) == set(items_of(rated_examples(opened, "test")))
    assert -1 <= figure.low <= figure.value <= figure.high <= 1
    assert figure.floor > figure.value  # the recording itself is read better than noise


def test_a_rater_model_that_cannot_read_recordings_does_not_judge(judged, monkeypatch):
    monkeypatch.setattr(words, "LEAST_READ", 1.1)
    with pytest.raises(
        ParameterError, match=r"at a correlation of 0\.\d\d with people, below 1.1: it needs more"
    ):
        judged("words", lambda opened, question: np.ones((len(opened.kind.axes), 2500), np.float32))


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, "expected an answer to each of 12 questions, got none to"),
        (np.full(6, np.nan), "must be finite numbers"),
        (np.full(6, 0.5), r"got the sum 3 and the least 0.5"),
        (np.array([1.5, -0.5, 0, 0, 0, 0]), r"got the sum 1 and the least -0.5"),
        (np.ones(5), r"must be the probabilities of 6 materials, shape \(6,\), sum 1, got shape \(5,\)"),
    ],
)
def test_broken_answers_are_refused(judged, tasks, answer, message):
    opened = tasks.open("name")
    kind = kind_of("classification")
    questions = kind.questions(opened)
    answers = {q.id: np.ones(6) / 6 for q in questions}
    answers[questions[0].id] = answer
    if answer is None:
        del answers[questions[0].id]
    with pytest.raises(ParameterError, match=message):
        check_answers(kind.form(opened), questions, answers, where="answers")


def test_a_model_of_a_display_learns_from_the_rated_surfaces_too(tasks):
    opened = tasks.open("display")
    kind = kind_of("words")
    kind.check(opened)
    assert not any(kind.fits(tasks.open("words"), models.find(name)) for name in ("ultrasonic_cgan", "rater"))
    materials = {info.id: info.material for info in opened.store.index}
    found = {}
    for name in ("ultrasonic_cgan", "texture_flow"):
        assert kind.fits(opened, models.find(name))
        parts = training_plan(opened, models.find(name), seed=0).parts
        assert not parts.validation  # it trains the judge
        found[name] = Counter(materials[segment.id] for segment in parts.train)
    assert found["texture_flow"] == {None: 6}
    assert found["ultrasonic_cgan"] == {None: 6, "material-0": 2, "material-1": 2}


def test_a_task_of_the_wrong_split_is_refused(tasks):
    opened = tasks.open("name")
    with pytest.raises(
        ParameterError, match="must hold recordings of materials that are trained on, and of others"
    ):
        kind_of("rejection").check(opened)
    with pytest.raises(ParameterError, match="two recordings or more of each of two materials"):
        kind_of("retrieval").check(opened)
    with pytest.raises(ParameterError, match="no training recording of"):
        kind_of("classification").check(tasks.open("none"))
    with pytest.raises(ParameterError, match="kind of a task must be one of classification"):
        kind_of("tasting")
