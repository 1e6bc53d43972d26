"""Session plans: every combination as often as planned, in an order that a seed decides."""

from collections import Counter

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_simulate.materials import STROKING_9, STROKING_30

PLAN = {
    "materials": ["a", "b", "c"],
    "contactors": ["finger", "pen"],
    "speeds_mm_s": [100, 200],
    "repetitions": 3,
}


def keys(plan):
    return [(t.material, t.contactor, t.speed_mm_s, t.repetition) for t in plan.trials()]


@pytest.mark.parametrize("order", ["random", "by-repetition", "as-listed"])
def test_every_combination_comes_as_often_as_planned(order):
    plan = SessionPlan.of(PLAN | {"order": order})
    counted = Counter(key[:3] for key in keys(plan))
    assert len(counted) == 12
    assert set(counted.values()) == {3}
    assert [t.number for t in plan.trials()] == list(range(1, 37))


def test_lists_may_be_written_with_commas():
    plan = SessionPlan.load("first-try", changes={"materials": "tile, carpet", "speeds_mm_s": 150})
    assert (plan.materials, plan.speeds_mm_s) == (("tile", "carpet"), (150.0,))
    assert SessionPlan.of(PLAN | {"speeds_mm_s": "100,200"}).speeds_mm_s == (100.0, 200.0)


def test_the_order_follows_from_the_seed_alone():
    plans = [SessionPlan.of(PLAN | {"seed": seed}) for seed in (1, 1, 2)]
    assert keys(plans[0]) == keys(plans[1]) != keys(plans[2])
    assert sorted(keys(plans[0])) == sorted(keys(plans[2]))


def test_by_repetition_has_every_combination_once_before_any_repeats():
    trials = keys(SessionPlan.of(PLAN | {"order": "by-repetition"}))
    rounds = [[key[:3] for key in trials[i : i + 12]] for i in (0, 12, 24)]
    assert all(len(set(held)) == 12 for held in rounds)
    assert rounds[0] != rounds[1]


@pytest.mark.parametrize("name", shipped_plans())
def test_shipped_plans_load(name):
    assert SessionPlan.load(name).trials()


def test_the_plan_of_saga_et_al_is_theirs():
    """Sec. II-C: "going back and forth for three minutes", "three times per object", at 100, 200 and 400 mm/s."""
    plan = SessionPlan.load("saga-classification")
    assert set(plan.materials) == {surface.name for surface in STROKING_30}
    assert (len(plan.materials), plan.contactors) == (15, ("finger", "pen"))
    assert (plan.speeds_mm_s, plan.repetitions, plan.seconds) == ((100, 200, 400), 3, 180)
    assert (plan.rate, plan.back_and_forth) == (330, True)  # Sec. II-A
    assert 70 <= plan.stroke_mm <= 100  # Fig. 4: "70-100 mm length"
    assert len(plan.trials()) == 270


def test_the_second_plan_of_saga_et_al_is_theirs():
    """Sec. III-B: nine textures, finger "rubbed the texture in one direction", "higher frequency data (1 kHz)"."""
    plan = SessionPlan.load("saga-generation")
    assert set(plan.materials) == {surface.name for surface in STROKING_9}
    assert (len(plan.materials), plan.contactors, plan.back_and_forth) == (9, ("finger",), False)
    assert plan.rate == 1000
    assert 10 * plan.seconds * plan.rate == 40_000  # repeated ten times, "around 40,000 points"


def test_the_plan_of_hatori_and_takemura_is_theirs():
    """Sec. III-B: "20 mm/s, 50 mm, 0.98 N, and 10 kHz", 2.5 s, "ten times for each of the 12 samples"."""
    plan = SessionPlan.load("hatori-plates")
    assert (len(plan.materials), plan.repetitions) == (12, 10)
    assert (len(plan.trials()), plan.speeds_mm_s, plan.stroke_mm) == (120, (20,), 50)
    assert (plan.seconds, plan.rate, plan.force_n) == (2.5, 10_000, 0.98)


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({"materials": []}, "materials"),
        ({"materials": ["a", "a"]}, "materials: values must differ"),
        ({"speeds_mm_s": [0]}, "speeds_mm_s.0"),
        ({"seconds": -1}, "seconds"),
        ({"speed": 100}, "unknown key 'speed'"),
        ({"limits": {"most_lots": 1}}, "most_lots"),
    ],
)
def test_an_invalid_plan_is_refused_by_its_key(values, match):
    with pytest.raises(ParameterError, match=match):
        SessionPlan.of(PLAN | values)


def test_a_missing_file_names_the_shipped_plans(tmp_path):
    with pytest.raises(ParameterError, match="saga-classification"):
        SessionPlan.load(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("materials = [")
    with pytest.raises(DataError, match="bad.toml: not readable as TOML"):
        SessionPlan.load(tmp_path / "bad.toml")


def test_limits_and_notes_may_change_within_a_session_and_materials_may_not():
    plan = SessionPlan.of(PLAN)
    assert SessionPlan.of(PLAN | {"notes": "warm", "limits": {"most_lost": 0.2}}).sha256 == plan.sha256
    assert SessionPlan.of(PLAN | {"materials": ["a", "b"]}).sha256 != plan.sha256


def test_values_are_changed_by_key_and_within_limits_by_dotted_key():
    plan = SessionPlan.load("first-try", changes={"seconds": 2, "limits.most_lost": 0.2})
    assert (plan.seconds, plan.limits.most_lost) == (2, 0.2)
    assert plan.repetitions == SessionPlan.load("first-try").repetitions
    with pytest.raises(ParameterError, match=r"seconds\.x"):
        SessionPlan.load("first-try", changes={"seconds.x": 1})
