from collections import Counter


def test_abx_places_a_b_and_x_equally_often_and_x_is_what_it_says(make_study, taken, trials):
    pages, _ = taken(make_study("abx"))
    placings = Counter(
        (page.questions[0].stimulus, page.slot("A").stimulus.condition, page.questions[0].right)
        for page in trials(pages)
    )
    assert set(placings.values()) == {1}
    assert len(placings) == 8
    assert all(
        page.slot("X").stimulus == page.slot(page.questions[0].right).stimulus for page in trials(pages)
    )
