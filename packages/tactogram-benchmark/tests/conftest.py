"""Small stores of noise, and tasks on them."""

import hashlib
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from tactogram.datasets import (
    SEVEN_POINT,
    Ratings,
    Recording,
    Segment,
    Split,
    create_store,
    item_of,
    split_last,
)
from tactogram.signal import Signal
from tactogram.workflows.evaluation.reference_models import EvaluationSettings
from tactogram.workflows.progress import silent
from tactogram_benchmark.data import open_task
from tactogram_benchmark.kinds import generation
from tactogram_benchmark.task import find_task
from tactogram_benchmark.task_kind import check_answers, kind_of

sys.path += [str(Path(__file__).parent), str(Path(__file__).parent / "experiments")]  # made_up_*

MATERIALS = tuple(f"material-{number}" for number in range(6))
RATE = 1000.0


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
            f'[data.simulate]\nset_name = "stroking9"\n{more}'
        )
        return self.open(name)

    def open(self, name):
        """Return a task with its data."""
        return open_task(find_task(name, [self.folder]), self.work)


def noise(rng, place, seconds, axes=1):
    """Return noise in a band and at a level of one material's own."""
    low = 30 + 50 * place
    white = rng.standard_normal((axes, round(seconds * RATE) + 200))
    shaped = sosfilt(butter(2, (low, low + 60), "bandpass", fs=RATE, output="sos"), white)[:, 200:]
    return Signal((2.0**place * shaped).astype(np.float32), RATE, "m/s^2", "xyz"[:axes])


def strokes(path):
    """Return a store of five recordings of each material."""
    rng = np.random.default_rng(0)
    made = (
        Recording(
            streams={"acceleration": noise(rng, place, 2.0)},
            material=name,
            labels={"recording": str(take)},
            simulated=True,
        )
        for place, name in enumerate(MATERIALS)
        for take in range(5)
    )
    return create_store(path, made, name="noise (simulated)", licence="CC0-1.0", simulated=True)


def rated_strokes(path):
    """Return a store of sixteen rated surfaces, louder ones rougher."""
    rng = np.random.default_rng(1)
    places = np.linspace(0, 5, 16)
    names = [f"surface-{number:02}" for number in range(len(places))]
    made = (
        Recording(streams={"acceleration": noise(rng, place, 1.0)}, material=name, simulated=True)
        for name, place in zip(names, places, strict=True)
    )
    rows = [
        (rater, name, word, float(np.clip(round(1 + sign * place + rng.normal(0, 0.3)), 1, 7)))
        for rater in ("a", "b")
        for name, place in zip(names, places, strict=True)
        for word, sign in (("rough", 1.0), ("dry", 0.5))
    ]
    raters, items, words, scores = zip(*rows, strict=True)
    ratings = Ratings(raters, items, words, np.array(scores), SEVEN_POINT)
    return create_store(
        path, made, name="rated (simulated)", licence="CC0-1.0", simulated=True, ratings=ratings
    )


def rated_drives(path):
    """Return a store of two rated surfaces with two recordings each, and twelve rated drives of a display."""
    rng = np.random.default_rng(2)
    names = [f"drive-{number:02}" for number in range(12)]
    made = [
        Recording(streams={"strain": noise(rng, place, 1.0)}, material=name, simulated=True)
        for place, name in enumerate(MATERIALS[:2])
        for _ in range(2)
    ] + [
        Recording(streams={"drive": noise(rng, place / 3, 1.0)}, labels={"item": name}, simulated=True)
        for place, name in enumerate(names)
    ]
    items = [*MATERIALS[:2], *names]
    scores = np.round(np.linspace(1, 7, len(items)))
    ratings = Ratings(["a"] * len(items), items, ["rough"] * len(items), scores, SEVEN_POINT)
    return create_store(
        path, made, name="drives (simulated)", licence="CC0-1.0", simulated=True, ratings=ratings
    )


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
    """Return a split by item, a half, a quarter and a quarter; of rated drives, if there are any, without surfaces."""
    index = [info for info in store.index if info.material is None] or store.index
    items = sorted({item_of(info) for info in index})
    part = dict.fromkeys(items, "train")
    part |= dict.fromkeys(items[::4], "test") | dict.fromkeys(items[1::4], "validation")
    held = {"train": [], "validation": [], "test": []}
    for info in index:
        held[part[item_of(info)]].append(Segment(info.id))
    groups = {info.id: item_of(info) for info in index}
    return Split(*map(tuple, held.values()), by="material", groups=groups)


@pytest.fixture(scope="session", autouse=True)
def quick_classifier():
    """Train the classifier that judges generated signals for a few steps."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(generation, "EvaluationSettings", partial(EvaluationSettings, steps=60))
        yield


@pytest.fixture(scope="session")
def tasks(tmp_path_factory):
    """Give tasks of each kind on small stores."""
    made = Tasks(tmp_path_factory.mktemp("benchmark"))
    held, rated = strokes(made.work / "stores" / "noise"), rated_strokes(made.work / "stores" / "rated")
    last = split_last(held.index, 2, validation=1)
    small = '"config.steps" = 30, "config.filters" = [8, 8, 16, 16, 16, 16], "config.dense" = [32, 16]'
    cheap = f"[recipes.stroke_cnn]\nchanges = {{ {small} }}\n"
    made.write("name", "classification", held, last, more=cheap)
    unknown = without(last, held, MATERIALS[:3], 9)
    made.write("none", "rejection", held, unknown, more=cheap)
    made.write("retrieve", "retrieval", held, unknown, more=cheap)
    made.write("generate", "generation", held, last)
    ends = (
        f"[options]\npairs = [[{MATERIALS[0]!r}, {MATERIALS[-1]!r}]]\nsteps = 3\nsignals = 2\nseconds = 1.0\n"
    )
    made.write("mix", "mixing", held, last, more=ends)
    made.write("rate", "rating", rated, by_item(rated))
    made.write("words", "words", rated, by_item(rated), head='label = "item"\n')
    drives = rated_drives(made.work / "stores" / "drives")
    made.write("display", "words", drives, by_item(drives), head='label = "item"\n')
    return made


@pytest.fixture(name="judged")
def judged_fixture(tasks):
    """Give a function that judges answers, by question, of a task."""

    def judge(name, answer):
        opened = tasks.open(name)
        kind = kind_of(opened.task.kind)
        kind.check(opened)
        questions = kind.questions(opened)
        answers = {question.id: answer(opened, question) for question in questions}
        check_answers(kind.form(opened), questions, answers, where=name)
        return opened, questions, kind.judge(opened, answers, silent)

    return judge
