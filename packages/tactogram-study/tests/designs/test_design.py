import itertools
from collections import Counter

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize
from scipy.stats import norm

from tactogram_study.designs.analysis.magnitude import intensity_of
from tactogram_study.designs.pairwise import expected_information, posterior
from tactogram_study.designs.staircase import Staircase, StaircaseTrack
from tactogram_study.session.progress import answer_rows, next_page
from tactogram_study.simulated_observer import SimulatedEffect, typical
from tactogram_study.simulated_participants import SimulatedParticipant, simulated_answers
from tactogram_study.study_file import Study
from tactogram_study.trials import PageAnswers, Participant

KINDS = ("two_area", "rating", "evoked", "abx", "staircase", "magnitude", "pairwise")
ANYBODY = Participant("P1", 1)


def taken(study, participant=ANYBODY, effect=None, seed=0):
    """Return all pages of a simulated participant, and what came back from each."""
    simulated = SimulatedParticipant(effect or SimulatedEffect(), (seed, participant.number))
    pages, given = [], []
    while (page := next_page(study, participant, given)) is not None:
        pages.append(page)
        given.append(PageAnswers(page.token, page.accepted(simulated.answer(page)), page.more))
    return pages, given


def trials(pages):
    return [page for page in pages if page.kind not in ("consent", "questions")]


@pytest.mark.parametrize("kind", KINDS)
def test_a_design_asks_to_its_end_and_each_answer_makes_a_row(make_study, kind):
    study = make_study(kind)
    pages, given = taken(study)
    assert [page.token for page in pages][:2] == ["consent", "before"]
    assert pages[-1].token == "after"
    asked = trials(pages)
    assert len({page.token for page in pages}) == len(pages)
    assert max(page.trial for page in asked) <= study.trials
    if kind != "staircase":
        assert max(page.trial for page in asked) == study.trials
    for page, one in zip(asked, given[2:], strict=False):
        rows = answer_rows(study, ANYBODY, page, one.responses, at="")
        assert len(rows) == len(page.questions)
        assert {row.design for row in rows} == {kind}
        assert all(np.isfinite(row.value) for row in rows)


@pytest.mark.parametrize("kind", KINDS)
def test_resuming_is_replaying_the_answers(make_study, kind):
    study = make_study(kind)
    pages, given = taken(study)
    again = make_study(kind)
    for done, page in enumerate(pages):
        assert next_page(again, ANYBODY, given[:done]) == page
    assert next_page(again, ANYBODY, given) is None


@pytest.mark.parametrize("kind", KINDS)
def test_a_participant_is_shown_no_name_and_no_right_answer(make_study, kind):
    pages, _ = taken(make_study(kind))
    for page in trials(pages):
        shown = str(page.shown("en"))
        names = [p.stimulus.name for p in page.presented if p.stimulus]
        assert not [name for name in (*names, "generated'", "recorded", "expected_bits") if name in shown]


def test_who_declines_is_asked_nothing(make_study):
    assert next_page(make_study(), ANYBODY, [PageAnswers("consent", {"consent": "declined"})]) is None


def test_a_rest_is_offered_after_so_many_trials(make_study):
    pages, _ = taken(make_study("two_area", rest_every=2))
    assert [page.trial for page in pages if page.rest] == [3]


def test_two_area_asks_which_and_then_how_real_each_is(make_study):
    pages, given = taken(make_study("two_area"), effect=SimulatedEffect(d_prime=10.0))
    which, realism = trials(pages)[:2]
    assert (which.trial, which.step, realism.trial, realism.step) == (1, 1, 1, 2)
    assert which.slot(which.questions[0].right).stimulus.condition == "generated"
    assert [asked.key for asked in realism.questions] == ["realism:A", "realism:B"]
    assert {asked.condition for asked in realism.questions} == {"generated", "recorded"}
    assert "real cork" in realism.text.texts["en"] or "real tile" in realism.text.texts["en"]
    assert given[2].responses["which"] == which.questions[0].right


def test_sides_are_drawn_or_balanced(make_study):
    design = {"kind": "two_area", "repeats": 10, "realism": False}
    free, _ = taken(make_study(design))
    balanced, _ = taken(make_study(design | {"sides": "balanced"}))
    counts = Counter((page.questions[0].stimulus, page.questions[0].side) for page in trials(balanced))
    assert set(counts.values()) == {5}
    assert len({page.questions[0].side for page in trials(free)}) == 2


def test_abx_places_a_b_and_x_equally_often_and_x_is_what_it_says(make_study):
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


def test_each_image_of_a_set_is_judged_and_sets_go_round(make_study):
    images = [{"name": f"i{n}", "image": "a.png"} for n in range(9)]
    study = make_study("evoked", stimuli=images)
    sets = []
    for number in (1, 2, 3, 4):
        pages, _ = taken(study, Participant(f"P{number}", number))
        sets.append({page.questions[0].stimulus for page in trials(pages)})
    assert [len(own) for own in sets] == [3, 3, 3, 3]
    assert sets[0] | sets[1] | sets[2] == {f"i{n}" for n in range(9)}
    assert sets[0] == sets[3]


