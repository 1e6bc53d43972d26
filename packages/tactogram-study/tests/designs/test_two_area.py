from collections import Counter

from tactogram_study.simulated_observer import SimulatedEffect


def test_two_area_asks_which_and_then_how_real_each_is(make_study, taken, trials):
    """Saga et al., Sec. IV-A: "using these two surveys as one trial"."""
    pages, given = taken(make_study("two_area"), effect=SimulatedEffect(d_prime=10.0))
    which, realism = trials(pages)[:2]
    assert (which.trial, which.step, realism.trial, realism.step) == (1, 1, 1, 2)
    assert which.slot(which.questions[0].right).stimulus.condition == "generated"
    assert [asked.key for asked in realism.questions] == ["realism:A", "realism:B"]
    assert {asked.condition for asked in realism.questions} == {"generated", "recorded"}
    assert "real cork" in realism.text.texts["en"] or "real tile" in realism.text.texts["en"]
    assert given[2].responses["which"] == which.questions[0].right


def test_sides_are_drawn_or_balanced(make_study, taken, trials):
    """Saga et al., Sec. IV-A: "The area the generated data is displayed in was randomly determined for each trial"."""
    design = {"kind": "two_area", "repeats": 10, "realism": False}
    free, _ = taken(make_study(design))
    balanced, _ = taken(make_study(design | {"sides": "balanced"}))
    counts = Counter((page.questions[0].stimulus, page.questions[0].side) for page in trials(balanced))
    assert set(counts.values()) == {5}
    assert len({page.questions[0].side for page in trials(free)}) == 2
