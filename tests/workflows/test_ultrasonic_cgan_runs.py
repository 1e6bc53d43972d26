"""A run of it, from a store to a signal: what came of each cluster stands in the run."""

import numpy as np
import pytest

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

WORDS = ("rough", "sticky")


def signal(seed, axes, seconds, rate):
    samples = np.random.default_rng(seed).standard_normal((axes, int(seconds * rate)))
    names = ("drive",) if axes == 1 else tuple(f"g{n + 1}" for n in range(axes))
    return Signal(0.2 * samples, rate, "1" if axes == 1 else "V", names)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Simulated: three plates measured five times at 600 Hz, six display signals at 400 Hz, two raters."""
    plates = [
        Recording(
            streams={"strain": signal(10 * p + m, 4, 1.2, 600.0)}, material=f"plate{p}", session=f"plate{p}-m{m}",
            source=f"plate{p}/{m}", simulated=True,
        )
        for p in range(3)
        for m in range(5)
    ]  # fmt: skip
    drives = [
        Recording(
            streams={"drive": signal(100 + n, 1, 1, 400.0)}, labels={"item": f"signal{n}"}, source=f"signal{n}",
            simulated=True,
        )
        for n in range(6)
    ]  # fmt: skip
    items = [*(f"plate{p}" for p in range(3)), *(f"signal{n}" for n in range(6))]
    rows = [(rater, item, word) for item in items for rater in ("r1", "r2") for word in WORDS]
    scores = np.array([1.0 + (7 * number // len(rows) + number) % 7 for number in range(len(rows))])
    columns = tuple(zip(*rows, strict=True))
    path = tmp_path_factory.mktemp("rated") / "store"
    facts = {"name": "made-up", "licence": "CC0-1.0", "simulated": True}
    return create_store(path, plates + drives, ratings=Ratings(*columns, scores), **facts).path


def trained(store, out, **changes):
    changes = {f"config.{name}": value for name, value in changes.items()}
    return train(
        "ultrasonic_cgan", store, recipe="tiny", by="session", changes=changes, out=out, accelerator="cpu"
    )


def test_a_run_says_what_came_of_each_cluster_and_draws_it(store, tmp_path):
    run = trained(store, tmp_path / "run")
    outcome = run.facts()["outcome"]
    assert outcome["group"] == "group B"
    assert sorted(name for cluster in outcome["clusters"] for name in cluster["surfaces"]) == [
        "plate0", "plate1", "plate2",
    ]  # fmt: skip
    assert [cluster["failed"] for cluster in outcome["clusters"]] == [False, False]
    for name in ("clusters", "selection"):
        assert (run.folder / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    loaded = load_run(run.folder)
    assert (loaded.kind.rate, loaded.kind.unit, loaded.kind.axes) == (400.0, "1", ("drive",))
    made = loaded.model.generate({"words": {"rough": 5, "sticky": 2}}, seed=1)
    assert (made.rate, len(made), made.axes) == (400.0, 400, ("drive",))


def test_a_run_that_failed_says_so_and_refuses_to_generate(store, tmp_path):
    run = trained(store, tmp_path / "run", rate_low=0.991, rate_high=0.992)
    assert [cluster["failed"] for cluster in run.facts()["outcome"]["clusters"]] == [True, True]
    assert run.facts()["validation"] == {"failed_clusters": 2.0}
    assert [line["failed"] for line in run.metrics() if "failed" in line] == [1.0, 1.0]
    with pytest.raises(ParameterError, match="failed: in none of its 12 iterations"):
        load_run(run.folder).model.generate({"words": {"rough": 5, "sticky": 2}}, seed=1)