def test_a_staircase_moves_by_levitts_rule():
    design = Staircase(start_db=0, steps_db=(4, 2), up=1, down=2, reversals=3, lowest_db=-10)
    track, path = StaircaseTrack(0.0), []
    for correct in (1, 1, 1, 1, 0, 1, 0, 1, 1, 1):
        track = design.after(track, correct=bool(correct))
        path.append(track.intensity)
    # Two right: down 4. A wrong one turns it: up 2, the second step. And so on; counted by hand.
    assert path == [0, -4, -4, -8, -6, -6, -4, -4, -6, -6]
    assert track.reversals == (-8, -4)
    assert not design.ended(track)
    assert design.ended(StaircaseTrack(0.0, 9, (1, 2, 3)))


def test_a_staircase_stays_within_its_limits():
    design = Staircase(start_db=0, steps_db=(8,), down=1, lowest_db=-10, highest_db=5)
    down = StaircaseTrack(0.0)
    for _ in range(3):
        down = design.after(down, correct=True)
    up = design.after(StaircaseTrack(0.0), correct=False)
    assert (down.intensity, up.intensity) == (-10, 5)


def test_three_down_one_up_settles_at_79_percent():
    # Levitt (1971): p**3 = 1/2, p = 0.794. Simulated observer: 0.5 + 0.5 Phi(x / 4), which is there at x = 0.89.
    design = Staircase(steps_db=(2,), down=3, reversals=100, start_db=4, lowest_db=-60, highest_db=60)
    rng, track, met = np.random.default_rng(0), StaircaseTrack(4.0), []
    for _ in range(2500):
        met.append(track.intensity)
        track = design.after(track, correct=rng.random() < 0.5 + 0.5 * norm.cdf(track.intensity / 4))
    turned = np.array(track.reversals)
    assert turned.mean() == pytest.approx(norm.ppf((0.5 ** (1 / 3) - 0.5) / 0.5) * 4, abs=0.8)


def test_staircases_of_several_targets_are_mixed_against_one_standard(make_study):
    design = {"kind": "staircase", "standard": "cork-recorded", "most_trials": 10}
    pages, _ = taken(make_study(design))
    assert {page.more["staircase"] for page in trials(pages)} == {
        "cork-generated",
        "tile-recorded",
        "tile-generated",
    }
    for page in trials(pages):
        beside = page.slot("B" if page.questions[0].side == "A" else "A")
        assert (beside.stimulus.name, beside.gain_db) == ("cork-recorded", 0.0)
        assert page.slot(page.questions[0].side).gain_db == page.questions[0].values["A"]


def test_the_posterior_of_preferences_is_at_its_maximum():
    won = [(0, 1), (0, 1), (1, 2), (0, 2), (2, 1)]

    def loss(u):
        return sum(np.log1p(np.exp(u[j] - u[i])) for i, j in won) + (u**2).sum() / 8

    mean, covariance = posterior(won, 3, prior_sd=2.0)
    assert mean == pytest.approx(minimize(loss, np.zeros(3), tol=1e-12).x, abs=1e-5)
    assert np.linalg.eigvalsh(covariance).min() > 0
    assert posterior([], 3, prior_sd=2.0)[1] == pytest.approx(4 * np.eye(3))


@pytest.mark.parametrize(("mean", "sd"), [(0.0, 0.5), (1.0, 2.0), (-3.0, 3.0)])
def test_expected_information_is_that_of_naive_integration(mean, sd):
    def entropy(p):
        return 0.0 if p in (0.0, 1.0) else -(p * np.log2(p) + (1 - p) * np.log2(1 - p))

    def p(d):
        return 1 / (1 + np.exp(-d))

    def expected(f):
        return quad(lambda d: f(d) * norm.pdf(d, mean, sd), mean - 9 * sd, mean + 9 * sd, limit=200)[0]

    naive = entropy(expected(p)) - expected(lambda d: entropy(p(d)))
    covariance = np.diag([sd**2 / 2, sd**2 / 2])
    [ours] = expected_information(np.array([mean, 0.0]), covariance, [(0, 1)])
    assert ours == pytest.approx(naive, abs=2e-6)


def test_the_next_pair_is_the_one_that_tells_most_and_never_the_same_at_once(make_study):
    study = make_study({"kind": "pairwise", "comparisons": 12})
    pages, _ = taken(study, effect=SimulatedEffect(shift={"generated": 3.0}))
    pairs = [(page.more["first"], page.more["second"]) for page in trials(pages)]
    assert all(one != other for one, other in itertools.pairwise(pairs))
    assert len(set(pairs)) > 3
    bits = [float(page.more["expected_bits"]) for page in trials(pages)]
    assert bits[0] == max(bits)
    assert bits[-1] < bits[0]


