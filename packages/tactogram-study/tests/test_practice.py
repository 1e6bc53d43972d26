from collections import Counter

import pytest

from tactogram.errors import ParameterError
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_participants import simulate

OWN = [
    {"name": f"own-{version}", "item": "felt", "condition": version, "file": "b.wav", "image": "b.png"}
    for version in ("recorded", "generated")
]


def walked(store, count):
    """Answer so many pages with A, and return what each showed."""
    code = store.enrol("P1").code
    shown = []
    for _ in range(count):
        page = store.page(code)
        shown.append(page.shown("en"))
        answers = {
            a.key: (a.question.options[0].value if a.question.options else "1") for a in page.questions
        }
        store.submit(code, page.token, answers)
    return code, shown


@pytest.fixture
def practised(make_study, tmp_path):
    study = make_study(practice={"trials": 3, "feedback": True})
    with SessionStore(tmp_path / "session", study) as store:
        yield store


def test_practice_comes_before_the_trials_and_is_marked(practised):
    _, shown = walked(practised, 6)
    assert [page["token"] for page in shown] == [
        "consent", "before", "practice-1.1", "practice-2.1", "practice-3.1", "trial-1.1",
    ]  # fmt: skip
    rows = practised.answers().where(design="practice")
    assert [(row.trial, row.more["practice"], row.more["token"]) for row in rows] == [
        (n, "abx", f"practice-{n}.1") for n in (1, 2, 3)
    ]
    assert [row.more["token"] for row in practised.answers().where(design="abx")] == ["trial-1.1"]
    [about] = [page["layout"]["practice"] for page in shown if page["token"] == "practice-2.1"]
    assert about == {"number": 2, "of": 3, "feedback": True, "text": "2 of 3. This answer does not count."}
    assert "practice" not in shown[-1]["layout"]


def test_feedback_says_whether_the_last_answer_was_right_and_nothing_before(practised):
    code, shown = walked(practised, 5)
    first = practised.page(code).shown("ja")
    right = [row.correct for row in practised.answers().where(design="practice")]
    ended = first["layout"]["practice_ended"]
    told = [*(page["layout"].get("feedback") for page in shown[2:]), ended["feedback"]]
    assert told[0] is None
    assert [one["correct"] for one in told[1:]] == right
    assert told[-1]["text"] == ("正解です。" if right[-1] else "不正解です。")
    assert ended["text"].startswith("練習は終わりです")
    assert "feedback" not in first["layout"]  # a trial that counts is shown without it
    practised.submit(code, "trial-1.1", {"which": "A"})
    assert "feedback" not in practised.page(code).layout


def test_practice_goes_on_where_it_was(practised):
    code, _ = walked(practised, 4)
    with SessionStore(practised.path.parent) as again:
        assert again.page(code).token == "practice-3.1"
        assert again.page(code) == practised.page(code)
    assert (practised.progress()[0]["practice"], practised.progress()[0]["trials"]) == (2, 0)


def test_the_trials_are_the_same_with_and_without_practice(make_study, tmp_path):
    orders = []
    for name, practice in (("with", {"trials": 3}), ("without", None)):
        with SessionStore(tmp_path / name, make_study(practice=practice)) as store:
            simulate(store, 1)
            orders.append([(r.stimulus, r.side, r.condition) for r in store.answers().where(design="abx")])
    assert orders[0] == orders[1]


@pytest.mark.parametrize(
    "design", ["two_area", "rating", "evoked", "abx", "staircase", "magnitude", "pairwise"]
)
def test_simulated_participants_take_the_practice_of_every_design(make_study, tmp_path, design):
    with SessionStore(tmp_path, make_study(design, practice={"trials": 2})) as store:
        [who] = simulate(store, 1)
        tokens = [row.more["token"].partition(".")[0] for row in store.answers()]
        assert {"practice-1", "practice-2"} <= set(tokens)
        assert "practice-3" not in tokens
        assert store.page(who.code) is None
        assert Counter(row.design for row in store.answers().where(design="practice"))["practice"] >= 2


def test_stimuli_of_its_own_come_in_practice_only(make_study, tmp_path):
    study = make_study("two_area", practice={"trials": 2, "own": OWN, "feedback": True})
    assert len(study.made_stimuli) == len(study.all_stimuli) + 2
    with SessionStore(tmp_path, study) as store:
        simulate(store, 2)
        rows = store.answers()
        assert set(rows.where(design="practice").column("stimulus")) == {"felt"}
        assert "felt" not in rows.where(design="two_area").column("stimulus")


@pytest.mark.parametrize(
    ("design", "practice", "message"),
    [
        (
            "rating",
            {"trials": 1, "feedback": True},
            "feedback needs answers that are right or wrong, which rating has not",
        ),
        ("abx", {"trials": 99}, "trials must be at most 8, those of the design, got 99"),
        ("abx", {"trials": 1, "stimuli": ["wood"]}, "stimuli must be of cork-recorded.*got 'wood'"),
        ("two_area", {"trials": 1, "stimuli": ["cork-recorded"]}, "practice: two_area needs each item as"),
        ("abx", {"trials": 1, "stimuli": ["cork-recorded", "cork-recorded"]}, "names 'cork-recorded' twice"),
        ("abx", {"trials": 1, "own": [{"name": "cork-recorded", "file": "a.wav"}]}, "is one of the study"),
        ("abx", {"trials": 0}, "greater than or equal to 1"),
    ],
)
def test_practice_that_cannot_be_is_refused_in_a_line(make_study, design, practice, message):
    with pytest.raises(ParameterError, match=message) as caught:
        make_study(design, practice=practice)
    assert "\n" not in str(caught.value)


def test_texts_of_practice_must_be_in_each_language(make_study):
    with pytest.raises(ParameterError, match=r"practice\.right lacks the language en"):
        make_study(languages=["ja", "en"], practice={"trials": 1, "right": {"ja": "はい"}})
