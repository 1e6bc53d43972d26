from types import SimpleNamespace

import pytest
import torch

from tactogram.errors import RunError
from tactogram.model import Stage
from tactogram.training import TrainingPosition, child_rng, child_seed, fit, torch_seeded


class Walk:
    """A learner whose state is a sum of its batches and of torch's random numbers."""

    def __init__(self, diverge_at=None):
        self.total = torch.zeros(1, dtype=torch.float64)
        self.diverge_at = diverge_at

    def setup(self, fabric):
        """Nothing to hand over."""

    def stages(self, examples):
        return Stage("first", 3), Stage("second", 5)

    def batches(self, stage, examples, *, seed, start=0):
        step = start
        while True:
            yield child_rng(seed, step).standard_normal()
            step += 1

    def step(self, stage, batch):
        self.total += batch * (2 if stage.name == "second" else 1) + torch.rand(1).double()
        if self.diverge_at and stage.name == "second":
            return {"loss": float("nan")}
        return {"loss": self.total.item()}

    def validate(self, examples):
        return {}

    def state(self):
        return {"total": self.total.clone()}

    def load_state(self, state):
        self.total = state["total"].clone()


def trail(**options):
    walk, seen = Walk(), []
    fit(
        walk,
        [],
        seed=options.pop("seed", 1),
        on_step=lambda p, s, losses: seen.append((p, walk.state())),
        **options,
    )
    return seen


@pytest.mark.parametrize("stop", range(8))
def test_going_on_from_any_step_is_never_having_stopped(stop):
    whole = trail()
    position, state = whole[stop]
    walk = Walk()
    walk.load_state(state)
    fit(walk, [], seed=1, start=position)
    assert torch.equal(walk.total, whole[-1][1]["total"])


def test_every_step_of_every_stage_is_done_once():
    assert [p for p, _ in trail()] == [TrainingPosition(0, k) for k in (1, 2, 3)] + [
        TrainingPosition(1, k) for k in (1, 2, 3, 4, 5)
    ]


def test_another_seed_is_another_training():
    assert not torch.equal(trail(seed=1)[-1][1]["total"], trail(seed=2)[-1][1]["total"])


def test_processes_share_batches_and_draw_their_own_numbers_in_a_step(monkeypatch):
    def of_process(number):
        walk = Walk()
        drawn = []
        monkeypatch.setattr(
            walk, "step", lambda stage, batch: drawn.append((batch, torch.rand(1).item())) or {}
        )
        monkeypatch.setattr(walk, "stages", lambda examples: (Stage("fit", 1), Stage("train", 3)))
        fit(walk, [], seed=0, fabric=SimpleNamespace(global_rank=number, world_size=1))
        return drawn

    first, second = of_process(0), of_process(1)
    assert first[0] == second[0]  # a closed form is the same everywhere
    assert [batch for batch, _ in first] == [batch for batch, _ in second]
    assert not {number for _, number in first[1:]} & {number for _, number in second[1:]}


def test_divergence_is_told():
    with pytest.raises(RunError, match="diverged at step 1 of second: loss nan"):
        fit(Walk(diverge_at=1), [], seed=0)


def test_seeds_by_purpose_differ_and_leave_the_global_state_alone():
    assert (
        len({child_seed(0), child_seed(1), child_seed(0, "a"), child_seed(0, "b"), child_seed(0, "a", 1)})
        == 5
    )
    before = torch.random.get_rng_state()
    with torch_seeded(3, "x"):
        one = torch.rand(2)
    with torch_seeded(3, "x"):
        assert torch.equal(one, torch.rand(2))
    assert torch.equal(before, torch.random.get_rng_state())