def test_magnitude_with_a_standard_shows_it_as_a(make_study):
    pages, _ = taken(make_study({"kind": "magnitude", "standard": "cork-recorded", "modulus": 50}))
    assert all(page.slot("A").stimulus.name == "cork-recorded" for page in trials(pages))
    assert "A counts as 50" in trials(pages)[0].text.texts["en"]
    assert (
        trials(pages)[0].questions[0].stimulus != "cork-recorded"
        or trials(pages)[0].questions[0].condition == "generated"
    )


def test_counterbalanced_orders_differ_by_participant_and_cover_each_place():
    study = Study.load("magnitude", changes={"design.repeats": 1, "practice": None})
    first = []
    for number in range(1, 7):
        participant = Participant(f"P{number}", number)
        first.append(
            next_page(study, participant, [PageAnswers("consent", {"consent": "agreed"})])
            .questions[0]
            .stimulus
        )
    assert len(set(first)) == 6


def test_an_effect_that_is_put_in_is_there_and_none_is_none(make_study):
    study = make_study({"kind": "two_area", "repeats": 100, "realism": False})
    right = {}
    for d_prime in (0.0, 2.0):
        pages, given = taken(study, effect=SimulatedEffect(d_prime=d_prime))
        asked = [page.questions[0] for page in trials(pages)]
        told = [one.responses["which"] for one in given[2:-1]]
        right[d_prime] = np.mean([a.right == t for a, t in zip(asked, told, strict=True)])
    assert right[0.0] == pytest.approx(0.5, abs=0.1)
    assert right[2.0] == pytest.approx(norm.cdf(2**0.5), abs=0.07)


def test_simulated_participants_can_prefer_differently_and_each_the_same_again(make_study):
    study = make_study({"kind": "pairwise", "choice": "listed", "repeats": 20})
    won = []
    for number in range(1, 9):
        pages, given = taken(study, Participant(f"P{number}", number), SimulatedEffect(preference_sd=3.0))
        asked = [page.questions[0] for page in trials(pages)]
        first = [one.responses["preferred"] == a.side for a, one in zip(asked, given[2:-1], strict=True)]
        pair = (asked[0].stimulus, asked[0].condition, asked[0].other, asked[0].other_condition)
        same = [(a.stimulus, a.condition, a.other, a.other_condition) == pair for a in asked]
        won.append(np.mean(np.array(first)[same]))
    assert np.mean(np.abs(np.array(won) - 0.5)) > 0.3  # alike, they would be 0.09 from one half
    assert min(won) < 0.2 < 0.8 < max(won)


def test_simulated_participants_can_have_exponents_of_their_own():
    drawn = [SimulatedParticipant(SimulatedEffect(exponent=0.8, exponent_sd=0.2), (3, n)) for n in range(300)]
    exponents = np.array([one.exponent for one in drawn])
    assert exponents.mean() == pytest.approx(0.8, abs=3 * 0.2 / np.sqrt(300))
    assert exponents.std() == pytest.approx(0.2, rel=0.13)
    study = Study.load("magnitude", changes={"design.repeats": 2, "practice": None})
    steep = SimulatedEffect(exponent=0.8, exponent_sd=0.5, within_sd=0.0)
    answers = simulated_answers(study, 3, effect=steep, seed=3).where(design="magnitude")
    for number, own in enumerate(answers.by("participant").values(), 1):
        slope = np.polyfit(np.log([intensity_of(row) for row in own]), np.log([row.value for row in own]), 1)[
            0
        ]
        assert slope == pytest.approx(SimulatedParticipant(steep, (3, number)).exponent, abs=1e-3)


def test_spreads_between_people_change_no_other_answer(make_study):
    study = make_study("rating")
    spread = SimulatedEffect(preference_sd=1.0, exponent_sd=0.3)
    assert simulated_answers(study, 2, effect=spread).rows == simulated_answers(study, 2).rows


def test_a_staircases_item_can_have_a_threshold_of_its_own_and_items_can_be_alike(make_study):
    pages, _ = taken(make_study("staircase"))
    page = trials(pages)[0]
    item = page.questions[0].stimulus
    same = SimulatedEffect(threshold_db=page.questions[0].values["A"], lapse=0.0)
    harder = same.model_copy(update={"shift": {item: 4.0}})
    everybody = [
        SimulatedParticipant(effect.model_copy(update={"threshold_sd_db": 0.0}), (0, 1))
        for effect in (same, harder)
    ]
    sure = [Staircase.simulated_share(page, one) for one in everybody]
    assert sure == pytest.approx([0.75, 0.5 + 0.5 * norm.cdf(-1)])
    assert typical(SimulatedEffect(typical_sd=0), 1, "plate", "rough") == 0
    assert typical(SimulatedEffect(typical_sd=2), 1, "plate", "rough") == pytest.approx(
        2 * typical(SimulatedEffect(), 1, "plate", "rough")
    )
