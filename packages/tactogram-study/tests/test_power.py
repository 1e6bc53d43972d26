from dataclasses import replace

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.statistics.comparison import paired_equivalence
from tactogram_study import power
from tactogram_study.designs.analysis import pairwise as power_preferences
from tactogram_study.designs.analysis.pairwise import simulated_preferences
from tactogram_study.designs.catalogue import power_tables
from tactogram_study.planned import PowerAssumptions
from tactogram_study.power import clustered_ps, power_table as table_of_design, within_ps
from tactogram_study.statistics import pooled_share


def power_table(name, **options):
    """Return the power table of this name, whichever design it is of."""
    design = power_tables()[name]
    fields = PowerAssumptions.__dataclass_fields__
    assumed = replace(design.power[name], **{key: options.pop(key) for key in fields if key in options})
    return table_of_design(name, assumed, design.power_method(assumed.kind), **options)


def test_many_studies_at_once_give_the_p_of_each():
    hits = np.random.default_rng(0).binomial(9, 0.6, (4, 7))
    p, equal = clustered_ps(hits, 9, margin=0.2)
    for k, study in enumerate(hits):
        answers = np.concatenate([[1] * one + [0] * (9 - one) for one in study])
        found = pooled_share(answers, np.repeat(np.arange(7), 9).tolist(), margin=0.2)
        assert (p[k], equal[k]) == pytest.approx((found.p, found.equivalence_p))
    gaps = np.random.default_rng(1).normal(size=(2, 6))
    assert within_ps(gaps, 0.8) == pytest.approx([paired_equivalence(row, margin=0.8) for row in gaps])


@pytest.mark.parametrize("design", power_tables())
def test_every_design_has_a_table_in_which_nothing_is_shown_too_often(design):
    table = power_table(design, participants=[12], trials=[20], simulations=400)
    [row] = table.rows
    assert row["type_1"] < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 400)
    assert row["power"] > 2 * row["type_1"]


def test_where_people_differ_the_test_by_participant_does_not_err():
    [row] = power_table("two_area", participants=[10], trials=[90], simulations=500).rows
    assert row["type_1"] < 0.08


def test_a_table_says_how_many_people_equivalence_takes():
    options = {"participants": [20], "trials": [30], "simulations": 100}
    few = power_table("pairwise", margin=0.4, **options)
    [row] = few.rows
    assert row["equivalence"] < 0.05
    assert row["all_equivalent"] <= row["equivalence"]
    assert few.equivalence_from[30] >= 60
    assert power_table("abx", margin=0.2, **options).equivalence_from[30] <= 10
    assert power_table("abx", margin=0.005, **options).equivalence_from == {30: None}
    with pytest.raises(ParameterError, match="compares no items with each other, got 3"):
        power_table("abx", items=3)


def test_many_items_take_no_more_memory_at_once(monkeypatch):
    monkeypatch.setattr(power_preferences, "AT_ONCE", 36_000)
    options = {"effect": 0.0, "person_sd": 0.5, "rng": np.random.default_rng(0)}
    for items, studies in ((6, 100), (30, 4), (80, 1)):
        some, _ = next(simulated_preferences(10, 60, items=items, studies=200, **options))
        assert some.shape[0] == studies


def test_a_table_tells_how_far_it_is_to_the_end():
    told = []
    power_table(
        "abx", participants=[4, 8], trials=[10], simulations=100, progress=lambda *how: told.append(how)
    )
    taking = [done for task, done, whole in told if task == power.TAKING and whole == 1200]
    assert taking == [0, 400, 1200]
    assert told[-1] == (power.LOOKING, 1, 1)


def test_an_effect_of_none_is_shown_no_more_often_than_alpha():
    [row] = power_table("pairwise", effect=0.0, participants=[10], trials=[15], simulations=200).rows
    assert row["power"] < 0.05


def test_a_table_is_the_same_for_the_same_seed():
    one, two = (power_table("realism", simulations=100, seed=3).as_dict() for _ in range(2))
    assert one == two


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"name": "two_area", "participants": [1]}, "participants must be 2 or more"),
        ({"name": "abx", "participants": [10_001]}, "participants must be 10000 or fewer"),
        ({"name": "two_area", "trials": [0]}, "trials must be from 1"),
        ({"name": "two_area", "effect": 1.2}, "share between 0 and 1"),
        ({"name": "two_area", "margin": float("nan")}, "margin must be finite"),
        ({"name": "realism", "trial_sd": 0.0}, "trial_sd must be > 0"),
        ({"name": "realism", "simulations": 5}, "simulations must be >= 100"),
        ({"name": "pairwise", "items": 1}, "items must be from 2 to 100, got 1"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(options, words):
    with pytest.raises(ParameterError, match=words):
        power_table(**options)
