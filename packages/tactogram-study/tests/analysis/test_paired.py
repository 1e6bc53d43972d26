from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tactogram.errors import DataError
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
from tactogram_study.analysis.paired import REST, WHOLE, analyse_means, gaps_to_the_rest, item_contrasts
from tactogram_study.answers import Answer, Answers


def marks(gap, people=8, trials=5, seed=0):
    """Return marks of simulated participants on two stimuli, ``gap`` higher under the second condition."""
    rng = np.random.default_rng(seed)
    return Answers(
        tuple(
            Answer(
                "small", f"P{who}", design="line", question="pleasant", stimulus=stimulus, condition=condition,
                trial=trial, value=50 + shift + own + rng.normal(), simulated=True,
            )
            for who, own in enumerate(rng.normal(0, 10, people))
            for stimulus in ("cork", "tile")
            for condition, shift in (("a", 0.0), ("b", gap))
            for trial in range(trials)
        )
    )  # fmt: skip


def test_a_mean_and_its_interval_are_over_participants():
    answers = marks(0.0)
    rows = analyse_means(answers, title="Line").tables["means over participants"]
    assert [(row["stimulus"], row["condition"]) for row in rows] == [
        ("cork", "a"),
        ("cork", "b"),
        ("tile", "a"),
        ("tile", "b"),
    ]
    own = [
        group.numbers().mean()
        for group in answers.where(stimulus="cork", condition="a").by("participant").values()
    ]
    low, high = stats.t.interval(0.95, len(own) - 1, np.mean(own), stats.sem(own))
    assert (rows[0]["mean"], rows[0]["low"], rows[0]["high"]) == pytest.approx((np.mean(own), low, high))


def test_conditions_are_compared_by_participant():
    answers = marks(-6.0)
    [there] = analyse_means(answers, title="Line", margin=3.0).role("confirmatory")
    means = [
        [g.where(condition=c).numbers().mean() for g in answers.by("participant").values()] for c in "ab"
    ]
    assert there.p == pytest.approx(stats.ttest_rel(*means).pvalue)
    assert (there.of, there.verdict) == ("a minus b", SHOWN)
    assert there.low < 6.0 < there.high
    [absent] = analyse_means(marks(0.0, seed=1), title="Line", margin=3.0).role("confirmatory")
    assert absent.verdict == EQUIVALENT


def test_one_condition_is_described_and_nothing_is_tested():
    section = analyse_means(marks(0.0).where(condition="a"), title="Line")
    assert section.findings == ()
    assert "nothing is compared" in section.notes[-1]
    with pytest.raises(DataError, match="Line: must have an answer with a number"):
        analyse_means(Answers(tuple(replace(row, value=float("nan")) for row in marks(0.0))), title="Line")


WORDS = ("rough", "dry")


def scores(shift=0.0, people=20, items=("a", "b", "c", "d"), leave_out=(), seed=0):
    """Return answers of simulated participants, each with a level of its own; ``shift`` is of item a."""
    rng = np.random.default_rng(seed)
    rows = []
    for person in range(people):
        own = 3 * rng.standard_normal()
        for item in items:
            for word in WORDS:
                value = own + shift * (item == "a") + 0.3 * rng.standard_normal()
                if (person, item) not in leave_out:
                    rows.append(
                        Answer(
                            study="sim",
                            participant=f"P{person}",
                            design="rating",
                            question=word,
                            stimulus=item,
                            answer="-",
                            value=value,
                            simulated=True,
                        )
                    )
    return Answers(tuple(rows))


def test_what_stands_out_is_shown_whatever_level_people_answer_at():
    found = {one.of: one for one in item_contrasts(scores(0.8), "points") if one.test.startswith("paired t")}
    one = found[f"a {REST}, {WHOLE}"]
    assert one.verdict == SHOWN
    assert one.low < 0.8 < one.high
    assert one.correction == "Holm"
    assert found[f"b {REST}, {WHOLE}"].estimate == pytest.approx(-0.8 / 3, abs=0.15)


def test_items_that_are_alike_are_equivalent_with_a_margin_and_never_without():
    assert {one.verdict for one in item_contrasts(scores(), "points", margin=0.4)} == {EQUIVALENT}
    assert {one.verdict for one in item_contrasts(scores(), "points")} == {"not shown"}


def test_each_word_is_looked_at_if_asked():
    whole, single = (item_contrasts(scores(0.8), "points", per_word=asked) for asked in (False, True))
    assert len(single) == len(whole) * (1 + len(WORDS))
    rough = next(one for one in single if one.of == f"a {REST}, rough")
    assert rough.verdict == SHOWN
    assert rough.n == 20


def test_gaps_are_those_of_each_person_and_missing_ones_are_left_out():
    answers = scores(leave_out={(3, "a"), (1, "b"), (1, "c"), (1, "d")})
    gaps = gaps_to_the_rest(answers)
    assert np.isnan(gaps[3, 0]).all()
    assert np.isnan(gaps[1]).all()
    own = {row.stimulus: row.value for row in answers if row.participant == "P2" and row.question == "dry"}
    assert gaps[2, 0, 1] == pytest.approx(own["a"] - np.mean([own[k] for k in "bcd"]))
    assert next(o for o in item_contrasts(answers, "points") if o.of.startswith("a ")).participants == 18


def test_one_item_has_nothing_to_stand_out_from():
    assert item_contrasts(scores(items=("a",)), "points") == []
    assert item_contrasts(scores(people=1), "points") == []
