"""Items that are held against the others that the same people met."""

import numpy as np
import pytest

from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
from tactogram_study.analysis.paired import REST, WHOLE, gaps_to_the_rest, item_contrasts
from tactogram_study.answers import Answer, Answers

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
