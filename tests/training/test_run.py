import pytest
import torch

from tactogram.errors import RunError
from tactogram.model import SignalKind
from tactogram.recipe import Preparation, Recipe
from tactogram.signal.io.atomic import host_name
from tactogram.training import Run, TrainingPosition

DATA = {"path": "x", "name": "made up", "sha256": "0", "licence": "-", "label": "material", "simulated": True}


class Counter:
    """A learner that is a number."""

    def __init__(self):
        self.n = torch.zeros(1)

    def state(self):
        return {"n": self.n, "optimisers": {"large": torch.ones(1000)}}

    def load_state(self, state):
        self.n = state["n"]


@pytest.fixture
def run(tmp_path):
    recipe = Recipe(model="counter", prepare=Preparation(band=(20, 1000)))
    return Run.create(tmp_path / "run", recipe=recipe, data=DATA, identity="abc")


def test_the_recipe_is_read_as_it_was_written(run):
    assert run.recipe == Recipe(model="counter", prepare=Preparation(band=(20, 1000)))
    assert run.data == DATA | {"run_id": "abc"}


def test_a_folder_holds_one_run(run):
    with pytest.raises(RunError, match="contains a run, which has begun; resume it"):
        Run.create(run.folder, recipe=run.recipe, data={}, identity="abc")


def test_restoring_forgets_what_was_logged_after_the_checkpoint(run):
    learner = Counter()
    for step in range(1, 6):
        learner.n += 1
        run.log(TrainingPosition(0, step), {"loss": float(step)})
        if step == 3:
            run.save_checkpoint(learner, TrainingPosition(0, step))
    with (run.folder / "metrics.jsonl").open("a") as file:
        file.write('{"stage": 0, "st')  # a kill in the middle of a line
    left = run.folder / f".checkpoint-{host_name()[:16]}-99999999-0123abcd.part.safetensors"
    left.write_bytes(b"half")  # and one in the middle of a checkpoint
    again = Counter()
    assert run.restore(again) == TrainingPosition(0, 3)
    assert again.n.item() == 3
    assert [m["step"] for m in run.metrics()] == [1, 2, 3]
    assert not left.exists()


def test_a_finished_run_has_weights_without_optimisers(run):
    learner = Counter()
    run.log(TrainingPosition(0, 1), {"loss": 0.5})
    run.save_checkpoint(learner, TrainingPosition(0, 1))
    with pytest.raises(RunError, match="training is not finished"):
        run.kind()
    kind = SignalKind(330.0, "m/s^2", ("x", "y", "z"), ("a", "b"), simulated=True)
    run.finish(learner, kind, {"model": "counter", "notes": []})
    assert run.kind() == kind
    assert run.finished
    assert (run.folder / "metrics.csv").read_text() == "stage,step,loss\n0,1,0.5\n"
    assert not (run.folder / "checkpoint.safetensors").exists()
    assert (run.folder / "model.safetensors").stat().st_size < 1000


def test_a_kind_keeps_its_domain_and_runs_from_before_it_are_over_time(run):
    kind = SignalKind(40.0, "1", ("friction",), ("felt",), domain="displacement")
    run.finish(Counter(), kind, {"model": "counter", "notes": []})
    assert run.kind() == kind
    facts = run.read_json("model.json", dict)
    del facts["kind"]["domain"]
    run.write_json("model.json", facts)
    assert run.kind().domain == "time"


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(RunError, match="not a run"):
        Run.open(tmp_path)


def test_a_later_version_is_refused(run):
    run.write_json("model.json", {"version": 99})
    with pytest.raises(RunError, match="of a later version"):
        run.facts()


@pytest.mark.parametrize("line", ["{", "[" * 100_000, "[1]", '{"loss": 1}', "\xff"])
def test_a_broken_line_of_the_log_is_named(run, line):
    run.log(TrainingPosition(), {"loss": 1.0})
    with (run.folder / "metrics.jsonl").open("a", encoding="latin-1") as file:
        file.write(f"{line}\n")
    with pytest.raises(
        RunError, match="metrics.jsonl: (line 2|not UTF-8 text).*; delete the line, or the run"
    ):
        run.metrics()


def test_a_checkpoint_of_another_learner_is_refused(run):
    learner = Counter()
    run.save_checkpoint(learner, TrainingPosition())
    learner.load_state = lambda state: state["weights"]
    with pytest.raises(RunError, match="checkpoint.safetensors: the checkpoint is of another run"):
        run.restore(learner)
