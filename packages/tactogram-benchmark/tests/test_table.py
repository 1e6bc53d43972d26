"""Tables of ranked results as text."""

import dataclasses

import pytest
from made_up_results import TASKS, result, table

from tactogram_benchmark.ranking import rank_models
from tactogram_benchmark.table import TaskTable, markdown


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(0.05, 0.17, "0.110 ± 0.002 [0.047, 0.173]"), (0.01, 0.9, "0.11 ± 0.00 [0.01, 0.90]")],
)
def test_values_are_told_to_the_digits_that_their_interval_allows(low, high, text):
    seeds = []
    for seed, value in enumerate((0.1085, 0.1115)):
        made = result(TASKS["lmt108-generate"], "near", value, seed=seed)
        main = dataclasses.replace(made.main, low=low, high=high)
        seeds.append(made.model_copy(update={"figures": {"distance": main}}))
    page = markdown([TaskTable(TASKS["lmt108-generate"], tuple(rank_models(seeds)), ())])
    assert f"| 1 | `near` | {text} | 2 |" in page
    assert "lower is better; at best 0, by chance 1." in page


def test_beside_a_model_that_copies_the_best_that_makes_something_new_is_named():
    text = markdown([table("lmt108-generate", {"replay": 0.05, "texture_var": 0.3}, copying=["replay"])])
    overview = next(line for line in text.splitlines() if line.startswith("| [Generate"))
    assert "| `replay` (copies) 0.05" in overview
    assert "; making something new: `texture_var` 0.3" in overview
    assert "| 1 | `replay` (copies) | 0.05" in text
