"""Small simulated stores, and tasks on them."""

import hashlib
from functools import partial
from pathlib import Path

import pytest

from tactogram.benchmark.data import open_task
from tactogram.benchmark.kinds import generation
from tactogram.benchmark.task import find_task
from tactogram.datasets import Segment, Split, item_of, split_last
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.evaluation.reference_models import EvaluationSettings


class Tasks:
    """A folder of tasks on stores of one work folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.work = folder / "tasks", folder / "work"
        self.folder.mkdir()

    def write(self, name, kind, store, split, *, more="", head=""):
        """Write a task and its split, and return it opened."""
        path = self.folder / f"{name}-split.json"
        split.save(path)
        sha = hashlib.sha256(path.read_bytes()).hexdigest()
        (self.folder / f"{name}.toml").write_text(
            f'title = "{name}"\nkind = "{kind}"\nsplit = "{path.name}"\nsplit_sha256 = "{sha}"\n{head}'
            f'[data]\nname = "{store.name}"\nsha256 = "{store.sha256}"\nwhat = "tiny"\n'
            f"[data.simulate]\nset_name = {store.set_name!r}\n{more}"
        )
        return self.open(name)

    def open(self, name):
        """Return a task with its data."""
        return open_task(find_task(name, [self.folder]), self.work)


def simulated(folder, set_name, **options):
    """Return a simulated store, with the name of its set."""
    from tactogram.datasets import open_store

    path = folder / "work" / "stores" / set_name
    simulate_to_store(set_name, path, workers=1, **options)
    store = open_store(path)
    store.set_name = set_name
    return store


def without(split, store, names, count):
    """Return a split without some materials in training, whose recordings are tested."""
    strange = {info.id for info in store.index if info.material in names}
    kept = {
        part: tuple(segment for segment in held if segment.id not in strange)
        for part, held in split.parts.items()
    }
    left_out = tuple(Segment(info.id) for info in store.index if info.id in strange)[:count]
    return Split(kept["train"], kept["validation"], (*kept["test"], *left_out), by="recording")


def by_item(store):
    """Return a split of rated recordings by item: a half, a quarter and a quarter."""
    items = sorted({item_of(info) for info in store.index})
    part = dict.fromkeys(items, "train")
    part |= dict.fromkeys(items[::4], "test") | dict.fromkeys(items[1::4], "validation")
    held = {"train": [], "validation": [], "test": []}
    for info in store.index:
        held[part[item_of(info)]].append(Segment(info.id))
    groups = {info.id: item_of(info) for info in store.index}
    return Split(*map(tuple, held.values()), by="material", groups=groups)


@pytest.fixture(scope="session", autouse=True)
def quick_classifier():
    """Train the classifier that judges generated signals for a few steps."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(generation, "EvaluationSettings", partial(EvaluationSettings, steps=60))
        yield


@pytest.fixture(scope="session")
def tasks(tmp_path_factory):
    """Give tasks of each kind on small simulated stores."""
    folder = tmp_path_factory.mktemp("benchmark")
    made = Tasks(folder)
    strokes = simulated(folder, "stroking9", seed=3, per_class=5, seconds=2.0)
    last = split_last(strokes.index, 2, validation=1)
    names = sorted({info.material for info in strokes.index})
    cheap = '[recipes.stroke_cnn]\nchanges = { "config.steps" = 30 }\n'
    made.write("name", "classification", strokes, last, more=cheap)
    unknown = without(last, strokes, names[:3], 9)
    made.write("none", "rejection", strokes, unknown, more=cheap)
    made.write("retrieve", "retrieval", strokes, unknown, more=cheap)
    made.write("generate", "generation", strokes, last)
    pairs = f"[options]\npairs = [[{names[0]!r}, {names[-1]!r}]]\nsteps = 3\nsignals = 2\nseconds = 1.0\n"
    made.write("mix", "mixing", strokes, last, more=pairs)
    rated = simulated(folder, "surfaces", seed=3, random=16, per_class=2, seconds=1.0)
    alone = '[prepare]\naxes = "dft321"\n'
    made.write("rate", "rating", rated, by_item(rated), more=alone)
    made.write("words", "words", rated, by_item(rated), more=alone, head='label = "item"\n')
    return made
